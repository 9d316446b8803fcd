//! Simulated logs of the frozen set: effects of the catalogue, harder truths, effects put into recordings, and a second generator.

use crate::accuracy::effect_table::{self, CASES};
use crate::accuracy::injected::Source;
use crate::frozen::entry::{Entry, Hidden, Made, Rows};
use ironout_analysis::outcome::outcome::Verdict;
use ironout_simulation::Log;
use ironout_simulation::truths::{Kind, draw};
use second_generator::Kind as SecondKind;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Logs per row of the table of effects.
const LOGS_PER_EFFECT: u64 = 3;
/// Logs per kind of harder truth.
const LOGS_PER_KIND: u64 = 15;
/// Logs per recording into which effects are put.
const LOGS_PER_RECORDING: u64 = 10;
/// Logs per kind of the second generator.
const LOGS_PER_SECOND_KIND: usize = 7;
/// Seeds apart from those that tables are measured on and thresholds were tuned on.
const FAMILY: u64 = 0xf0_2e;
/// Longer logs are left to the tables: the command is to take minutes.
const MAX_ROWS: f64 = 3500.0;

fn made(log: Log, hidden: Hidden) -> Made {
    let columns = log.names.into_iter().zip(log.columns).collect();
    // A fault that removes rows leaves the truth longer than the log.
    let rows = |columns: &Vec<(String, Vec<f64>)>| columns.first().map_or(0, |(_, values)| values.len());
    let truth = (log.truth.body_field_ut.len() == rows(&columns)).then_some(log.truth.body_field_ut);
    Made { rows: Rows::Columns(columns), hidden, body_field_ut: truth }
}

/// The table of effects: every row of it.
pub fn effects() -> Vec<Entry> {
    let each = CASES.iter().enumerate().flat_map(|(place, case)| {
        (0..LOGS_PER_EFFECT).map(move |seed| {
            let name = if case.hidden.is_empty() { "nothing" } else { case.hidden };
            Entry::new("effects", format!("{place} {name} {seed}"), move || {
                let log = effect_table::log(case, 1000 + seed);
                let hidden = match case.verdict {
                    Verdict::Unexplained => Hidden::ColumnMissing,
                    _ => Hidden::Effects(log.truth.effects.iter().map(|effect| effect.kind.id()).collect()),
                };
                Ok(made(log, hidden))
            })
        })
    });
    each.collect()
}

/// Harder truths, those that are short enough.
pub fn truths() -> Vec<Entry> {
    let each = Kind::ALL.into_iter().flat_map(|kind| {
        let short = move |number: &u64| {
            let drawn = draw(kind, FAMILY, *number);
            drawn.world.options().seconds * drawn.world.options().rate_hz <= MAX_ROWS
        };
        (0..).filter(short).take(LOGS_PER_KIND as usize).map(move |number| {
            Entry::new(kind.name(), number.to_string(), move || {
                let drawn = draw(kind, FAMILY, number);
                let hidden = match kind {
                    Kind::Deleted => Hidden::ColumnMissing,
                    _ => Hidden::Effects(drawn.hidden),
                };
                Ok(made(drawn.world.run(), hidden))
            })
        })
    });
    each.collect()
}

/// Effects put into real recordings, and the recordings untouched beside columns that cause nothing.
pub fn injected() -> Vec<Entry> {
    let each = Source::ALL.into_iter().flat_map(|source| {
        (0..LOGS_PER_RECORDING).map(move |number| {
            Entry::new(source.name(), number.to_string(), move || {
                // Other numbers than those of the table.
                let (columns, hidden) =
                    source.columns(1000 + number).ok_or("SKIPPED: the recording is not here")?;
                Ok(Made {
                    rows: Rows::Columns(columns),
                    hidden: Hidden::Injected(hidden),
                    body_field_ut: None,
                })
            })
        })
    });
    each.collect()
}

/// Logs that nothing was tuned on: so many of each kind of both generators and of each recording, from seeds that only these have.
pub fn unseen(numbers: Range<u64>) -> Vec<Entry> {
    /// Seeds of the own simulator.
    const FAMILY: u64 = 0x40_e1;
    /// The first number of the second generator, and of injected effects.
    const FROM: u64 = 8000;
    let later = FROM + numbers.start..FROM + numbers.end;
    let own = Kind::ALL.into_iter().flat_map(|kind| {
        numbers.clone().map(move |number| {
            Entry::new(kind.name(), format!("unseen {number}"), move || {
                let drawn = draw(kind, FAMILY, number);
                let hidden = match kind {
                    Kind::Deleted => Hidden::ColumnMissing,
                    _ => Hidden::Effects(drawn.hidden),
                };
                Ok(made(drawn.world.run(), hidden))
            })
        })
    });
    let second_numbers = later.clone();
    let second = SecondKind::ALL.into_iter().flat_map(move |kind| {
        second_numbers.clone().map(move |number| {
            Entry::new(&format!("second-{}", kind.name()), format!("unseen {number}"), move || {
                let drawn = second_generator::draw(kind, number);
                Ok(Made {
                    hidden: hidden_by_second(kind, &drawn.truth),
                    rows: Rows::Columns(drawn.columns),
                    body_field_ut: Some(drawn.truth.field_body_ut),
                })
            })
        })
    });
    let recorded = Source::ALL.into_iter().flat_map(|source| {
        later.clone().map(move |number| {
            Entry::new(source.name(), format!("unseen {number}"), move || {
                let (columns, hidden) = source.columns(number).ok_or("SKIPPED: the recording is not here")?;
                Ok(Made {
                    rows: Rows::Columns(columns),
                    hidden: Hidden::Injected(hidden),
                    body_field_ut: None,
                })
            })
        })
    });
    own.chain(second).chain(recorded).collect()
}

/// What a log of the second generator hides, as a diagnosis names it.
fn hidden_by_second(kind: SecondKind, truth: &second_generator::Truth) -> Hidden {
    match kind {
        SecondKind::Deleted => Hidden::ColumnMissing,
        // No effect of the catalogue is the right answer.
        SecondKind::Beyond => Hidden::Unknown,
        _ => {
            // A delay in seconds behind the sign, where a diagnosis has the word.
            let id = |hidden: &second_generator::Hidden| match hidden.id.split_once('@') {
                Some((plain, _)) => format!("{plain}@delay"),
                None => hidden.id.clone(),
            };
            Hidden::Effects(truth.hidden.iter().map(id).collect())
        }
    }
}

/// Logs of the second generator, the first of each kind that are short enough. A log's length is known when it is drawn: a kind's are
/// drawn when the first of them is asked for.
pub fn second() -> Vec<Entry> {
    let each = SecondKind::ALL.into_iter().flat_map(|kind| {
        let drawn: Arc<OnceLock<Vec<Made>>> = Arc::default();
        (0..LOGS_PER_SECOND_KIND).map(move |place| {
            let drawn = Arc::clone(&drawn);
            Entry::new(&format!("second-{}", kind.name()), place.to_string(), move || {
                Ok(drawn.get_or_init(|| short_of_second(kind))[place].clone())
            })
        })
    });
    each.collect()
}

fn short_of_second(kind: SecondKind) -> Vec<Made> {
    let drawn = (0..).map(move |number| second_generator::draw(kind, number));
    let short = drawn.filter(|drawn| drawn.columns.first().is_some_and(|(_, t)| t.len() as f64 <= MAX_ROWS));
    let made = short.take(LOGS_PER_SECOND_KIND).map(|drawn| Made {
        hidden: hidden_by_second(kind, &drawn.truth),
        rows: Rows::Columns(drawn.columns),
        body_field_ut: Some(drawn.truth.field_body_ut),
    });
    made.collect()
}
