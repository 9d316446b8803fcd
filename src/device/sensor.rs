//! Keeping the sensor going: when to read it, when to call it failed, when to try it again.

use core::fmt;

use crate::sensor::{Reading, Sensor};

/// Reads in a row that must fail before the sensor is configured afresh: a single lost transaction costs one
/// sample, not the configuration.
const FAILURES_IN_A_ROW: u8 = 3;
/// A chip that has been configured and shows nothing new for this many of its periods, and a second at least, has lost its
/// configuration.
const SILENT_PERIODS: u64 = 8;
const SHORTEST_SILENCE_MS: u64 = 1000;
/// The pause after a failed start, doubled each time up to the longest.
const FIRST_PAUSE_MS: u64 = 100;
const LONGEST_PAUSE_MS: u64 = 3200;

/// What is wrong with the sensor, as far as the board can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorFault {
    /// The bus failed, or nothing answered.
    NoAnswer,
    /// Another chip answered.
    WrongChip {
        /// The identification bytes of the right chip.
        expected: [u8; 3],
        /// Those that were read.
        found: [u8; 3],
    },
    /// The chip does not keep its configuration.
    NotKept,
    /// The chip answers and has had no new measurement for eight of its periods, and a second at least.
    Silent,
    /// The driver was configured for what the chip cannot do; the text says what.
    InvalidConfig(&'static str),
    /// It is not touched: the firmware has failed again and again, see [`Device::rest`](super::Device::rest).
    AtRest,
}

impl fmt::Display for SensorFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SensorFault::NoAnswer => {
                f.write_str("does not answer on the bus: check power, wiring and address")
            }
            SensorFault::WrongChip { expected, found } => {
                write!(f, "is another chip: identity {found:02x?} instead of {expected:02x?}")
            }
            SensorFault::NotKept => f.write_str("does not keep its configuration: check its supply voltage"),
            SensorFault::Silent => f.write_str("answers but measures nothing: check its supply"),
            SensorFault::InvalidConfig(what) => write!(f, "cannot be configured like this: {what}"),
            SensorFault::AtRest => {
                f.write_str("is not used after repeated faults of the firmware (see version): switch the power off and on")
            }
        }
    }
}

/// When samples are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// At this beat of the board's own clock, ms. For a chip that is always ready, or is asked less often than it measures.
    Every(u32),
    /// Each conversion once, as soon as it is ready: for a chip with a data-ready flag, asked from shortly before the end of its
    /// period on.
    EachConversion,
    /// The board reads the sensor by itself, in an interrupt of its data-ready line for example, and hands the readings over
    /// ([`Device::on_sample`](super::Device::on_sample)). The device only asks for the start.
    Pushed,
}

/// What the board has to do with its sensor now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorTask {
    /// Free the bus if it is stuck, then identify and configure the chip.
    Start,
    /// Ask for a measurement.
    Sample,
    /// Ask for the chip's temperature.
    Temperature,
}

/// What came of a [`SensorTask`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorAnswer {
    /// [`SensorTask::Start`] succeeded.
    Started,
    /// A measurement, in the chip's axes.
    Reading(Reading),
    /// No new measurement yet; it will be asked for again in a moment.
    NotReady,
    /// The chip's temperature, °C; `None` where it has none.
    Temperature(Option<f32>),
    /// It failed.
    Failed(SensorFault),
}

#[derive(Debug, Clone, Copy)]
enum State {
    Absent {
        fault: SensorFault,
        retry_at_ms: u64,
        pause_ms: u64,
    },
    /// `due_ms`: when a sample is due; `ask_ms`: when to ask for it, later where it was not ready.
    Working {
        due_ms: u64,
        ask_ms: u64,
        heard_ms: u64,
        /// Whether there was a sample at `heard_ms`, rather than the start.
        heard: bool,
        failures: u8,
    },
    AtRest,
}

/// The watch over one sensor.
#[derive(Debug, Clone)]
pub(super) struct SensorWatch {
    pace: Pace,
    /// Time between two conversions of the chip.
    conversion_ms: u64,
    state: State,
    faults: u32,
    lost: u32,
}

impl SensorWatch {
    /// A sensor that was not started yet.
    pub(super) fn new(pace: Pace, sensor: &Sensor) -> Self {
        let state = State::Absent { fault: SensorFault::NoAnswer, retry_at_ms: 0, pause_ms: FIRST_PAUSE_MS };
        Self { pace, conversion_ms: u64::from(sensor.period_ms()), state, faults: 0, lost: 0 }
    }

    /// A sensor that is never touched.
    pub(super) const fn rest(&mut self) {
        self.state = State::AtRest;
    }

    /// What is due at `t_ms`.
    pub(super) const fn task(&self, t_ms: u64) -> Option<SensorTask> {
        match self.state {
            State::Absent { retry_at_ms, .. } if t_ms >= retry_at_ms => Some(SensorTask::Start),
            State::Working { ask_ms, .. } if t_ms >= ask_ms && !matches!(self.pace, Pace::Pushed) => {
                Some(SensorTask::Sample)
            }
            _ => None,
        }
    }

    /// When something is due, or a silence is one.
    pub(super) fn deadline_ms(&self) -> u64 {
        match self.state {
            State::Absent { retry_at_ms, .. } => retry_at_ms,
            State::Working { heard_ms, .. } if self.pace == Pace::Pushed => heard_ms + self.silence_ms(),
            State::Working { ask_ms, .. } => ask_ms,
            State::AtRest => u64::MAX,
        }
    }

    fn silence_ms(&self) -> u64 {
        (SILENT_PERIODS * self.conversion_ms).max(SHORTEST_SILENCE_MS)
    }

    /// The time between two samples.
    fn period_ms(&self) -> u64 {
        match self.pace {
            Pace::Every(ms) => u64::from(ms.max(1)),
            Pace::EachConversion | Pace::Pushed => self.conversion_ms.max(1),
        }
    }

    /// How long it is until the next sample is due; `None` where none is waited for.
    pub(super) fn slack_ms(&self, t_ms: u64) -> Option<u64> {
        match self.state {
            State::Working { due_ms, .. } if self.pace != Pace::Pushed => Some(due_ms.saturating_sub(t_ms)),
            _ => None,
        }
    }

    /// What [`Self::slack_ms`] is right after a sample was taken on time: a long computation begins with three quarters of it
    /// at least. Of a slow sensor 100 ms are enough for any.
    pub(super) fn ample_slack_ms(&self) -> u64 {
        (self.period_ms() - self.period_ms() / 4).clamp(1, 100)
    }

    /// Nothing but the time has come.
    pub(super) fn time(&mut self, t_ms: u64) {
        if let State::Working { heard_ms, .. } = self.state
            && t_ms.saturating_sub(heard_ms) >= self.silence_ms()
        {
            self.lose(SensorFault::Silent, t_ms, FIRST_PAUSE_MS);
        }
    }

    /// A measurement came, asked for or not.
    pub(super) fn heard(&mut self, t_ms: u64) {
        let period_ms = self.period_ms();
        let before = match self.state {
            State::Working { due_ms, heard_ms, heard: true, .. } => Some((due_ms, heard_ms)),
            _ => None,
        };
        let (due_ms, lost) = match (self.pace, before) {
            // Keep the beat; where whole periods were missed, do not catch up.
            (Pace::Every(_), Some((due_ms, _))) => {
                let missed = t_ms.saturating_sub(due_ms) / period_ms;
                (due_ms.saturating_add((missed + 1) * period_ms), missed)
            }
            // The chip's clock is a few percent off, and a conversion is taken up to a turn of the loop late.
            (_, Some((_, heard_ms))) => {
                let periods = (t_ms.saturating_sub(heard_ms) + period_ms / 3) / period_ms;
                (t_ms + (period_ms - period_ms / 8).saturating_sub(1).max(1), periods.saturating_sub(1))
            }
            (_, None) => (t_ms.saturating_add(period_ms), 0),
        };
        self.lost = self.lost.saturating_add(u32::try_from(lost).unwrap_or(u32::MAX));
        self.state = State::Working { due_ms, ask_ms: due_ms, heard_ms: t_ms, heard: true, failures: 0 };
    }

    /// Takes note of what came of the task.
    pub(super) fn answered(&mut self, answer: SensorAnswer, t_ms: u64) {
        match (answer, self.state) {
            (_, State::AtRest) | (SensorAnswer::Temperature(_), _) => {}
            (SensorAnswer::Started, _) => {
                self.state =
                    State::Working { due_ms: t_ms, ask_ms: t_ms, heard_ms: t_ms, heard: false, failures: 0 };
            }
            (SensorAnswer::Reading(_), State::Working { .. }) => self.heard(t_ms),
            (SensorAnswer::NotReady, State::Working { due_ms, heard_ms, heard, failures, .. }) => {
                let ask_ms = t_ms + (self.conversion_ms / 16).max(1);
                self.state = State::Working { due_ms, ask_ms, heard_ms, heard, failures };
                self.time(t_ms);
            }
            (SensorAnswer::Failed(fault), State::Working { heard_ms, heard, failures, .. }) => {
                let failures = failures.saturating_add(1);
                if failures < FAILURES_IN_A_ROW {
                    self.faults = self.faults.saturating_add(1);
                    let due_ms = t_ms.saturating_add(self.period_ms());
                    self.state = State::Working { due_ms, ask_ms: due_ms, heard_ms, heard, failures };
                } else {
                    self.lose(fault, t_ms, FIRST_PAUSE_MS);
                }
            }
            (SensorAnswer::Failed(fault), State::Absent { pause_ms, .. }) => {
                self.lose(fault, t_ms, pause_ms.saturating_mul(2).min(LONGEST_PAUSE_MS));
            }
            // No answer to a start; it is asked for again after the pause.
            (SensorAnswer::Reading(_) | SensorAnswer::NotReady, State::Absent { fault, pause_ms, .. }) => {
                self.state = State::Absent { fault, retry_at_ms: t_ms.saturating_add(pause_ms), pause_ms };
            }
        }
    }

    fn lose(&mut self, fault: SensorFault, t_ms: u64, pause_ms: u64) {
        self.faults = self.faults.saturating_add(1);
        self.state = State::Absent { fault, retry_at_ms: t_ms.saturating_add(pause_ms), pause_ms };
    }

    /// Whether it works and is asked by the device, so that it may be asked for more than samples.
    pub(super) const fn asks(&self) -> bool {
        matches!(self.state, State::Working { heard: true, .. }) && !matches!(self.pace, Pace::Pushed)
    }

    /// What is wrong, if the sensor does not work.
    pub(super) const fn fault(&self) -> Option<SensorFault> {
        match self.state {
            State::Absent { fault, .. } => Some(fault),
            State::Working { .. } => None,
            State::AtRest => Some(SensorFault::AtRest),
        }
    }

    /// Transactions and starts that failed since power-up.
    pub(super) const fn faults(&self) -> u32 {
        self.faults
    }

    /// Samples that were due, or conversions that were made, and not taken, while the sensor worked.
    pub(super) const fn lost(&self) -> u32 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::{Pace, SensorAnswer, SensorFault, SensorTask, SensorWatch};
    use crate::sensor::{Reading, Sensor};

    const SAMPLE: SensorAnswer = SensorAnswer::Reading(Reading { counts: [1, 2, 3], overflow: [false; 3] });
    const FAILED: SensorAnswer = SensorAnswer::Failed(SensorFault::NoAnswer);

    fn watch(pace: Pace, rate_hz: f32) -> SensorWatch {
        SensorWatch::new(pace, &Sensor::uniform("chip", 0.1, rate_hz))
    }

    /// The times from `from_ms` to `to_ms` at which something was due, every task answered by `answer`.
    fn times(
        watch: &mut SensorWatch,
        from_ms: u64,
        to_ms: u64,
        mut answer: impl FnMut(u64) -> SensorAnswer,
    ) -> heapless::Vec<u64, 64> {
        let mut times = heapless::Vec::new();
        for t_ms in from_ms..to_ms {
            if watch.task(t_ms).is_some() {
                assert!(t_ms >= watch.deadline_ms());
                let _ = times.push(t_ms);
                watch.answered(answer(t_ms), t_ms);
            }
        }
        times
    }

    #[test]
    fn samples_keep_the_beat_and_do_not_catch_up_after_a_pause() {
        let mut watch = watch(Pace::Every(20), 75.0);
        watch.answered(SensorAnswer::Started, 5);
        assert_eq!(times(&mut watch, 5, 80, |_| SAMPLE), [5, 25, 45, 65]);
        // A turn of 35 ms: the sample due meanwhile is late, and none is lost.
        assert_eq!(times(&mut watch, 101, 150, |_| SAMPLE), [101, 105, 125, 145]);
        assert_eq!(watch.lost(), 0);
        assert_eq!(times(&mut watch, 300, 350, |_| SAMPLE), [300, 305, 325, 345]);
        assert_eq!((watch.faults(), watch.lost()), (0, 6));
    }

    #[test]
    fn each_conversion_is_taken_once_whatever_the_rate() {
        for rate_hz in [0.75, 1.5, 7.5, 15.0, 75.0, 200.0] {
            let mut watch = watch(Pace::EachConversion, rate_hz);
            watch.answered(SensorAnswer::Started, 0);
            // A chip whose clock is 3 % fast.
            let period_ms = 1000.0 / (1.03 * f64::from(rate_hz));
            let (mut taken, mut asked) = (0, 0);
            let end_ms = 40_000;
            for t_ms in 0..end_ms {
                if watch.task(t_ms).is_none() {
                    continue;
                }
                asked += 1;
                let conversions = (t_ms as f64 / period_ms) as u64;
                let answer = if conversions > taken { SAMPLE } else { SensorAnswer::NotReady };
                if answer == SAMPLE {
                    assert_eq!(conversions, taken + 1, "{rate_hz} Hz: one was missed at {t_ms}");
                    taken = conversions;
                }
                watch.answered(answer, t_ms);
            }
            assert_eq!((watch.fault(), watch.faults(), watch.lost()), (None, 0, 0), "{rate_hz} Hz");
            assert!(taken >= (end_ms as f64 / period_ms) as u64 - 1, "{rate_hz} Hz: {taken}");
            assert!(asked <= 6 * taken + 20, "{rate_hz} Hz: {asked} questions for {taken} conversions");
        }
    }

    #[test]
    fn a_conversion_that_nobody_took_is_counted() {
        let mut watch = watch(Pace::EachConversion, 50.0);
        watch.answered(SensorAnswer::Started, 0);
        for t_ms in [20, 40, 59, 81, 141, 160] {
            watch.answered(SAMPLE, t_ms);
        }
        assert_eq!(watch.lost(), 2);
    }

    #[test]
    fn a_single_failure_costs_a_sample_and_three_in_a_row_a_restart() {
        let mut watch = watch(Pace::Every(20), 75.0);
        watch.answered(SensorAnswer::Started, 0);
        watch.answered(FAILED, 0);
        watch.answered(FAILED, 20);
        assert_eq!(watch.fault(), None);
        watch.answered(SAMPLE, 40);
        for t_ms in [60, 80] {
            watch.answered(FAILED, t_ms);
            assert_eq!(watch.fault(), None);
        }
        watch.answered(FAILED, 100);
        assert_eq!(watch.fault(), Some(SensorFault::NoAnswer));
        assert_eq!(watch.faults(), 5);
        assert_eq!(watch.task(199), None);
        assert_eq!(watch.task(200), Some(SensorTask::Start));
    }

    #[test]
    fn an_absent_sensor_is_tried_with_growing_pauses_for_ever() {
        let mut watch = watch(Pace::Every(20), 75.0);
        assert_eq!(times(&mut watch, 0, 12_000, |_| FAILED), [0, 200, 600, 1400, 3000, 6200, 9400]);
        watch.answered(SensorAnswer::Started, 12_600);
        assert_eq!(watch.fault(), None);
        assert_eq!(watch.task(12_600), Some(SensorTask::Sample));
    }

    #[test]
    fn silence_is_eight_periods_of_the_sensor_and_a_second_at_least() {
        for (rate_hz, silent_ms) in [(75.0, 1000), (0.75, 8 * 1333)] {
            let mut watch = watch(Pace::EachConversion, rate_hz);
            watch.answered(SensorAnswer::Started, 0);
            watch.answered(SAMPLE, 0);
            watch.answered(SensorAnswer::NotReady, silent_ms - 1);
            assert_eq!(watch.fault(), None);
            watch.answered(SensorAnswer::NotReady, silent_ms);
            assert_eq!(watch.fault(), Some(SensorFault::Silent));
        }
    }

    #[test]
    fn a_sensor_that_is_read_elsewhere_works_as_soon_as_it_is_heard_of() {
        let mut watch = watch(Pace::Pushed, 75.0);
        assert_eq!(watch.task(0), Some(SensorTask::Start));
        watch.heard(3);
        assert_eq!((watch.fault(), watch.task(500)), (None, None));
        watch.time(watch.deadline_ms() - 1);
        assert_eq!(watch.fault(), None);
        watch.time(watch.deadline_ms());
        assert_eq!(watch.fault(), Some(SensorFault::Silent));
        assert_eq!(watch.task(1103), Some(SensorTask::Start));
    }

    #[test]
    fn a_sensor_at_rest_is_never_touched() {
        let mut watch = watch(Pace::EachConversion, 75.0);
        watch.rest();
        watch.answered(SensorAnswer::Started, 10);
        assert_eq!((watch.task(100_000), watch.fault()), (None, Some(SensorFault::AtRest)));
    }
}
