//! `cal zero`: the offset measured again with the matrix of the calibration in use, from a few turns, and a gyro if there is one.

use core::fmt;

use super::active::Active;
use super::machine::Device;
use crate::fit::MAX_PREDICTED_ERROR;
use crate::math::sqrt;
use crate::number::Num;
use crate::protocol::{Answered, Code, Reply};
use crate::record::{PredictedError, Record};
use crate::rezero::{GyroUse, MIN_LOOKS, NoOffset, OffsetChange};
use crate::session::State;

/// Residual of the looks, in multiples of what noise and calibration predict: beyond it they do not lie on one sphere.
const MAX_RESIDUAL_RATIO: f64 = 3.0;
/// Share of the field that is no sign of anything, however quiet the sensor is.
const LEAST_SHARE: f64 = 0.002;
/// Errors by which an offset has to differ before a change is proposed unasked ...
const PROPOSED_ERRORS: f64 = 3.0;
/// ... and the share of the field: half a degree of heading at a dip of 60°.
const PROPOSED_SHARE: f64 = 0.005;

/// Why there is no offset to accept.
enum NotZeroed {
    Looks(NoOffset),
    /// Error, as a share of the field, and what a gyro helped.
    TooUncertain(f64, GyroUse),
    /// Residual, µT.
    NotOneSphere(f64),
}

impl NotZeroed {
    const fn code(&self) -> &'static str {
        match self {
            NotZeroed::Looks(NoOffset::TooFewLooks(_)) => "too-few-samples",
            NotZeroed::Looks(NoOffset::Planar(_)) => "planar",
            NotZeroed::TooUncertain(..) => "error-too-large",
            NotZeroed::NotOneSphere(_) => "residual-too-large",
        }
    }
}

impl fmt::Display for NotZeroed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotZeroed::Looks(NoOffset::TooFewLooks(looks)) => write!(
                f,
                "the sensor turned too little ({looks} of {MIN_LOOKS} turns by 6 deg): turn it to and fro by 30 deg about each axis"
            ),
            NotZeroed::Looks(NoOffset::Planar(gyro)) => write!(
                f,
                "the turns were small, or in one plane: tilt the sensor further to both sides while you turn it{}",
                check_of(*gyro)
            ),
            NotZeroed::TooUncertain(share, gyro) => write!(
                f,
                "the error of the offset would be {:.1} % of the field (limit {:.0} %): tilt the sensor further and turn it{}",
                Num(100.0 * share),
                Num(100.0 * MAX_PREDICTED_ERROR),
                check_of(*gyro)
            ),
            NotZeroed::NotOneSphere(rms_ut) => write!(
                f,
                "the magnitude varies by {:.2} uT: something nearby bends the field, or the offset changed during \
                 the turns: cal zero start, then turn again",
                Num(*rms_ut)
            ),
        }
    }
}

/// What is to be checked of a gyro that could have helped.
const fn check_of(gyro: GyroUse) -> &'static str {
    match gyro {
        GyroUse::Disagrees => "; the gyro disagrees: check its axes, signs and unit (rad/s)",
        GyroUse::None | GyroUse::Used => "",
    }
}

/// A new offset for a record.
struct Zeroed {
    record: Record,
    change: OffsetChange,
    /// Whether the change is large enough to be proposed.
    is_worth_it: bool,
}

impl Active {
    /// The record with the offset that the looks show.
    #[inline(never)]
    fn zeroed(&self) -> Result<Zeroed, NotZeroed> {
        let Record { calibration, noise_ut, predicted_error, .. } = &self.record;
        let field_ut = calibration.field_ut;
        let matrix_ut = predicted_error.share().unwrap_or(MAX_PREDICTED_ERROR) * field_ut;
        let change = self.rezero.solve(matrix_ut as f32).map_err(NotZeroed::Looks)?;
        let least_ut = LEAST_SHARE * field_ut;
        let known_noise_ut = if noise_ut.is_finite() { *noise_ut } else { 0.0 };
        let expected_ut = sqrt(known_noise_ut * known_noise_ut + matrix_ut * matrix_ut + least_ut * least_ut);
        let rms_ut = f64::from(change.rms_ut);
        // Negated, so that a NaN is refused too.
        if !(rms_ut <= MAX_RESIDUAL_RATIO * expected_ut) {
            return Err(NotZeroed::NotOneSphere(rms_ut));
        }
        let error_ut = f64::from(change.error_ut);
        let share = sqrt(error_ut * error_ut + matrix_ut * matrix_ut) / field_ut;
        let offset_ut = calibration.distort(change.change_ut.map(f64::from));
        let (true, Some(offset_ut)) = (share <= MAX_PREDICTED_ERROR, offset_ut) else {
            return Err(NotZeroed::TooUncertain(share, change.gyro));
        };
        let mut record = self.record;
        record.calibration.offset_ut = offset_ut;
        record.predicted_error = PredictedError::of_share(share);
        // The errors of the old offset hung together with those of the matrix.
        record.covariance = None;
        let size_ut = f64::from(change.size_ut());
        let is_worth_it = size_ut > PROPOSED_ERRORS * error_ut && size_ut > PROPOSED_SHARE * field_ut;
        Ok(Zeroed { record, change, is_worth_it })
    }
}

impl Device {
    /// `cal zero`, and `cal zero start`, which forgets what was seen so far.
    #[inline(never)]
    pub(super) fn cal_zero<W: fmt::Write>(&mut self, reply: Reply<'_, W>, begins: bool) -> Answered {
        if self.session.state() == State::Collecting {
            return reply
                .err(Code::State, format_args!("samples are being collected: cal stop or cal cancel first"));
        }
        if let Some(fault) = self.sensor.fault() {
            return self.no_sensor(reply, fault);
        }
        let Some(active) = self.active.as_mut().filter(|active| active.live.is_ok()) else {
            return reply.err(Code::State, format_args!("there is no calibration in use: cal start"));
        };
        if begins {
            active.rezero.clear();
            return reply.ok(format_args!("turns=0 of={MIN_LOOKS}"));
        }
        let Zeroed { record, change, .. } = match active.zeroed() {
            Ok(zeroed) => zeroed,
            Err(why) => return reply.err(Code::Refused, format_args!("{} {why}", why.code())),
        };
        if let Err(why) = self.loading.take_record(&record, self.config.sensor.axes) {
            return reply.err(Code::Refused, format_args!("{why}"));
        }
        // One solution waits at a time: the last that came.
        self.session.cancel();
        self.status = None;
        reply.ok(format_args!("state={} {}", self.state().name(), Figures(&change)))
    }

    /// The line of `status` that proposes another offset.
    #[inline(never)]
    pub(super) fn propose_zero<W: fmt::Write>(&self, reply: &mut Reply<'_, W>) {
        let Some(active) = self.active.as_ref().filter(|active| active.live.is_ok()) else { return };
        if let Ok(Zeroed { change, is_worth_it: true, .. }) = active.zeroed() {
            reply.line(format_args!(
                "offset {}; the offset has changed; measure it again with: cal zero",
                Figures(&change)
            ));
        }
    }

    /// Whether there is enough to work out an offset.
    pub(super) fn may_propose_zero(&self) -> bool {
        self.active.as_ref().is_some_and(|active| active.rezero.count() >= MIN_LOOKS)
    }
}

/// The figures of a change.
struct Figures<'a>(&'a OffsetChange);

impl fmt::Display for Figures<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OffsetChange { error_ut, rms_ut, field_ut, looks, gyro, .. } = self.0;
        let (size_ut, error_ut) = (Num(f64::from(self.0.size_ut())), Num(f64::from(*error_ut)));
        let (rms_ut, field_ut) = (Num(f64::from(*rms_ut)), Num(f64::from(*field_ut)));
        write!(
            f,
            "change_ut={size_ut:.2} error_ut={error_ut:.2} rms_ut={rms_ut:.3} field_ut={field_ut:.1} turns={looks} gyro={}",
            gyro.name()
        )
    }
}
