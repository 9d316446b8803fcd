//! What a diagnosis says of one log, as a row of the snapshot.

use crate::accuracy::true_error::true_error_ut;
use crate::frozen::entry::{Hidden, Made};
use ironout_analysis::{Diagnosis, Options, Table, diagnose};

/// The columns of the snapshot.
pub const HEADER: [&str; 17] = [
    "set",
    "log",
    "hidden",
    "verdict",
    "named",
    "confounded",
    "faults",
    "field_ut",
    "offset_x_ut",
    "offset_y_ut",
    "offset_z_ut",
    "rms_ut",
    "holdout_rms_ut",
    "noise_floor_ut",
    "predicted_error_ut",
    "true_error_ut",
    "coefficients",
];
/// Columns that are words: they are compared exactly.
pub const WORDS: usize = 7;

/// One row, as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row(pub [String; HEADER.len()]);

impl Row {
    /// The cell of that column.
    pub fn cell(&self, column: &str) -> &str {
        HEADER.iter().position(|own| *own == column).map_or("", |place| self.0[place].as_str())
    }

    /// Set and log: what makes a row the same one in two snapshots.
    pub fn key(&self) -> (&str, &str) {
        (&self.0[0], &self.0[1])
    }

    /// A list that is held in one cell.
    pub fn list(&self, column: &str) -> Vec<&str> {
        self.cell(column).split('+').filter(|id| !id.is_empty()).collect()
    }

    /// A number, where the cell has one.
    pub fn number(&self, column: &str) -> Option<f64> {
        self.cell(column).parse().ok()
    }

    /// Of a log that could not be made or read.
    pub fn unread(set: &str, log: &str, why: &str) -> Row {
        let mut cells: [String; HEADER.len()] = Default::default();
        let first: String = why.lines().next().unwrap_or_default().chars().take(90).collect();
        cells[0] = set.to_owned();
        cells[1] = log.to_owned();
        cells[2] = "?".to_owned();
        cells[3] = format!("not read: {first}");
        Row(cells)
    }

    /// Diagnoses a log.
    pub fn of(set: &str, log: &str, made: &Made) -> Row {
        let Some(table) = made.rows.table() else { return Row::unread(set, log, "no magnetometer") };
        let options = Options { search: true, ..Options::default() };
        match diagnose(&table, &options) {
            Ok(diagnosis) => Row::said(set, log, made, &table, &diagnosis),
            Err(refusal) => Row::unread(set, log, &refusal.to_string()),
        }
    }

    fn said(set: &str, log: &str, made: &Made, table: &Table<'_>, diagnosis: &Diagnosis) -> Row {
        let named: Vec<&str> = diagnosis.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        let confounded = diagnosis.candidates.iter().filter(|row| row.status.name() == "confounded");
        let mut faults: Vec<&str> = diagnosis.data_faults.iter().map(|fault| fault.kind.name()).collect();
        faults.dedup();
        let calibration = diagnosis.calibration.as_ref();
        let offset = |axis: usize| calibration.map(|calibration| calibration.offset_ut[axis]);
        let last = diagnosis.steps.last();
        let coefficients = diagnosis.effects.iter().map(|effect| {
            let numbers: Vec<String> =
                effect.coefficients.iter().map(|value| format!("{value:.4e}")).collect();
            format!("{}={}", effect.id, numbers.join("/"))
        });
        let true_error =
            made.body_field_ut.as_deref().and_then(|truth| true_error_ut(table, diagnosis, truth));
        Row([
            set.to_owned(),
            log.to_owned(),
            hidden(&made.hidden),
            diagnosis.verdict.name().to_owned(),
            named.join("+"),
            confounded.map(|row| row.id.as_str()).collect::<Vec<_>>().join("+"),
            faults.join("+"),
            number(calibration.map(|calibration| calibration.field_ut)),
            number(offset(0)),
            number(offset(1)),
            number(offset(2)),
            number(last.map(|step| step.rms_ut)),
            number(last.and_then(|step| step.holdout_rms_ut)),
            number(diagnosis.noise_floor_ut),
            number(diagnosis.vector_error_ut()),
            number(true_error),
            coefficients.collect::<Vec<_>>().join(" "),
        ])
    }
}

fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or_else(String::new, |value| format!("{value:.4}"))
}

/// What is hidden, as a cell.
pub fn hidden(hidden: &Hidden) -> String {
    match hidden {
        Hidden::Unknown => "?".to_owned(),
        Hidden::Effects(ids) => ids.join("+"),
        Hidden::Injected(ids) => format!("injected+{}", ids.join("+")),
        Hidden::ColumnMissing => "column missing".to_owned(),
    }
}
