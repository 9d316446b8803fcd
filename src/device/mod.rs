//! The board's application without the board: sensor in, console in and out, calibration applied and kept.
//!
//! [`Device`] does no I/O of its own. Its owner, a firmware's main loop or a test, gives it
//! - the time and a way to do what the sensor needs ([`Device::tick`]),
//! - the bytes that arrive on the console and a place for the answers ([`Device::on_byte`]),
//! - presses of the button ([`Device::on_button`]),
//! - memory that survives a restart ([`Store`]),
//!
//! and shows [`Device::light`]. What holds whatever goes wrong: a calibration in use is replaced only by one
//! that was accepted, stored and read back; each line is answered exactly once; a sensor that fails is tried
//! again for ever.
//!
//! ```
//! use ironout::device::{Device, DeviceConfig, SensorAnswer, SensorTask};
//! # use ironout::store::{Slot, Store, StoreError};
//! # struct Rom([[u8; 512]; 2]);
//! # impl Store for Rom {
//! #     fn read_slot(&mut self, slot: Slot, bytes: &mut [u8]) -> Result<(), StoreError> {
//! #         bytes.copy_from_slice(&self.0[slot.index()][..bytes.len()]);
//! #         Ok(())
//! #     }
//! #     fn write_slot(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), StoreError> {
//! #         self.0[slot.index()][..bytes.len()].copy_from_slice(bytes);
//! #         Ok(())
//! #     }
//! # }
//! # let mut rom = Rom([[0xff; 512]; 2]);
//! let mut device = Device::new(DeviceConfig {
//!     board: "bench",
//!     sensor: "LSM303DLHC",
//!     ut_per_count: [0.1, 0.1, 0.11],
//!     sample_period_ms: 20,
//! });
//! device.boot(&mut rom); // applies the stored calibration, if there is one
//! let mut console = String::new();
//! for &byte in b"stream raw\n" {
//!     device.on_byte(byte, &mut console, &mut rom)?;
//! }
//! assert!(console.starts_with("err sensor "), "it was not started yet");
//! for t_ms in 0..30 {
//!     device.tick(t_ms, &mut console, |task| match task {
//!         SensorTask::Start => SensorAnswer::Started,
//!         SensorTask::Sample => SensorAnswer::Sample { counts: [1, 2, 3], saturated: false },
//!     })?;
//! }
//! # Ok::<(), core::fmt::Error>(())
//! ```

mod calibrate;
mod console;
mod light;
mod sensor;
mod stream;

use core::fmt;
use core::mem;

use crate::calibration::Calibration;
use crate::effect::TIME;
use crate::extended::Live;
use crate::gate::block_samples;
use crate::protocol::{Line, LineSplitter, StreamMode};
use crate::record::Record;
use crate::session::{Session, SessionConfig, State};
use crate::store::{Slot, Slots, Store};

pub use calibrate::ButtonEvent;
pub use light::Light;
use sensor::SensorWatch;
pub use sensor::{SensorAnswer, SensorFault, SensorTask};

/// What a device needs to know of its board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceConfig {
    /// The board's name, for `version`.
    pub board: &'static str,
    /// The sensor's name, for `version` and for messages.
    pub sensor: &'static str,
    /// µT per count of each axis.
    pub ut_per_count: [f32; 3],
    /// Time between samples.
    pub sample_period_ms: u32,
}

/// The calibration in use.
#[derive(Debug, Clone)]
struct Active {
    record: Record,
    slot: Slot,
    live: Live<f32>,
    /// What the recording's clock shows when that of `live` is zero.
    origin_s: f64,
    /// What has to be added to the time since power-up to give the recording's clock; unknown until it is fed.
    clock_s: Option<f64>,
}

impl Active {
    /// `None` where the record's effects cannot run here.
    fn new(slot: Slot, record: Record) -> Option<Self> {
        let (calibration, origin_s) = record.extended().on_own_clock();
        let live = Live::new(&calibration.cast()).ok()?;
        Some(Self { record, slot, live, origin_s, clock_s: None })
    }

    /// The correction at this time.
    fn at(&mut self, t_ms: u64) -> &Live<f32> {
        if self.live.needs_time() {
            let now_s = t_ms as f64 / 1000.0;
            self.live.advance(now_s + self.clock_s.map_or(0.0, |clock_s| clock_s - self.origin_s));
            if self.clock_s.is_none() {
                self.live.set(TIME, f32::NAN);
            }
        }
        &self.live
    }

    /// Feeds a column; the time too. Says whether an effect reads it.
    fn feed(&mut self, column: &str, value: f64, t_ms: u64) -> bool {
        if column == TIME {
            self.clock_s = Some(value - t_ms as f64 / 1000.0);
            self.at(t_ms);
            return !self.live.slots(TIME).is_empty();
        }
        self.live.set(column, value as f32)
    }
}

/// The application: see the [module](self).
#[derive(Debug, Clone)]
pub struct Device {
    config: DeviceConfig,
    session: Session,
    active: Option<Active>,
    sensor: SensorWatch,
    stream: StreamMode,
    splitter: LineSplitter,
    /// A slot could not be read when the store was looked at last.
    store_unread: bool,
    restarts: Restarts,
    /// Time of the last sample.
    now_ms: u64,
}

/// Restarts of the board after a fault of its firmware.
#[derive(Debug, Clone, Copy, Default)]
struct Restarts {
    count: u32,
    last: &'static str,
}

impl Device {
    /// A device with an idle session, a sensor to be started and no calibration yet; see [`Self::boot`].
    pub fn new(config: DeviceConfig) -> Self {
        let rate_hz = 1000.0 / f64::from(config.sample_period_ms.max(1));
        let session = Session::new(SessionConfig {
            ut_per_count: config.ut_per_count.map(f64::from),
            field_ut: None,
            method: Default::default(),
            samples_per_block: block_samples(rate_hz),
        });
        Self {
            config,
            session,
            active: None,
            sensor: SensorWatch::new(config.sample_period_ms),
            stream: StreamMode::Off,
            splitter: LineSplitter::new(),
            store_unread: true,
            restarts: Restarts::default(),
            now_ms: 0,
        }
    }

    /// Tells the device that the board restarted `count` times since power-up after a fault of its firmware, and in words
    /// what the last one was. `status` counts them among its faults, `version` shows the last.
    pub fn note_restarts(&mut self, count: u32, last: &'static str) {
        self.restarts = Restarts { count, last };
    }

    /// Looks for a stored calibration and applies it. Returns what stands in the slots, for a log.
    ///
    /// Where a slot does not answer, it is looked at again with the next line on the console.
    pub fn boot(&mut self, store: &mut impl Store) -> Slots {
        let slots = Slots::inspect(store);
        self.store_unread = slots.unreadable().is_some();
        if let Some((slot, record)) = slots.current() {
            self.active = Active::new(slot, *record);
        }
        slots
    }

    /// To be called often, with the time since power-up. When something is due, `sensor` is asked to do it; a
    /// measurement goes into the session and the stream.
    ///
    /// # Errors
    /// That of `out`; the sample was taken all the same.
    pub fn tick(
        &mut self,
        t_ms: u64,
        out: &mut impl fmt::Write,
        sensor: impl FnOnce(SensorTask) -> SensorAnswer,
    ) -> fmt::Result {
        let Some(task) = self.sensor.task(t_ms) else { return Ok(()) };
        let answer = sensor(task);
        self.sensor.answered(answer, t_ms);
        match answer {
            SensorAnswer::Sample { counts, saturated } => self.on_sample(counts, saturated, t_ms, out),
            SensorAnswer::Started | SensorAnswer::NotReady | SensorAnswer::Failed(_) => Ok(()),
        }
    }

    /// Takes one measurement. [`Self::tick`] does this; it is here for boards whose sensor has a pace of its own.
    ///
    /// # Errors
    /// That of `out`; the sample was taken all the same.
    pub fn on_sample(
        &mut self,
        counts: [i16; 3],
        saturated: bool,
        t_ms: u64,
        out: &mut impl fmt::Write,
    ) -> fmt::Result {
        self.session.push(counts, saturated);
        self.now_ms = t_ms;
        if self.stream == StreamMode::Off {
            return Ok(());
        }
        let [x, y, z] = counts.map(f32::from);
        let [sx, sy, sz] = self.config.ut_per_count;
        let measured_ut = (!saturated).then_some([x * sx, y * sy, z * sz]);
        let sample = stream::Sample { t_ms, counts, measured_ut };
        let live = self.active.as_mut().map(|active| active.at(t_ms));
        stream::write_line(out, self.stream, &sample, live)
    }

    /// Takes one byte from the console; where it ends a line, the answer goes to `out`.
    ///
    /// # Errors
    /// That of `out`; the command was done all the same.
    pub fn on_byte(&mut self, byte: u8, out: &mut impl fmt::Write, store: &mut impl Store) -> fmt::Result {
        if byte != b'\n' {
            // Nothing but the end of a line gives a line.
            let _ = self.splitter.push(byte);
            return Ok(());
        }
        let mut splitter = mem::take(&mut self.splitter);
        splitter.push(byte).map_or(Ok(()), |line| self.on_line(line, out, store))
    }

    /// Answers one line: lines that begin with `+ `, then exactly one `ok …` or `err CODE text`.
    ///
    /// # Errors
    /// That of `out`; the command was done all the same.
    pub fn on_line(
        &mut self,
        line: Line<'_>,
        out: &mut impl fmt::Write,
        store: &mut impl Store,
    ) -> fmt::Result {
        if self.store_unread {
            self.boot(store);
        }
        self.answer(line, out, store).result()
    }

    /// The calibration in use.
    pub fn calibration(&self) -> Option<&Calibration<f64>> {
        self.active.as_ref().map(|active| &active.record.calibration)
    }

    /// The stored record of the calibration in use.
    pub fn record(&self) -> Option<&Record> {
        self.active.as_ref().map(|active| &active.record)
    }

    /// The session: what is being collected and what came of it.
    pub const fn session(&self) -> &Session {
        &self.session
    }

    /// What is wrong with the sensor, if it does not work.
    pub const fn sensor_fault(&self) -> Option<SensorFault> {
        self.sensor.fault()
    }

    /// What the light has to show.
    pub fn light(&self) -> Light {
        match self.session.state() {
            _ if self.sensor.fault().is_some() => Light::SensorFault,
            State::Collecting => Light::Collecting,
            State::Solved => Light::Solved,
            State::Refused => Light::Refused,
            State::Idle if self.active.is_some() => Light::Calibrated,
            State::Idle => Light::Uncalibrated,
        }
    }
}
