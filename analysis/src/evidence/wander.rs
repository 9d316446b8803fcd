//! How the offset wanders where no column says why: how far, how fast, in which direction, and when.

use crate::bounds::MIN_ODDS;
use crate::evidence::fit::Fit;
use crate::evidence::hidden::hidden_cause;
use crate::noise::cause::{Cause, Moves};
use crate::noise::model::{Noise, Track};
use serde::Serialize;

/// Points of a trace, at most.
const MOST_POINTS: usize = 400;

/// An offset that wanders.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wander {
    /// Its standard deviation by the noise model, all axes together, µT: beside the part that offset and matrix take for themselves.
    pub rms_ut: f64,
    /// Its time constant, s: its values this far apart are alike to 37 %.
    pub time_constant_s: f64,
    /// Its direction in the sensor's axes (a unit vector) where a single one is likelier than three axes of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Times of the trace, s.
    pub t_s: Vec<f64>,
    /// The offset at those times less its mean, µT.
    pub offset_ut: Vec<[f64; 3]>,
}

/// What moves in what a fit leaves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Moving {
    /// The offset.
    pub offset: Option<Wander>,
    /// The share of the variance that a field makes which is stronger in one place than in another.
    pub field_share: Option<f64>,
}

impl Moving {
    /// Of a fit.
    pub fn of(fit: &Fit) -> Moving {
        let cause = hidden_cause(fit).filter(|cause| cause.gain > 0.0);
        match cause {
            Some(field) if field.moves == Moves::Field && field.gain > MIN_ODDS => {
                Moving { offset: None, field_share: Some(field.share(&fit.residual())) }
            }
            // What is no single offset has no direction to show.
            other => {
                let offset = Wander::of(fit, other.filter(|cause| cause.moves == Moves::Offset));
                Moving { offset, field_share: None }
            }
        }
    }
}

impl Wander {
    /// Of what a fit leaves, with the single cause that is behind it; `None` where nothing of it wanders.
    fn of(fit: &Fit, cause: Option<Cause>) -> Option<Wander> {
        let (trace, rms_ut, time_constant_s) = match &cause {
            Some(cause) => (cause.trace_ut(&fit.residual()), cause.size_ut(), cause.time_constant_s),
            None => {
                // A short memory would stand for what moves.
                let track = Track { without_memory: true, ..fit.track.clone() };
                let noise = Noise::fit(&track, &fit.residual(), None, f64::INFINITY);
                if noise.wander.is_none() {
                    return None;
                }
                let history = noise.wander.history(&track, &fit.residual());
                let sum = |[fast, slow]: &[[f64; 3]; 2]| [0, 1, 2].map(|i| fast[i] + slow[i]);
                let (per_axis_ut, time_constant_s) = noise.wander_ut();
                (history.iter().map(sum).collect(), 3f64.sqrt() * per_axis_ut, time_constant_s)
            }
        };
        let n = trace.len() as f64;
        let mean: [f64; 3] = [0, 1, 2].map(|i| trace.iter().map(|v| v[i]).sum::<f64>() / n);
        let off: Vec<[f64; 3]> = trace.iter().map(|v| [0, 1, 2].map(|i| v[i] - mean[i])).collect();
        if !(rms_ut > 0.0) {
            return None;
        }
        let each = off.len().div_ceil(MOST_POINTS);
        Some(Wander {
            rms_ut,
            time_constant_s,
            direction: cause.map(|cause| cause.direction.into()),
            t_s: fit.track.time_s.iter().step_by(each).copied().collect(),
            offset_ut: off.into_iter().step_by(each).collect(),
        })
    }
}
