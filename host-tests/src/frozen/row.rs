//! What a diagnosis says of one log, as a row of the snapshot.

use crate::frozen::entry::{Hidden, Made};
use ironout_analysis::base::axes::Alignment;
use ironout_analysis::effects::calibrated;
use ironout_analysis::{Corrector, Diagnosis, Options, Table, diagnose};
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

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
/// An error of this many medians is that of a bad reading: six standard deviations of a vector of white noise.
const OUTLIER_OF_MEDIAN: f64 = 4.0;
/// Rounds in which bad readings are left out.
const ROUNDS_WITHOUT_OUTLIERS: usize = 4;
/// Directions of the sphere in which an error is looked at.
const DIRECTIONS: usize = 200;
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

fn hidden(hidden: &Hidden) -> String {
    match hidden {
        Hidden::Unknown => "?".to_owned(),
        Hidden::Effects(ids) => ids.join("+"),
        Hidden::Injected(ids) => format!("injected+{}", ids.join("+")),
        Hidden::ColumnMissing => "column missing".to_owned(),
    }
}

/// True error of the calibration in the worst direction of the sphere, µT: the part of the corrected vectors' errors that is an
/// offset and a matrix, which noise hardly enters. In the scale of the truth: a log alone cannot tell the size of the field, nor,
/// without an accelerometer, how the axes are turned, so that scale and (there) the best rotation are taken out.
fn true_error_ut(table: &Table<'_>, diagnosis: &Diagnosis, truth: &[[f64; 3]]) -> Option<f64> {
    let entries: Vec<_> = diagnosis.effects.iter().map(Into::into).collect();
    let calibrated = calibrated(diagnosis.calibration?, &entries, diagnosis.registry).ok()?;
    let corrector = Corrector::new(calibrated, table).ok()?;
    let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = truth
        .iter()
        .enumerate()
        // A stale reading is that of an earlier attitude.
        .filter(|&(row, _)| row == 0 || table.field(row) != table.field(row - 1))
        .filter_map(|(row, truth)| Some((Vector3::from(corrector.correct(row).ok()?), Vector3::from(*truth))))
        .filter(|(own, truth)| own.iter().chain(truth).all(|value| value.is_finite()))
        .collect();
    let linear = linear_error(pairs, matches!(diagnosis.alignment, Alignment::Done { .. }))?;
    let worst = (0..DIRECTIONS).map(|place| {
        // A spiral of equal areas.
        let z = 1.0 - (2 * place + 1) as f64 / DIRECTIONS as f64;
        let (sine, cosine) = (place as f64 * 2.399_963_229_728_653).sin_cos();
        let across = (1.0 - z * z).sqrt();
        (linear.transpose() * Vector4::new(1.0, across * cosine, across * sine, z)).norm()
    });
    Some(worst.fold(0.0, f64::max))
}

/// The errors of corrected vectors (beside the true ones) as least squares on (1, direction), µT. A stale, clipped or disturbed
/// reading is no error of the calibration: those far off the others are left out, and the rest is fitted again.
fn linear_error(
    mut pairs: Vec<(Vector3<f64>, Vector3<f64>)>,
    is_aligned: bool,
) -> Option<SMatrix<f64, 4, 3>> {
    let mut rounds = 0..ROUNDS_WITHOUT_OUTLIERS;
    loop {
        let mean = |list: &mut dyn Iterator<Item = f64>| list.sum::<f64>() / pairs.len().max(1) as f64;
        let field_ut = mean(&mut pairs.iter().map(|(_, truth)| truth.norm()));
        let scale = field_ut / mean(&mut pairs.iter().map(|(own, _)| own.norm()));
        let rotation = if is_aligned { Matrix3::identity() } else { best_rotation(&pairs)? };
        let at = |truth: &Vector3<f64>| {
            let direction = truth / field_ut;
            Vector4::new(1.0, direction.x, direction.y, direction.z)
        };
        let error = |own: &Vector3<f64>, truth: &Vector3<f64>| rotation * own * scale - truth;
        let (mut normal, mut right) = (Matrix4::zeros(), SMatrix::<f64, 4, 3>::zeros());
        for (own, truth) in &pairs {
            normal += at(truth) * at(truth).transpose();
            right += at(truth) * error(own, truth).transpose();
        }
        let linear = normal.cholesky()?.solve(&right);
        if rounds.next().is_none() {
            return Some(linear);
        }
        let off: Vec<f64> = (pairs.iter())
            .map(|(own, truth)| (error(own, truth) - linear.transpose() * at(truth)).norm())
            .collect();
        let mut sorted = off.clone();
        sorted.sort_by(f64::total_cmp);
        let limit = OUTLIER_OF_MEDIAN * sorted.get(sorted.len() / 2)?;
        let mut off = off.into_iter();
        pairs.retain(|_| off.next().is_some_and(|off| off <= limit));
    }
}

/// The rotation that turns the first vectors best onto the second (Kabsch 1976).
fn best_rotation(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Option<Matrix3<f64>> {
    let products: Matrix3<f64> = pairs.iter().map(|(own, truth)| truth * own.transpose()).sum();
    let svd = products.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    Some(u * mirror * v_t)
}
