//! The study of a board that stays on: what begins today is named, whatever was before it.
//!
//! `IRONOUT_STUDY_DAYS=365` makes the clean time before it a year (some ten minutes of a host).

extern crate std;

use super::memory::Memory;
use super::*;
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, ColumnName};
use crate::extended::ExtendedCalibration;
use crate::math;
use core::f64::consts::TAU;

/// Normal numbers, mean zero and variance one: drawn from 4096.
struct Noise {
    numbers: std::vec::Vec<f32>,
    state: u64,
}

impl Noise {
    fn new(seed: u64) -> Self {
        let mut noise = Self { numbers: std::vec::Vec::new(), state: seed };
        let mut numbers: std::vec::Vec<f32> = (0..4096)
            .map(|_| (0..12).map(|_| (noise.bits() >> 11) as f32 / (1u64 << 53) as f32 - 0.5).sum())
            .collect();
        let mean = numbers.iter().sum::<f32>() / 4096.0;
        let rms = math::sqrtf(numbers.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / 4096.0);
        numbers.iter_mut().for_each(|x| *x = (*x - mean) / rms);
        noise.numbers = numbers;
        noise
    }

    fn bits(&mut self) -> u64 {
        self.state =
            self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.state
    }

    fn next(&mut self) -> [f32; 3] {
        let bits = self.bits();
        [28, 40, 52].map(|shift| self.numbers[(bits >> shift) as usize & 4095])
    }
}

const NOISE_UT: f32 = 0.3;
const HZ: u64 = 50;
const HOUR: u64 = 3600 * HZ;
const OFFSET_UT: [f64; 3] = [20.0, -8.0, 3.0];
/// 0.1 µT/°C.
const PER_DEGREE_UT: [f64; 3] = [0.06, -0.06, 0.053];

/// A board that is turned, and the temperature that it measures.
struct Board {
    learner: Learner,
    noise: Noise,
    samples: u64,
    temp_c: fn(f64) -> f64,
}

impl Board {
    fn new(seed: u64, temp_c: fn(f64) -> f64) -> Self {
        let mut learner = Learner::new();
        learner.begin(&base());
        Self { learner, noise: Noise::new(seed), samples: 0, temp_c }
    }

    fn hours(&self) -> f64 {
        self.samples as f64 / HOUR as f64
    }

    /// Goes on for so long, with a disturbance, µT, that goes by hours and °C.
    fn run(&mut self, hours: f64, disturbance: impl Fn(f64, f64) -> [f64; 3]) {
        let name = ColumnName::new("temp_c").expect("a name");
        for _ in 0..(hours * HOUR as f64) as u64 {
            let hours = self.hours();
            // A sensor's steps.
            let temp_c = math::round((self.temp_c)(hours) * 8.0) / 8.0;
            if self.samples.is_multiple_of(HZ / 4) {
                assert_eq!(self.learner.feed(&name, temp_c as f32), Fed::Tested);
            }
            let t_s = self.samples as f64 / HZ as f64;
            let (turn, tilt) = (0.85 * t_s, 1.5 * math::sin(0.305 * t_s));
            let field =
                [math::cos(tilt) * math::cos(turn), math::cos(tilt) * math::sin(turn), math::sin(tilt)];
            let (noise, more) = (self.noise.next(), disturbance(hours, temp_c));
            let measured = core::array::from_fn(|axis| {
                (50.0 * field[axis] + OFFSET_UT[axis] + more[axis]) as f32 + NOISE_UT * noise[axis]
            });
            self.learner.push(measured, 1000 / HZ * self.samples, &Motion::UNKNOWN);
            self.samples += 1;
        }
    }

    fn ask(&mut self) -> Outcome {
        self.learner.settle();
        let mut inquiry = Inquiry::new(&self.learner, InUse::default());
        loop {
            if let Some(outcome) = inquiry.step(&self.learner) {
                return outcome;
            }
        }
    }

    /// Runs without a disturbance; nothing is missing then, and all is noise.
    fn clean(&mut self, hours: f64) {
        self.run(hours, |_, _| [0.0; 3]);
        if hours > 0.0 {
            let outcome = self.ask();
            assert_eq!(outcome.verdict, Verdict::Complete, "after {:.1} h: {outcome:?}", self.hours());
            for ut in [outcome.floor_ut, outcome.rms_ut] {
                assert!((ut - NOISE_UT).abs() < 0.005, "after {:.1} h: {outcome:?}", self.hours());
            }
        }
    }
}

fn base() -> Calibration<f64> {
    Calibration { offset_ut: OFFSET_UT, ..Calibration::identity(50.0) }
}

/// A room that is heated, three quarters of an hour a time, in a day.
fn heated(hours: f64) -> f64 {
    25.0 + 3.0 * math::sin(TAU * hours / 0.75) + 4.0 * math::sin(TAU * hours / 24.0)
}

/// A board whose load comes and goes.
fn loaded(hours: f64) -> f64 {
    let phase = 2.0 * hours - math::floor(2.0 * hours);
    31.0 + if phase < 0.5 {
        8.0 - 8.0 * math::exp(-20.0 * phase)
    } else {
        8.0 * math::exp(-20.0 * (phase - 0.5))
    }
}

/// Hours without an effect, before it begins.
fn clean_hours() -> std::vec::Vec<f64> {
    let days = std::env::var("IRONOUT_STUDY_DAYS").ok().and_then(|days| days.parse::<f64>().ok());
    [0.0, 1.0, 24.0].into_iter().chain(days.map(|days| 24.0 * days)).collect()
}

#[test]
fn an_effect_that_begins_today_is_named_within_the_hour_however_long_the_board_has_been_on() {
    for (seed, temp_c) in [(1, heated as fn(f64) -> f64), (2, loaded)] {
        for clean_hours in clean_hours().into_iter().filter(|hours| seed == 1 || *hours <= 1.0) {
            let mut board = Board::new(seed, temp_c);
            board.clean(clean_hours);
            // Above 25 °C or so, a moment that stands out by nothing else.
            board.run(1.0, |_, temp_c| PER_DEGREE_UT.map(|per_degree| per_degree * (temp_c - 25.0)));
            let outcome = board.ask();
            let (first, finding) = outcome.ranked().next().expect("candidates");
            let what = std::format!("{seed}, {clean_hours} h before: {outcome:?}");
            assert_eq!((first, finding.status), (Candidate::Column(0), Status::Missing), "{what}");
            assert_eq!(outcome.verdict, Verdict::Missing, "{what}");
            assert_ne!(outcome.of(Candidate::Step).status, Status::Missing, "{what}");

            let with = board.learner.add(first, &ExtendedCalibration::plain(base())).expect("it is shown");
            let fitted = with.effects.iter().next().expect("an effect");
            for axis in 0..3 {
                let error = math::abs(fitted.coefficients[axis] - PER_DEGREE_UT[axis]);
                assert!(error < 5.0 * fitted.std_errors[axis], "{what}: {fitted:?}");
                assert!(fitted.std_errors[axis] < 0.003, "{what}: {fitted:?}");
                // Base and reference together are the truth, too.
                let BuiltIn::Offset(offset) = fitted.effect else { panic!("{fitted:?}") };
                let at_reference = PER_DEGREE_UT[axis] * (offset.reference - 25.0);
                let error = math::abs(with.base.offset_ut[axis] - OFFSET_UT[axis] - at_reference);
                assert!(error < 0.02, "{what}: {with:?}");
            }
        }
    }
}

#[test]
fn a_jump_and_a_drift_of_today_are_named_after_half_a_day_without_one() {
    let step: fn(f64, f64) -> [f64; 3] = |hours, _| if hours < 12.4 { [0.0; 3] } else { [0.8, -0.6, 0.5] };
    let drift: fn(f64, f64) -> [f64; 3] =
        |hours, _| [0.9, 0.7, -0.8].map(|slope| slope * (hours - 12.0).max(0.0));
    for (expected, disturbance) in [(Candidate::Step, step), (Candidate::Drift, drift)] {
        let mut board = Board::new(7, |hours| 25.0 + math::sin(TAU * hours / 0.3));
        board.clean(12.0);
        board.run(1.0, disturbance);
        let outcome = board.ask();
        let (first, finding) = outcome.ranked().next().expect("candidates");
        assert_eq!((first, finding.status), (expected, Status::Missing), "{outcome:?}");
        match board.learner.effect(expected) {
            Some(BuiltIn::Step(step)) => assert!(math::abs(step.at_s - 12.4 * 3600.0) < 60.0, "{step:?}"),
            Some(BuiltIn::Drift(drift)) => {
                assert!((11.9..13.0).contains(&(drift.reference_s / 3600.0)), "{drift:?}")
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Three weeks of differences at 50 samples a second: single precision adds nothing to a sum as large as that of four days.
#[test]
fn the_noise_of_three_weeks_is_as_large_as_that_of_an_hour() {
    let (mut memory, mut noise) = (Memory::new(), Noise::new(3));
    let mut floor_after = |samples: u64| {
        for _ in 0..samples / 3 {
            noise.next().iter().for_each(|residual| memory.push(0.006 * residual));
        }
        memory.floor(f64::from(0.006f32 * 0.006))
    };
    let (hour, weeks) = (floor_after(HOUR), floor_after(504 * HOUR));
    assert!((hour / 0.006 - 1.0).abs() < 0.01, "{hour}");
    assert!((weeks / 0.006 - 1.0).abs() < 0.01, "{weeks}");
}
