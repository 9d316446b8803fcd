//! The fit of a log that does not show all attitudes, for the attitudes that it shows.

use crate::base::axes::Alignment;
use crate::base::ground::Ground;
use crate::base::solution::Solution;
use crate::base::start::sphere;
use crate::calibration::{AtTilt, HoldsFor, Information, StdErrors};
use crate::confined::channels::{Channel, turned_by_ut};
use crate::confined::heading::{self, heading_error_deg, horizontal_ut};
use crate::confined::known::{Before, implausible, triangle_covariance};
use crate::confined::log::Log;
use crate::confined::solve::{Solved, solve};
use crate::fit::fitted::Fitted;
use crate::outcome::request::{Options, Purpose};
use crate::reason::Reason;
use crate::samples::samples::Samples;
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
const MOST_TILT_DEG: f64 = 60.0;
/// A calibration is never for less tilt than this, degrees: a road is no table.
const LEAST_TILT_DEG: f64 = 5.0;
/// What most samples stay below.
const MOST: f64 = 0.95;
/// The field turns as the gyro says within so many times the error of the magnitude, ...
const ACROSS: f64 = 3.0;
/// ... or explains all but this share of the variance by which it turns: a reversed axis leaves more than half of it, and the zero error
/// that is fitted beside it takes most of that.
const UNEXPLAINED: f64 = 0.05;
/// The dip is one dip within this, degrees rms; more is another mounting, or no gravity.
const DIP_DEG: f64 = 10.0;
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
        || !options.add.is_empty()
        || counted.rests
        || counted.table.axes_in_doubt
        || counted.axes != [true; 3]
        || (counted.used.len() as u64) < MIN_SAMPLES
        || refused.is_of_other_axes()
        || refused.is_of_another_field();
    let log = if elsewhere { None } else { Log::of(&counted.samples) };
    let log = log.filter(|log| log.tilt_deg(MOST) < MOST_TILT_DEG);
    match log.and_then(|log| Some((solved(ground, options, &log)?, log))) {
        Some((solved, log)) => judged(ground, options, refused, &solved, &log),
        None => refused,
    }
}

/// The likeliest calibration.
fn solved(ground: &Ground, options: &Options, log: &Log) -> Option<Solved> {
    let prior = options.prior.as_ref();
    let own = ground.base.as_ref().ok().map(|base| base.solution.calibration.offset_ut);
    let own = own.or_else(|| sphere(&ground.counted.samples).map(|(centre, _)| centre));
    let offsets: Vec<Vector3<f64>> =
        [own, prior.map(|prior| prior.offset_ut)].into_iter().flatten().map(Vector3::from).collect();
    let matrix = prior.map_or(Matrix3::identity(), |prior| Matrix3::from_fn(|i, j| prior.triangle[i][j]));
    let before = Before { field_ut: options.field_ut, dip_deg: options.dip_deg, prior: prior.cloned() };
    solve(log, matrix, &offsets, &before)
}

/// How far a solution carries, and the verdict.
fn judged(ground: &Ground, options: &Options, refused: Fitted, solved: &Solved, log: &Log) -> Fitted {
    let Some(solution) = solution(ground, options, solved, log) else { return refused };
    let own_tilt_deg = (solved.tilt_share.sqrt() * log.tilt_deg(MOST)).max(LEAST_TILT_DEG);
    let tilt_deg = match options.purpose {
        Purpose::Tilt(tilt_deg) => tilt_deg,
        Purpose::AsShown | Purpose::All => own_tilt_deg.ceil(),
    };
    let at = |tilt_deg| AtTilt {
        tilt_deg,
        heading_error_deg: heading_error_deg(solved, &log.mean_down, tilt_deg),
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
    let dip_spread_deg = rms_ut(Channel::Dip).atan2(horizontal_ut(solved)).to_degrees();
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
    if dip_spread_deg > DIP_DEG || !sound {
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
            "only {sectors} of {SECTORS} sectors of heading were covered. Fix: turn a full circle to the left and one to \
             the right"
        )
    } else {
        "continue, over slopes and in both directions".to_string()
    };
    let asked = if error_deg > 90.0 { "anything".to_string() } else { format!("{error_deg:.1}°") };
    format!(
        "{shown}, and for tilts up to {tilt_deg:.0}° the heading error would be {asked} (1σ; {} at most): {}. Fix: \
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
        let v = solved.state.corrected(&row.measured_ut);
        let turn = second.dot(&v).atan2(first.dot(&v)) / std::f64::consts::TAU;
        seen[((turn + 0.5) * SECTORS as f64) as usize % SECTORS] = true;
    }
    seen.into_iter().filter(|seen| *seen).count()
}

/// As other fits give it.
fn solution(ground: &Ground, options: &Options, solved: &Solved, log: &Log) -> Option<Solution> {
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
    let covariance = triangle_covariance(&state.matrix, &solved.covariance)?;
    Some(Solution {
        calibration,
        std_errors: StdErrors { offset_ut, matrix },
        effects: Vec::new(),
        rms_ut: mean_square(&|v| norm(calibration.apply(v)) - state.field_ut),
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
