//! Every sample that counts, under a calibration.

use crate::correct::Corrector;
use crate::table::Table;
use ironout::calibration::{Calibration, norm};

/// Samples in the order of time.
#[derive(Default)]
pub struct Rows {
    /// The row of the log of each.
    pub row: Vec<usize>,
    /// Measured, µT.
    pub measured_ut: Vec<[f64; 3]>,
    /// Corrected, µT.
    pub corrected_ut: Vec<[f64; 3]>,
    /// `‖corrected‖ − F` of offset and matrix only, µT.
    pub without_ut: Vec<f64>,
    /// The same of the whole calibration, µT.
    pub with_ut: Vec<f64>,
}

impl Rows {
    /// Of these rows of a log; those that cannot be corrected are left out. `base` is the calibration without effects that the
    /// whole one is held against.
    pub fn of(
        table: &Table,
        rows: impl Iterator<Item = usize>,
        base: &Calibration<f64>,
        corrector: &Corrector,
    ) -> Rows {
        let field_ut = corrector.calibration().base.field_ut;
        let mut out = Rows::default();
        for row in rows {
            let measured = table.field(row);
            let Ok(corrected) = corrector.correct(row) else { continue };
            // On a journey each place has its own field.
            let share = table.place(row).share;
            out.row.push(row);
            out.measured_ut.push(measured);
            out.corrected_ut.push(corrected);
            out.without_ut.push(norm(base.apply(measured)) - base.field_ut * share);
            out.with_ut.push(norm(corrected) - field_ut * share);
        }
        out
    }
}
