//! The firmware: wires a board to the driver, the device and the console.
//!
//! One thread: interrupts only move bytes and time, everything else happens in the loop below. The loop comes round at
//! every interrupt, at least once a millisecond; its longest turn is a solve (`cal stop`, and `status` while collecting: the
//! coverage and the verdict add a tenth to it), during which the console's bytes are buffered and samples are left out. A
//! sample itself takes under five thousand instructions.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("the firmware is built for a board's target: use an alias, such as `cargo fw-mps2`");
#[cfg(not(any(feature = "board-mps2")))]
compile_error!("the firmware is built for exactly one board: choose a feature, such as `board-mps2`");

mod board;
mod button;
mod fault;

use board::Board;
use button::Button;
use core::fmt::Debug;
use defmt::{Debug2Format, Display2Format};
use ironout::device::{Device, DeviceConfig, SensorAnswer, SensorFault, SensorTask};
use ironout_drivers::{Error, Magnetometer};

/// 50 samples a second.
const SAMPLE_PERIOD_MS: u32 = 20;

#[cortex_m_rt::entry]
fn main() -> ! {
    let restarts = fault::Restarts::read();
    let Some(board) = Board::take() else { panic!("the board was taken before") };
    let Board { mut sensor, mut store, mut console, clock, mut panel } = board;
    let mut device = Device::new(DeviceConfig {
        board: board::NAME,
        sensor: sensor.name(),
        ut_per_count: sensor.ut_per_count(),
        sample_period_ms: SAMPLE_PERIOD_MS,
    });
    device.note_restarts(restarts.count, restarts.last);
    defmt::info!("ironout {=str} on {=str}", env!("CARGO_PKG_VERSION"), board::NAME);
    if restarts.count > 0 {
        defmt::error!("restart {=u32} after a fault: {=str}", restarts.count, restarts.last);
    }
    let [a, b] = device.boot(&mut store).states;
    defmt::info!("slots: {}, {}", Display2Format(&a), Display2Format(&b));

    let mut button = Button::default();
    // What the log has said of the sensor; nothing yet.
    let mut logged = None;
    loop {
        // The sensor comes first, so that it is found before the first command asks for it. Writing to the console never
        // fails: what a stalled terminal does not take is dropped.
        let now_ms = clock.now_ms();
        let _ = device.tick(now_ms, &mut console, |task| serve(&mut sensor, task));
        while let Some(byte) = console.read() {
            let _ = device.on_byte(byte, &mut console, &mut store);
        }
        let fault = device.sensor_fault();
        if logged != Some(fault) {
            logged = Some(fault);
            match fault {
                Some(fault) => defmt::warn!("sensor: {}", fault),
                None => defmt::info!("sensor: works"),
            }
        }
        if button.pressed(panel.button_down(), now_ms) {
            defmt::info!("button: {}", device.on_button(&mut store));
        }
        panel.set_light(device.light().is_on(now_ms));
        board::sleep();
    }
}

/// Does with the sensor what the device asks for.
fn serve<M: Magnetometer<BusError: Debug>>(sensor: &mut M, task: SensorTask) -> SensorAnswer {
    let answer = match task {
        SensorTask::Start => sensor.init().map(|()| SensorAnswer::Started),
        SensorTask::Sample => match sensor.data_ready() {
            Ok(true) => sensor.read().map(|reading| SensorAnswer::Sample {
                counts: reading.counts,
                saturated: reading.saturated(),
            }),
            Ok(false) => Ok(SensorAnswer::NotReady),
            Err(error) => Err(error),
        },
    };
    answer.unwrap_or_else(|error| {
        // The cause in the bus's own words goes to the log; the console tells what to check.
        defmt::debug!("sensor: {}", Debug2Format(&error));
        SensorAnswer::Failed(match error {
            Error::NotFound { expected, found } => SensorFault::WrongChip { expected, found },
            Error::NotKept { .. } => SensorFault::NotKept,
            Error::Bus(_) | Error::InvalidConfig(_) => SensorFault::NoAnswer,
        })
    })
}
