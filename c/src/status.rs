//! What a session tells, as plain structs.

use crate::error::IronoutError;
use crate::pointer;
use crate::side::{bits_of, words_of};
use core::ffi::c_char;
use ironout::fit::FitError;
use ironout::quality::Reason;
use ironout::session::{Hint, Outcome, State, Status};

/// Where a session is.
// The names are those of C.
#[allow(non_camel_case_types)]
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IronoutState {
    /// Samples are collected.
    IRONOUT_COLLECTING = 1,
    /// A calibration was found: accept it.
    IRONOUT_SOLVED = 2,
    /// The samples do not support a calibration: begin again with ironout_session_init.
    IRONOUT_REFUSED = 3,
}

/// What the user should do next.
// The names are those of C.
#[allow(non_camel_case_types)]
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IronoutHint {
    /// Turn the board slowly in all directions: nothing has moved yet.
    IRONOUT_HINT_MOVE = 1,
    /// Keep turning: bring the side `missing` to where the side `now` is now.
    IRONOUT_HINT_TURN = 2,
    /// There are enough directions: call ironout_session_stop.
    IRONOUT_HINT_STOP = 3,
    /// Call ironout_session_accept.
    IRONOUT_HINT_ACCEPT = 4,
    /// The samples were refused: begin again with ironout_session_init.
    IRONOUT_HINT_AGAIN = 5,
}

/// A snapshot of a session.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IronoutStatus {
    /// State of the session.
    pub state: IronoutState,
    /// What to do next; ironout_hint_text makes a sentence of it.
    pub hint: IronoutHint,
    /// With IRONOUT_HINT_TURN: the side that the field has not come through yet, bits of ironout_side; 0 is any side.
    pub missing: u32,
    /// With IRONOUT_HINT_TURN: the side that the field comes through now.
    pub now: u32,
    /// Samples in motion, used.
    pub samples: u32,
    /// Samples not used: at rest, repeated or saturated.
    pub skipped: u32,
    /// Of these, samples at the sensor's limits.
    pub saturated: u32,
    /// Fraction of directions seen, 0 to 1.
    pub coverage: f32,
    /// Largest gap between the directions seen, degrees.
    pub gap_deg: f32,
    /// Residual rms of the fit so far, µT; NaN while there is no fit.
    pub rms_ut: f32,
    /// Noise of the sensor, standard deviation per axis, µT; NaN while there is no fit.
    pub noise_ut: f32,
    /// Predicted error (1 sigma) of the corrected vector, over the field; NaN while there is no fit. Up to 0.01 is accepted.
    pub predicted_error: f32,
}

/// A reason of a verdict.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IronoutReason {
    /// Which.
    pub code: IronoutError,
    /// Its number, in the unit of its kind: percent of the field (ERROR_TOO_LARGE, RESIDUAL_TOO_LARGE), percent of the
    /// samples (SATURATED), samples (TOO_FEW_SAMPLES), axis 0 to 2 (STUCK_AXIS, COPIED_AXIS), percent of thickness over
    /// width (PLANAR), percent of the distance (THROUGH_ORIGIN), offset over field (OFFSET_TOO_LARGE), longest over
    /// shortest axis (AXIS_RATIO), measured magnitude in µT (FIELD_MISMATCH); 0 for the others.
    pub value: f32,
}

/// The most reasons that a verdict has.
pub const IRONOUT_REASONS: usize = 6;

/// The verdict of ironout_session_stop.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IronoutOutcome {
    /// 1 if the calibration may be used, 0 if not.
    pub accepted: u32,
    /// How many of `reasons` are valid. An accepted calibration may have a note here.
    pub reason_count: u32,
    /// The reasons, refusing ones first.
    pub reasons: [IronoutReason; IRONOUT_REASONS],
    /// The side that the field has not come through, bits of ironout_side; 0 is any side.
    pub missing: u32,
}

impl IronoutStatus {
    pub(crate) fn of(status: &Status) -> Self {
        let (hint, missing, now) = match status.hint {
            Hint::Start | Hint::Move => (IronoutHint::IRONOUT_HINT_MOVE, 0, 0),
            Hint::Turn { missing, now } => (IronoutHint::IRONOUT_HINT_TURN, bits_of(missing), bits_of(now)),
            Hint::Stop => (IronoutHint::IRONOUT_HINT_STOP, 0, 0),
            Hint::Accept => (IronoutHint::IRONOUT_HINT_ACCEPT, 0, 0),
            Hint::Again => (IronoutHint::IRONOUT_HINT_AGAIN, 0, 0),
        };
        let figure = |value: Option<f64>| value.map_or(f32::NAN, |value| value as f32);
        Self {
            state: match status.state {
                State::Idle | State::Collecting => IronoutState::IRONOUT_COLLECTING,
                State::Solved => IronoutState::IRONOUT_SOLVED,
                State::Refused => IronoutState::IRONOUT_REFUSED,
            },
            hint,
            missing,
            now,
            samples: saturated_u32(status.counts.n),
            skipped: saturated_u32(status.counts.skipped),
            saturated: saturated_u32(status.counts.saturated),
            coverage: status.coverage,
            gap_deg: status.gap_deg,
            rms_ut: figure(status.rms_ut),
            noise_ut: figure(status.noise_ut),
            predicted_error: figure(status.predicted_error),
        }
    }
}

impl IronoutOutcome {
    pub(crate) fn of(outcome: &Outcome) -> Self {
        let mut reasons = [IronoutReason { code: IronoutError::IRONOUT_OK, value: 0.0 }; IRONOUT_REASONS];
        let mut reason_count = 0;
        for (place, reason) in reasons.iter_mut().zip(&outcome.verdict.reasons) {
            *place = IronoutReason { code: IronoutError::of_reason(reason), value: value_of(reason) };
            reason_count += 1;
        }
        Self {
            accepted: outcome.verdict.accepted.into(),
            reason_count,
            reasons,
            missing: bits_of(outcome.coverage.missing_side()),
        }
    }
}

/// The number that belongs to a reason.
fn value_of(reason: &Reason) -> f32 {
    let value = match reason {
        Reason::Fit(error) => match error {
            FitError::TooFewSamples { samples } => *samples as f64,
            FitError::StuckAxis { axis } | FitError::CopiedAxis { axis, .. } => f64::from(*axis),
            FitError::Planar { thickness } => 100.0 * thickness,
            FitError::ThroughOrigin { distance } => 100.0 * distance,
            FitError::OffsetTooLarge { fields } => *fields,
            FitError::AxisRatio { ratio } => *ratio,
            FitError::NotAnEllipsoid | FitError::NotFinite => 0.0,
        },
        Reason::ErrorTooLarge { percent, .. }
        | Reason::ResidualTooLarge { percent }
        | Reason::Saturated { percent } => *percent,
        Reason::FieldMismatch { measured_ut, .. } => *measured_ut,
    };
    value as f32
}

/// As many as fit.
pub(crate) fn saturated_u32(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// The beginning of an [`IronoutStatus`] as C may hand it in: any number may stand where an enum should.
#[repr(C)]
struct Said {
    state: i32,
    hint: i32,
    missing: u32,
    now: u32,
}

const _: () = {
    assert!(core::mem::offset_of!(IronoutStatus, state) == core::mem::offset_of!(Said, state));
    assert!(core::mem::offset_of!(IronoutStatus, hint) == core::mem::offset_of!(Said, hint));
    assert!(core::mem::offset_of!(IronoutStatus, missing) == core::mem::offset_of!(Said, missing));
    assert!(core::mem::offset_of!(IronoutStatus, now) == core::mem::offset_of!(Said, now));
};

/// Sentence of a hint; an error for an unknown hint.
fn sentence(said: &Said, text: *mut c_char, room: usize) -> Result<(), IronoutError> {
    const MOVE: i32 = IronoutHint::IRONOUT_HINT_MOVE as i32;
    const TURN: i32 = IronoutHint::IRONOUT_HINT_TURN as i32;
    const STOP: i32 = IronoutHint::IRONOUT_HINT_STOP as i32;
    const ACCEPT: i32 = IronoutHint::IRONOUT_HINT_ACCEPT as i32;
    const AGAIN: i32 = IronoutHint::IRONOUT_HINT_AGAIN as i32;
    let [a, b, c, d, e] = words_of(said.missing);
    let [f, g, h, i, k] = words_of(said.now);
    let turn =
        ["keep turning; bring the ", a, b, c, d, e, " side to where the ", f, g, h, i, k, " side is now"];
    let sentence: &[&str] = match said.hint {
        MOVE => &["turn the board slowly in all directions"],
        TURN => &turn,
        STOP => &["enough directions: stop"],
        ACCEPT => &["solved: accept"],
        AGAIN => &["the samples were refused: begin again"],
        _ => return Err(IronoutError::IRONOUT_BAD_ARGUMENT),
    };
    pointer::write_text(text, room, sentence)
}

/// Writes the hint of a status as an English sentence, with a zero byte at its end, into `text`, which has room for `room`
/// bytes. 100 are enough; a longer sentence is cut.
///
/// IRONOUT_BAD_ARGUMENT: `status` was not written by ironout_session_status.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_hint_text(
    status: *const IronoutStatus,
    text: *mut c_char,
    room: usize,
) -> IronoutError {
    IronoutError::of(pointer::input(status.cast::<Said>()).and_then(|said| sentence(said, text, room)))
}
