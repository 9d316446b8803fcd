//! The error codes and their texts.

use core::ffi::{CStr, c_char};
use ironout::fit::FitError;
use ironout::quality::Reason;

/// What a function returns: IRONOUT_OK, or why it did nothing. The numbers stay the same in later versions.
// The names are those of C.
#[allow(non_camel_case_types)]
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IronoutError {
    /// Success.
    IRONOUT_OK = 0,
    /// A pointer is null or misaligned.
    IRONOUT_BAD_POINTER = 1,
    /// The state was not initialised: call its init function first.
    IRONOUT_NOT_INITIALISED = 2,
    /// A number is not finite, or out of range for the function.
    IRONOUT_BAD_ARGUMENT = 3,
    /// The caller's buffer is too small.
    IRONOUT_TOO_LITTLE_ROOM = 4,
    /// The session is in another state: see the function's description.
    IRONOUT_WRONG_STATE = 5,
    /// There is no further entry.
    IRONOUT_NO_MORE = 6,

    /// Refused: too few samples in motion. Keep turning.
    IRONOUT_TOO_FEW_SAMPLES = 20,
    /// Refused: an axis never moved. Turn in all directions; if it did move, check the driver.
    IRONOUT_STUCK_AXIS = 21,
    /// Refused: an axis is a copy of another. Check the driver.
    IRONOUT_COPIED_AXIS = 22,
    /// Refused: all samples lie near one plane. Tilt the board on its side and upside down.
    IRONOUT_PLANAR = 23,
    /// Refused: no ellipsoid fits. Turn through more directions, away from moving iron and currents.
    IRONOUT_NOT_AN_ELLIPSOID = 24,
    /// Refused: the ellipsoid passes through the sensor's zero.
    IRONOUT_THROUGH_ORIGIN = 25,
    /// Refused: the offset is too large for the field. Look for a magnet, or turn through more directions.
    IRONOUT_OFFSET_TOO_LARGE = 26,
    /// Refused: the axes differ too much. Check the scale of each axis, or turn through more directions.
    IRONOUT_AXIS_RATIO = 27,
    /// Refused: a number is not finite or out of range.
    IRONOUT_NOT_FINITE = 28,
    /// Refused: the predicted error of the corrected vector is above 1 % of the field. Keep turning.
    IRONOUT_ERROR_TOO_LARGE = 29,
    /// Refused: the residual is above 5 % of the field. Keep away from moving iron and currents.
    IRONOUT_RESIDUAL_TOO_LARGE = 30,
    /// Refused: more than 1 % of the samples are at the sensor's limits. Choose a wider range.
    IRONOUT_SATURATED = 31,
    /// A note, not a refusal: the measured magnitude differs from the expected field by more than 20 %.
    IRONOUT_FIELD_MISMATCH = 32,

    /// No record: the bytes are erased (all 0xff or all 0).
    IRONOUT_RECORD_EMPTY = 40,
    /// No record: it is damaged, or only a part of it was written.
    IRONOUT_RECORD_TORN = 41,
    /// A record of a version that this library does not know.
    IRONOUT_RECORD_UNSUPPORTED = 42,
    /// The checksum is correct, but the numbers are not a valid calibration.
    IRONOUT_RECORD_UNSOUND = 43,
    /// The record contains effects: correct with ironout_live_apply.
    IRONOUT_RECORD_HAS_EFFECTS = 44,

    /// A column that an effect needs is not known: set it with ironout_live_set.
    IRONOUT_COLUMN_UNKNOWN = 60,
    /// No effect of the record reads this column.
    IRONOUT_COLUMN_NOT_READ = 61,
    /// An effect needs the rate of turn.
    IRONOUT_NEEDS_GYRO = 62,
    /// The corrected vector would be longer than twice the field: the effects do not apply to this reading.
    IRONOUT_TOO_FAR = 63,

    /// No heading: the front of the board points straight up or down.
    IRONOUT_STEEP = 80,
    /// No heading: the field is vertical.
    IRONOUT_VERTICAL_FIELD = 81,
}

impl IronoutError {
    /// The code of a reason of the verdict.
    pub(crate) const fn of_reason(reason: &Reason) -> Self {
        match reason {
            Reason::Fit(error) => Self::of_fit(error),
            Reason::ErrorTooLarge { .. } => Self::IRONOUT_ERROR_TOO_LARGE,
            Reason::ResidualTooLarge { .. } => Self::IRONOUT_RESIDUAL_TOO_LARGE,
            Reason::Saturated { .. } => Self::IRONOUT_SATURATED,
            Reason::FieldMismatch { .. } => Self::IRONOUT_FIELD_MISMATCH,
        }
    }

    const fn of_fit(error: &FitError) -> Self {
        match error {
            FitError::TooFewSamples { .. } => Self::IRONOUT_TOO_FEW_SAMPLES,
            FitError::StuckAxis { .. } => Self::IRONOUT_STUCK_AXIS,
            FitError::CopiedAxis { .. } => Self::IRONOUT_COPIED_AXIS,
            FitError::Planar { .. } => Self::IRONOUT_PLANAR,
            FitError::NotAnEllipsoid => Self::IRONOUT_NOT_AN_ELLIPSOID,
            FitError::ThroughOrigin { .. } => Self::IRONOUT_THROUGH_ORIGIN,
            FitError::OffsetTooLarge { .. } => Self::IRONOUT_OFFSET_TOO_LARGE,
            FitError::AxisRatio { .. } => Self::IRONOUT_AXIS_RATIO,
            FitError::NotFinite => Self::IRONOUT_NOT_FINITE,
        }
    }

    /// `Ok` and `Err` as one code.
    pub(crate) fn of(result: Result<(), Self>) -> Self {
        result.err().unwrap_or(Self::IRONOUT_OK)
    }
}

/// Every code with its text.
#[rustfmt::skip]
const TEXTS: [(IronoutError, &CStr); 31] = {
    use IronoutError::*;
    [
        (IRONOUT_OK, c"ok"),
        (IRONOUT_BAD_POINTER, c"a pointer is null or misaligned"),
        (IRONOUT_NOT_INITIALISED, c"the state was not initialised: call its init function first"),
        (IRONOUT_BAD_ARGUMENT, c"a number is not finite or out of range"),
        (IRONOUT_TOO_LITTLE_ROOM, c"the buffer is too small"),
        (IRONOUT_WRONG_STATE, c"the session is in another state"),
        (IRONOUT_NO_MORE, c"there is no further entry"),
        (IRONOUT_TOO_FEW_SAMPLES, c"too few samples in motion: keep turning the board"),
        (IRONOUT_STUCK_AXIS, c"an axis never moved: turn the board in all directions; if it did move, check the sensor"),
        (IRONOUT_COPIED_AXIS, c"an axis is a copy of another: check the driver"),
        (IRONOUT_PLANAR, c"all samples lie near one plane: tilt the board on its side and upside down"),
        (IRONOUT_NOT_AN_ELLIPSOID, c"no ellipsoid fits. Rotate the sensor through more directions, away from moving iron and currents"),
        (IRONOUT_THROUGH_ORIGIN, c"the ellipsoid passes through the sensor's zero: turn the board through more directions"),
        (IRONOUT_OFFSET_TOO_LARGE, c"the offset is too large for the field: look for a magnet, or turn through more directions"),
        (IRONOUT_AXIS_RATIO, c"the axes differ too much: check the scale of each axis, or turn through more directions"),
        (IRONOUT_NOT_FINITE, c"a number is not finite or out of range"),
        (IRONOUT_ERROR_TOO_LARGE, c"the predicted error is above 1 % of the field: turn through more directions"),
        (IRONOUT_RESIDUAL_TOO_LARGE, c"the residual is above 5 % of the field: keep away from moving iron and currents"),
        (IRONOUT_SATURATED, c"more than 1 % of the samples are at the sensor's limits: choose a wider range, or remove the magnet"),
        (IRONOUT_FIELD_MISMATCH, c"note: the measured magnitude differs from the expected field by more than 20 %"),
        (IRONOUT_RECORD_EMPTY, c"no record: the memory is erased"),
        (IRONOUT_RECORD_TORN, c"no record: it is damaged or only partly written"),
        (IRONOUT_RECORD_UNSUPPORTED, c"a record of an unknown version"),
        (IRONOUT_RECORD_UNSOUND, c"the numbers of this record are not plausible"),
        (IRONOUT_RECORD_HAS_EFFECTS, c"the record contains effects: correct with ironout_live_apply"),
        (IRONOUT_COLUMN_UNKNOWN, c"a column that an effect needs is not known"),
        (IRONOUT_COLUMN_NOT_READ, c"no effect of the record reads this column"),
        (IRONOUT_NEEDS_GYRO, c"an effect needs the rate of turn"),
        (IRONOUT_TOO_FAR, c"the corrected vector would be longer than twice the field"),
        (IRONOUT_STEEP, c"no heading: the front of the board points straight up or down"),
        (IRONOUT_VERTICAL_FIELD, c"no heading: the field is vertical"),
    ]
};

/// A sentence for a code, in English, at most 120 bytes. It is never null and stays valid. For an unknown code:
/// "unknown error".
#[unsafe(no_mangle)]
pub extern "C" fn ironout_error_text(error: i32) -> *const c_char {
    let known = TEXTS.iter().find(|(code, _)| *code as i32 == error);
    let text = known.map_or(c"unknown error", |(_, text)| text);
    text.as_ptr()
}
