//! The firmware: wires a board to the driver, the device and the console.
//!
//! One thread: interrupts only move bytes and time, and on some boards read the sensor; everything else happens in the loop below,
//! one turn of the device after the other, and sleep until the next is due. The longest turn is a solve; `version` tells how long
//! it was.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("the firmware is built for a board's target: use an alias, such as `cargo fw-mps2`");

mod board;
mod fault;

use board::{Board, Sampled};
use defmt::Display2Format;
use ironout::device::{Device, DeviceConfig, SensorAnswer};
use ironout::sensor::{Magnetometer, Sensor};

#[cortex_m_rt::entry]
fn main() -> ! {
    let restarts = fault::Restarts::read();
    let Some(board) = Board::take() else { panic!("the board was taken before") };
    let Board {
        mut sensor,
        mut sampled,
        mut columns,
        mut store,
        mut console,
        mut clock,
        mut panel,
        mut watchdog,
    } = board;
    if !restarts.is_stuck() {
        // A board that finds its sensor by probing knows only now what it is. An error is told by the device, which asks again.
        let _ = sensor.init();
    }
    let mut described = sensor.describe();
    let mut device = Device::new(config_of(described));
    device.note_restarts(restarts.count, restarts.last);
    if board::SHOWS_COVERAGE {
        device.show_coverage();
    }
    defmt::info!("ironout {=str} on {=str}", env!("CARGO_PKG_VERSION"), board::NAME);
    if restarts.count > 0 {
        defmt::error!("restart {=u32} after a fault: {=str}", restarts.count, restarts.last);
    }
    if restarts.is_stuck() {
        defmt::error!("every start has failed: sensor and store are left alone");
        device.rest();
    }

    // What the log has said; nothing yet.
    let (mut logged, mut slots) = (None, None);
    let mut started = false;
    loop {
        let begun_us = clock.now_us();
        let now_ms = begun_us / 1000;
        if !started && now_ms >= fault::STARTED_MS {
            started = true;
            fault::started();
        }
        watchdog.turned();
        // Another chip than before has been found: counts have another meaning, and nothing collected is worth anything.
        if device.is_idle() && sensor.describe() != described {
            described = sensor.describe();
            device.begin_anew(config_of(described));
        }
        // One line at a time: its reply goes where it came from. An idle device takes every byte.
        while device.is_idle()
            && let Some(byte) = console.read()
        {
            let _ = device.take_byte(byte);
        }
        device.on_button_level(panel.button_down(), now_ms);
        // One sample a turn: each has its line of a stream.
        if let Some(Sampled { at_us, reading, moved, temp_c }) = sampled.next() {
            columns.measure(at_us, |name, value, origin| device.on_own_column(name, value, origin));
            if let Some(temp_c) = temp_c {
                device.complete_sensor(SensorAnswer::Temperature(temp_c), at_us / 1000);
            }
            if moved.accel_mps2.is_some() || moved.turn_radps.is_some() {
                device.on_motion(moved.accel_mps2, moved.turn_radps);
            }
            match reading {
                Ok(reading) => device.on_sample(&reading, at_us / 1000),
                Err(fault) => device.complete_sensor(SensorAnswer::Failed(fault), at_us / 1000),
            }
        }
        device.note_stamp_jitter_us(sampled.jitter_us());
        let more = device.turn(now_ms, &mut sensor, &mut store, &mut console);
        // Half an hour in one turn fits.
        device.note_turn_us(clock.now_us().saturating_sub(begun_us) as u32);

        let fault = device.sensor_fault();
        if logged != Some(fault) {
            logged = Some(fault);
            match fault {
                Some(fault) => defmt::warn!("sensor: {}", fault),
                None => defmt::info!("sensor: works"),
            }
        }
        if slots != Some(device.slots()) {
            slots = Some(device.slots());
            let [a, b] = device.slots().states;
            defmt::info!("slots: {}, {}", Display2Format(&a), Display2Format(&b));
        }
        if let Some(event) = device.take_event() {
            defmt::info!("button: {}", event);
        }
        panel.show(&device.shown(now_ms));
        if !more {
            let wants_bytes = device.is_idle();
            clock.sleep_until_ms(device.next_deadline_ms(), || {
                (wants_bytes && console.has_input()) || sampled.is_waiting()
            });
        }
    }
}

/// What the application knows of this board, with this sensor.
fn config_of(sensor: Sensor) -> DeviceConfig {
    DeviceConfig { board: board::NAME, sensor: sensor.mounted(board::MOUNTING), pace: board::PACE }
}
