//! A firmware whose tick of milliseconds has 32 bits, from a minute before it wraps.

use crate::common::records::{bytes, record};
use crate::common::value;
use ironout::calibration::Calibration;
use ironout::device::{
    Action, ButtonEvent, Device, DeviceConfig, Pace, SensorAnswer, SensorTask, StoreAnswer,
};
use ironout::effect::BuiltIn;
use ironout::learn::Candidate;
use ironout::record::{MAX_RECORD_BYTES, Record};
use ironout::sensor::{Reading, Sensor};
use ironout::store::{Slot, Store, StoreError, serve};

const BEFORE_MS: u32 = 60_000;
const BEGIN_TICK: u32 = BEFORE_MS.wrapping_neg();
/// The time of the wrap, ms.
const WRAP_MS: u64 = 1 << 32;

struct Memory {
    bytes: [[u8; MAX_RECORD_BYTES]; 2],
    answers: bool,
}

impl Store for Memory {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        bytes.copy_from_slice(&self.bytes[slot.index()][at..at + bytes.len()]);
        if self.answers { Ok(()) } else { Err(StoreError::Read(slot)) }
    }
    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        self.bytes[slot.index()][at..at + bytes.len()].copy_from_slice(bytes);
        if self.answers { Ok(()) } else { Err(StoreError::Write(slot)) }
    }
}

/// A firmware that knows nothing but its tick.
struct Firmware {
    device: Device,
    memory: Memory,
    tick: u32,
    /// Since it began.
    passed_ms: u64,
    pace: Pace,
    period_ms: u64,
    pushed_ms: u64,
    out: heapless::String<8192>,
    said: String,
    samples: u64,
    /// The last conversion that was taken.
    conversion: u64,
    temperatures: u64,
    state: u64,
    /// Of the field, µT, by the time since the wrap, ms.
    disturbance: fn(i64) -> [f64; 3],
}

impl Firmware {
    /// With a calibration that does nothing in its memory.
    fn new(pace: Pace, rate_hz: f32, disturbance: fn(i64) -> [f64; 3]) -> Self {
        let sensor = Sensor::uniform("a chip", 0.1, rate_hz);
        let stored =
            Record { sequence: 1, calibration: Calibration::identity(50.0), noise_ut: 0.3, ..record(0.0) };
        let mut memory = Memory { bytes: [[0xff; MAX_RECORD_BYTES]; 2], answers: true };
        let stored = bytes(&stored);
        memory.bytes[0][..stored.len()].copy_from_slice(&stored);
        Self {
            device: Device::new(DeviceConfig { board: "bench", sensor, pace }),
            memory,
            tick: BEGIN_TICK,
            passed_ms: 0,
            pace,
            period_ms: (1000.0 / rate_hz) as u64,
            pushed_ms: 0,
            out: heapless::String::new(),
            said: String::new(),
            samples: 0,
            conversion: 0,
            temperatures: 0,
            state: 1,
            disturbance,
        }
    }

    fn reading(&mut self) -> Reading {
        self.samples += 1;
        let t_s = self.passed_ms as f64 / 1000.0;
        let (turn, tilt) = (1.7 * t_s, 1.4 * (0.61 * t_s).sin());
        let field = [tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin()];
        let more = (self.disturbance)(self.passed_ms as i64 - i64::from(BEFORE_MS));
        let counts = std::array::from_fn(|axis| {
            self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let noise = (self.state >> 33) as f64 / f64::from(1u32 << 31) - 0.5;
            (10.0 * (50.0 * field[axis] + more[axis] + noise)).round() as i16
        });
        Reading { counts, overflow: [false; 3] }
    }

    fn pass(&mut self, ms: u64) {
        self.tick = self.tick.wrapping_add(ms as u32);
        self.passed_ms += ms;
    }

    fn run(&mut self, ms: u64) {
        let end_ms = self.passed_ms + ms;
        while self.passed_ms < end_ms {
            let now_ms = u64::from(self.tick);
            if self.pace == Pace::Pushed && self.passed_ms >= self.pushed_ms + self.period_ms {
                self.pushed_ms += self.period_ms;
                let reading = self.reading();
                // The stamp of an interrupt, some milliseconds old.
                let late = (self.passed_ms - self.pushed_ms) as u32;
                self.device.on_sample(&reading, u64::from(self.tick.wrapping_sub(late)));
            }
            match self.device.poll(now_ms, &mut self.out) {
                Action::Sensor(SensorTask::Start) => {
                    self.device.complete_sensor(SensorAnswer::Started, now_ms);
                }
                Action::Sensor(SensorTask::Sample) => {
                    let conversion = self.passed_ms / self.period_ms;
                    let answer = if self.pace == Pace::EachConversion && conversion == self.conversion {
                        SensorAnswer::NotReady
                    } else {
                        SensorAnswer::Reading(self.reading())
                    };
                    self.conversion = conversion;
                    self.device.complete_sensor(answer, now_ms);
                }
                Action::Sensor(SensorTask::Temperature) => {
                    self.temperatures += 1;
                    self.device.complete_sensor(SensorAnswer::Temperature(Some(25.0)), now_ms);
                }
                Action::Store(task) => {
                    let answer: StoreAnswer = serve(&mut self.memory, &task);
                    self.device.complete_store(&answer, now_ms);
                }
                Action::Again => {}
                Action::Sleep => {
                    let sleep_ms = (self.device.next_deadline_ms() as u32).wrapping_sub(self.tick) as i32;
                    assert!(sleep_ms < 5000, "it sleeps for {sleep_ms} ms at tick {}", self.tick);
                    let next_ms = self.pushed_ms + self.period_ms;
                    let most_ms = match self.pace {
                        Pace::Pushed => next_ms.saturating_sub(self.passed_ms),
                        _ => 5000,
                    };
                    self.pass(u64::from(sleep_ms.max(1) as u32).min(most_ms.max(1)));
                }
            }
            self.said += &self.out;
            self.out.clear();
        }
    }

    fn command(&mut self, line: &str) -> String {
        self.said.clear();
        for byte in line.bytes().chain(*b"\n") {
            assert!(self.device.take_byte(byte));
        }
        while self.device.is_idle() || !self.said.contains("ok ") && !self.said.contains("err ") {
            self.run(1);
            if !self.said.is_empty() && self.device.is_idle() {
                break;
            }
        }
        std::mem::take(&mut self.said)
    }

    /// Milliseconds since the wrap.
    fn since_wrap_ms(&self) -> i64 {
        self.passed_ms as i64 - i64::from(BEFORE_MS)
    }
}

const PACES: [(Pace, f32); 3] =
    [(Pace::Every(20), 75.0), (Pace::EachConversion, 50.0), (Pace::Pushed, 100.0)];

#[test]
fn samples_go_on_across_the_wrap_at_every_pace() {
    for (pace, rate_hz) in PACES {
        let mut firmware = Firmware::new(pace, rate_hz, |_| [0.0; 3]);
        firmware.run(50_000);
        assert!(firmware.command("stream raw").contains("ok stream=raw"), "{pace:?}");
        let (samples, temperatures) = (firmware.samples, firmware.temperatures);
        firmware.said.clear();
        firmware.run(70_000);
        assert!(firmware.since_wrap_ms() >= 59_000);
        let taken = firmware.samples - samples;
        let expected = match pace {
            Pace::Pushed => 7000,
            _ => 3500,
        };
        assert!(taken.abs_diff(expected) <= 10, "{pace:?}: {taken}");
        assert_eq!((firmware.device.samples_lost(), firmware.device.sensor_fault()), (0, None), "{pace:?}");
        let temperatures = firmware.temperatures - temperatures;
        let asked = if pace == Pace::Pushed { 0..=0 } else { 250..=290 };
        assert!(asked.contains(&temperatures), "{pace:?}: {temperatures} temperatures");
        // The stream's time goes on, and never goes back.
        let times = firmware.said.lines().filter_map(|line| line.split(',').nth(1)?.parse::<u64>().ok());
        let times: Vec<u64> = times.collect();
        assert!(times.len() as u64 + 10 >= taken, "{pace:?}: {} lines", times.len());
        assert!(times.is_sorted() && times[times.len() - 1] > WRAP_MS + 59_000, "{pace:?}");
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] <= 40), "{pace:?}");
    }
}

#[test]
fn the_monitor_and_the_study_go_on_across_the_wrap() {
    for (pace, rate_hz) in PACES {
        // A jump ten seconds after the wrap.
        let step: fn(i64) -> [f64; 3] = |ms| if ms < 10_000 { [0.0; 3] } else { [3.0, -2.0, 2.5] };
        let mut firmware = Firmware::new(pace, rate_hz, step);
        firmware.run(69_000);
        let status = firmware.command("status");
        assert!(status.contains("monitor condition=good"), "{pace:?}: {status}");
        firmware.run(21_000);
        let status = firmware.command("status");
        assert!(status.contains("monitor condition=disturbed"), "{pace:?}: {status}");
        firmware.run(20_000);
        let why = firmware.command("why");
        assert!(why.contains("verdict=missing first=step"), "{pace:?}: {why}");
        let n: u64 = value(why.lines().next().unwrap(), "n").parse().unwrap();
        assert!(n > 4000, "{pace:?}: all of it was learned from: {n}");
        let Some(BuiltIn::Step(step)) = firmware.device.learner().effect(Candidate::Step) else {
            panic!("a step")
        };
        let at_ms = step.at_s * 1000.0 - WRAP_MS as f64;
        assert!((at_ms - 10_000.0).abs() < 1500.0, "{pace:?}: {at_ms} ms after the wrap");
    }
}

#[test]
fn every_timeout_runs_out_across_the_wrap() {
    for (pace, rate_hz) in PACES {
        let mut firmware = Firmware::new(pace, rate_hz, |_| [0.0; 3]);
        // A memory that does not answer until half a second after the wrap.
        firmware.memory.answers = false;
        firmware.run(u64::from(BEFORE_MS) - 10);
        assert!(firmware.device.calibration().is_none());
        // A button that bounces, and settles across the wrap.
        firmware.device.on_button_level(true, u64::from(firmware.tick));
        firmware.run(60);
        firmware.device.on_button_level(true, u64::from(firmware.tick));
        firmware.run(20);
        assert_eq!(firmware.device.take_event(), Some(ButtonEvent::Started), "{pace:?}");
        firmware.run(430);
        firmware.memory.answers = true;
        firmware.run(1100);
        assert!(firmware.device.calibration().is_some(), "{pace:?}: the store was asked again");
        // The lights go on.
        let mut changes = 0;
        let mut last = None;
        let end_ms = firmware.passed_ms + 2000;
        while firmware.passed_ms < end_ms {
            firmware.run(5);
            let is_on = firmware.device.shown(u64::from(firmware.tick)).is_on;
            changes += u32::from(last.is_some_and(|last| last != is_on));
            last = Some(is_on);
        }
        assert!((12..=18).contains(&changes), "{pace:?}: collecting blinks four times a second: {changes}");
    }
}

#[test]
fn a_clock_that_is_set_back_costs_no_more_than_a_sample() {
    let mut firmware = Firmware::new(Pace::Every(20), 75.0, |_| [0.0; 3]);
    // Microseconds of 32 bits over a thousand wrap after 71 minutes.
    firmware.tick = 4_294_967 - 30_000;
    for _ in 0..2 {
        firmware.run(30_000);
        firmware.tick = 0;
        let samples = firmware.samples;
        firmware.run(30_000);
        assert!((1499..=1501).contains(&(firmware.samples - samples)), "{}", firmware.samples - samples);
        firmware.tick = 4_294_967 - 30_000;
    }
    assert_eq!(firmware.device.sensor_fault(), None);
}
