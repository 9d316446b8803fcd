//! The table of the board's own study: how often it names what is hidden, and what `effect add` leaves.

use super::trace::{Kind, Trace, TraceOptions};
use crate::rate::Rate;
use ironout_simulation::Motion;

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// What was hidden, how the noise is and how the board was turned.
    pub name: String,
    /// Traces whose verdict is right: the hidden effect named first, nothing missing, confounded.
    pub right: Rate,
    /// The seeds of the others.
    pub wrong: Vec<u64>,
}

/// Whether `why` says what is hidden.
pub fn is_right(kind: Kind, said: &super::trace::Said) -> bool {
    match kind {
        Kind::Clean => said.verdict() == "complete",
        Kind::Ramp => said.verdict() == "confounded",
        _ => said.first() == kind.id(),
    }
}

/// Runs some traces of one kind.
pub fn row(kind: Kind, correlation: f64, motion: Motion, seeds: std::ops::Range<u64>) -> Row {
    let mut row = Row {
        name: format!("{}, noise {correlation:.1}, {motion:?}", kind.name()),
        right: Rate::default(),
        wrong: Vec::new(),
    };
    for seed in seeds {
        let mut trace = Trace::new(TraceOptions { correlation, motion, ..TraceOptions::new(kind, seed) });
        trace.calibrate();
        let is_right = is_right(kind, &trace.why());
        row.right.of += 1;
        row.right.count += u64::from(is_right);
        if !is_right {
            row.wrong.push(seed);
        }
    }
    row
}
