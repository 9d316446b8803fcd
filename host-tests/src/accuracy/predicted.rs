//! Whether the error that a diagnosis predicts of its corrected vectors is the true one, for kinds of logs of two generators.

use crate::accuracy::snapshot;
use crate::accuracy::true_error::true_error_ut;
use crate::accuracy::truths::{MEASURED_ON, in_parallel};
use crate::measured;
use crate::rate::Rate;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Options, Table, diagnose};
use ironout_simulation::truths::{Kind, draw};
use second_generator::Kind as SecondKind;
use serde_json::{Value, json};
use std::io;
use std::path::PathBuf;

/// Logs of each kind.
pub const LOGS: u64 = 40;
/// An error is beyond what is predicted above so many standard deviations.
const MAX_ERRORS_PREDICTED: f64 = 3.0;
/// Numbers of the second generator apart from those of the frozen set, and from 5000 to 5039, on which causes were found.
const FIRST_OF_SECOND: u64 = 6000;

const OWN: [Kind; 4] = [Kind::Nothing, Kind::NothingFlicker, Kind::Strong, Kind::OfAttitude];
const SECOND: [SecondKind; 6] = [
    SecondKind::NothingWhite,
    SecondKind::NothingColoured,
    SecondKind::PlainOffset,
    SecondKind::Gain,
    SecondKind::Lag,
    SecondKind::Shape,
];

/// One log.
#[derive(Debug, Clone, Copy)]
struct Judged {
    /// The true error of the corrected vector over the predicted one; `None` without a calibration.
    ratio: Option<f64>,
    /// The verdict says that nothing else is missing.
    claims: bool,
}

fn judged(columns: &[(String, Vec<f64>)], truth: &[[f64; 3]]) -> Judged {
    let named = columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
    let nothing = Judged { ratio: None, claims: false };
    let Ok(table) = Table::from_columns(named) else { return nothing };
    let Ok(found) = diagnose(&table, &Options { search: true, ..Options::default() }) else { return nothing };
    let ratio = true_error_ut(&table, &found, truth)
        .zip(found.vector_error_ut())
        .map(|(error, predicted)| error / predicted)
        .filter(|ratio| ratio.is_finite());
    Judged { ratio, claims: matches!(found.verdict, Verdict::Complete | Verdict::Missing) }
}

fn judged_second(kind: SecondKind, number: u64) -> Judged {
    let drawn = second_generator::draw(kind, number);
    judged(&drawn.columns, &drawn.truth.field_body_ut)
}

/// The true error of the corrected vector over the predicted one, of one log of the second generator; `None` without a calibration.
pub fn ratio_of_second(kind: SecondKind, number: u64) -> Option<f64> {
    judged_second(kind, number).ratio
}

/// One kind.
struct Row<'a> {
    kind: &'a str,
    /// Of true over predicted error.
    median: f64,
    rms: f64,
    beyond: Rate,
    /// Where the verdict says that nothing else is missing.
    beyond_of_claimed: Rate,
}

/// The table, a line a kind.
pub struct Predicted(Vec<(String, Vec<Judged>)>);

impl Predicted {
    /// Runs so many logs of each kind; `say` hears each kind as it begins.
    pub fn measure(logs: u64, say: impl Fn(&str)) -> Self {
        let own = OWN.map(|kind| {
            say(kind.name());
            let of = |number| {
                let log = draw(kind, MEASURED_ON, number).world.run();
                let columns: Vec<_> = log.names.into_iter().zip(log.columns).collect();
                judged(&columns, &log.truth.body_field_ut)
            };
            (kind.name().to_owned(), in_parallel(0..logs, of))
        });
        let second = SECOND.map(|kind| {
            let name = format!("second-{}", kind.name());
            say(&name);
            let of = |number| judged_second(kind, number);
            (name, in_parallel(FIRST_OF_SECOND..FIRST_OF_SECOND + logs, of))
        });
        Predicted(own.into_iter().chain(second).collect())
    }

    fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.0.iter().map(|(kind, logs)| {
            let beyond = |logs: &mut dyn Iterator<Item = &Judged>| {
                let ratios: Vec<f64> = logs.filter_map(|one| one.ratio).collect();
                let count = ratios.iter().filter(|ratio| **ratio > MAX_ERRORS_PREDICTED).count() as u64;
                Rate { count, of: ratios.len() as u64 }
            };
            let mut ratios: Vec<f64> = logs.iter().filter_map(|one| one.ratio).collect();
            ratios.sort_by(f64::total_cmp);
            Row {
                kind,
                median: ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN),
                rms: (ratios.iter().map(|ratio| ratio * ratio).sum::<f64>() / ratios.len() as f64).sqrt(),
                beyond: beyond(&mut logs.iter()),
                beyond_of_claimed: beyond(&mut logs.iter().filter(|one| one.claims)),
            }
        })
    }

    /// What the snapshot holds.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{:<26}  {:>6}  {:>6}  {:<30}beyond 3, complete or missing\n",
            "kind", "median", "rms", "beyond 3"
        );
        for Row { kind, median, rms, beyond, beyond_of_claimed } in self.rows() {
            text += &format!("{kind:<26}  {median:>6.2}  {rms:>6.2}  {beyond:<30}{beyond_of_claimed}\n");
        }
        text
    }

    /// One object a kind.
    pub fn json(&self) -> Value {
        let of = |rate: Rate| json!({ "count": rate.count, "of": rate.of });
        let rows = self.rows().map(|row| {
            json!({
                "kind": row.kind, "median": row.median, "rms": row.rms,
                "beyond_3": of(row.beyond), "beyond_3_of_complete_or_missing": of(row.beyond_of_claimed),
            })
        });
        rows.collect()
    }

    /// Where the snapshot lies.
    pub fn snapshot_path() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/predicted.txt"))
    }

    /// Writes the snapshot and the table of the document.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn store(&self) -> io::Result<()> {
        std::fs::write(Self::snapshot_path(), self.text())?;
        measured::write(&[("accuracy-predicted", self.text())])
    }

    /// Holds the table to its snapshot.
    ///
    /// # Errors
    /// It differs, or there is no snapshot.
    pub fn hold(&self) -> io::Result<()> {
        snapshot::hold(&Self::snapshot_path(), &self.text())
    }
}
