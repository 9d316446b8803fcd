//! Reads the sensor in an interrupt of the timer, each conversion once, whatever the loop is doing.
//!
//! The loop asks for a start and is answered at once, because the interrupt comes before it goes on. Readings wait in a queue.

use super::bus::Bus;
use super::time::{Alarm, now_us};
use crate::board::sampled::Sampled;
use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use embassy_rp::interrupt;
use embassy_rp::interrupt::InterruptExt;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::ErrorKind;
use heapless::spsc::{Consumer, Producer, Queue};
use ironout::device::SensorFault;
use ironout::sensor::{Error, Magnetometer, Reading, Sensor};
use ironout_drivers::{AnyMagnetometer, Kind, probe};

/// The sensor as long as none was found: whatever it will be, it is described anew then.
const UNKNOWN: Sensor = Sensor::uniform("magnetometer", 0.15, 100.0);

/// The timer's alarm of the sampler.
const ALARM: Alarm = Alarm(1);

/// Readings that wait for the loop: more than a second of them, several times the longest solve.
const WAITING: usize = 128;

/// Failures in a row after which the device asks for a start, and nothing is tried before.
const FAILURES: u8 = 3;

/// How often a sampler without a sensor shows that it lives.
const IDLE_US: u64 = 100_000;

/// The bus with the chip that was found on it, if one was.
enum Chip {
    Unknown(Bus),
    Found(AnyMagnetometer<Bus, Wait>),
}

/// What the interrupt works with.
struct Sampler {
    /// Taken out only while it is exchanged.
    chip: Option<Chip>,
    out: Producer<'static, Sampled>,
    period_us: u64,
    is_running: bool,
    failures: u8,
}

/// The loop's wish for a start, and what came of it.
#[derive(Clone, Copy)]
enum Start {
    None,
    Asked,
    Done(Result<(), Error<ErrorKind>>),
}

static SAMPLER: Mutex<RefCell<Option<Sampler>>> = Mutex::new(RefCell::new(None));
/// The sensor as it was described when it was started last.
static DESCRIPTION: Mutex<Cell<Sensor>> = Mutex::new(Cell::new(UNKNOWN));
static START: Mutex<Cell<Start>> = Mutex::new(Cell::new(Start::None));

/// Counts the sampler's turns: that it counts shows that interrupts and the timer work.
static BEATS: AtomicU32 = AtomicU32::new(0);

/// How often the sampler has had its turn.
pub fn beats() -> u32 {
    BEATS.load(Ordering::Relaxed)
}

/// Starts the sampler's interrupt. `None` at the second call.
pub fn start(bus: Bus) -> Option<(Proxy, Samples)> {
    let queue = cortex_m::singleton!(: Queue<Sampled, WAITING> = Queue::new())?;
    let (out, samples) = queue.split();
    let sampler =
        Sampler { chip: Some(Chip::Unknown(bus)), out, period_us: IDLE_US, is_running: false, failures: 0 };
    critical_section::with(|section| SAMPLER.borrow(section).replace(Some(sampler)));
    // SAFETY: its handler is below, and no critical section relies on masks.
    unsafe { interrupt::TIMER_IRQ_1.enable() };
    ALARM.set(now_us() + IDLE_US);
    Some((Proxy(()), Samples(samples)))
}

#[interrupt]
fn TIMER_IRQ_1() {
    let tick_us = now_us();
    ALARM.clear();
    BEATS.store(BEATS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    // Taken out for the time of its work, so that other interrupts go on meanwhile; nobody else takes it.
    let Some(mut sampler) = critical_section::with(|section| SAMPLER.borrow(section).take()) else { return };
    if let Start::Asked = critical_section::with(|section| START.borrow(section).get()) {
        let done = sampler.start();
        (sampler.is_running, sampler.failures) = (done.is_ok(), 0);
        critical_section::with(|section| START.borrow(section).set(Start::Done(done)));
    }
    let next_us = sampler.turn(tick_us);
    critical_section::with(|section| SAMPLER.borrow(section).replace(Some(sampler)));
    ALARM.set(next_us);
}

/// Waits by counting: a chip's start asks for some milliseconds at most.
struct Wait;

impl DelayNs for Wait {
    fn delay_ns(&mut self, ns: u32) {
        let end_us = now_us() + u64::from(ns.div_ceil(1000));
        while now_us() < end_us {}
    }
}

impl Sampler {
    /// Starts the chip that was found before; where that fails, or none was found yet, the bus is looked through anew.
    fn start(&mut self) -> Result<(), Error<ErrorKind>> {
        let mut bus = match self.chip.take() {
            Some(Chip::Found(mut driver)) => {
                if driver.init().is_ok() {
                    self.chip = Some(Chip::Found(driver));
                    return Ok(());
                }
                driver.destroy()
            }
            Some(Chip::Unknown(bus)) => bus,
            None => return Err(Error::Bus(ErrorKind::Other)),
        };
        let findings = probe(&mut bus, &mut Wait);
        // An ICM-20948 with its bypass open is found as the AK09916 behind it as well; whoever closes it is the first of the two.
        let icm20948 = findings.iter().find(|found| found.kind == Kind::Icm20948);
        let Some(found) = icm20948.or(findings.first()) else {
            self.chip = Some(Chip::Unknown(bus));
            return Err(Error::Bus(findings.trouble.unwrap_or(ErrorKind::Other)));
        };
        let mut driver = AnyMagnetometer::new(bus, Wait, found);
        let done = driver.init();
        if done.is_err() {
            self.chip = Some(Chip::Unknown(driver.destroy()));
            return done;
        }
        let description = driver.describe();
        self.period_us = (1e6 / description.rate_hz) as u64;
        critical_section::with(|section| DESCRIPTION.borrow(section).set(description));
        self.chip = Some(Chip::Found(driver));
        Ok(())
    }

    /// Looks for a conversion; when to look again.
    fn turn(&mut self, tick_us: u64) -> u64 {
        let (true, Some(Chip::Found(driver))) = (self.is_running, &mut self.chip) else {
            return tick_us + IDLE_US;
        };
        let reading = match driver.data_ready() {
            Ok(false) => return tick_us + self.period_us / 16,
            Ok(true) => driver.read(),
            Err(error) => Err(error),
        };
        let reading = reading.map_err(|error| SensorFault::of(&error));
        self.failures = if reading.is_ok() { 0 } else { self.failures + 1 };
        self.is_running = self.failures < FAILURES;
        // Where the loop is that far behind, the sample is lost, and the device counts it by the times of the others.
        let _ = self.out.enqueue(Sampled { at_ms: tick_us / 1000, reading });
        // The chip's clock may be some percent fast.
        tick_us + self.period_us - self.period_us / 8
    }
}

/// What the sampler has read.
pub struct Samples(Consumer<'static, Sampled>);

impl Samples {
    /// The oldest reading that waits.
    pub fn next(&mut self) -> Option<Sampled> {
        self.0.dequeue()
    }

    /// Whether one waits.
    pub fn is_waiting(&self) -> bool {
        self.0.ready()
    }
}

/// The magnetometer as the loop sees it: it can be described and started.
pub struct Proxy(());

impl Magnetometer for Proxy {
    type BusError = ErrorKind;

    /// Changes where another chip is found than before.
    fn describe(&self) -> Sensor {
        critical_section::with(|section| DESCRIPTION.borrow(section).get())
    }

    /// The sampler starts the sensor before this goes on: its interrupt has to wait for nobody.
    fn init(&mut self) -> Result<(), Error<ErrorKind>> {
        critical_section::with(|section| START.borrow(section).set(Start::Asked));
        interrupt::TIMER_IRQ_1.pend();
        loop {
            let done = critical_section::with(|section| match START.borrow(section).get() {
                Start::Done(done) => {
                    START.borrow(section).set(Start::None);
                    Some(done)
                }
                Start::None | Start::Asked => None,
            });
            if let Some(done) = done {
                return done;
            }
        }
    }

    /// Never: readings come from the queue.
    fn data_ready(&mut self) -> Result<bool, Error<ErrorKind>> {
        Ok(false)
    }

    /// There is none here: readings come from the queue.
    fn read(&mut self) -> Result<Reading, Error<ErrorKind>> {
        Err(Error::Bus(ErrorKind::Other))
    }

    fn temperature_c(&mut self) -> Result<Option<f32>, Error<ErrorKind>> {
        Ok(None)
    }
}
