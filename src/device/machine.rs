//! The state machine: what is due, in which order, and what becomes of the answers.

use core::mem;

use heapless::Deque;

use super::active::Active;
use super::button::{Button, ButtonEvent};
use super::config::DeviceConfig;
use super::job_purpose::JobPurpose;
use super::learner_inputs::LearnerInputs;
use super::loading::Loading;
use super::log::Log;
use super::output::{MAX_REPLY_BYTES, Output};
use super::sensor::{SensorTask, SensorWatch};
use super::store_watch::StoreWatch;
use super::stream;
use super::streamed;
use super::view::View;
use crate::clock::SteadyClock;
use crate::level::Forces;
use crate::protocol::{Line, LineSplitter, StreamMode};
use crate::session::{Session, State, Status};
use crate::store::{BothSlots, Done, SlotState, StoreAnswer, StoreJob, StoreTask};

/// What the owner has to do now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Action {
    /// This, and then [`Device::complete_sensor`].
    Sensor(SensorTask),
    /// This, and then [`Device::complete_store`].
    Store(StoreTask),
    /// Something was done: take in what has arrived meanwhile, and poll again with the time it is then.
    Again,
    /// Nothing until [`Device::next_deadline_ms`], or a byte, a reading or a level of the button.
    Sleep,
}

/// Lines of a stream that wait for the next poll; a reading in an interrupt may come a few times between two.
const WAITING_SAMPLES: usize = 8;
/// How long a status is good for while samples come in: one solve in this time is all that `status` costs, however often
/// it is asked.
const STATUS_AGE_MS: u64 = 500;
/// How long a computation waits at most for the moment after a sample.
const PATIENCE_MS: u64 = 300;
/// When a full output is looked at again.
const OUTPUT_RETRY_MS: u64 = 10;

/// Restarts of the board after a fault of its firmware.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Restarts {
    pub(super) count: u32,
    pub(super) last: &'static str,
}

/// The application: see the [module](super).
#[derive(Debug, Clone)]
pub struct Device {
    pub(super) config: DeviceConfig,
    pub(super) session: Session,
    pub(super) loading: Loading,
    pub(super) active: Option<Active>,
    pub(super) learner_inputs: LearnerInputs,
    /// The accelerometer of a vehicle that turns level, while `cal start level` collects.
    pub(super) level: Option<Forces>,
    pub(super) view: View,
    pub(super) sensor: SensorWatch,
    pub(super) stream: StreamMode,
    pub(super) log: Log,
    pub(super) samples_taken: u32,
    pub(super) waiting: Deque<streamed::Sample, WAITING_SAMPLES>,
    splitter: LineSplitter,
    line_waits: bool,
    /// Since when a computation has waited for the moment after a sample.
    pub(super) compute_asked_ms: Option<u64>,
    pub(super) status: Option<(u64, Status)>,
    job: Option<(JobPurpose, StoreJob)>,
    pub(super) slots: BothSlots,
    pub(super) store_watch: StoreWatch,
    clock: SteadyClock,
    button: Button,
    presses: u8,
    event: Option<ButtonEvent>,
    pub(super) restarts: Restarts,
    pub(super) longest_turn_us: u32,
    pub(super) stamp_jitter_us: Option<u32>,
    /// The time of the last poll or answer.
    pub(super) now_ms: u64,
}

impl Device {
    /// A device with an idle session, a sensor to be started and a store to be looked at.
    #[inline(never)]
    pub fn new(config: DeviceConfig) -> Self {
        let sensor = &config.sensor;
        Self {
            config,
            session: Session::new(config.session()),
            loading: Loading::nothing(),
            active: None,
            learner_inputs: LearnerInputs::new(),
            level: None,
            view: View::new(),
            sensor: SensorWatch::new(config.pace, sensor),
            stream: StreamMode::Off,
            log: Log::new(),
            samples_taken: 0,
            waiting: Deque::new(),
            splitter: LineSplitter::new(),
            line_waits: false,
            compute_asked_ms: None,
            status: None,
            job: Some((JobPurpose::Boot, StoreJob::inspect())),
            slots: BothSlots { states: [SlotState::Unreadable; 2] },
            store_watch: StoreWatch::new(),
            clock: SteadyClock::new(),
            button: Button::default(),
            presses: 0,
            event: None,
            restarts: Restarts::default(),
            longest_turn_us: 0,
            stamp_jitter_us: None,
            now_ms: 0,
        }
    }

    /// Begins from nothing with another sensor, in place: a second device would be as large as this one. What was told of restarts
    /// and of the owner's turns stays.
    #[inline(never)]
    pub fn begin_anew(&mut self, config: DeviceConfig) {
        self.sensor = SensorWatch::new(config.pace, &config.sensor);
        self.session = Session::new(config.session());
        self.config = config;
        self.loading.forget();
        self.active = None;
        self.learner_inputs.begin_anew();
        self.level = None;
        self.view.begin_anew();
        self.stream = StreamMode::Off;
        self.log = Log::new();
        self.samples_taken = 0;
        self.waiting.clear();
        (self.splitter, self.line_waits) = (LineSplitter::new(), false);
        (self.compute_asked_ms, self.status) = (None, None);
        self.job = Some((JobPurpose::Boot, StoreJob::inspect()));
        self.slots = BothSlots { states: [SlotState::Unreadable; 2] };
        self.store_watch = StoreWatch::new();
        (self.presses, self.event) = (0, None);
    }

    /// Tells the device that the board restarted `count` times since power-up after a fault of its firmware, and in words
    /// what the last one was. `status` counts them among its faults, `version` shows the last.
    pub fn note_restarts(&mut self, count: u32, last: &'static str) {
        self.restarts = Restarts { count, last };
    }

    /// Leaves sensor and store alone from now on, and answers the console all the same: for a firmware that has failed at every
    /// start and does not know at what. `status` says so.
    pub fn rest(&mut self) {
        self.sensor.rest();
        self.job = None;
        self.store_watch.rest();
    }

    /// Tells the device how long a turn of the owner's loop was; `version` shows the longest.
    pub fn note_turn_us(&mut self, us: u32) {
        self.longest_turn_us = self.longest_turn_us.max(us);
    }

    /// Tells the device how far the stamps of samples were from the sensor's own rhythm, at most; `version` shows it.
    pub const fn note_stamp_jitter_us(&mut self, us: Option<u32>) {
        self.stamp_jitter_us = us;
    }

    /// Takes a byte from the console. `false`, and nothing taken, while a line waits for its answer: the byte is to be offered
    /// again after the next poll.
    #[must_use = "a byte that was not taken is to be offered again"]
    pub fn take_byte(&mut self, byte: u8) -> bool {
        if self.line_waits {
            return false;
        }
        let packets = self.stream == StreamMode::MotionCal;
        self.line_waits = self.splitter.push_or_packet(byte, packets).is_some();
        true
    }

    /// Takes the level of the button, bounces and all: at each change or as often as it is polled, and again at
    /// [`Self::next_deadline_ms`].
    pub fn on_button_level(&mut self, down: bool, now_ms: u64) {
        let now_ms = self.clock.at(now_ms);
        if self.button.pressed(down, now_ms) {
            self.on_press();
        }
    }

    /// Takes a press of a button that does not bounce: it starts a calibration, or ends one and accepts it if its verdict
    /// allows. What came of it is told by [`Self::take_event`].
    pub fn on_press(&mut self) {
        self.presses = self.presses.saturating_add(1);
    }

    /// What a press of the button has done, once.
    pub fn take_event(&mut self) -> Option<ButtonEvent> {
        self.event.take()
    }

    /// Takes what came of an [`Action::Store`], with the time it is now.
    pub fn complete_store(&mut self, answer: &StoreAnswer, now_ms: u64) {
        let now_ms = self.steady(now_ms);
        if let Some((_, job)) = &mut self.job {
            job.complete(answer, now_ms);
        }
    }

    /// The time, ms, of an owner whose clock may wrap or be set back, taken note of.
    #[inline]
    pub(super) fn steady(&mut self, owner_ms: u64) -> u64 {
        let t_ms = self.clock.at(owner_ms);
        self.now_ms = self.now_ms.max(t_ms);
        t_ms
    }

    /// What has to be done at `now_ms` (since power-up; see the [module](super) for a tick that wraps). The same action is returned until it is completed, so that an owner
    /// may give up on one and poll again. The order: streams, the sensor, the store, the button, one line of the console.
    // Not within its owner: a loop's frame would hold what all of it needs, for as long as the loop turns.
    #[inline(never)]
    pub fn poll(&mut self, now_ms: u64, out: &mut impl Output) -> Action {
        let now_ms = self.steady(now_ms);
        self.sensor.time(now_ms);
        self.write_stream(out);
        if let Some(task) = self.sensor.task(now_ms).or_else(|| self.temperature_task()) {
            return Action::Sensor(task);
        }
        if let Some((purpose, job)) = &self.job {
            if let Some(task) = job.task(now_ms) {
                return Action::Store(task);
            }
            // The reply waits for its room; samples and streams do not.
            if !job.is_finished() || Self::replies(*purpose) && !out.takes(MAX_REPLY_BYTES) {
                return Action::Sleep;
            }
            self.finish(out);
            return Action::Again;
        }
        if self.store_watch.is_due(self.now_ms) {
            self.begin(JobPurpose::Boot, StoreJob::inspect());
            return Action::Again;
        }
        if self.presses > 0 && self.may_compute(self.session.state() == State::Collecting) {
            self.presses -= 1;
            self.compute_asked_ms = None;
            self.pressed();
            return Action::Again;
        }
        #[cfg(feature = "study")]
        if self.learner_inputs.question.is_some() {
            return if out.takes(MAX_REPLY_BYTES) && self.ponder(out) {
                Action::Again
            } else {
                Action::Sleep
            };
        }
        if self.line_waits && out.takes(MAX_REPLY_BYTES) && self.answer_line(out) {
            return Action::Again;
        }
        #[cfg(feature = "study")]
        if self.begin_to_learn() {
            return Action::Again;
        }
        if self.look_at_coverage() { Action::Again } else { Action::Sleep }
    }

    /// When there is something to do without anything coming from outside, by the owner's clock; a time past: at once.
    pub fn next_deadline_ms(&self) -> u64 {
        let job = match &self.job {
            Some((_, job)) => Some(job.deadline_ms().unwrap_or(self.now_ms + OUTPUT_RETRY_MS)),
            None if self.line_waits || self.presses > 0 || self.learner_inputs.question.is_some() => {
                // It waits for room, or for the moment after a sample, which comes with the sample.
                Some(self.now_ms + OUTPUT_RETRY_MS)
            }
            None => None,
        };
        let store = self.store_watch.deadline_ms().filter(|_| self.job.is_none());
        let light = self.light().next_change_ms(self.now_ms);
        let deadline_ms = [job, store, self.button.deadline_ms(), light]
            .into_iter()
            .flatten()
            .fold(self.sensor.deadline_ms(), u64::min);
        self.clock.of_owner(deadline_ms)
    }

    fn write_stream(&mut self, out: &mut impl Output) {
        while let Some(sample) = self.waiting.pop_front() {
            if out.takes(stream::line_bytes(self.stream, &self.log)) {
                let live = self.active.as_mut().and_then(|active| active.at(sample.t_ms));
                // What cannot be written is left out, as where there is no room.
                let _ = stream::write_line(out, self.stream, &sample, live, &mut self.log);
            }
        }
    }

    /// Whether a computation of many milliseconds may begin: right after a sample, so that the next one is late at most; where
    /// that moment does not come, after a while.
    pub(super) fn may_compute(&mut self, is_long: bool) -> bool {
        let ample = |slack_ms| slack_ms >= self.sensor.ample_slack_ms();
        if !is_long || self.sensor.slack_ms(self.now_ms).is_none_or(ample) {
            return true;
        }
        let asked_ms = *self.compute_asked_ms.get_or_insert(self.now_ms);
        self.now_ms.saturating_sub(asked_ms) >= PATIENCE_MS
    }

    /// Whether `status` has to solve.
    pub(super) fn status_is_old(&self) -> bool {
        self.session.state() == State::Collecting
            && self.status.is_none_or(|(t_ms, status)| {
                status.state != State::Collecting || self.now_ms.saturating_sub(t_ms) >= STATUS_AGE_MS
            })
    }

    /// Answers the line that waits, or begins what its answer needs. `false` where it has to wait.
    #[inline(never)]
    fn answer_line(&mut self, out: &mut impl Output) -> bool {
        let splitter = mem::take(&mut self.splitter);
        let line = splitter.last().unwrap_or(Line::NotText);
        if self.store_watch.is_unread() && !self.store_watch.looked_again {
            self.store_watch.looked_again = true;
            self.begin(JobPurpose::Boot, StoreJob::inspect());
        } else if !self.may_compute(self.is_long(line)) {
            self.splitter = splitter;
            return false;
        } else {
            self.compute_asked_ms = None;
            let answered = self.answer(line, out);
            // Where the job goes on with it, the line is done all the same: `finish` writes the reply.
            (self.line_waits, self.store_watch.looked_again) = (false, false);
            if let Some(answered) = answered {
                // Room was made sure of; an output that fails all the same has nobody at its end.
                let _ = answered.result();
            }
            return true;
        }
        self.splitter = splitter;
        true
    }

    pub(super) fn begin(&mut self, purpose: JobPurpose, job: StoreJob) {
        self.job = Some((purpose, job));
    }

    const fn replies(purpose: JobPurpose) -> bool {
        match purpose {
            JobPurpose::Version | JobPurpose::Accept | JobPurpose::Clear => true,
            #[cfg(feature = "study")]
            JobPurpose::Effect => true,
            JobPurpose::Boot | JobPurpose::AcceptByButton => false,
        }
    }

    #[inline(never)]
    fn finish(&mut self, out: &mut impl Output) {
        let Some((purpose, job)) = &self.job else { return };
        let (purpose, Some(outcome)) = (*purpose, job.outcome()) else { return };
        self.job = None;
        match &outcome {
            Ok(Done::Inspected(slots, record)) => self.adopt(*slots, record.as_ref()),
            Ok(Done::Saved(..) | Done::Erased) => self.store_watch.answered(),
            Err(_) => self.store_watch.failed(self.now_ms),
        }
        let answered = match purpose {
            JobPurpose::Boot => return,
            JobPurpose::Version => self.version(out),
            JobPurpose::Accept => self.accepted(outcome, out),
            JobPurpose::AcceptByButton => {
                let event = match self.stored(outcome) {
                    Ok(slot) => ButtonEvent::Accepted(slot),
                    Err(error) => ButtonEvent::NotStored(error),
                };
                self.event = Some(event);
                return;
            }
            JobPurpose::Clear => self.cleared(outcome, out),
            #[cfg(feature = "study")]
            JobPurpose::Effect => self.effect_stored(outcome, out),
        };
        // As for any other line.
        let _ = answered.result();
    }

    /// Takes note of a button's event.
    pub(super) fn tell(&mut self, event: ButtonEvent) {
        self.event = Some(event);
    }

    /// Whether all that came from outside is dealt with: no line waits for its answer, no press for its effect, and nothing is
    /// under way at the store.
    pub const fn is_idle(&self) -> bool {
        !self.line_waits && self.presses == 0 && self.job.is_none() && self.learner_inputs.question.is_none()
    }
}
