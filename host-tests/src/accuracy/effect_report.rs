//! The table of hidden effects as a whole: measured, as text, as JSON, and kept beside its snapshot.

use crate::accuracy::dip_table;
use crate::accuracy::effect_table::{CASES, Case, HEADING, Row, Special, line, run};
use crate::accuracy::pooled;
use crate::measured;
use serde_json::{Value, json};
use std::io;
use std::path::PathBuf;

/// Logs of each kind behind the snapshot.
pub const SEEDS: u64 = 20;

/// Every row of the table.
pub struct Effects {
    rows: Vec<(Case, Row)>,
    dip: Vec<(&'static str, dip_table::Row)>,
}

impl Effects {
    /// Runs `seeds` logs of each kind; `say` hears every line as it is done.
    pub fn measure(seeds: u64, mut say: impl FnMut(&str)) -> Self {
        heading().lines().for_each(&mut say);
        let rows: Vec<(Case, Row)> = CASES
            .iter()
            .map(|case| {
                // Few seeds are for a quick look.
                let row = run(case, if seeds < SEEDS { seeds } else { case.logs(seeds) });
                say(&line(case, &row));
                (*case, row)
            })
            .collect();
        say("");
        say(dip_table::HEADING);
        let dip = dip_table::CASES
            .iter()
            .map(|hidden| {
                let row = dip_table::run(hidden, seeds);
                say(&dip_table::line(hidden, &row));
                (*hidden, row)
            })
            .collect();
        say("");
        pooled::text(&rows).lines().for_each(&mut say);
        Effects { rows, dip }
    }

    /// What the snapshot holds.
    pub fn text(&self) -> String {
        let lines = self.rows.iter().map(|(case, row)| line(case, row) + "\n");
        let dip = self.dip.iter().map(|(hidden, row)| dip_table::line(hidden, row) + "\n");
        format!(
            "{}{}\n{}\n{}\n{}",
            heading(),
            lines.collect::<String>(),
            dip_table::HEADING,
            dip.collect::<String>(),
            pooled::text(&self.rows)
        )
    }

    /// The rows that only the dip sees, one object each.
    pub fn dip_json(&self) -> Value {
        self.dip.iter().map(|(hidden, row)| dip_table::json(hidden, row)).collect()
    }

    /// One object a row; counts are of logs.
    pub fn json(&self) -> Value {
        self.rows
            .iter()
            .map(|(case, row)| {
                let [all, one, three] = row.coefficients;
                json!({
                    "hidden": case.hidden, "noise_ut": case.noise_ut, "correlation": case.correlation,
                    "without": case.without, "ramp": case.special == Special::Ramp,
                    "planar": case.special == Special::Planar, "verdict": case.verdict.name(),
                    "logs": row.logs, "named_first": row.named_first, "exact": row.exact,
                    "right_verdict": row.verdict, "worst_holdout_over_floor": row.worst_over_floor,
                    "coefficients": all, "inside_one_se": one, "inside_three_se": three,
                })
            })
            .collect()
    }

    /// Where the snapshot lies.
    pub fn snapshot_path() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/effects.txt"))
    }

    /// Writes the snapshot, and the table of the document of measurements.
    ///
    /// # Errors
    /// A file that cannot be written, or a document without the table's markers.
    pub fn store(&self) -> io::Result<()> {
        let text = self.text();
        std::fs::write(Self::snapshot_path(), &text)?;
        measured::write(&[("accuracy-effects", text)])
    }
}

fn heading() -> String {
    format!("logs of 80 s at 50 Hz\n{HEADING}\n")
}
