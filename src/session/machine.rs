//! The state machine.

use super::collector::{Collector, Stopped};
use super::config::SessionConfig;
use super::status::{Counts, Hint, Outcome, State, StateError, Status};
#[cfg(feature = "methods")]
use crate::fit::Method;
use crate::fit::{FitError, FitReport};
#[cfg(feature = "device")]
use crate::level::{Forces, LevelFit, LevelPrior, NotLevel};
use crate::record::Record;
use crate::sensor::Sample;

/// Where a session stands, and what it knows there.
#[derive(Clone, Debug)]
// The difference is what a session that collects needs; there is nowhere else to keep it.
#[allow(clippy::large_enum_variant)]
enum Stage {
    Idle,
    Collecting(Collector),
    Stopped(Stopped),
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct Session {
    config: SessionConfig,
    stage: Stage,
}

/// Where it stands: its sums are more than a line of a log.
#[cfg(feature = "defmt")]
impl defmt::Format for Session {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Session {}", self.state());
    }
}

const _: () = assert!(core::mem::size_of::<Session>() <= 1600, "the session's memory is a promise");

impl Session {
    /// An idle session.
    pub fn new(config: SessionConfig) -> Self {
        Self { config, stage: Stage::Idle }
    }

    /// The configuration.
    pub fn config(&self) -> &SessionConfig {
        &self.config
    }

    /// Changes the method of the next solve.
    #[cfg(feature = "methods")]
    pub fn set_method(&mut self, method: Method) {
        self.config.method = method;
    }

    /// Changes the expected magnitude; `false`, and nothing changed, unless it is positive and finite or `None`.
    pub fn set_field_ut(&mut self, field_ut: Option<f64>) -> bool {
        let sound = field_ut.is_none_or(|v| v.is_finite() && v > 0.0);
        if sound {
            self.config.field_ut = field_ut;
        }
        sound
    }

    /// Where the session stands.
    pub fn state(&self) -> State {
        match &self.stage {
            Stage::Idle => State::Idle,
            Stage::Collecting(_) => State::Collecting,
            Stage::Stopped(stopped) if stopped.outcome.verdict.accepted => State::Solved,
            Stage::Stopped(_) => State::Refused,
        }
    }

    /// Starts collecting, from nothing. Whatever was collected or solved before is forgotten.
    pub fn start(&mut self) {
        self.stage = Stage::Collecting(Collector::new(&self.config));
    }

    /// Gives up; idle again.
    pub fn cancel(&mut self) {
        self.stage = Stage::Idle;
    }

    /// Takes one sample, in any state: outside of `Collecting` it is left alone. A sample out of range, or at the
    /// ends of the 16-bit range, is counted but not used.
    pub fn push(&mut self, sample: Sample) {
        if let Stage::Collecting(collector) = &mut self.stage {
            collector.push(sample);
        }
    }

    /// Takes one sample in µT, as [`SessionConfig::sample`] rounds it to counts.
    ///
    /// ```
    /// use ironout::session::{Session, SessionConfig};
    ///
    /// // 0.05 µT a count: ±1638 µT fit. 100 samples a second.
    /// let mut session = Session::new(SessionConfig::scaled([0.05; 3], 100.0));
    /// session.start();
    /// session.push_ut([21.3, -4.7, 40.2]);
    /// session.push_ut([f32::NAN, -4.7, 40.2]);
    /// assert_eq!(session.counts().saturated, 1);
    /// ```
    pub fn push_ut(&mut self, measured_ut: [f32; 3]) {
        self.push(self.config.sample(measured_ut));
    }

    /// Samples are missing before the next one: it is not taken for the neighbour of the last.
    pub fn interrupt(&mut self) {
        if let Stage::Collecting(collector) = &mut self.stage {
            collector.interrupt();
        }
    }

    /// The fit of the samples in motion so far; it changes nothing. `None` unless collecting.
    ///
    /// # Errors
    /// In the `Some`, the [`FitError`] that [`Self::stop`] would refuse with.
    pub fn fit_so_far(&self) -> Option<Result<FitReport, FitError>> {
        match &self.stage {
            Stage::Collecting(collector) => Some(collector.fit(&self.config)),
            _ => None,
        }
    }

    /// The same without the lower orders, in less than half of the time.
    pub(crate) fn ellipsoid_so_far(&self) -> Option<Result<FitReport, FitError>> {
        match &self.stage {
            Stage::Collecting(collector) => Some(collector.ellipsoid(&self.config)),
            _ => None,
        }
    }

    /// The fit for level headings of the samples so far; `None` unless collecting.
    #[cfg(feature = "device")]
    pub(crate) fn level_so_far(
        &self,
        prior: &LevelPrior,
        forces: &Forces,
    ) -> Option<Result<LevelFit, NotLevel>> {
        match &self.stage {
            Stage::Collecting(collector) => Some(collector.level(&self.config, prior, forces)),
            _ => None,
        }
    }

    /// Solves for the calibration and judges it.
    ///
    /// # Errors
    /// [`StateError`] unless collecting.
    #[inline(never)]
    pub fn stop(&mut self) -> Result<&Outcome, StateError> {
        let error = StateError { state: self.state() };
        let Stage::Collecting(collector) = &mut self.stage else { return Err(error) };
        self.stage = Stage::Stopped(collector.stop(&self.config));
        self.outcome().ok_or(error)
    }

    /// The outcome of the last [`Self::stop`], until the next start or cancel.
    pub fn outcome(&self) -> Option<&Outcome> {
        match &self.stage {
            Stage::Stopped(stopped) => Some(&stopped.outcome),
            _ => None,
        }
    }

    /// The accepted solution that waits for [`Self::accept`].
    pub fn solution(&self) -> Option<&FitReport> {
        self.outcome().filter(|o| o.verdict.accepted).and_then(|o| o.report.as_ref())
    }

    /// Hands the solution over, as it is stored; idle again.
    ///
    /// # Errors
    /// [`StateError`] unless solved.
    #[inline(never)]
    pub fn accept(&mut self) -> Result<Record, StateError> {
        let mut record = self.solution().map(Record::of).ok_or(StateError { state: self.state() })?;
        record.axes = self.config.axes;
        self.cancel();
        Ok(record)
    }

    /// What was taken so far, without a solve.
    pub fn counts(&self) -> Counts {
        match &self.stage {
            Stage::Idle => Counts::default(),
            Stage::Collecting(collector) => collector.counts(),
            Stage::Stopped(stopped) => stopped.counts,
        }
    }

    /// A snapshot; while collecting it solves the data so far to tell what they carry.
    #[inline(never)]
    pub fn status(&self) -> Status {
        match &self.stage {
            Stage::Idle => Status::of(State::Idle, None),
            Stage::Collecting(collector) => collector.status(&self.config),
            Stage::Stopped(stopped) => {
                let Outcome { verdict, report, coverage } = &stopped.outcome;
                let (state, hint) = if verdict.accepted {
                    (State::Solved, Hint::Accept)
                } else {
                    (State::Refused, Hint::Again)
                };
                Status {
                    counts: stopped.counts,
                    coverage: coverage.fraction,
                    gap_deg: coverage.gap_deg,
                    seen: coverage.seen,
                    hint,
                    ..Status::of(state, report.as_ref())
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math;
    use crate::sensor::{Axis, AxisMap, Sensor};

    fn collecting() -> Session {
        let mut session = Session::new(SessionConfig {
            ut_per_count: [0.05; 3],
            field_ut: Some(50.0),
            #[cfg(feature = "methods")]
            method: Method::Adjusted,
            samples_per_block: 16,
            axes: None,
        });
        session.start();
        session
    }

    /// Seeded noise of variance one, correlated from sample to sample by `rho`.
    struct Noise {
        state: u64,
        rho: f64,
        last: [f64; 3],
    }

    impl Noise {
        fn next(&mut self) -> [f64; 3] {
            for axis in 0..3 {
                let mut sum = -6.0;
                for _ in 0..12 {
                    self.state = self
                        .state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    sum += (self.state >> 33) as f64 / f64::from(1u32 << 31);
                }
                self.last[axis] = self.rho * self.last[axis] + math::sqrt(1.0 - self.rho * self.rho) * sum;
            }
            self.last
        }
    }

    /// Directions all over the sphere, a radian a second at 50 Hz.
    fn smooth(i: u32) -> [f64; 3] {
        let (turn, z) = (0.02 * f64::from(i), math::sin(0.0037 * f64::from(i)));
        let r = math::sqrt(1.0 - z * z);
        [r * math::cos(turn), r * math::sin(turn), z]
    }

    #[test]
    fn samples_in_microtesla_are_those_in_counts_and_what_16_bits_do_not_hold_is_out_of_range() {
        let (mut in_ut, mut in_counts) = (collecting(), collecting());
        for i in 0..400 {
            let field_ut = smooth(i).map(|part| (50.0 * part) as f32);
            in_ut.push_ut(field_ut);
            let counts = field_ut.map(|ut| math::round(f64::from(ut) / 0.05) as i16);
            in_counts.push(Sample::valid(counts));
        }
        assert_eq!((in_ut.counts(), in_ut.status()), (in_counts.counts(), in_counts.status()));
        assert_eq!(in_ut.counts().saturated, 0);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1638.4, -1638.4] {
            in_ut.push_ut([1.0, bad, 2.0]);
        }
        assert_eq!(in_ut.counts().saturated, 5);
        in_ut.push_ut([1.0, 1638.3, 2.0]);
        assert_eq!(in_ut.counts().saturated, 5);
    }

    #[test]
    fn no_hint_of_the_session_names_a_command_of_the_console() {
        for hint in [Hint::Start, Hint::Move, Hint::Stop, Hint::Accept, Hint::Again] {
            let words = std::string::ToString::to_string(&hint);
            assert!(!words.contains("cal ") && !words.contains(" with"), "{words}");
        }
    }

    #[test]
    fn correlated_noise_counts_as_fewer_samples_and_widens_the_error() {
        let outcome = |rho: f64| {
            let mut noise = Noise { state: 3, rho, last: [0.0; 3] };
            let mut session = collecting();
            for i in 0..2000 {
                let (u, w) = (smooth(i), noise.next());
                let counts = [0, 1, 2].map(|a| math::round(1000.0 * u[a] + 10.0 * w[a] + 300.0) as i16);
                session.push(Sample::valid(counts));
            }
            let report = session.stop().ok().and_then(|o| o.report.clone());
            report.map_or((0.0, 0.0), |r| (r.effective_samples / r.samples as f64, r.predicted_error_ut))
        };
        let ((white, white_ut), (slow, slow_ut)) = (outcome(0.0), outcome(0.9));
        assert!(white > 0.7 && white_ut > 0.0, "white noise: {white}");
        // (1 − ρ)/(1 + ρ) = 0.053, and the error grows by the root of its inverse: 4.4.
        assert!((0.02..0.2).contains(&slow), "correlated noise: {slow}");
        assert!((2.2..7.0).contains(&(slow_ut / white_ut)), "{white_ut} uT, {slow_ut} uT");
    }

    #[test]
    fn the_hint_and_the_refusal_name_the_side_that_the_field_has_not_passed() {
        let cases = [
            ([1.0, 0.0, 0.0], "back", "front"),
            ([-1.0, 0.0, 0.0], "front", "back"),
            ([0.0, 1.0, 0.0], "left", "right"),
            ([0.0, -1.0, 0.0], "right", "left"),
            ([0.0, 0.0, 1.0], "top", "bottom"),
            ([0.0, 0.0, -1.0], "bottom", "top"),
        ];
        for (axis, missing, passed) in cases {
            let mut noise = Noise { state: 11, rho: 0.0, last: [0.0; 3] };
            let mut session = collecting();
            assert_eq!(session.status().hint, Hint::Move);
            for i in 0..6000 {
                let u = smooth(i);
                if (0..3).map(|a| u[a] * axis[a]).sum::<f64>() < 0.6 {
                    continue;
                }
                let w = noise.next();
                let counts = [0, 1, 2].map(|a| math::round(1000.0 * u[a] + 30.0 * w[a] - 700.0) as i16);
                session.push(Sample::valid(counts));
            }
            session.push(Sample::valid(axis.map(|v| (1000.0 * v) as i16 - 700)));
            // Whether the fit knows the centre by now or not.
            let Hint::Turn { missing: side, now } = session.status().hint else {
                panic!("{missing}: {:?}", session.status().hint)
            };
            assert!(side.split('-').any(|word| word == missing), "{missing}: the hint says {side}");
            assert!(now.split('-').any(|word| word == passed), "{passed}: the field comes through {now}");
            let outcome = session.stop().expect("it collects");
            let missing_side = outcome.coverage.missing_side();
            assert!(
                missing_side.split('-').any(|word| word == missing),
                "{missing}: the outcome says {missing_side}"
            );
        }
    }

    #[test]
    fn a_record_says_how_the_sensor_was_mounted() {
        let turned = AxisMap::new([Axis::Y, Axis::MinusX, Axis::Z]).expect("a rotation");
        let sensor = Sensor::uniform("a chip", 0.05, 50.0).mounted(turned);
        let mut session = Session::new(SessionConfig::of(&sensor));
        session.start();
        for i in 0..3000 {
            session.push(Sample::valid(smooth(i).map(|u| math::round(1000.0 * u + 300.0) as i16)));
        }
        assert!(session.stop().is_ok_and(|outcome| outcome.verdict.accepted));
        assert_eq!(session.accept().map(|record| record.axes), Ok(Some(turned)));
    }

    #[test]
    fn each_sample_is_in_the_sums_held_or_counted_as_left_out() {
        let mut session = collecting();
        let mut pushed = 0;
        for i in 0..3000u32 {
            let u = smooth(if i % 1000 < 600 { i } else { i / 1000 * 1000 + 600 });
            let repeated = u32::from(i % 40 == 7) + 1;
            for _ in 0..repeated {
                pushed += 1;
                let counts = [0, 1, 2].map(|a| (1000.0 * u[a]) as i16 + (i % 3) as i16);
                let sample = if i % 500 == 9 { Sample::out_of_range } else { Sample::valid };
                session.push(sample(counts));
            }
        }
        let status = session.status();
        let Counts { n, skipped, saturated } = status.counts;
        assert_eq!(n + skipped, pushed, "{status:?}");
        assert!(saturated == 6 && skipped > 900, "{status:?}");
        session.stop().expect("it collects");
        let stopped = session.status().counts;
        assert_eq!(stopped.n + stopped.skipped, n + skipped);
        assert_eq!(stopped.saturated, saturated);
        assert!(session.stop().is_err() && session.fit_so_far().is_none());
    }
}
