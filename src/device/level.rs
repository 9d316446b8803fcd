//! `cal start level`: a calibration for a vehicle that only turns level, and the tilts that a calibration holds for.

use core::fmt;

use super::level_worse::LevelWorse;
use super::machine::Device;
use crate::calibration::Calibration;
use crate::extended::Effects;
use crate::fit::{MAX_PREDICTED_ERROR, Order};
use crate::level::{LevelFit, LevelPrior, NotLevel};
use crate::number::Num;
use crate::protocol::{Answered, Code, Reply};
use crate::record::{HoldsFor, PredictedError, Record, TILTS_DEG};

/// Magnitude of the identity's field, µT: the fit replaces it.
const ANY_FIELD_UT: f64 = 50.0;

/// The tilts that a calibration holds for, as `status` and `cal show` give them.
pub(super) struct Tilts<'a>(pub(super) &'a HoldsFor);

impl fmt::Display for Tilts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let HoldsFor { tilt_deg, down, heading_errors_deg } = self.0;
        let [x, y, z] = down.map(Num);
        write!(f, "holds_for tilt_deg={:.0} down={x:.3},{y:.3},{z:.3}", Num(*tilt_deg))?;
        for (tilt_deg, error_deg) in TILTS_DEG.into_iter().zip(heading_errors_deg) {
            write!(f, " heading_error_at_{:.0}_deg={:.1}", Num(tilt_deg), Num(*error_deg))?;
        }
        Ok(())
    }
}

/// A tilt further than a calibration holds for.
pub(super) struct Tilted {
    tilt_deg: f32,
    limit_deg: f32,
}

impl Device {
    /// Whether level turns are being collected. Never without the feature `methods`, so that nothing of them is linked.
    pub(super) fn is_level(&self) -> bool {
        cfg!(feature = "methods") && self.level.is_some()
    }

    /// The fit of the level turns so far.
    #[inline(never)]
    fn level_so_far(&self) -> Option<Result<LevelFit, NotLevel>> {
        let forces = self.level.as_ref()?;
        let in_use = self.active.as_ref().filter(|active| active.live.is_ok());
        let prior = match in_use.map(|active| &active.record) {
            Some(record) => LevelPrior {
                calibration: record.calibration,
                error: Some(record.predicted_error.share().unwrap_or(MAX_PREDICTED_ERROR)),
                holds_for: record.holds_for,
            },
            None => {
                LevelPrior { calibration: Calibration::identity(ANY_FIELD_UT), error: None, holds_for: None }
            }
        };
        self.session.level_so_far(&prior, forces)
    }

    /// Solves the level turns; the solution waits to be accepted. Where there is none, the session goes on collecting.
    #[inline(never)]
    pub(super) fn solve_level(&mut self) -> Result<LevelFit, NotLevel> {
        let fit = self.level_so_far().unwrap_or(Err(NotLevel::NOTHING))?;
        let record = Record {
            sequence: 0,
            calibration: fit.calibration,
            effects: Effects::none(),
            method: self.session.config().solved_by(),
            model: Order::Ellipsoid,
            samples: fit.samples,
            noise_ut: fit.rms_ut,
            rms_ut: fit.rms_ut,
            axes: Some(self.config.sensor.axes),
            predicted_error: PredictedError::of_share(fit.error),
            covariance: None,
            holds_for: Some(fit.holds_for),
        };
        self.loading.take_record(&record, self.config.sensor.axes).map_err(|_| NotLevel::NOTHING)?;
        self.loading.worse = LevelWorse::of(&fit);
        self.session.cancel();
        (self.level, self.status) = (None, None);
        Ok(fit)
    }

    /// `cal stop` after `cal start level`.
    #[inline(never)]
    pub(super) fn level_stop<W: fmt::Write>(&mut self, mut reply: Reply<'_, W>) -> Answered {
        match self.solve_level() {
            Ok(LevelFit { calibration, holds_for, rms_ut, horizontal_ut, samples, in_use, .. }) => {
                let [level_deg, ..] = holds_for.heading_errors_deg;
                if let Some(worse) = &self.loading.worse {
                    reply.line(format_args!("note {worse}"));
                }
                // A missing one is `-`.
                let in_use_deg = in_use.map_or(f64::NAN, |in_use| in_use.heading_error_deg);
                reply.ok(format_args!(
                    "verdict=accepted model=level n={samples} field_ut={:.3} horizontal_ut={:.3} rms_ut={:.4} heading_error_deg={:.2} \
                     in_use_error_deg={:.2} holds_to_deg={:.0}",
                    Num(calibration.field_ut),
                    Num(horizontal_ut),
                    Num(rms_ut),
                    Num(level_deg),
                    Num(in_use_deg),
                    Num(holds_for.tilt_deg)
                ))
            }
            Err(why) => {
                reply.err(Code::Refused, format_args!("{} {why}; the samples so far are kept", why.code()))
            }
        }
    }

    /// The hint of `status` while level turns are collected.
    #[inline(never)]
    pub(super) fn level_hint<W: fmt::Write>(&self, reply: &mut Reply<'_, W>) {
        match self.level_so_far() {
            Some(Ok(fit)) => {
                let [level_deg, ..] = fit.holds_for.heading_errors_deg;
                reply.line(format_args!(
                    "hint a level heading is right to {:.1} deg, and to 1.5 deg tilted by {:.0} deg; solve with: cal stop",
                    Num(level_deg),
                    Num(fit.holds_for.tilt_deg)
                ));
            }
            Some(Err(why @ (NotLevel::Uncertain(..) | NotLevel::Leaning(_)))) => {
                reply.line(format_args!("hint {why}"));
            }
            _ => {
                reply.line(format_args!("hint turn level: two full circles to the left and two to the right"))
            }
        }
    }

    /// The tilt now, if it is further than the calibration in use holds for.
    pub(super) fn tilted(&self) -> Option<Tilted> {
        let holds_for = self.active.as_ref()?.record.holds_for.as_ref()?;
        let tilt_deg = holds_for.tilt_deg_of(self.learner_inputs.motion.accel_mps2?)?;
        let limit_deg = holds_for.tilt_deg;
        (tilt_deg > limit_deg).then_some(Tilted { tilt_deg, limit_deg })
    }

    /// Says that the board is tilted too far.
    #[inline(never)]
    pub(super) fn say_tilted<W: fmt::Write>(&self, reply: &mut Reply<'_, W>) {
        if let Some(Tilted { tilt_deg, limit_deg }) = self.tilted() {
            reply.line(format_args!(
                "tilted tilt_deg={:.0} holds_to_deg={:.0}; the calibration is not for this tilt",
                Num(tilt_deg),
                Num(limit_deg)
            ));
        }
    }

    /// The lines of `status` about the tilts that the calibration in use holds for.
    #[inline(never)]
    pub(super) fn say_tilts<W: fmt::Write>(&self, reply: &mut Reply<'_, W>) {
        let Some(holds_for) = self.active.as_ref().and_then(|active| active.record.holds_for.as_ref()) else {
            return;
        };
        reply.line(format_args!("{}", Tilts(holds_for)));
        self.say_tilted(reply);
    }
}
