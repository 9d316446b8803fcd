//! `ironout` in an async firmware: the device is one task among others.
//!
//!     cargo run -p ironout-host-tests --example async_tasks
//!
//! The executor is `embassy_futures::block_on`, time is simulated; with embassy's timers, buses and UARTs the task below stays as it
//! is. It sleeps until the device's next deadline or the next byte, whichever is first.

mod bench;

use bench::{Bench, END_MS, SCRIPT};
use core::cell::RefCell;
use core::future::poll_fn;
use core::task::Poll;
use embassy_futures::block_on;
use embassy_futures::select::{Either3, select, select3};
use embassy_futures::yield_now;
use heapless::Deque;
use ironout::device::{Action, Device, DeviceConfig, Pace, SensorAnswer, SensorTask, serve_sensor};
use ironout::sensor::Magnetometer;
use ironout::store::{self, StoreAnswer, StoreTask};
use ironout_rig::bus::Clock;

/// Bytes on their way to the console's task.
type Line = RefCell<Deque<u8, 128>>;

/// Ready at `at_ms`.
async fn timer(clock: &Clock, at_ms: u64) {
    poll_fn(|_| if clock.ms() >= at_ms { Poll::Ready(()) } else { Poll::Pending }).await;
}

/// Ready when a byte waits.
async fn readable(line: &Line) {
    poll_fn(|_| if line.borrow().is_empty() { Poll::Pending } else { Poll::Ready(()) }).await;
}

/// The device's task.
async fn device_task(
    device: &mut Device,
    clock: &Clock,
    sensor: &mut impl Magnetometer,
    store: &mut impl store::Store,
    line: &Line,
    sent: &RefCell<String>,
) {
    let mut out = heapless::String::<4096>::new();
    loop {
        while line.borrow().front().is_some_and(|&byte| device.take_byte(byte)) {
            line.borrow_mut().pop_front();
        }
        match device.poll(clock.ms(), &mut out) {
            Action::Sensor(task) => {
                let answer = ask_sensor(sensor, task).await;
                device.complete_sensor(answer, clock.ms());
            }
            Action::Store(task) => {
                let answer = ask_store(store, &task).await;
                device.complete_store(&answer, clock.ms());
            }
            Action::Again => yield_now().await,
            Action::Sleep => {
                *sent.borrow_mut() += &out; // with a UART: uart.write(out.as_bytes()).await
                out.clear();
                select(timer(clock, device.next_deadline_ms()), readable(line)).await;
            }
        }
    }
}

/// A transaction of 0.3 ms, so that a driver that waits for it does no harm; one for `embedded-hal-async` is awaited here.
async fn ask_sensor(sensor: &mut impl Magnetometer, task: SensorTask) -> SensorAnswer {
    let answer = serve_sensor(sensor, task);
    yield_now().await;
    answer
}

async fn ask_store(store: &mut impl store::Store, task: &StoreTask) -> StoreAnswer {
    let answer = store::serve(store, task);
    yield_now().await;
    answer
}

/// A user at the other end of the line.
async fn user_task(clock: &Clock, line: &Line) {
    for (at_ms, text) in SCRIPT {
        timer(clock, at_ms).await;
        for byte in text.bytes().chain(*b"\n") {
            line.borrow_mut().push_back(byte).expect("lines are short");
        }
    }
    timer(clock, END_MS).await;
}

/// What stands in for hardware: whenever all tasks wait, time passes.
async fn time_passes(clock: &Clock) {
    poll_fn(|context| {
        clock.advance_ns(500_000);
        context.waker().wake_by_ref();
        Poll::<()>::Pending
    })
    .await;
}

fn main() {
    let Bench { clock, chip: _, mut sensor, mut store } = Bench::new();
    let description = sensor.describe();
    let mut device =
        Device::new(DeviceConfig { board: "async", sensor: description, pace: Pace::EachConversion });
    let (line, sent) = (Line::default(), RefCell::new(String::new()));
    let done = block_on(select3(
        user_task(&clock, &line),
        device_task(&mut device, &clock, &mut sensor, &mut store, &line, &sent),
        time_passes(&clock),
    ));
    assert!(matches!(done, Either3::First(())), "the device's task never ends");
    bench::check(&sent.borrow(), f64::from(description.rate_hz));
}

#[test]
fn it_calibrates_and_loses_nothing() {
    main();
}
