//! Readings that move in steps too large for the field they turned in.

use crate::plausible::field::{ALL_OVER, JUMP, least_step, points, sphere, tilted};
use crate::samples::samples::unique_rows;
use crate::samples::series::median;
use crate::table::Table;
use nalgebra::Vector3;

/// A step of this share of the field turns the reading by more than two degrees. Sensors resolve a tenth of it or better, and whole
/// microtesla in a weak field are just this.
const MAX_STEP_SHARE: f64 = 0.04;

/// Steps that are too large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coarse {
    /// The step of the coarsest axis, µT as read.
    pub step_ut: f64,
    /// The radius of the sphere that the readings lie on, µT as read.
    pub field_ut: f64,
}

/// Whether the readings move in steps that are too large for the field; nothing where the sensor was not turned enough to tell.
pub fn find(table: &Table) -> Option<Coarse> {
    let rows = unique_rows(table);
    let (points, middle) = points(table, &rows)?;
    let about: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    let found = sphere(&about)?;
    let step_ut = (0..3).map(|axis| least_step(&about, axis)).fold(0.0, f64::max);
    if step_ut < MAX_STEP_SHARE * found.radius {
        return None;
    }
    // Noise between a few steps lies on something round, too: it jumps across it, and gravity stays where it is.
    let mut jumps: Vec<f64> = rows
        .windows(2)
        .map(|pair| (Vector3::from(table.field(pair[1])) - Vector3::from(table.field(pair[0]))).norm())
        .collect();
    let turned = tilted(table, &rows).unwrap_or(found.spread >= ALL_OVER);
    let is_turned = turned && median(&mut jumps) <= JUMP * found.radius;
    is_turned.then_some(Coarse { step_ut, field_ut: found.radius })
}
