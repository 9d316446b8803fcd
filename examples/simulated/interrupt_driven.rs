//! `ironout` in a firmware whose interrupts do the work that cannot wait.
//!
//!     cargo run -p ironout-host-tests --example interrupt_driven
//!
//! The sensor's data-ready line raises an interrupt that reads the chip into a queue, the UART's interrupt fills another one, and the
//! main loop feeds both to the device and sleeps until something is due. However long the main loop computes, no conversion is lost:
//! a solve is taken here to last 60 ms, more than four conversions.

mod bench;

use bench::{Bench, END_MS, SCRIPT};
use heapless::spsc::{Consumer, Producer, Queue};
use ironout::device::{Action, Device, DeviceConfig, Pace, serve_sensor};
use ironout::sensor::{Magnetometer, Reading};
use ironout::store;
use std::cell::RefCell;

/// Conversions that may come while the main loop computes.
const READINGS: usize = 16;

/// The handler of the data-ready line.
fn on_data_ready(sensor: &mut impl Magnetometer, readings: &mut Producer<'_, (u64, Reading)>, now_ms: u64) {
    // The first conversion after a change of the gain is not ready: the driver drops it. A bus error is a conversion less.
    if sensor.data_ready().unwrap_or(false)
        && let Ok(reading) = sensor.read()
    {
        // A full queue is a conversion lost; the device counts it by the gap.
        let _ = readings.enqueue((now_ms, reading));
    }
}

fn main() {
    let Bench { clock, chip, sensor, mut store } = Bench::new();
    // On a microcontroller: a mutex of critical-section, since main loop and handler both use the sensor.
    let sensor = RefCell::new(sensor);
    let mut readings = Queue::<_, READINGS>::new();
    let (mut to_main, mut from_interrupt): (_, Consumer<'_, (u64, Reading)>) = readings.split();
    let mut received = Queue::<u8, 128>::new();
    let (mut to_line, mut from_uart) = received.split();

    // What the hardware does while time passes: interrupts.
    let mut script = SCRIPT.into_iter().peekable();
    let mut was_ready = false;
    let mut pass_until_ms = |end_ms: u64| {
        while clock.ms() < end_ms {
            clock.advance_to_ms(clock.ms() + 1);
            let is_ready = chip.borrow_mut().data_ready_line(&clock);
            if is_ready && !was_ready {
                on_data_ready(&mut *sensor.borrow_mut(), &mut to_main, clock.ms());
            }
            was_ready = chip.borrow_mut().data_ready_line(&clock);
            while let Some((_, line)) = script.next_if(|(at_ms, _)| *at_ms <= clock.ms()) {
                line.bytes().chain(*b"\n").for_each(|byte| to_line.enqueue(byte).expect("lines are short"));
            }
        }
    };

    // The firmware.
    let description = sensor.borrow().describe();
    let mut device =
        Device::new(DeviceConfig { board: "interrupts", sensor: description, pace: Pace::Pushed });
    let mut out = heapless::String::<4096>::new();
    let mut sent = String::new();
    while clock.ms() < END_MS {
        while let Some((t_ms, reading)) = from_interrupt.dequeue() {
            device.on_sample(&reading, t_ms);
        }
        while from_uart.peek().is_some_and(|&byte| device.take_byte(byte)) {
            from_uart.dequeue();
        }
        let light = device.light();
        match device.poll(clock.ms(), &mut out) {
            Action::Sensor(task) => {
                let answer = serve_sensor(&mut *sensor.borrow_mut(), task);
                device.complete_sensor(answer, clock.ms());
            }
            Action::Store(task) => {
                device.complete_store(&store::serve(&mut store, &task), clock.ms());
                // The simulated wait for the memory let time pass without interrupts; here they are.
                pass_until_ms(clock.ms() + 1);
            }
            // On a 25 MHz processor some turns take this long; the interrupts go on meanwhile.
            Action::Again if device.light() != light => pass_until_ms(clock.ms() + 60),
            Action::Again => pass_until_ms(clock.ms() + 1),
            Action::Sleep => {
                sent += &out;
                out.clear();
                // On a microcontroller: a timer for the deadline, then wfi. Any interrupt ends the sleep.
                let deadline_ms = device.next_deadline_ms().min(END_MS);
                while clock.ms() < deadline_ms && from_interrupt.is_empty() && from_uart.is_empty() {
                    pass_until_ms(clock.ms() + 1);
                }
            }
        }
    }
    bench::check(&sent, f64::from(description.rate_hz));
}

#[test]
fn it_calibrates_and_loses_nothing() {
    main();
}
