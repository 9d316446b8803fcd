//! Tables without names: which three columns are the magnetometer's.

use crate::failure::Outcome;
use crate::input::names::Kind;
use crate::input::text::asked;
use crate::input::text::choice::{Choice, FIELD_COUNTS, FIELD_UT, Taken};
use crate::input::text::grid::Grid;
use crate::input::text::magnitude::{self, Size};
use crate::input::text::table::MONITOR;
use crate::input::text::vectors::Vector;
use crate::input::unit::{Quantity, Unit};

/// A gyroscope comes to rest: its least magnitude is below this share of its greatest.
const COMES_TO_REST: f64 = 0.1;
/// In fewer rows an axis may run forward by chance.
const TELLING: usize = 50;
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
    // A field never runs forward from row to row.
    let leads = free.len() > 3
        && !choice.has_name("t_s")
        && free
            .first()
            .and_then(|first| grid.columns.get(*first))
            .is_some_and(|c| magnitude::clock(&c.values, &choice.rows).is_some());
    let vectors_from = usize::from(leads);
    let triples: Vec<[usize; 3]> = free.get(vectors_from..).unwrap_or_default().as_chunks::<3>().0.to_vec();
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
        if unit.is_some() && !alone && magnitude::field_units(&size).is_empty() {
            vectors.push(vector(Kind::Accel, triple, unit));
        } else {
            left.push((triple, size));
        }
    }
    if leads && let Some(first) = free.first() {
        name_time(grid, *first, choice)?;
    }
    if mapped {
        if let [(gyro, _)] = left.as_slice() {
            vectors.push(vector(Kind::Gyro, *gyro, None));
        }
        return Ok(());
    }
    let can_be = |size: &Size| {
        size.least_share > COMES_TO_REST && (size.whole || !magnitude::field_units(size).is_empty())
    };
    // What runs forward from row to row is time or a count, and no axis of a field.
    let forward = |triple: &[usize; 3]| {
        triple.iter().any(|column| {
            grid.columns.get(*column).is_some_and(|c| magnitude::clock(&c.values, &choice.rows).is_some())
        })
    };
    if choice.rows.len() >= TELLING && left.iter().any(|(triple, _)| forward(triple)) {
        return Err(asked::no_field(grid));
    }
    let candidates: Vec<&([usize; 3], Size)> = left.iter().filter(|(_, size)| can_be(size)).collect();
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
            "there are no names: {} are taken for the magnetometer, by the size of the numbers",
            asked::names(grid, taken)
        ));
    } else {
        choice.reasons.push(format!(
            "there are no names: {} are taken for the magnetometer",
            asked::names(grid, taken)
        ));
    }
    vectors.push(vector(Kind::Field, taken, None));
    let others: Vec<[usize; 3]> =
        left.iter().map(|(triple, _)| *triple).filter(|triple| *triple != taken).collect();
    if let [gyro] = others.as_slice() {
        vectors.push(vector(Kind::Gyro, *gyro, None));
    }
    vectors.sort_by_key(|vector| vector.columns[0]);
    Ok(())
}

fn vector(kind: Kind, columns: [usize; 3], unit: Option<Unit>) -> Vector {
    Vector { kind, columns, unit, counts: false, stem: String::new(), rank: 0 }
}

/// The first column runs forward; it is time where exactly one unit makes it a sensor's step.
fn name_time(grid: &Grid, column: usize, choice: &mut Choice) -> Outcome<()> {
    let Some(found) = grid.columns.get(column) else { return Ok(()) };
    let Some(clock) = magnitude::clock(&found.values, &choice.rows) else { return Ok(()) };
    if let Some(unit) = &found.unit {
        choice.taken.push(Taken { column, name: "t_s".into(), unit: Some(unit.clone()) });
        return Ok(());
    }
    match clock.units.as_slice() {
        [] => {}
        [unit] => {
            choice.reasons.push(format!(
                "{} runs forward and is taken for time, in {}, the only unit that fits its steps",
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
