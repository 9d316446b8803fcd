//! What the device keeps for its study.

use super::own::OwnColumns;
#[cfg(not(feature = "study"))]
use super::study::Question;
use super::study::{Learner, Motion};
#[cfg(feature = "study")]
use crate::calibration::Calibration;
#[cfg(feature = "study")]
use crate::learn::{Inquiry, Outcome};
#[cfg(feature = "study")]
use crate::protocol::EffectId;

/// Why a question is asked.
#[cfg(feature = "study")]
#[derive(Debug, Clone)]
pub(super) enum Purpose {
    /// For `why`.
    Why,
    /// For `effect add`.
    Add(EffectId),
}

/// A question under way.
#[cfg(feature = "study")]
#[derive(Debug, Clone)]
pub(super) struct Question {
    pub(super) purpose: Purpose,
    pub(super) inquiry: Inquiry,
    /// Pieces of work that it took.
    pub(super) steps: u16,
}

/// A vector that comes axis by axis.
pub(super) type Axes = [Option<f32>; 3];

/// The study and what it is fed.
#[derive(Debug, Clone)]
pub(super) struct LearnerInputs {
    pub(super) learner: Learner,
    pub(super) motion: Motion,
    /// The motion as it was fed by name.
    pub(super) accel: Axes,
    pub(super) turn: Axes,
    /// When the rate of turn was fed last.
    pub(super) turn_at_ms: u64,
    pub(super) question: Option<Question>,
    /// When the chip's temperature is asked for next; never, where it has none.
    pub(super) temperature_at_ms: u64,
    /// When it is looked next whether a calibration under way is good enough to begin at.
    pub(super) begin_at_ms: u64,
    /// What `effect add` or `effect remove` will have made of the study once its record is stored.
    #[cfg(feature = "study")]
    pub(super) changed: Option<Change>,
    /// The effects of time in use go by the board's clock since power-up.
    pub(super) own_clock: bool,
    /// The chip has been asked for its temperature and has none.
    pub(super) no_temperature: bool,
    /// What the board measures beside field and motion.
    pub(super) own: OwnColumns,
}

/// A change that waits for the store.
#[cfg(feature = "study")]
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    pub(super) before: Calibration<f64>,
    pub(super) rms_ut: [f32; 2],
}

/// The answer and what it took.
#[cfg(feature = "study")]
#[derive(Debug, Clone, Copy)]
pub(super) struct Answer {
    pub(super) outcome: Outcome,
    pub(super) steps: u16,
}

impl LearnerInputs {
    pub(super) const fn new() -> Self {
        Self {
            learner: Learner::new(),
            motion: Motion::UNKNOWN,
            accel: [None; 3],
            turn: [None; 3],
            turn_at_ms: 0,
            question: None,
            temperature_at_ms: 0,
            begin_at_ms: 0,
            #[cfg(feature = "study")]
            changed: None,
            own_clock: false,
            no_temperature: false,
            own: OwnColumns::new(),
        }
    }

    /// Forgets everything, in place.
    pub(super) fn begin_anew(&mut self) {
        self.learner.begin_anew();
        self.motion = Motion::UNKNOWN;
        (self.accel, self.turn) = ([None; 3], [None; 3]);
        self.question = None;
        #[cfg(feature = "study")]
        {
            self.changed = None;
        }
        (self.temperature_at_ms, self.begin_at_ms, self.turn_at_ms) = (0, 0, 0);
        (self.own_clock, self.no_temperature) = (false, false);
        self.own = OwnColumns::new();
    }
}
