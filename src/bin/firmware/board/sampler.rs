//! Reads the sensor in an interrupt of a timer, each conversion once, whatever the loop is doing.
//!
//! The loop asks for a start and is answered at once, because the interrupt comes before it goes on. Readings wait in a queue, each
//! with the time of the interrupt that found it.

use super::sampled::{Moved, Sampled};
use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use embedded_hal::i2c::ErrorKind;
use heapless::spsc::{Consumer, Producer, Queue};
use ironout::device::{Conversions, NO_TEMPERATURE_MS, SensorFault, TEMPERATURE_MS};
use ironout::sensor::{Error, Magnetometer, Reading, Sensor};

/// Readings that wait for the loop: several times those of the longest solve.
const WAITING: usize = 32;

/// Failures in a row after which the device asks for a start, and nothing is tried before.
const FAILURES: u8 = 3;

/// How often a sampler without a sensor shows that it lives.
const IDLE_US: u64 = 100_000;

/// Readings and their queue.
pub type Waiting = Queue<Sampled, WAITING>;

/// What the sampler needs of a board.
pub trait Ground: 'static {
    /// The magnetometer. One that is found by looking for it is looked for by `init`, and described anew then.
    type Sensor: Magnetometer<BusError = ErrorKind> + Send;
    /// What tells of the board's motion, if anything does: `()`.
    type Motion: Motion + Send;

    /// Microseconds since start.
    fn now_us() -> u64;
    /// Makes the sampler's interrupt come at this time, at once where that is past.
    fn set_alarm(at_us: u64);
    /// Makes it come now, before this returns.
    fn pend();
}

/// Accelerometer and gyro.
pub trait Motion {
    /// Starts what there is.
    fn start(&mut self);
    /// Reads it.
    fn read(&mut self) -> Moved;
}

impl Motion for () {
    fn start(&mut self) {}
    fn read(&mut self) -> Moved {
        Moved::default()
    }
}

/// What the interrupt works with.
struct Sampler<G: Ground> {
    sensor: G::Sensor,
    motion: G::Motion,
    out: Producer<'static, Sampled>,
    rhythm: Conversions,
    is_running: bool,
    failures: u8,
    temperature_at_us: u64,
}

/// The loop's wish for a start, and what came of it.
#[derive(Clone, Copy)]
enum Start {
    None,
    Asked,
    Done(Result<(), Error<ErrorKind>>),
}

/// The sampler's place, shared by its interrupt and the loop: a static of the board's.
pub struct Seat<G: Ground> {
    sampler: Mutex<RefCell<Option<Sampler<G>>>>,
    /// The sensor as it was described when it was started last.
    description: Mutex<Cell<Option<Sensor>>>,
    start: Mutex<Cell<Start>>,
    /// Counts the sampler's turns: that it counts shows that interrupts and the timer work.
    beats: AtomicU32,
    /// How far stamps were from the sensor's rhythm at most, µs; the highest number as long as that is not known.
    jitter_us: AtomicU32,
}

impl<G: Ground> Seat<G> {
    /// An empty one.
    pub const fn new() -> Self {
        Self {
            sampler: Mutex::new(RefCell::new(None)),
            description: Mutex::new(Cell::new(None)),
            start: Mutex::new(Cell::new(Start::None)),
            beats: AtomicU32::new(0),
            jitter_us: AtomicU32::new(u32::MAX),
        }
    }

    /// Takes sensor and queue in. The interrupt may come from now on.
    pub fn take_in(
        &'static self,
        sensor: G::Sensor,
        motion: G::Motion,
        queue: &'static mut Waiting,
    ) -> (Proxy<G>, Samples) {
        let (out, samples) = queue.split();
        let described = sensor.describe();
        let rhythm = Conversions::new(described.rate_hz);
        let sampler =
            Sampler { sensor, motion, out, rhythm, is_running: false, failures: 0, temperature_at_us: 0 };
        critical_section::with(|section| {
            self.description.borrow(section).set(Some(described));
            self.sampler.borrow(section).replace(Some(sampler));
        });
        G::set_alarm(G::now_us() + IDLE_US);
        (Proxy { seat: self, described }, Samples { waiting: samples, jitter_us: &self.jitter_us })
    }

    /// How often the sampler has had its turn.
    pub fn beats(&self) -> u32 {
        self.beats.load(Ordering::Relaxed)
    }

    /// The interrupt.
    pub fn interrupt(&self) {
        let tick_us = G::now_us();
        self.beats.store(self.beats().wrapping_add(1), Ordering::Relaxed);
        // Taken out for the time of its work, so that other interrupts go on meanwhile; nobody else takes it.
        let Some(mut sampler) = critical_section::with(|section| self.sampler.borrow(section).take()) else {
            return;
        };
        if let Start::Asked = critical_section::with(|section| self.start.borrow(section).get()) {
            let done = sampler.start();
            critical_section::with(|section| {
                self.description.borrow(section).set(Some(sampler.sensor.describe()));
                self.start.borrow(section).set(Start::Done(done));
            });
        }
        let next_us = sampler.turn(tick_us);
        self.jitter_us.store(sampler.rhythm.worst_off_us().unwrap_or(u32::MAX), Ordering::Relaxed);
        critical_section::with(|section| self.sampler.borrow(section).replace(Some(sampler)));
        G::set_alarm(next_us);
    }
}

impl<G: Ground> Sampler<G> {
    fn start(&mut self) -> Result<(), Error<ErrorKind>> {
        let done = self.sensor.init();
        (self.is_running, self.failures) = (done.is_ok(), 0);
        self.temperature_at_us = 0;
        self.rhythm = Conversions::new(self.sensor.describe().rate_hz);
        if self.is_running {
            self.motion.start();
        }
        done
    }

    /// Looks for a conversion; when to look again.
    fn turn(&mut self, tick_us: u64) -> u64 {
        if !self.is_running {
            return tick_us + IDLE_US;
        }
        let reading = match self.sensor.data_ready() {
            Ok(false) => return self.rhythm.missed(tick_us),
            Ok(true) => self.sensor.read(),
            Err(error) => Err(error),
        };
        let is_read = reading.is_ok();
        let reading = reading.map_err(|error| SensorFault::of(&error));
        self.failures = if is_read { 0 } else { self.failures + 1 };
        self.is_running = self.failures < FAILURES;
        let moved = if is_read { self.motion.read() } else { Moved::default() };
        let is_due = is_read && tick_us >= self.temperature_at_us;
        let temp_c = if is_due { self.temperature(tick_us) } else { None };
        // Where the loop is that far behind, the sample is lost, and the device counts it by the times of the others.
        let _ = self.out.enqueue(Sampled { at_us: tick_us, reading, moved, temp_c });
        if is_read { self.rhythm.found(tick_us) } else { tick_us + u64::from(self.rhythm.period_us()) }
    }

    /// The chip's temperature; a bus that fails shows with the next sample.
    fn temperature(&mut self, tick_us: u64) -> Option<Option<f32>> {
        let temp_c = self.sensor.temperature_c().ok();
        let is_without = matches!(temp_c, Some(None));
        self.temperature_at_us = tick_us + 1000 * if is_without { NO_TEMPERATURE_MS } else { TEMPERATURE_MS };
        temp_c
    }
}

/// What the sampler has read.
pub struct Samples {
    waiting: Consumer<'static, Sampled>,
    jitter_us: &'static AtomicU32,
}

impl Samples {
    /// The oldest reading that waits.
    pub fn next(&mut self) -> Option<Sampled> {
        self.waiting.dequeue()
    }

    /// Whether one waits.
    pub fn is_waiting(&self) -> bool {
        self.waiting.ready()
    }

    /// How far the stamps of samples were from the sensor's own rhythm at most, µs, since it was known.
    pub fn jitter_us(&self) -> Option<u32> {
        Some(self.jitter_us.load(Ordering::Relaxed)).filter(|us| *us < u32::MAX)
    }
}

/// The magnetometer as the loop sees it: it can be described and started.
pub struct Proxy<G: Ground> {
    seat: &'static Seat<G>,
    /// As it was taken in.
    described: Sensor,
}

impl<G: Ground> Magnetometer for Proxy<G> {
    type BusError = ErrorKind;

    /// Changes where another chip is found than before.
    fn describe(&self) -> Sensor {
        critical_section::with(|section| self.seat.description.borrow(section).get())
            .unwrap_or(self.described)
    }

    /// The sampler starts the sensor before this goes on: its interrupt has to wait for nobody.
    fn init(&mut self) -> Result<(), Error<ErrorKind>> {
        critical_section::with(|section| self.seat.start.borrow(section).set(Start::Asked));
        G::pend();
        loop {
            let done = critical_section::with(|section| match self.seat.start.borrow(section).get() {
                Start::Done(done) => {
                    self.seat.start.borrow(section).set(Start::None);
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
