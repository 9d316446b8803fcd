//! What to do with the refused log of a vehicle that was not turned over.

use crate::base::ground::Ground;
use crate::confined::log::Log;
use crate::fit::confined::{MOST, MOST_TILT_DEG};
use crate::fit::fitted::Fitted;
use crate::outcome::request::Options;
use crate::reason::Reason;

/// Codes of refusals that more orientations would cure.
const FOR_ORIENTATIONS: [&str; 3] = ["planar", "no-ellipsoid", "error-too-large"];

/// Says first what such a log is good for: "rotate the sensor" is no advice for a flight.
pub(crate) fn advised(ground: &Ground, options: &Options, mut fitted: Fitted) -> Fitted {
    let first = fitted.reasons.first().map(|reason| reason.code);
    if fitted.accepted
        || options.prior.is_some()
        || ground.counted.rests
        || !first.is_some_and(|code| FOR_ORIENTATIONS.contains(&code))
    {
        return fitted;
    }
    let counted = &ground.counted;
    let log = if counted.samples.stride == 1 { Log::of(&counted.samples) } else { Log::of_counted(counted) };
    let Some(tilt_deg) = log.map(|log| log.tilt_deg(MOST)).filter(|tilt_deg| *tilt_deg < MOST_TILT_DEG)
    else {
        return fitted;
    };
    fitted.reasons.insert(
        0,
        Reason::new(
            "vehicle",
            format!(
                "this log does not contain all orientations (tilts up to {tilt_deg:.0}°). Fix: if the sensor is in a vehicle that \
                 cannot be turned over, keep a calibration made on the bench (--prior bench.json --free offset) or the autopilot's own \
                 (--prior-from parameters)"
            ),
        ),
    );
    fitted
}
