//! What a target holds, fitted again on a log, and what it costs next to the whole calibration.

use crate::base::counted::Counted;
use crate::base::heading::{HeadingError, difference_deg, heading_deg};
use crate::correct::Corrector;
use crate::effects::Calibrated;
use crate::export::held::{Held, Shape};
use crate::table::Table;
use ironout::calibration::norm;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::fmt;

/// A step that promises less than this share of the squares is the last.
const STEP_LEFT: f64 = 1e-14;
/// Steps at most.
const STEPS: usize = 60;
/// The damping of steps that do not help.
const DAMPED: f64 = 1e8;

/// Why a log tells nothing about the cost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoCost {
    /// The log lacks what the calibration's effects need: the column, and why.
    Column(String, String),
    /// The board rests, or too few samples are left.
    TooLittle,
    /// The fit of what the target holds did not converge.
    NotFitted,
}

impl fmt::Display for NoCost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoCost::Column(column, why) => write!(f, "column {column}: {why}"),
            NoCost::TooLittle => {
                f.write_str("too few samples of a rotating sensor. Fix: give the log that the calibration was fitted to")
            }
            NoCost::NotFitted => f.write_str(
                "the target's parameters could not be fitted to this log. Fix: rotate the sensor through more orientations",
            ),
        }
    }
}

impl std::error::Error for NoCost {}

/// The error of a calibration as a whole next to that of what a target holds, on one log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Samples, without those set aside.
    pub samples: usize,
    /// Rms of the corrected magnitude about the field of each place, of the whole calibration, µT.
    pub whole_rms_ut: f64,
    /// The same of what the target holds, µT.
    pub held_rms_ut: f64,
    /// The heading; `None` without an accelerometer, or where the calibration was not aligned to one.
    pub heading: Option<HeadingCost>,
}

/// What it costs in heading, degrees rms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingCost {
    /// Between the two.
    pub between_deg: f64,
    /// Of the whole calibration against the log's reference heading, and of what the target holds; `None` without one.
    pub errors_deg: Option<[f64; 2]>,
}

/// One sample: the vector in the sensor's axes, the field where it was taken, and the values of the columns of the effects that
/// are held.
struct Row {
    sensor_ut: Vector3<f64>,
    field_ut: f64,
    values: Vec<f64>,
    whole_ut: [f64; 3],
    row: usize,
}

/// Fits what the target holds again where the target does not hold all of the calibration, and says what that costs.
///
/// # Errors
/// Where the log does not tell.
pub fn refit(held: &Held, calibration: &Calibrated, table: &Table) -> Result<(Held, Cost), NoCost> {
    let counted = Counted::of(table, 1.0);
    let corrector = Corrector::new(*calibration, table)
        .map_err(|error| NoCost::Column(error.column.clone(), error.why.clone()))?;
    if counted.rests || counted.used.len() < 100 {
        return Err(NoCost::TooLittle);
    }
    let mut rows = Vec::with_capacity(counted.used.len());
    for &sample in &counted.used {
        let row = counted.data.row(sample);
        let Ok(whole_ut) = corrector.correct(row) else { continue };
        let conditions = corrector.conditions(row);
        let value = |place: usize| conditions.inputs.get(place).map_or(f64::NAN, |inputs| inputs[0]);
        rows.push(Row {
            sensor_ut: held.to_sensor(table.field(row)),
            field_ut: held.field_ut * table.place(row).share,
            values: held.effects.iter().map(|effect| value(effect.place)).collect(),
            whole_ut,
            row,
        });
    }
    let fitted = if held.is_whole() { held.clone() } else { fitted(held, &rows).ok_or(NoCost::NotFitted)? };
    let rms = |magnitude: &dyn Fn(&Row) -> f64| {
        let squares: f64 = rows.iter().map(|row| (magnitude(row) - row.field_ut).powi(2)).sum();
        (squares / rows.len().max(1) as f64).sqrt()
    };
    let cost = Cost {
        samples: rows.len(),
        whole_rms_ut: rms(&|row| norm(row.whole_ut)),
        held_rms_ut: rms(&|row| fitted.apply(row.sensor_ut, &row.values).norm()),
        heading: held.lost_deg.and_then(|_| heading(&fitted, &rows, &counted, table)),
    };
    Ok((fitted, cost))
}

/// The headings of both, where the accelerometer shows the direction down.
fn heading(held: &Held, rows: &[Row], counted: &Counted, table: &Table) -> Option<HeadingCost> {
    let samples = &counted.samples;
    let (mut between, mut of_whole, mut of_held) = (Vec::new(), Vec::new(), Vec::new());
    let mut next = rows.iter().peekable();
    for (&row, reading) in samples.row.iter().zip(&samples.readings) {
        while next.next_if(|one| one.row < row).is_some() {}
        let (Some(one), Some(down)) = (next.peek().filter(|one| one.row == row), reading.down) else {
            continue;
        };
        let own = held.apply(one.sensor_ut, &one.values);
        let (Some(whole), Some(own)) = (heading_deg(one.whole_ut, down), heading_deg(own.into(), down))
        else {
            continue;
        };
        between.push(difference_deg(own, whole));
        let truth =
            table.heading_deg.and_then(|reference| reference.get(row)).filter(|value| value.is_finite());
        if let Some(truth) = truth {
            of_whole.push(difference_deg(whole, *truth));
            of_held.push(difference_deg(own, *truth));
        }
    }
    let rms = |differences: &[f64]| HeadingError::of(differences).map(|error| error.rms_deg);
    Some(HeadingCost {
        between_deg: rms(&between)?,
        errors_deg: rms(&of_whole).zip(rms(&of_held)).map(|(whole, held)| [whole, held]),
    })
}

/// Entries of the matrix that are free, each with the places that it fills.
fn entries(shape: Shape) -> &'static [&'static [(usize, usize)]] {
    match shape {
        Shape::Scalar => &[&[(0, 0), (1, 1), (2, 2)]],
        Shape::Diagonal => &[&[(0, 0)], &[(1, 1)], &[(2, 2)]],
        Shape::Symmetric => {
            &[&[(0, 0)], &[(1, 1)], &[(2, 2)], &[(0, 1), (1, 0)], &[(0, 2), (2, 0)], &[(1, 2), (2, 1)]]
        }
        // The rotation is not the magnitude's: nine entries would have three too many.
        Shape::Full => &[],
    }
}

/// Levenberg–Marquardt on `‖S·(raw − b − Σ c·x)‖ − F`. A full matrix keeps its entries up to a common factor.
fn fitted(held: &Held, rows: &[Row]) -> Option<Held> {
    let entries = entries(held.room.shape);
    let matrix = match held.room.shape {
        Shape::Full => None,
        _ => Some(entries),
    };
    let columns = 3 + matrix.map_or(1, <[_]>::len) + 3 * held.effects.len();
    let squares = |held: &Held| -> f64 {
        rows.iter().map(|row| (held.apply(row.sensor_ut, &row.values).norm() - row.field_ut).powi(2)).sum()
    };
    let mut now = Held { refitted: true, ..held.clone() };
    let (mut cost, mut damping) = (squares(&now), 1e-6);
    for _ in 0..STEPS {
        let mut normal = DMatrix::<f64>::zeros(columns, columns);
        let mut right = DVector::<f64>::zeros(columns);
        let mut slope = DVector::<f64>::zeros(columns);
        for row in rows {
            let v = now.centred(row.sensor_ut, &row.values);
            let h = now.matrix * v;
            let (length, u) = (h.norm(), h.normalize());
            let pull = -(now.matrix.transpose() * u);
            slope.rows_mut(0, 3).copy_from(&pull);
            match matrix {
                Some(entries) => {
                    for (slot, places) in entries.iter().enumerate() {
                        slope[3 + slot] = places.iter().map(|&(i, j)| u[i] * v[j]).sum();
                    }
                }
                None => slope[3] = length,
            }
            let first = columns - 3 * now.effects.len();
            for (index, (effect, value)) in now.effects.iter().zip(&row.values).enumerate() {
                slope.rows_mut(first + 3 * index, 3).copy_from(&(pull * effect.factor(*value)));
            }
            normal.ger(1.0, &slope, &slope, 1.0);
            right.axpy(row.field_ut - length, &slope, 1.0);
        }
        let mut damped = normal.clone();
        (0..columns).for_each(|i| damped[(i, i)] *= 1.0 + damping);
        let step = damped.cholesky()?.solve(&right);
        let promised = step.dot(&right);
        let next = moved(&now, &step, matrix);
        let reached = squares(&next);
        if !promised.is_finite() {
            return None;
        }
        if reached <= cost {
            let last = promised <= STEP_LEFT * cost;
            (now, cost, damping) = (next, reached, damping * 0.1);
            if last {
                return Some(now);
            }
        } else if promised <= STEP_LEFT * cost {
            return Some(now);
        } else if damping > DAMPED {
            return None;
        } else {
            damping *= 10.0;
        }
    }
    None
}

fn moved(held: &Held, step: &DVector<f64>, matrix: Option<&[&[(usize, usize)]]>) -> Held {
    let mut next = held.clone();
    next.offset_ut += Vector3::new(step[0], step[1], step[2]);
    match matrix {
        Some(entries) => {
            let mut change = Matrix3::zeros();
            for (slot, places) in entries.iter().enumerate() {
                places.iter().for_each(|&place| change[place] = step[3 + slot]);
            }
            next.matrix += change;
        }
        None => next.matrix *= 1.0 + step[3],
    }
    let first = step.len() - 3 * held.effects.len();
    for (index, effect) in next.effects.iter_mut().enumerate() {
        let at = first + 3 * index;
        effect.coefficient_ut += Vector3::new(step[at], step[at + 1], step[at + 2]);
    }
    next
}
