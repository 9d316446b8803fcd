//! Recordings with optical truth: the true error of the corrected vector and of the heading, next to what a fit predicts.
//!
//! The corrected field is turned into the room by the optical orientation. A perfect calibration gives one vector there; its scatter is
//! the true error, which contains noise and what the magnetometer is late.

use ironout_analysis::base::axes::Alignment;
use ironout_analysis::{Options, Table, fit};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};

/// What a fit of one recording says, and what is true.
#[derive(Debug, Clone)]
pub struct Row {
    /// The recording.
    pub name: String,
    /// Whether the calibration is accepted.
    pub accepted: bool,
    /// The rotation to the accelerometer that the matrix contains, degrees; `None` where it contains none.
    pub rotation_deg: Option<f64>,
    /// Predicted 1σ error of the corrected vector, % of the field.
    pub predicted_percent: f64,
    /// True rms error of the corrected vector, % of the field.
    pub vector_percent: f64,
    /// Predicted 1σ error of the heading, degrees.
    pub predicted_heading_deg: f64,
    /// True rms error of the heading, degrees.
    pub heading_deg: f64,
    /// Why it is refused, or what to know.
    pub reasons: Vec<String>,
}

/// The folder of the recordings; `None` where it is not beside the project.
pub fn folder() -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/broad"));
    path.is_dir().then(|| path.to_path_buf())
}

/// Columns by name.
pub type Columns = Vec<(String, Vec<f64>)>;

fn columns(path: &Path) -> Option<Columns> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).ok()?;
    let mut columns: Columns =
        reader.headers().ok()?.iter().map(|name| (name.to_owned(), Vec::new())).collect();
    for record in reader.records() {
        for ((_, values), cell) in columns.iter_mut().zip(record.ok()?.iter()) {
            values.push(cell.trim().parse().unwrap_or(f64::NAN));
        }
    }
    Some(columns)
}

/// The columns of a recording and of its truth; `None` where one of them is missing.
pub fn columns_of(log: &Path) -> Option<(Columns, Columns)> {
    let name = log.file_stem()?.to_str()?;
    Some((columns(log)?, columns(&log.with_file_name(format!("{name}.truth.csv")))?))
}

/// The values of a column; none where there is none of this name.
pub fn column<'c>(columns: &'c [(String, Vec<f64>)], name: &str) -> &'c [f64] {
    columns.iter().find(|(own, _)| own == name).map_or(&[], |(_, values)| values)
}

/// Fits a recording and holds it against its truth; `None` where there is no fit or no truth.
fn row(log: &Path) -> Option<Row> {
    let name = log.file_stem()?.to_str()?.to_owned();
    let (own, truth) = columns_of(log)?;
    let table =
        Table::from_columns(own.iter().map(|(name, values)| (name.as_str(), values.as_slice()))).ok()?;
    let fitted = fit(&table, &Options::default()).ok()?;
    let solution = fitted.solution.as_ref()?;
    let field_ut = solution.calibration.field_ut;
    let times = column(&truth, "t_s");
    let turned = |at: usize| {
        let [w, x, y, z] = ["qw", "qx", "qy", "qz"].map(|name| column(&truth, name)[at]);
        let unit = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)?;
        unit.coords.iter().all(|value| value.is_finite()).then_some(unit)
    };
    let in_room: Vec<Vector3<f64>> = column(&own, "t_s")
        .iter()
        .enumerate()
        .filter_map(|(row, t)| {
            let at = times.partition_point(|time| *time < t - 1e-3).min(times.len() - 1);
            Some(turned(at)? * Vector3::from(solution.calibration.apply(table.field(row))))
        })
        .collect();
    let n = in_room.len() as f64;
    let mean = in_room.iter().sum::<Vector3<f64>>() / n;
    let scatter = (in_room.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / n).sqrt();
    let north = mean.y.atan2(mean.x);
    let off = in_room.iter().map(|v| {
        let off = v.y.atan2(v.x) - north;
        off.sin().atan2(off.cos()).powi(2)
    });
    Some(Row {
        name,
        accepted: fitted.accepted,
        rotation_deg: match solution.alignment {
            Alignment::Done { angle_deg, .. } => Some(angle_deg),
            _ => None,
        },
        predicted_percent: 100.0 * solution.vector_error_ut() / field_ut,
        vector_percent: 100.0 * scatter / field_ut,
        predicted_heading_deg: fitted.heading_error_deg.unwrap_or(f64::NAN),
        heading_deg: (off.sum::<f64>() / n).sqrt().to_degrees(),
        reasons: fitted.reasons.iter().map(ToString::to_string).collect(),
    })
}

/// All recordings of the folder, by name.
pub fn rows(folder: &Path) -> Vec<Row> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut logs: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    logs.retain(|path| path.extension().is_some_and(|end| end == "csv"));
    logs.sort();
    logs.iter().filter_map(|log| row(log)).collect()
}

/// The table.
pub fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<46} {:>8}  {:>8}  {:>9} {:>6}  {:>9} {:>7}\n",
        "recording", "verdict", "rotation", "predicted", "vector", "predicted", "heading"
    );
    for row in rows {
        text += &format!(
            "{:<46} {:>8}  {:>8}  {:>7.2} % {:>4.1} %  {:>7.1} ° {:>5.1} °\n",
            row.name,
            if row.accepted { "accepted" } else { "refused" },
            row.rotation_deg.map_or("-".to_owned(), |deg| format!("{deg:.1} °")),
            row.predicted_percent,
            row.vector_percent,
            row.predicted_heading_deg,
            row.heading_deg,
        );
    }
    text
}
