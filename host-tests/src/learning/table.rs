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
    /// Of those that were named, how many stream at most 1.1 times the noise floor once the effect is added; none of a lag, which the
    /// magnitude does not show.
    pub added: Rate,
}

/// Whether `why` says what is hidden.
pub fn is_right(kind: Kind, said: &super::trace::Said) -> bool {
    match kind {
        Kind::Clean => said.verdict() == "complete",
        Kind::Ramp => said.verdict() == "confounded",
        _ => said.first() == kind.id(),
    }
}

/// Runs some traces of one kind, with noise of this correlation, the board turned like this.
pub fn row(kind: Kind, correlation: f64, motion: Motion, seeds: std::ops::Range<u64>) -> Row {
    let name = format!("{}, noise {correlation:.1}, {motion:?}", kind.name());
    row_of(name, TraceOptions { correlation, motion, ..TraceOptions::new(kind, 0) }, seeds)
}

/// Runs some traces that differ in their seed alone.
pub fn row_of(name: String, options: TraceOptions, seeds: std::ops::Range<u64>) -> Row {
    let mut row = Row { name, right: Rate::default(), wrong: Vec::new(), added: Rate::default() };
    let kind = options.kind;
    for seed in seeds {
        let mut trace = Trace::new(TraceOptions { seed, ..options });
        trace.calibrate();
        let said = trace.why();
        let is_right = is_right(kind, &said);
        if is_right && matches!(kind, Kind::Temperature | Kind::Current | Kind::Step) {
            let added = trace.last(&format!("effect add {}", kind.id())).starts_with("ok ");
            let streamed_ut = trace.streamed_rms_ut(20);
            row.added.of += 1;
            row.added.count += u64::from(added && streamed_ut <= 1.1 * said.base("noise_floor_ut"));
        }
        row.right.of += 1;
        row.right.count += u64::from(is_right);
        if !is_right {
            row.wrong.push(seed);
        }
    }
    row
}
