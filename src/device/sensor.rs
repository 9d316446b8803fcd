//! Keeping the sensor going: when to read it, when to call it failed, when to try it again.

use core::fmt;

/// Reads in a row that must fail before the sensor is configured afresh: a single lost transaction costs one
/// sample, not the configuration.
const FAILURES_IN_A_ROW: u8 = 3;
/// A chip that has been configured and shows nothing new for this long has lost its configuration.
const SILENCE_MS: u64 = 1000;
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
    /// The chip answers and has no new measurement for a second.
    Silent,
}

impl fmt::Display for SensorFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SensorFault::NoAnswer => {
                f.write_str("does not answer on the bus: check power, wiring and address")
            }
            SensorFault::WrongChip { expected, found } => {
                write!(f, "is another chip: identity {found:02x?} where {expected:02x?} is expected")
            }
            SensorFault::NotKept => f.write_str("does not keep its configuration: check its supply"),
            SensorFault::Silent => f.write_str("answers but measures nothing: check its supply"),
        }
    }
}

/// What the board has to do with its sensor now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorTask {
    /// Free the bus if it is stuck, then identify and configure the chip.
    Start,
    /// Ask for a measurement.
    Sample,
}

/// What came of a [`SensorTask`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorAnswer {
    /// [`SensorTask::Start`] succeeded.
    Started,
    /// A measurement.
    Sample {
        /// x, y, z.
        counts: [i16; 3],
        /// An axis was out of range.
        saturated: bool,
    },
    /// No new measurement yet; it will be asked for again at once.
    NotReady,
    /// It failed.
    Failed(SensorFault),
}

#[derive(Debug, Clone, Copy)]
enum State {
    Absent { fault: SensorFault, retry_at_ms: u64, pause_ms: u64 },
    Working { next_ms: u64, heard_ms: u64, failures: u8 },
}

/// The watch over one sensor.
#[derive(Debug, Clone)]
pub(super) struct SensorWatch {
    period_ms: u64,
    state: State,
    faults: u32,
}

impl SensorWatch {
    /// A sensor that was not started yet.
    pub(super) const fn new(period_ms: u32) -> Self {
        let state = State::Absent { fault: SensorFault::NoAnswer, retry_at_ms: 0, pause_ms: FIRST_PAUSE_MS };
        Self { period_ms: if period_ms == 0 { 1 } else { period_ms as u64 }, state, faults: 0 }
    }

    /// What is due at `t_ms`.
    pub(super) const fn task(&self, t_ms: u64) -> Option<SensorTask> {
        match self.state {
            State::Absent { retry_at_ms, .. } if t_ms >= retry_at_ms => Some(SensorTask::Start),
            State::Working { next_ms, .. } if t_ms >= next_ms => Some(SensorTask::Sample),
            _ => None,
        }
    }

    /// Takes note of what came of the task.
    pub(super) fn answered(&mut self, answer: SensorAnswer, t_ms: u64) {
        match (answer, self.state) {
            (SensorAnswer::Started, _) => {
                self.state = State::Working { next_ms: t_ms, heard_ms: t_ms, failures: 0 };
            }
            (SensorAnswer::Sample { .. }, State::Working { next_ms, .. }) => {
                // Keep the beat; where whole periods were missed (a solve took long), do not catch up.
                let due_ms = next_ms.saturating_add(self.period_ms);
                let next_ms = if due_ms > t_ms { due_ms } else { t_ms.saturating_add(self.period_ms) };
                self.state = State::Working { next_ms, heard_ms: t_ms, failures: 0 };
            }
            (SensorAnswer::NotReady, State::Working { heard_ms, .. }) => {
                if t_ms.saturating_sub(heard_ms) >= SILENCE_MS {
                    self.lose(SensorFault::Silent, t_ms, FIRST_PAUSE_MS);
                }
            }
            (SensorAnswer::Failed(fault), State::Working { heard_ms, failures, .. }) => {
                let failures = failures.saturating_add(1);
                if failures < FAILURES_IN_A_ROW {
                    self.faults = self.faults.saturating_add(1);
                    let next_ms = t_ms.saturating_add(self.period_ms);
                    self.state = State::Working { next_ms, heard_ms, failures };
                } else {
                    self.lose(fault, t_ms, FIRST_PAUSE_MS);
                }
            }
            (SensorAnswer::Failed(fault), State::Absent { pause_ms, .. }) => {
                self.lose(fault, t_ms, pause_ms.saturating_mul(2).min(LONGEST_PAUSE_MS));
            }
            (SensorAnswer::Sample { .. } | SensorAnswer::NotReady, State::Absent { .. }) => {}
        }
    }

    fn lose(&mut self, fault: SensorFault, t_ms: u64, pause_ms: u64) {
        self.faults = self.faults.saturating_add(1);
        self.state = State::Absent { fault, retry_at_ms: t_ms.saturating_add(pause_ms), pause_ms };
    }

    /// What is wrong, if the sensor does not work.
    pub(super) const fn fault(&self) -> Option<SensorFault> {
        match self.state {
            State::Absent { fault, .. } => Some(fault),
            State::Working { .. } => None,
        }
    }

    /// Transactions and starts that failed since power-up.
    pub(super) const fn faults(&self) -> u32 {
        self.faults
    }
}

#[cfg(test)]
mod tests {
    use super::{SensorAnswer, SensorFault, SensorTask, SensorWatch};

    const SAMPLE: SensorAnswer = SensorAnswer::Sample { counts: [1, 2, 3], saturated: false };
    const FAILED: SensorAnswer = SensorAnswer::Failed(SensorFault::NoAnswer);

    /// The times within `to_ms` at which `task` was due, every task answered by `answer`.
    fn times(
        watch: &mut SensorWatch,
        from_ms: u64,
        to_ms: u64,
        answer: SensorAnswer,
    ) -> heapless::Vec<u64, 64> {
        let mut times = heapless::Vec::new();
        for t_ms in from_ms..to_ms {
            if watch.task(t_ms).is_some() {
                let _ = times.push(t_ms);
                watch.answered(answer, t_ms);
            }
        }
        times
    }

    #[test]
    fn samples_keep_the_beat_and_do_not_catch_up_after_a_pause() {
        let mut watch = SensorWatch::new(20);
        watch.answered(SensorAnswer::Started, 5);
        assert_eq!(times(&mut watch, 5, 80, SAMPLE), [5, 25, 45, 65]);
        assert_eq!(times(&mut watch, 300, 350, SAMPLE), [300, 320, 340]);
        assert_eq!(watch.faults(), 0);
    }

    #[test]
    fn a_single_failure_costs_a_sample_and_three_in_a_row_a_restart() {
        let mut watch = SensorWatch::new(20);
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
        let mut watch = SensorWatch::new(20);
        assert_eq!(times(&mut watch, 0, 12_000, FAILED), [0, 200, 600, 1400, 3000, 6200, 9400]);
        watch.answered(SensorAnswer::Started, 12_600);
        assert_eq!(watch.fault(), None);
        assert_eq!(watch.task(12_600), Some(SensorTask::Sample));
    }

    #[test]
    fn a_chip_that_has_nothing_new_for_a_second_is_configured_afresh() {
        let mut watch = SensorWatch::new(20);
        watch.answered(SensorAnswer::Started, 0);
        watch.answered(SAMPLE, 0);
        watch.answered(SensorAnswer::NotReady, 999);
        assert_eq!(watch.fault(), None);
        watch.answered(SensorAnswer::NotReady, 1000);
        assert_eq!(watch.fault(), Some(SensorFault::Silent));
    }
}
