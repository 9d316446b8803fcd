//! One row of the table: what was found in one log.

use ironout_analysis::fleet::{Calibrated, FleetLog, Move};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io::{self, Write};

/// An effect that a log names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct RowEffect {
    pub id: String,
    /// Empty where the effect has none, as swapped axes.
    pub coefficients: Vec<f64>,
    pub unit: String,
    /// Value of its column at which it is zero; null without a column, or with several.
    pub reference: Option<f64>,
}

impl RowEffect {
    fn as_move(&self) -> Option<Move> {
        let is_proportional = self.id.starts_with("offset:") && !self.id.contains('^');
        let coefficients = self.coefficients.as_slice().try_into().ok().filter(|_| is_proportional)?;
        Some(Move { id: self.id.clone(), coefficients, reference: self.reference? })
    }
}

/// One row. Unknown values are null.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Row {
    pub log: String,
    pub vehicle: String,
    pub sensor: String,
    /// Start in UTC.
    pub start: Option<String>,
    /// What says so: `log`, `name` (of the file or its folder) or `file` (its last change).
    pub start_from: Option<String>,
    pub format: Option<String>,
    pub rows: Option<u64>,
    pub samples_used: Option<u64>,
    pub samples_set_aside: Option<u64>,
    /// Length of the log.
    pub seconds: Option<f64>,
    pub verdict: String,
    pub accepted: Option<bool>,
    pub field_ut: Option<f64>,
    pub offset_ut: Option<[f64; 3]>,
    pub offset_std_ut: Option<[f64; 3]>,
    pub matrix: Option<[[f64; 3]; 3]>,
    pub base_rms_ut: Option<f64>,
    pub rms_ut: Option<f64>,
    pub holdout_rms_ut: Option<f64>,
    pub noise_floor_ut: Option<f64>,
    pub predicted_error_ut: Option<f64>,
    pub heading_error_deg: Option<f64>,
    pub effects: Vec<RowEffect>,
    pub reasons: Vec<String>,
    pub notices: Vec<String>,
    pub error: Option<String>,
    /// Time that the study took.
    pub took_s: Option<f64>,
}

impl Row {
    /// The log as the summary takes it.
    pub fn fleet_log(&self) -> FleetLog {
        let usable = self.accepted == Some(true) || matches!(self.verdict.as_str(), "complete" | "missing");
        let calibrated = self.offset_ut.zip(self.matrix).zip(self.field_ut).filter(|_| usable);
        FleetLog {
            name: self.log.clone(),
            vehicle: self.vehicle.clone(),
            sensor: self.sensor.clone(),
            day: self.start_s().map(|seconds| seconds / 86_400.0),
            verdict: self.verdict.clone(),
            effects: self.effects.iter().map(|effect| effect.id.clone()).collect(),
            calibrated: calibrated.map(|((offset_ut, matrix), field_ut)| Calibrated {
                offset_ut,
                gains: [0, 1, 2].map(|axis| matrix[axis][axis]),
                field_ut,
                moves: self.effects.iter().filter_map(RowEffect::as_move).collect(),
            }),
            error_share: self.base_rms_ut.zip(self.field_ut).map(|(rms, field)| rms / field),
            noise_ut: self.noise_floor_ut,
        }
    }

    fn start_s(&self) -> Option<f64> {
        let start: Timestamp = self.start.as_ref()?.parse().ok()?;
        Some(start.as_millisecond() as f64 / 1e3)
    }

    /// The cells of the row in a flat table, each with its name.
    pub fn cells(&self) -> Vec<(String, Cell)> {
        let mut cells: Vec<(String, Cell)> = Vec::new();
        let mut add = |name: &str, cell: Cell| cells.push((name.to_string(), cell));
        let text = |text: &str| Cell::Text(Some(text.to_string()));
        add("log", text(&self.log));
        add("vehicle", text(&self.vehicle));
        add("sensor", text(&self.sensor));
        add("start", Cell::Text(self.start.clone()));
        add("start_from", Cell::Text(self.start_from.clone()));
        add("format", Cell::Text(self.format.clone()));
        add("rows", Cell::Count(self.rows));
        add("samples_used", Cell::Count(self.samples_used));
        add("samples_set_aside", Cell::Count(self.samples_set_aside));
        add("seconds", Cell::Number(self.seconds));
        add("verdict", text(&self.verdict));
        add("accepted", Cell::Flag(self.accepted));
        add("field_ut", Cell::Number(self.field_ut));
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            add(&format!("offset_{letter}_ut"), Cell::Number(self.offset_ut.map(|offset| offset[axis])));
        }
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            add(&format!("offset_std_{letter}_ut"), Cell::Number(self.offset_std_ut.map(|std| std[axis])));
        }
        for i in 0..3 {
            for j in 0..3 {
                add(&format!("matrix_{i}{j}"), Cell::Number(self.matrix.map(|matrix| matrix[i][j])));
            }
        }
        add("base_rms_ut", Cell::Number(self.base_rms_ut));
        add("rms_ut", Cell::Number(self.rms_ut));
        add("holdout_rms_ut", Cell::Number(self.holdout_rms_ut));
        add("noise_floor_ut", Cell::Number(self.noise_floor_ut));
        add("predicted_error_ut", Cell::Number(self.predicted_error_ut));
        add("heading_error_deg", Cell::Number(self.heading_error_deg));
        let effects = self.effects.iter().map(|effect| {
            let numbers: Vec<String> = effect.coefficients.iter().map(f64::to_string).collect();
            match numbers.is_empty() {
                true => effect.id.clone(),
                false => format!("{}={} {}", effect.id, numbers.join(","), effect.unit),
            }
        });
        add("effects", text(&effects.collect::<Vec<_>>().join("; ")));
        add("reasons", text(&self.reasons.join("; ")));
        add("notices", text(&self.notices.join("; ")));
        add("error", Cell::Text(self.error.clone()));
        add("took_s", Cell::Number(self.took_s));
        cells
    }
}

/// One cell of the flat table; `None` is unknown.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Text(Option<String>),
    Count(Option<u64>),
    Number(Option<f64>),
    Flag(Option<bool>),
}

impl fmt::Display for Cell {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cell::Text(Some(text)) => out.write_str(text),
            Cell::Count(Some(count)) => write!(out, "{count}"),
            Cell::Number(Some(number)) => write!(out, "{number}"),
            Cell::Flag(Some(flag)) => write!(out, "{flag}"),
            _ => Ok(()),
        }
    }
}

/// Writes the rows as CSV.
pub(super) fn write_csv(out: &mut dyn Write, rows: &[&Row]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(Row::default().cells().iter().map(|(name, _)| name))?;
    for row in rows {
        table.write_record(row.cells().iter().map(|(_, cell)| cell.to_string()))?;
    }
    table.flush()
}

/// Writes the rows as JSON Lines.
pub(super) fn write_json_lines(out: &mut dyn Write, rows: &[&Row]) -> io::Result<()> {
    for row in rows {
        serde_json::to_writer(&mut *out, row)?;
        writeln!(out)?;
    }
    Ok(())
}
