//! An attitude from known headings: the gyro turns it, gravity levels it, the headings hold its yaw.
//!
//! Nothing of it comes from the magnetometer, so that it is evidence about the magnetometer. It then goes the way of an attitude that an
//! autopilot logged, with the same parameters for a yaw that is wrong.

use crate::table::Table;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// A known heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownHeading {
    /// Time, s.
    pub time_s: f64,
    /// Clockwise from true north, degrees.
    pub heading_deg: f64,
}

/// A heading counts for the rows within this time of it, s.
const ABOUT_S: f64 = 0.25;
/// Further from every known heading than this, s, the yaw is not known: a gyro drifts.
const REACH_S: f64 = 120.0;
/// The accelerometer levels the attitude within this time, s.
const LEVEL_S: f64 = 3.0;
/// ... as far as it shows gravity within this share.
const GRAVITY_SHARE: f64 = 0.05;
const GRAVITY_MPS2: f64 = 9.806_65;
/// Between rows further apart than this, s, the gyro is not known.
const PAUSE_S: f64 = 0.3;
/// The gyro's zero error is its mean where it is below this, rad/s, for so long, s.
const AT_REST_RADPS: f64 = 0.03;
const AT_REST_S: f64 = 2.0;
/// A course is a heading above this speed, m/s, ...
const COURSE_SPEED_MPS: f64 = 3.0;
/// ... or so many times what the receiver says of the error of its speed: the course is then right to 6°, ...
const COURSE_SPEED_ERRORS: f64 = 10.0;
/// ... while the vehicle turns by no more than this, rad/s, ...
const STRAIGHT_RADPS: f64 = 0.03;
/// ... for so long, s; one heading is made of so long a stretch at most, s.
const STRAIGHT_S: f64 = 1.0;
const STRETCH_S: f64 = 10.0;

/// The headings of the stretches that the vehicle drove straight, from the course of a GPS receiver, degrees, its speed and the error of
/// that, m/s.
pub fn of_course(
    table: &Table,
    course_deg: &[f64],
    speed_mps: &[f64],
    speed_error_mps: Option<&[f64]>,
) -> Vec<KnownHeading> {
    let (Some(time_s), Some(gyro)) = (table.time_s, table.gyro_radps) else { return Vec::new() };
    // A vehicle on a road rolls and pitches with every bump: only its turns about the vertical count.
    let up = table.accel_mps2.and_then(|accel| {
        let sum = |axis: &[f64]| axis.iter().filter(|value| value.is_finite()).sum::<f64>();
        Vector3::from(accel.map(sum)).try_normalize(f64::MIN_POSITIVE)
    });
    let is_straight = |row: usize| {
        let least = speed_error_mps.map_or(COURSE_SPEED_MPS, |error| COURSE_SPEED_ERRORS * error[row]);
        let rate = Vector3::from(gyro.map(|axis| axis[row]));
        let turn = up.map_or(rate.norm(), |up| rate.dot(&up).abs());
        speed_mps[row] > least.max(1.0) && turn < STRAIGHT_RADPS && course_deg[row].is_finite()
    };
    let mut list = Vec::new();
    let mut row = 0;
    while row < time_s.len() {
        let begin = row;
        let (mut sine, mut cosine) = (0.0, 0.0);
        while row < time_s.len() && is_straight(row) && time_s[row] - time_s[begin] < STRETCH_S {
            let (s, c) = course_deg[row].to_radians().sin_cos();
            (sine, cosine) = (sine + s, cosine + c);
            row += 1;
        }
        if row > begin && time_s[row - 1] - time_s[begin] >= STRAIGHT_S {
            let time_s = 0.5 * (time_s[row - 1] + time_s[begin]);
            list.push(KnownHeading { time_s, heading_deg: f64::atan2(sine, cosine).to_degrees() });
        }
        row = row.max(begin + 1);
    }
    list
}

/// How a logged yaw differs from known headings: by an error that depends on the heading, as that of a compass does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Its amplitude, degrees.
    pub amplitude_deg: f64,
    /// The standard error of that, degrees.
    pub error_deg: f64,
}

/// Fewest headings that show a deviation: its constant, sine and cosine, and one to measure the error with.
const MIN_HEADINGS: usize = 4;
/// A course is not better than this, degrees (1σ): few headings that agree by chance show no smaller error.
const COURSE_ERROR_DEG: f64 = 1.0;
/// A deviation is significant beyond so many standard errors ...
const DEVIATION_SIGMAS: f64 = 4.0;
/// ... and matters beyond this amplitude, degrees: a compass heading is accepted with 1.5° (1σ).
const MIN_DEVIATION_DEG: f64 = 3.0;
/// A course further than this from the usual difference, degrees, is that of a vehicle in reverse.
const REVERSE_DEG: f64 = 90.0;

/// The deviation of the table's attitude from these headings; `None` where it is not significant. Headings of a vehicle in reverse are taken
/// out of the list.
pub fn deviation(table: &Table, known: &mut Vec<KnownHeading>) -> Option<Deviation> {
    let (time_s, columns) = (table.time_s?, table.attitude?);
    let [w, x, y, z] = columns;
    let off_deg = |one: &KnownHeading| {
        let row = time_s.partition_point(|t| *t < one.time_s).min(time_s.len().checked_sub(1)?);
        let q = UnitQuaternion::new_normalize(Quaternion::new(w[row], x[row], y[row], z[row]));
        let forward = q * Vector3::x();
        let off = one.heading_deg - forward.y.atan2(forward.x).to_degrees();
        off.is_finite().then(|| wrapped_deg(off))
    };
    let mut offs: Vec<f64> = known.iter().filter_map(off_deg).collect();
    if offs.len() != known.len() || offs.is_empty() {
        return None;
    }
    // The middle of a circle: the difference that the others are nearest to.
    let usual = |offs: &[f64]| {
        let far = |from: f64| offs.iter().map(|off| wrapped_deg(off - from).abs()).sum::<f64>();
        offs.iter().copied().min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or_default()
    };
    let middle = usual(&offs);
    let mut forwards = offs.iter().map(|off| wrapped_deg(off - middle).abs() < REVERSE_DEG);
    known.retain(|_| forwards.next().unwrap_or(false));
    offs.retain(|off| wrapped_deg(off - middle).abs() < REVERSE_DEG);
    if known.len() < MIN_HEADINGS {
        return None;
    }
    let rows = known.iter().zip(&offs).map(|(one, off)| {
        let (sine, cosine) = one.heading_deg.to_radians().sin_cos();
        (Vector3::new(1.0, sine, cosine), wrapped_deg(off - middle))
    });
    let (mut normal, mut right, mut square) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for (row, off) in rows {
        normal += row * row.transpose();
        right += off * row;
        square += off * off;
    }
    let inverse = normal.try_inverse()?;
    let solved = inverse * right;
    let variance = (square - solved.dot(&right)).max(0.0) / (known.len() - 3) as f64;
    let variance = variance.max(COURSE_ERROR_DEG * COURSE_ERROR_DEG);
    let amplitude_deg = solved.y.hypot(solved.z);
    let along = Vector3::new(0.0, solved.y, solved.z) / amplitude_deg;
    let error_deg = (variance * along.dot(&(inverse * along))).sqrt();
    (amplitude_deg > MIN_DEVIATION_DEG && amplitude_deg > DEVIATION_SIGMAS * error_deg)
        .then_some(Deviation { amplitude_deg, error_deg })
}

fn wrapped_deg(angle: f64) -> f64 {
    angle - 360.0 * (angle / 360.0).round()
}

/// The attitude at every row, as a quaternion from body axes (forward, right, down) to north, east, down: w, x, y, z; NaN where it is not
/// known. `None` without time, accelerometer or gyro, or if no heading falls into the log.
pub fn attitude(table: &Table, known: &[KnownHeading]) -> Option<[Vec<f64>; 4]> {
    let (time_s, accel, gyro) = (table.time_s?, table.accel_mps2?, table.gyro_radps?);
    let at = |columns: [&[f64]; 3], row: usize| Vector3::from(columns.map(|column| column[row]));
    let bias = at_rest(time_s, |row| at(gyro, row));
    let turns = |row: usize| {
        let (step_s, rate) = (time_s[row] - time_s[row - 1], at(gyro, row) + at(gyro, row - 1));
        let is_known = step_s < PAUSE_S && rate.iter().all(|axis| axis.is_finite());
        is_known.then(|| UnitQuaternion::from_scaled_axis((0.5 * rate - bias) * step_s))
    };
    let down = Vector3::z();
    let levelled = |attitude: UnitQuaternion<f64>, row: usize, share: f64| {
        let force = at(accel, row);
        let size = force.norm();
        if !((size / GRAVITY_MPS2 - 1.0).abs() < GRAVITY_SHARE) {
            return attitude;
        }
        let seen = attitude * (-force / size);
        let turn = UnitQuaternion::rotation_between(&seen, &down).unwrap_or_default();
        UnitQuaternion::from_scaled_axis(share * turn.scaled_axis()) * attitude
    };
    // Forwards for its end, then back: each row is levelled by what comes before and after it.
    let mut attitudes = vec![UnitQuaternion::identity(); time_s.len()];
    let mut now = levelled(UnitQuaternion::identity(), 0, 1.0);
    let mut pieces = vec![0_usize; time_s.len()];
    for row in 1..time_s.len() {
        let share = ((time_s[row] - time_s[row - 1]) / LEVEL_S).min(1.0);
        pieces[row] = pieces[row - 1];
        match turns(row) {
            Some(turn) => now = levelled(now * turn, row, share),
            None => {
                pieces[row] += 1;
                now = levelled(now, row, 1.0);
            }
        }
    }
    for row in (0..time_s.len()).rev() {
        attitudes[row] = now;
        if row > 0 {
            let share = ((time_s[row] - time_s[row - 1]) / LEVEL_S).min(1.0);
            now = match turns(row) {
                Some(turn) => levelled(now * turn.inverse(), row - 1, share),
                None => levelled(now, row - 1, 1.0),
            };
        }
    }
    let heading = |row: usize| {
        let forward = attitudes[row] * Vector3::x();
        forward.y.atan2(forward.x)
    };
    let mut held = Vec::new();
    for one in known {
        let begin = time_s.partition_point(|t| *t < one.time_s - ABOUT_S);
        let end = time_s.partition_point(|t| *t <= one.time_s + ABOUT_S);
        let offs: Vec<f64> = (begin..end).map(|row| one.heading_deg.to_radians() - heading(row)).collect();
        if !offs.is_empty() {
            let sum = |of: fn(f64) -> f64| offs.iter().map(|off| of(*off)).sum::<f64>();
            held.push((one.time_s, pieces[(begin + end) / 2], sum(f64::sin).atan2(sum(f64::cos))));
        }
    }
    held.sort_by(|one, other| one.0.total_cmp(&other.0));
    if held.is_empty() {
        return None;
    }
    let mut columns: [Vec<f64>; 4] = Default::default();
    for row in 0..time_s.len() {
        let yaw = held_yaw(&held, time_s[row], pieces[row]);
        let q = yaw.map(|yaw| UnitQuaternion::from_scaled_axis(yaw * down) * attitudes[row]);
        let parts = q.map_or([f64::NAN; 4], |q| [q.w, q.i, q.j, q.k]);
        columns.iter_mut().zip(parts).for_each(|(column, part)| column.push(part));
    }
    Some(columns)
}

/// What has to be added to the yaw at this time, rad, on the line between the known headings of the same piece of the log.
fn held_yaw(held: &[(f64, usize, f64)], time_s: f64, piece: usize) -> Option<f64> {
    let own = || held.iter().filter(move |one| one.1 == piece && (one.0 - time_s).abs() < REACH_S);
    let before = own().rfind(|one| one.0 <= time_s);
    let after = own().find(|one| one.0 > time_s);
    match (before, after) {
        (Some(before), Some(after)) => {
            let turn = std::f64::consts::TAU;
            let moved = after.2 - before.2;
            let moved = moved - turn * (moved / turn).round();
            Some(before.2 + moved * (time_s - before.0) / (after.0 - before.0))
        }
        (Some(only), None) | (None, Some(only)) => Some(only.2),
        (None, None) => None,
    }
}

/// The gyro's zero error, rad/s, where the vehicle stood long enough; else zero.
fn at_rest(time_s: &[f64], rate: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
    let (mut sum, mut count, mut rest_s) = (Vector3::zeros(), 0.0, 0.0);
    for row in 1..time_s.len() {
        let one = rate(row);
        let step_s = time_s[row] - time_s[row - 1];
        if one.norm() < AT_REST_RADPS && step_s < PAUSE_S {
            (sum, count, rest_s) = (sum + one, count + 1.0, rest_s + step_s);
        }
    }
    if rest_s > AT_REST_S { sum / count } else { Vector3::zeros() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A vehicle that drives a square of straight sides, with a drifting gyro: its columns, and its true heading, rad.
    fn driven() -> ([Vec<f64>; 8], Vec<f64>) {
        let mut columns: [Vec<f64>; 8] = Default::default();
        let (mut heading, mut truth) = (0.4_f64, Vec::new());
        for i in 0..6000 {
            let t = 0.02 * f64::from(i);
            let rate = if (i / 500) % 2 == 1 { 0.157 } else { 0.0 };
            heading += 0.02 * rate;
            let course = heading.to_degrees().rem_euclid(360.0);
            let row = [t, 0.0, 0.0, -9.806_65, 0.004, -0.002, rate + 0.003, course];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            truth.push(heading);
        }
        (columns, truth)
    }

    fn table(columns: &[Vec<f64>; 8]) -> Table<'_> {
        let [t, ax, ay, az, gx, gy, gz, _] = columns.each_ref().map(Vec::as_slice);
        Table {
            time_s: Some(t),
            accel_mps2: Some([ax, ay, az]),
            gyro_radps: Some([gx, gy, gz]),
            ..Table::default()
        }
    }

    fn most_off_deg(attitude: &[Vec<f64>; 4], truth: &[f64]) -> f64 {
        let [w, x, y, z] = attitude;
        let off = |row: usize| {
            let yaw = f64::atan2(
                2.0 * (w[row] * z[row] + x[row] * y[row]),
                1.0 - 2.0 * (y[row].powi(2) + z[row].powi(2)),
            );
            let off = (yaw - truth[row]) / std::f64::consts::TAU;
            360.0 * (off - off.round()).abs()
        };
        (0..truth.len()).filter(|row| w[*row].is_finite()).map(off).fold(0.0, f64::max)
    }

    #[test]
    fn the_course_of_straight_sides_holds_the_yaw_through_the_turns() {
        let (columns, truth) = driven();
        let table = table(&columns);
        let speed = vec![6.0; truth.len()];
        let known = of_course(&table, &columns[7], &speed, None);
        assert!((6..=12).contains(&known.len()), "{known:?}");
        let attitude = attitude(&table, &known).expect("there are headings");
        assert!(most_off_deg(&attitude, &truth) < 2.0, "{}", most_off_deg(&attitude, &truth));
        // A receiver that is not sure of its speed, and one that stands.
        assert!(of_course(&table, &columns[7], &speed, Some(&vec![1.0; truth.len()])).is_empty());
        assert!(of_course(&table, &columns[7], &vec![0.5; truth.len()], None).is_empty());
    }

    #[test]
    fn a_yaw_that_follows_a_compass_deviates_and_a_turned_one_does_not() {
        let (columns, truth) = driven();
        let speed = vec![6.0; truth.len()];
        let mut deviations = Vec::new();
        // Hard iron of a third of the horizontal field; a sensor that is turned by 20°.
        for deviate in [|heading: f64| heading + 0.33 * heading.sin(), |heading: f64| heading + 0.35] {
            let mut attitude: [Vec<f64>; 4] = Default::default();
            for heading in &truth {
                let q = UnitQuaternion::from_scaled_axis(Vector3::z() * deviate(*heading));
                attitude.iter_mut().zip([q.w, q.i, q.j, q.k]).for_each(|(column, value)| column.push(value));
            }
            let [w, x, y, z] = attitude.each_ref().map(Vec::as_slice);
            let table = Table { attitude: Some([w, x, y, z]), ..table(&columns) };
            let mut known = of_course(&table, &columns[7], &speed, None);
            // In reverse on one of the sides.
            let count = known.len();
            known[2].heading_deg += 180.0;
            deviations.push(deviation(&table, &mut known));
            assert_eq!(known.len(), count - 1);
        }
        let [Some(Deviation { amplitude_deg, error_deg }), None] = deviations[..] else {
            panic!("{deviations:?}")
        };
        assert!((amplitude_deg - 18.9).abs() < 3.0 && error_deg < 2.0, "{deviations:?}");
    }

    #[test]
    fn one_heading_holds_as_far_as_the_gyro_does_and_none_holds_nothing() {
        let (columns, truth) = driven();
        let table = table(&columns);
        let one = KnownHeading { time_s: 60.0, heading_deg: truth[3000].to_degrees() };
        let held = attitude(&table, &[one]).expect("a heading");
        assert!(most_off_deg(&held, &truth) < 15.0, "{}", most_off_deg(&held, &truth));
        assert!(attitude(&table, &[KnownHeading { time_s: 900.0, ..one }]).is_none());
        assert!(attitude(&Table { gyro_radps: None, ..table }, &[one]).is_none());
    }
}
