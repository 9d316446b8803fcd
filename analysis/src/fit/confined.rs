//! The fit of a log that does not show all attitudes, for the attitudes that it shows.

use crate::base::axes::Alignment;
use crate::base::ground::Ground;
use crate::base::solution::Solution;
use crate::base::start::sphere;
use crate::calibration::{AtTilt, FittedEffect, HoldsFor, Information, StdErrors};
use crate::confined::channels::{Channel, turned_by_ut};
use crate::confined::heading::{self, heading_error_deg, horizontal_ut};
use crate::confined::known::{Before, implausible, implausible_attitude, triangle_covariance};
use crate::confined::log::Log;
use crate::confined::solve::{Solved, solve};
use crate::fit::confined_effects::{entries, offsets};
use crate::fit::fitted::Fitted;
use crate::outcome::request::{Options, Purpose};
use crate::reason::Reason;
use crate::samples::samples::{MOST_SAMPLES, Samples};
use crate::table::Table;
use ironout::calibration::{Calibration, norm};
use ironout::fit::{MIN_SAMPLES, Order};
use ironout::quality::MAX_RESIDUAL;
use nalgebra::{Matrix3, Vector3};

/// Largest 1σ of a heading at the attitudes that a calibration is for, degrees: nineteen of twenty headings are then within 3°. A decision,
/// and no physical bound.
pub const MAX_HEADING_ERROR_DEG: f64 = 1.5;
/// Tilts that the error of a heading is said for, degrees.
const TILTS_DEG: [f64; 4] = [0.0, 10.0, 20.0, 45.0];
/// A board that is tilted further than this, degrees, is turned by hand, and has a verdict for all attitudes.
pub(crate) const MOST_TILT_DEG: f64 = 60.0;
/// A calibration is never for less tilt than this, degrees: a road is not a table.
const LEAST_TILT_DEG: f64 = 5.0;
/// What most samples stay below.
pub(crate) const MOST: f64 = 0.95;
/// The field turns as the gyro says within so many times the error of the magnitude, ...
const ACROSS: f64 = 3.0;
/// ... or explains all but this share of the variance by which it turns: a reversed axis leaves more than half of it, and the zero error
/// that is fitted next to it takes most of that.
const UNEXPLAINED: f64 = 0.05;
/// The dip is one dip within this, degrees rms; more is another mounting, or no gravity.
const DIP_DEG: f64 = 10.0;
/// The field keeps its direction against a logged yaw within this, degrees rms, after all that is fitted of it.
const YAW_DEG: f64 = 15.0;
/// The logged yaw errs with the heading by so much, degrees: said, since a yaw that follows this compass does.
const YAW_ERROR_DEG: f64 = 2.0;
/// The model is linear in the attitude's delay: it is fitted again about a delay of more than this, s, so many times at most.
const DELAY_S: f64 = 0.01;
const DELAY_ROUNDS: usize = 3;
/// A sensor is not further from what such sensors are than so many standard deviations.
const IMPLAUSIBLE: f64 = 5.0;
/// Sectors of heading, and how many of them show the board turned all round.
const SECTORS: usize = 12;
const ALL_ROUND: usize = 11;

/// Fits a log that the ordinary fit has refused, for the attitudes that it shows. What is refused stays as it was where these do not
/// carry a heading either, and says so.
pub(crate) fn tried(ground: &Ground, options: &Options, refused: Fitted) -> Fitted {
    let counted = &ground.counted;
    let elsewhere = refused.accepted
        || options.purpose == Purpose::All
        || counted.rests
        || counted.table.axes_in_doubt
        || counted.axes != [true; 3]
        || (counted.used.len() as u64) < MIN_SAMPLES
        || refused.is_of_other_axes()
        || refused.is_of_another_field();
    let columns = offsets(&counted.samples, options);
    let (false, Some(columns)) = (elsewhere, columns) else { return refused };
    // Of a log in stretches neither columns nor attitude are at hand.
    let whole = counted.samples.stride == 1;
    if !whole && !columns.is_empty() {
        return refused;
    }
    let plain = if whole { Log::of(&counted.samples) } else { Log::of_counted(counted) };
    let Some(plain) = plain.map(|log| log.with_effects(&columns)) else { return refused };
    let unused = match if whole { posed(ground, options, &plain) } else { too_long(counted.table.attitude) } {
        Some(Ok((solved, log))) => return judged(ground, options, refused, &solved, &log),
        Some(Err(why)) => Some(why),
        None => None,
    };
    if plain.tilt_deg(MOST) >= MOST_TILT_DEG {
        return refused;
    }
    let Some(solved) = solved(ground, options, &plain) else { return refused };
    let mut fitted = judged(ground, options, refused, &solved, &plain);
    if let Some(why) = unused {
        fitted.reasons.push(Reason::new(
            "logged-attitude-unused",
            format!("note: the logged attitude is not used: {why}"),
        ));
    }
    fitted
}

/// Why a log is not calibrated for the tilts that it contains either.
fn of_its_tilts(dip_spread_deg: f64, error_share: f64) -> String {
    let why = if dip_spread_deg > DIP_DEG {
        format!(
            "the angle between field and gravity varies by {dip_spread_deg:.0}° rms (limit {DIP_DEG:.0}°). Either \
             magnetometer and accelerometer have different axes (--rotate), or the accelerometer does not measure gravity"
        )
    } else {
        format!(
            "the error of the magnitude is {:.1} % of the field (limit {:.0} %). Fix: run ironout diagnose to find the cause",
            100.0 * error_share,
            100.0 * MAX_RESIDUAL
        )
    };
    format!("the fit for limited tilts is refused too: {why}")
}

/// Why the attitude of a log that is taken in stretches is not used.
fn too_long(attitude: Option<[&[f64]; 4]>) -> Option<Result<(Solved, Log), String>> {
    attitude.map(|_| {
        Err(format!("the log has more than {MOST_SAMPLES} samples. Fix: cut it, or log at a lower rate"))
    })
}

/// The likeliest calibration with the logged attitude, or why that is not used; `None` where there is none.
fn posed(ground: &Ground, options: &Options, plain: &Log) -> Option<Result<(Solved, Log), String>> {
    let counted = &ground.counted;
    let mut after_s = 0.0;
    let mut rounds = 0;
    loop {
        let log = match plain.with_attitude(counted.table, &counted.samples, after_s)? {
            Ok(log) => log,
            Err(why) => return Some(Err(why)),
        };
        if log.tilt_deg(MOST) >= MOST_TILT_DEG {
            return None;
        }
        let solved = solved(ground, options, &log)?;
        let delay_s = solved.state.attitude_delay_s;
        if let Some(why) = attitude_fault(&solved, after_s + delay_s) {
            return Some(Err(why));
        }
        rounds += 1;
        if delay_s.abs() < DELAY_S || rounds == DELAY_ROUNDS {
            return Some(Ok((solved, log)));
        }
        after_s += delay_s;
    }
}

/// Why the attitude of a log, so many seconds early, is not to be believed.
fn attitude_fault(solved: &Solved, early_s: f64) -> Option<String> {
    let rms_ut =
        |channel| solved.heard.iter().find(|heard| heard.channel == channel).map(|heard| heard.rms_ut);
    let level_ut = horizontal_ut(solved);
    let yaw_deg = rms_ut(Channel::Yaw)?.atan2(level_ut).to_degrees();
    let tilt_deg = rms_ut(Channel::Tilt)?.atan2(level_ut).to_degrees();
    if yaw_deg > YAW_DEG {
        return Some(format!("the field turns by {yaw_deg:.0}° rms against its yaw"));
    }
    if tilt_deg > DIP_DEG {
        return Some(format!("the dip varies by {tilt_deg:.0}° rms against its down"));
    }
    implausible_attitude(&solved.state, early_s, IMPLAUSIBLE)
}

/// The likeliest calibration.
fn solved(ground: &Ground, options: &Options, log: &Log) -> Option<Solved> {
    let prior = options.prior.as_ref();
    let own = ground.base.as_ref().ok().map(|base| base.solution.calibration.offset_ut);
    let own = own.or_else(|| sphere(&ground.counted.samples).map(|(centre, _)| centre));
    let offsets: Vec<Vector3<f64>> =
        [own, prior.map(|prior| prior.offset_ut)].into_iter().flatten().map(Vector3::from).collect();
    let matrix = prior.map_or(Matrix3::identity(), |prior| Matrix3::from_fn(|i, j| prior.triangle[i][j]));
    let earth = ground.counted.table.earth;
    let before = Before {
        field_ut: options.field_ut.or(earth.map(|earth| earth.field_ut)),
        dip_deg: options.dip_deg.or(earth.map(|earth| earth.dip_deg)),
        declination_deg: earth.map(|earth| earth.declination_deg),
        prior: prior.cloned(),
    };
    solve(log, matrix, &offsets, &before)
}

/// How far a solution carries, and the verdict.
fn judged(ground: &Ground, options: &Options, refused: Fitted, solved: &Solved, log: &Log) -> Fitted {
    let found = entries(&ground.counted.samples, options, solved, log);
    let Some((effects, not_significant)) = found else { return refused };
    let Some(solution) = solution(ground, options, solved, log, effects) else { return refused };
    let own_tilt_deg = (solved.tilt_share.sqrt() * log.tilt_deg(MOST)).max(LEAST_TILT_DEG);
    let tilt_deg = match options.purpose {
        Purpose::Tilt(tilt_deg) => tilt_deg,
        Purpose::AsShown | Purpose::All => own_tilt_deg.ceil(),
    };
    let at = |tilt_deg| AtTilt {
        tilt_deg,
        heading_error_deg: heading_error_deg(solved, &log.mean_down, &log.effects, tilt_deg),
    };
    let holds_for = HoldsFor {
        tilt_deg,
        down: log.mean_down.into(),
        heading_errors: TILTS_DEG.into_iter().map(at).collect(),
    };
    let error_deg = at(tilt_deg).heading_error_deg;
    let field_ut = solution.calibration.field_ut;
    let rms_ut = |channel| {
        let heard = solved.heard.iter().find(|heard| heard.channel == channel);
        heard.map_or(0.0, |heard| heard.rms_ut)
    };
    let (along_ut, across_ut) = (rms_ut(Channel::Magnitude), rms_ut(Channel::Gyro));
    let dip_channel = if log.has_attitude() { Channel::Tilt } else { Channel::Dip };
    let dip_spread_deg = rms_ut(dip_channel).atan2(horizontal_ut(solved)).to_degrees();
    let sectors = sectors(log, solved);
    let mut fitted = refused.clone();
    fitted.holdout_rms_ut = None;
    fitted.judge(&ground.counted, solution, options.registry);
    fitted.dip_deg =
        Some((solved.state.vertical_ut / solved.state.field_ut).clamp(-1.0, 1.0).asin().to_degrees());
    fitted.heading_error_deg = Some(error_deg);
    let turned_ut = if across_ut > 0.0 { turned_by_ut(log, &solved.state) } else { 0.0 };
    let turns_otherwise =
        across_ut > ACROSS * along_ut && across_ut.powi(2) > UNEXPLAINED * turned_ut.powi(2);
    let implausible = implausible(&solved.state, IMPLAUSIBLE);
    let sound = fitted.is_refused_for_attitudes_only() && along_ut < MAX_RESIDUAL * field_ut;
    if dip_spread_deg > DIP_DEG || along_ut >= MAX_RESIDUAL * field_ut {
        let mut refused = refused;
        refused
            .reasons
            .push(Reason::new("not-for-its-tilts", of_its_tilts(dip_spread_deg, along_ut / field_ut)));
        return refused;
    }
    if !sound {
        return refused;
    }
    if turns_otherwise || implausible.is_some() {
        let mut refused = refused;
        let why = implausible.map_or_else(String::new, |words| format!(": {words}"));
        refused.reasons.insert(
            0,
            Reason::new("gyro-disagrees", format!(
                "the field does not rotate as gyro and accelerometer measure{why}. Check the axes and units of the three \
                 sensors (--rotate, --map), and that magnetometer and gyro use the same clock"
            )));
        return refused;
    }
    let shown = format!("this log does not contain all orientations (tilts up to {own_tilt_deg:.0}°)");
    if !(error_deg <= MAX_HEADING_ERROR_DEG) {
        let mut refused = refused;
        let words = too_little(&shown, &holds_for, tilt_deg, error_deg, sectors);
        refused.reasons.insert(0, Reason::new("too-few-orientations", words));
        return refused;
    }
    if !not_significant.is_empty() && !options.force_effect {
        let mut refused = refused;
        let remedy = "Drop it, or use --force-effect if you know it from another test";
        refused.reasons.splice(
            0..0,
            not_significant
                .into_iter()
                .map(|doubt| Reason::new("effect-not-significant", format!("{doubt}. {remedy}"))),
        );
        return refused;
    }
    fitted.accepted = true;
    fitted.reasons = vec![Reason::new(
        "limited-tilt",
        format!(
            "note: {shown}. Fitted for tilts up to {tilt_deg:.0}°: the heading error is {} (1σ), plus the constant mounting \
         angle of the sensor in the vehicle, which a magnetometer cannot measure",
            holds_for.words()
        ),
    )];
    if across_ut == 0.0 {
        fitted.reasons.push(Reason::new("no-gyro", "note: without a gyro ironout cannot detect an inverted magnetometer axis. Compare with one known \
             heading"));
    }
    let yaw_error_deg = solved.yaw_error_rad.to_degrees();
    if log.has_attitude() && yaw_error_deg > YAW_ERROR_DEG {
        fitted.reasons.push(Reason::new(
            "logged-yaw",
            format!(
                "note: the logged yaw is wrong by about {yaw_error_deg:.0}° in a way that depends on the heading, as if it came from \
                 this compass. ironout gives it less weight"
            ),
        ));
    }
    fitted.reasons.extend(not_significant.into_iter().map(|doubt| {
        Reason::new("effect-not-significant", format!("note: {doubt}. It is kept because of --force-effect"))
    }));
    fitted.reasons.extend(refused.reasons.iter().filter(|reason| reason.starts_with("note: ")).cloned());
    fitted.holds_for = Some(holds_for);
    fitted
}

/// What to know of a log that is tilted further than its calibration is for.
pub fn beyond(holds_for: &HoldsFor, table: &Table) -> Option<String> {
    let samples = Samples::take(table, &vec![false; table.rows()], [true; 3]);
    let log = Log::of(&samples)?.about(holds_for.down.into());
    let tilt_deg = log.tilt_deg(MOST);
    (tilt_deg > holds_for.tilt_deg + LEAST_TILT_DEG).then(|| {
        format!(
            "this log is tilted by up to {tilt_deg:.0}° and the calibration is for tilts up to {:.0}°: the heading error is \
             {} (1σ)",
            holds_for.tilt_deg,
            holds_for.words()
        )
    })
}

/// Why not, and what to do.
fn too_little(shown: &str, holds_for: &HoldsFor, tilt_deg: f64, error_deg: f64, sectors: usize) -> String {
    let remedy = if sectors < ALL_ROUND {
        format!(
            "the log covers {sectors} of {SECTORS} heading sectors. Fix: turn a full circle to the left and one to \
             the right"
        )
    } else {
        "continue, over slopes and in both directions".to_string()
    };
    let asked = if error_deg > 90.0 { "anything".to_string() } else { format!("{error_deg:.1}°") };
    format!(
        "{shown}, and for tilts up to {tilt_deg:.0}° the heading error would be {asked} (1σ; limit {}): {}. Fix: \
         {remedy}, or use a calibration made on the bench with --prior bench.json --free offset",
        format_args!("{MAX_HEADING_ERROR_DEG}°"),
        holds_for.words()
    )
}

/// How many sectors of heading the board was turned through.
fn sectors(log: &Log, solved: &Solved) -> usize {
    let first = log.mean_down.cross(&Vector3::ith(log.mean_down.iamin(), 1.0)).normalize();
    let second = log.mean_down.cross(&first);
    let mut seen = [false; SECTORS];
    for row in &log.rows {
        let v = solved.state.corrected(row);
        let turn = second.dot(&v).atan2(first.dot(&v)) / std::f64::consts::TAU;
        seen[((turn + 0.5) * SECTORS as f64) as usize % SECTORS] = true;
    }
    seen.into_iter().filter(|seen| *seen).count()
}

/// As other fits give it.
fn solution(
    ground: &Ground,
    options: &Options,
    solved: &Solved,
    log: &Log,
    effects: Vec<FittedEffect>,
) -> Option<Solution> {
    let state = &solved.state;
    let full = state.matrix_as_shown(&log.mean_down);
    let rows_of = |matrix: &Matrix3<f64>| std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    let calibration =
        Calibration { offset_ut: state.offset_ut.into(), matrix: rows_of(&full), field_ut: state.field_ut };
    if !calibration.is_sound() {
        return None;
    }
    let (offset_ut, matrix) = heading::std_errors(solved);
    let counted = &ground.counted;
    let mean_square = |value: &dyn Fn([f64; 3]) -> f64| {
        let squares: f64 = counted.used.iter().map(|&sample| value(counted.data.field(sample)).powi(2)).sum();
        (squares / counted.used.len().max(1) as f64).sqrt()
    };
    let rms_ut = match effects.is_empty() {
        true => mean_square(&|v| norm(calibration.apply(v)) - state.field_ut),
        false => {
            let off = |row| (state.corrected(row).norm() - state.field_ut).powi(2);
            (log.rows.iter().map(off).sum::<f64>() / log.rows.len().max(1) as f64).sqrt()
        }
    };
    let covariance = triangle_covariance(&state.matrix, &solved.covariance)?;
    Some(Solution {
        calibration,
        std_errors: StdErrors { offset_ut, matrix },
        effects,
        rms_ut,
        predicted_error_ut: heading::vector_error_ut(solved),
        rotation_error_rad: 0.0,
        field_varies_by_ut: 0.0,
        measured_field_ut: mean_square(&|v| {
            norm(std::array::from_fn(|axis| v[axis] - calibration.offset_ut[axis]))
        }),
        model: Order::Ellipsoid,
        information: Information::from_covariance(&covariance),
        alignment: Alignment::ByAll,
        without_effects: None,
        prior: Some(match options.prior {
            Some(_) => "the information of the earlier calibration, and typical magnetometer tolerances".into(),
            None => "typical magnetometer tolerances: gains within 10 %, axes within 3° of right angles, mounted within 6° \
                 of the accelerometer's axes"
                .into(),
        }),
    })
}
