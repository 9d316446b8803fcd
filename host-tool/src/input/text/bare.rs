//! Tables without names: which three columns are the magnetometer's.

use crate::failure::Outcome;
use crate::input::names::Kind;
use crate::input::text::asked;
use crate::input::text::choice::{Choice, FIELD_COUNTS, FIELD_UT, Taken};
use crate::input::text::grid::Grid;
use crate::input::text::magnitude::{self, Size};
use crate::input::text::rest::is_magnitude;
use crate::input::text::table::MONITOR;
use crate::input::text::vectors::Vector;
use crate::input::unit::{Quantity, Unit};
use ironout_analysis::plausible::field::FieldSize;
use ironout_analysis::plausible::orientation;

/// A gyroscope comes to rest: its least magnitude is below this share of its greatest.
const COMES_TO_REST: f64 = 0.1;
/// What may be a gyroscope next to a magnetometer that is known.
const RESTS: f64 = 0.5;
/// In fewer rows an axis may run forward by chance.
const TELLING: usize = 50;
/// Rows that are looked at for what columns are.
const LOOK: usize = 2000;
/// One g as MotionCal has it, counts.
const MOTIONCAL_G: f64 = 8192.0;

/// Finds time and vectors among columns that have numbers only.
///
/// # Errors
/// Several triples that can be the magnetometer.
pub fn without_names(grid: &Grid, vectors: &mut Vec<Vector>, choice: &mut Choice) -> Outcome<()> {
    vectors.clear();
    let numeric: Vec<usize> = (0..grid.columns.len())
        .filter(|column| {
            grid.columns
                .get(*column)
                .is_some_and(|c| c.header != MONITOR && c.finite() * 2 > grid.rows() && c.dates == 0)
        })
        .collect();
    if let Some(columns) = ros2_echo(grid) {
        vectors.push(vector(Kind::Field, columns, Unit::of("T", Quantity::Field)));
        choice.reasons.push(
            "ros2 topic echo --csv of sensor_msgs/MagneticField: seconds, nanoseconds, frame, x, y, z in T"
                .into(),
        );
        return Ok(());
    }
    let free: Vec<usize> = numeric.into_iter().filter(|column| !choice.has(*column)).collect();
    let Parts { time, triples } = parts(grid, &free, choice);
    // A clock that is written as one goes before a number that runs forward, unless that stands in front: it may be a temperature.
    let has_clock = grid.columns.iter().any(|column| column.header == MONITOR);
    let time = time.filter(|time| !has_clock || free.first() == Some(time));
    let none = triples.is_empty();
    let sizes: Vec<Option<Size>> =
        triples.iter().map(|triple| magnitude::size(grid, *triple, &choice.rows)).collect();
    let one_g = |size: &Size| (size.median / MOTIONCAL_G - 1.0).abs() < 0.1 && size.whole;
    // Nine whole numbers with one g of 8192: what MotionCal reads, without its word in front.
    if let ([accel, gyro, mag], [Some(size), ..]) = (triples.as_slice(), sizes.as_slice())
        && one_g(size)
        && magnitude::accel_unit(size).is_none()
    {
        choice
            .reasons
            .push("one g is 8192 in the first three: MotionCal's 1/8192 g, 1/16 deg/s, 0.1 uT".into());
        let unit = |text, quantity| Unit::stated(text, Some(quantity));
        vectors.push(vector(Kind::Accel, *accel, unit("1/8192 g", Quantity::Acceleration)));
        vectors.push(vector(Kind::Gyro, *gyro, unit("1/16 deg/s", Quantity::Rate)));
        vectors.push(vector(Kind::Field, *mag, unit("0.1 uT", Quantity::Field)));
        return Ok(());
    }
    let mapped = FIELD_UT.iter().chain(&FIELD_COUNTS).any(|name| choice.has_name(name));
    let mut left: Vec<([usize; 3], Size)> = Vec::new();
    for (triple, size) in triples.into_iter().zip(sizes) {
        let Some(size) = size else { continue };
        let unit = magnitude::accel_unit(&size);
        let alone = free.len() < 6;
        if unit.is_some() && !alone && !size.is_field() {
            vectors.push(vector(Kind::Accel, triple, unit));
        } else {
            left.push((triple, size));
        }
    }
    if mapped {
        if let Some(time) = time {
            name_time(grid, time, None, choice)?;
        }
        if let [(gyro, _)] = left.as_slice() {
            vectors.push(vector(Kind::Gyro, *gyro, None));
        }
        return Ok(());
    }
    if none && choice.rows.len() >= TELLING {
        return Err(asked::no_field(grid));
    }
    // What lies on a sphere of the Earth's field is the magnetometer; where nothing was turned enough to see one, what does not rest.
    let is_field = |size: &Size| {
        size.is_field() || (size.whole && size.field.as_ref().is_some_and(FieldSize::is_radius))
    };
    let can_be = |size: &Size| {
        size.least_share > COMES_TO_REST && (size.whole || !magnitude::field_units(size).is_empty())
    };
    let mut candidates: Vec<&([usize; 3], Size)> = left.iter().filter(|(_, size)| is_field(size)).collect();
    if candidates.is_empty() {
        candidates = left.iter().filter(|(_, size)| can_be(size)).collect();
    }
    let taken = match (left.as_slice(), candidates.as_slice()) {
        ([(only, _)], _) => *only,
        (_, [(only, _)]) => *only,
        ([], _) => return Ok(()),
        (_, []) => {
            let all: Vec<[usize; 3]> = left.iter().map(|(triple, _)| *triple).collect();
            let units = vec![Vec::new(); all.len()];
            return Err(asked::which_vector(grid, &all, &units));
        }
        (_, several) => {
            let all: Vec<[usize; 3]> = several.iter().map(|(triple, _)| *triple).collect();
            let units: Vec<Vec<Unit>> =
                several.iter().map(|(_, size)| magnitude::field_units(size)).collect();
            return Err(asked::which_vector(grid, &all, &units));
        }
    };
    if left.len() + vectors.len() > 1 {
        choice.reasons.push(format!(
            "the table has no header. ironout uses {} as the magnetometer, because its readings lie on a sphere or never come to rest",
            asked::names(grid, taken)
        ));
    } else {
        choice.reasons.push(format!(
            "the table has no header. ironout uses {} as the magnetometer",
            asked::names(grid, taken)
        ));
    }
    vectors.push(vector(Kind::Field, taken, None));
    let is_gyro = |(triple, size): &&([usize; 3], Size)| *triple != taken && size.least_share < RESTS;
    let others: Vec<[usize; 3]> = left.iter().filter(is_gyro).map(|(triple, _)| *triple).collect();
    if let [gyro] = others.as_slice() {
        vectors.push(vector(Kind::Gyro, *gyro, None));
    }
    vectors.sort_by_key(|vector| vector.columns[0]);
    if let Some(time) = time {
        let size = left.iter().find(|(triple, _)| *triple == taken).map(|(_, size)| size);
        name_time(grid, time, size, choice)?;
    }
    Ok(())
}

/// Columns without names, by what they are.
struct Parts {
    time: Option<usize>,
    /// Three axes each, in the order of the file.
    triples: Vec<[usize; 3]>,
}

/// Finds fields first, by the sphere that they lie on; then sets aside orientations, time, norms and numbers of rows, and cuts what is left
/// into threes: sensors stand side by side.
fn parts(grid: &Grid, free: &[usize], choice: &mut Choice) -> Parts {
    let looked: Vec<usize> = choice.rows.iter().step_by((choice.rows.len() / LOOK).max(1)).copied().collect();
    let picked = |column: &usize| -> Vec<f64> {
        let values = grid.columns.get(*column).map(|c| c.values.as_slice()).unwrap_or_default();
        looked.iter().map(|row| values.get(*row).copied().unwrap_or(f64::NAN)).collect()
    };
    let values: Vec<Vec<f64>> = free.iter().map(picked).collect();
    let views: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let forward = |column: usize| {
        grid.columns.get(column).is_some_and(|c| magnitude::clock(&c.values, &choice.rows).is_some())
    };
    let beside = |place: usize, width: usize| {
        let next = free.get(place..place + width).unwrap_or_default();
        next.windows(2).all(|pair| pair[1] == pair[0] + 1) && next.len() == width
    };
    let mut aside: Vec<(usize, &str)> = Vec::new();
    let mut triples: Vec<[usize; 3]> = Vec::new();
    // Which of the columns are known already.
    let mut known = vec![false; free.len()];
    let mut place = 0;
    while place < free.len() {
        let form = views.get(place..).and_then(orientation::beginning_with);
        // Three directions alone may be what somebody takes for the magnetometer.
        let form = form.filter(|form| beside(place, form.width()) && free.len() > form.width());
        let axes_at = |place: usize| {
            free.get(place..).and_then(|next| next.first_chunk::<3>()).copied().filter(|_| beside(place, 3))
        };
        let is_field = |axes: &[usize; 3]| {
            magnitude::size(grid, *axes, &choice.rows).is_some_and(|size| !size.whole && size.is_field())
        };
        let width = if let Some(form) = form {
            aside.extend((place..place + form.width()).map(|at| (free[at], form.words())));
            form.width()
        } else if let Some(axes) = axes_at(place).filter(is_field)
            // A number of the row and two axes lie on a sphere, too, where the third axis rises as evenly.
            && !(values.iter().skip(place).take(3).any(|values| is_even(values)) && axes_at(place + 1).is_some_and(|next| is_field(&next)))
        {
            triples.push(axes);
            axes.len()
        } else {
            place += 1;
            continue;
        };
        known.iter_mut().skip(place).take(width).for_each(|known| *known = true);
        place += width;
    }
    let unknown = |place: &usize| !known.get(*place).copied().unwrap_or(true);
    let wants_time = free.len() > 3 && !choice.has_name("t_s");
    // In a few rows an axis may run forward by chance, and a first column hardly.
    let many = choice.rows.len() >= TELLING;
    let time = (0..if many { free.len() } else { 1 })
        .filter(unknown)
        .filter_map(|place| free.get(place).copied())
        .find(|column| wants_time && forward(*column));
    let mut runs: Vec<Vec<usize>> = vec![Vec::new()];
    for (place, &column) in free.iter().enumerate() {
        let is_norm = || {
            let before = place.checked_sub(3).and_then(|from| free.get(from..place)?.first_chunk::<3>());
            let of = |axes: &[usize; 3]| {
                grid.columns.get(column).is_some_and(|c| is_magnitude(grid, axes, c, &looked))
            };
            before.is_some_and(of)
        };
        let is_known = !unknown(&place);
        let why = if is_known || Some(column) == time {
            None
        } else if values.get(place).is_some_and(|values| is_step(values)) {
            Some("constant except in its first row: a time step")
        } else if many && forward(column) {
            Some("increases with the rows")
        } else if is_norm() {
            Some("the magnitude of the three columns before it")
        } else {
            if let Some(run) = runs.last_mut() {
                run.push(column);
            }
            continue;
        };
        aside.extend(why.map(|why| (column, why)));
        runs.push(Vec::new());
    }
    let is_sensor = |triple: &[usize; 3]| {
        let size = magnitude::size(grid, *triple, &choice.rows);
        size.is_some_and(|size| size.is_field() || magnitude::accel_unit(&size).is_some())
    };
    for run in runs {
        // Where columns are left over, the sensors stand where most of them are known.
        let cut = |start: usize| run.get(start..).unwrap_or_default().as_chunks::<3>().0.to_vec();
        let score = |start: &usize| {
            (cut(*start).iter().filter(|triple| is_sensor(triple)).count(), run.len() - start)
        };
        let start = match run.len() % 3 {
            0 => 0,
            spare => (0..=spare).max_by_key(score).unwrap_or(0),
        };
        let own = cut(start);
        triples.extend(own);
    }
    triples.sort_unstable();
    for (column, why) in aside {
        choice.set_aside.push(column);
        let header = grid.columns.get(column).map(|column| column.header.as_str()).unwrap_or_default();
        choice.not_read.push(format!("{header} ({why})"));
    }
    Parts { time, triples }
}

/// Whether a column rises by the same step in every row.
fn is_even(values: &[f64]) -> bool {
    let step = values.get(1).zip(values.first()).map_or(0.0, |(second, first)| second - first);
    step > 0.0 && values.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() <= 1e-3 * step)
}

/// Whether a column changes after its first row only: the step of an even time.
fn is_step(values: &[f64]) -> bool {
    let Some((first, rest)) = values.split_first() else { return false };
    let same = rest.first().copied().unwrap_or(f64::NAN);
    rest.len() > 2
        && *first == 0.0
        && same > 0.0
        && rest.iter().all(|value| (value - same).abs() <= 1e-3 * same)
}

fn vector(kind: Kind, columns: [usize; 3], unit: Option<Unit>) -> Vector {
    Vector { kind, columns, unit, counts: false, stem: String::new(), rank: 0 }
}

/// A column runs forward; it is time where exactly one unit makes it a sensor's step, and no board turns too fast in it.
fn name_time(grid: &Grid, column: usize, size: Option<&Size>, choice: &mut Choice) -> Outcome<()> {
    let Some(found) = grid.columns.get(column) else { return Ok(()) };
    let Some(mut clock) = magnitude::clock(&found.values, &choice.rows) else { return Ok(()) };
    if let Some(unit) = &found.unit {
        choice.taken.push(Taken { column, name: "t_s".into(), unit: Some(unit.clone()) });
        return Ok(());
    }
    if let Some(size) = size {
        clock.units = magnitude::turning_units(&clock, size);
    }
    match clock.units.as_slice() {
        [] => {}
        [unit] => {
            choice.reasons.push(format!(
                "{} increases, so ironout uses it as time, in {} (the only unit that fits its steps)",
                found.header, unit.name
            ));
            choice.taken.push(Taken { column, name: "t_s".into(), unit: Some(unit.clone()) });
        }
        units => return Err(asked::time_unit(grid, column, units, clock.step)),
    }
    Ok(())
}

/// Seconds, nanoseconds, a frame, x, y, z and nine covariances.
fn ros2_echo(grid: &Grid) -> Option<[usize; 3]> {
    let column = |index: usize| grid.columns.get(index);
    let epoch = |v: &f64| (1e9..4e9).contains(v) && v.fract() == 0.0;
    let is = grid.columns.iter().filter(|c| c.header != MONITOR).count() == 15
        && column(0)?.values.iter().all(epoch)
        && column(1)?.values.iter().all(|v| (0.0..1e9).contains(v))
        && column(2)?.texts == grid.rows();
    is.then_some([3, 4, 5])
}
