//! The session: from samples to a calibration.

use crate::calibration::IronoutCalibration;
use crate::error::IronoutError;
use crate::pointer;
use crate::sensor::IronoutSensor;
use crate::state::{self, Kind};
use crate::status::{IronoutOutcome, IronoutStatus};
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig};

/// With ironout_session_push: the chip says that an axis was out of its range. The sample is counted and not used.
pub const IRONOUT_OUT_OF_RANGE: u32 = 1;
/// With ironout_session_push: samples are missing before this one. Gaps that the time stamps show need no flag.
pub const IRONOUT_GAP: u32 = 2;

/// After so many sample periods without a sample there is a gap.
const GAP_PERIODS: f32 = 4.0;
/// The same without a rate, ms.
const GAP_MS: u32 = 500;

/// A calibration session, in the caller's memory. Its content is the library's own.
#[repr(C)]
pub struct IronoutSession {
    opaque: [u64; IRONOUT_SESSION_WORDS],
}

/// Size of ironout_session in words of 8 bytes.
pub const IRONOUT_SESSION_WORDS: usize = 204;

/// What is in it.
pub(crate) struct Collecting {
    session: Session,
    gap_ms: u32,
    last_ms: Option<u32>,
}

impl Kind for Collecting {
    const MARK: u32 = 0x4972_6f01;
    type Opaque = IronoutSession;
}

const _: () = Collecting::FITS;

impl Collecting {
    fn new(sensor: &IronoutSensor) -> Result<Self, IronoutError> {
        let positive = |value: &f32| value.is_finite() && *value > 0.0;
        let optional = |value: &f32| *value == 0.0 || positive(value);
        let IronoutSensor { ut_per_count, rate_hz, field_ut } = sensor;
        if !(ut_per_count.iter().all(positive) && optional(rate_hz) && optional(field_ut)) {
            return Err(IronoutError::IRONOUT_BAD_ARGUMENT);
        }
        let gap_ms = if *rate_hz > 0.0 { (GAP_PERIODS * 1000.0 / rate_hz) as u32 } else { GAP_MS };
        let mut session = Session::new(SessionConfig {
            field_ut: (*field_ut > 0.0).then_some(f64::from(*field_ut)),
            ..SessionConfig::scaled(ut_per_count.map(f64::from), f64::from(*rate_hz))
        });
        session.start();
        Ok(Self { session, gap_ms, last_ms: None })
    }

    fn push(&mut self, counts: [i16; 3], t_ms: u32, flags: u32) -> Result<(), IronoutError> {
        if flags & !(IRONOUT_OUT_OF_RANGE | IRONOUT_GAP) != 0 {
            return Err(IronoutError::IRONOUT_BAD_ARGUMENT);
        }
        let passed_ms = self.last_ms.replace(t_ms).map(|last_ms| t_ms.wrapping_sub(last_ms));
        if flags & IRONOUT_GAP != 0 || passed_ms.is_some_and(|passed_ms| passed_ms > self.gap_ms) {
            self.session.interrupt();
        }
        let is_valid = flags & IRONOUT_OUT_OF_RANGE == 0;
        self.session.push(if is_valid { Sample::valid(counts) } else { Sample::out_of_range(counts) });
        Ok(())
    }

    fn push_ut(&mut self, measured_ut: [f32; 3], t_ms: u32, flags: u32) -> Result<(), IronoutError> {
        if !measured_ut.iter().all(|value| value.is_finite()) {
            return Err(IronoutError::IRONOUT_BAD_ARGUMENT);
        }
        // At the ends of 16 bits a count is saturated, whatever the flags say.
        let counts = self.session.config().sample(measured_ut).counts;
        self.push(counts, t_ms, flags)
    }

    pub(crate) fn solved(&self) -> Result<&ironout::fit::FitReport, IronoutError> {
        self.session.solution().ok_or(IronoutError::IRONOUT_WRONG_STATE)
    }
}

/// Begins to collect, whatever `session` was before: this is also how to begin again and how to give up. A calibration in
/// use is not touched.
///
/// IRONOUT_BAD_ARGUMENT: a scale is not positive, the rate or the field is negative, or a value is not finite.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_session_init(
    session: *mut IronoutSession,
    sensor: *const IronoutSensor,
) -> IronoutError {
    let begun = pointer::input(sensor).and_then(Collecting::new);
    IronoutError::of(begun.and_then(|collecting| state::init(session, collecting)))
}

/// Takes one sample: three counts in the board's axes, the time in ms (a tick that wraps is fine), and 0 or flags
/// (IRONOUT_OUT_OF_RANGE, IRONOUT_GAP). Push every conversion once. Samples at rest, repeated ones and those at the ends of
/// the 16-bit range are left out and counted. After ironout_session_stop nothing is taken.
///
/// Takes the same short time for every sample; solves nothing.
/// cbindgen:ptrs-as-arrays=[[counts; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_session_push(
    session: *mut IronoutSession,
    counts: *const i16,
    t_ms: u32,
    flags: u32,
) -> IronoutError {
    let counts = pointer::vector(counts);
    let pushed = counts.and_then(|counts| state::get_mut::<Collecting>(session)?.push(counts, t_ms, flags));
    IronoutError::of(pushed)
}

/// As ironout_session_push, from µT. They are rounded to counts of `ut_per_count`: choose a scale as fine as the sensor's
/// resolution, so that the largest value stays below 32767 counts.
///
/// IRONOUT_BAD_ARGUMENT: a value is not finite, or a flag is unknown; the sample was not taken.
/// cbindgen:ptrs-as-arrays=[[measured_ut; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_session_push_ut(
    session: *mut IronoutSession,
    measured_ut: *const f32,
    t_ms: u32,
    flags: u32,
) -> IronoutError {
    let measured_ut = pointer::vector(measured_ut);
    let pushed = measured_ut
        .and_then(|measured_ut| state::get_mut::<Collecting>(session)?.push_ut(measured_ut, t_ms, flags));
    IronoutError::of(pushed)
}

/// Writes a snapshot of the session to `status`: what was collected, how good a calibration from it would be, and what to do
/// next. It changes nothing.
///
/// While the session collects, this solves the samples so far: call it once a second, not for every sample. docs/c.md
/// gives the instructions and the stack it needs.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_session_status(
    session: *const IronoutSession,
    status: *mut IronoutStatus,
) -> IronoutError {
    let read = state::get::<Collecting>(session)
        .and_then(|collecting| pointer::write(status, IronoutStatus::of(&collecting.session.status())));
    IronoutError::of(read)
}

/// Stops collecting, solves and judges. Returns IRONOUT_OK if the calibration is accepted, otherwise the first reason why
/// it is refused. `outcome` gets all reasons; it may be null. A calibration in use is not touched.
///
/// IRONOUT_WRONG_STATE: the session was stopped before.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_session_stop(
    session: *mut IronoutSession,
    outcome: *mut IronoutOutcome,
) -> IronoutError {
    let stopped = state::get_mut::<Collecting>(session).and_then(|collecting| {
        let found = collecting.session.stop().map_err(|_| IronoutError::IRONOUT_WRONG_STATE)?;
        if !outcome.is_null() {
            pointer::write(outcome, IronoutOutcome::of(found))?;
        }
        let first = found.verdict.reasons.first().map(IronoutError::of_reason);
        match first {
            _ if found.verdict.accepted => Ok(()),
            Some(reason) => Err(reason),
            // Refused without a reason: the matrix is not sound.
            None => Err(IronoutError::IRONOUT_NOT_FINITE),
        }
    });
    IronoutError::of(stopped)
}

/// Writes the accepted calibration to `calibration`, which may be the one in use: on an error it is left as it was. The
/// session stays solved, so that ironout_record_encode works before and after.
///
/// IRONOUT_WRONG_STATE: there is no accepted calibration.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_session_accept(
    session: *const IronoutSession,
    calibration: *mut IronoutCalibration,
) -> IronoutError {
    let accepted = state::get::<Collecting>(session)
        .and_then(Collecting::solved)
        .and_then(|report| pointer::write(calibration, IronoutCalibration::of_report(report)));
    IronoutError::of(accepted)
}
