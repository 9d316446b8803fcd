//! A log as the evidence sees it: samples, their times, and the columns that may be a cause.

use crate::base::prior::Prior;
use crate::base::term::Term;
use crate::samples::clock::even;
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::effect::{Acts, Follows, MAX_INPUTS, Made, Named, Need, Parts, Past, Zero};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::Arc;

/// Values of the columns of an effect, a row per sample.
pub type Inputs = Arc<Vec<[f64; MAX_INPUTS]>>;

/// Times that begin this near to zero, s, have a zero of their own that phases may count from.
const OWN_ZERO_S: f64 = 1000.0;

/// Low-passes of columns that are kept, at most: each is a pass over all rows of the log, and every screen asks for the same grid.
const MOST_KEPT: usize = 256;

/// Samples and what belongs to them.
pub struct Log<'a> {
    /// The samples.
    pub samples: &'a Samples,
    /// The rows they are of.
    pub table: &'a Table<'a>,
    /// Times, s; numbers of the samples where the log has none.
    pub time_s: Vec<f64>,
    /// Whether the times are those of the log.
    pub is_timed: bool,
    /// The even times behind stamps of arrival, where those scatter.
    pub even_s: Option<Vec<f64>>,
    /// Field over the mean one along the way, per sample; empty where it is one field.
    pub share: Vec<f64>,
    /// What is known of offset and matrix besides the log, where that is more than how magnetometers are.
    pub known: Option<&'a Prior>,
    /// Whether the board rests: each sample stands there three times, once for each axis, and the reading itself is the residual.
    pub is_at_rest: bool,
    work: Cell<u64>,
    /// Columns and their low-passes, by column and bits of the time constant.
    kept: RefCell<HashMap<(usize, u64), Inputs>>,
}

impl<'a> Log<'a> {
    /// Of the samples of a table.
    pub fn new(
        samples: &'a Samples,
        table: &'a Table<'a>,
        known: Option<&'a Prior>,
        is_at_rest: bool,
    ) -> Self {
        let (time_s, is_timed) = match &samples.time {
            Some(time) => (time.clone(), true),
            None => ((0..samples.len()).map(|i| i as f64).collect(), false),
        };
        let even_s = table
            .time_s
            .and_then(even)
            .map(|grid| samples.row.iter().map(|&row| grid[row]).collect::<Vec<f64>>());
        let share = samples.places.iter().map(|place| place.share).collect();
        Log {
            samples,
            table,
            time_s,
            is_timed,
            even_s,
            share,
            known,
            is_at_rest,
            work: Cell::new(0),
            kept: RefCell::default(),
        }
    }

    /// Counts so many looks at a sample.
    pub fn look(&self, times: usize) {
        self.work.set(self.work.get() + times as u64);
    }

    /// How often samples were looked at.
    pub fn evaluations(&self) -> u64 {
        self.work.get()
    }

    /// Whether a term of these shapes can be told: where the board rests or the matrix is held, what turns with the board stands in
    /// for the matrix.
    pub fn tells(&self, acts: Acts) -> bool {
        acts == Acts::Added || !(self.is_at_rest || self.known.is_some_and(Prior::holds_matrix))
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// From the first to the last sample, s.
    pub fn length_s(&self) -> f64 {
        self.time_s.last().zip(self.time_s.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// Mean time between samples, s.
    pub fn step_s(&self) -> f64 {
        self.length_s() / self.len().saturating_sub(1).max(1) as f64
    }

    /// Whether the log has what an effect needs besides its column.
    pub fn has(&self, need: Need) -> bool {
        match need {
            Need::Time => self.is_timed,
            Need::Gyro => {
                self.samples.readings.iter().filter(|reading| reading.turn_radps.is_some()).count() * 2
                    > self.len()
            }
        }
    }

    /// Indices of the columns that can be tested.
    pub fn usable(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.samples.columns.len()).filter(|&index| self.samples.columns[index].problem.is_none())
    }

    /// Where phases count from: the log's own zero if that is near its beginning.
    pub fn origin_s(&self) -> f64 {
        match self.time_s.first() {
            Some(first) if first.abs() >= OWN_ZERO_S => *first,
            _ => 0.0,
        }
    }

    /// The effect of an id, what is searched of it given (any number where nothing is). `None` where the log lacks what it needs.
    pub fn term(&self, named: &Named, parameter: f64) -> Option<Term<'a>> {
        let Named { family, form, column } = *named;
        if family.need(form).is_some_and(|need| !self.has(need)) {
            return None;
        }
        let single = self.usable().find(|&index| self.samples.columns[index].name == column);
        let pair = if form.column && single.is_none() { Some(self.pair(named)?) } else { None };
        let index = single.filter(|_| form.column).or(pair.map(|(_, [first, _])| first));
        let known = index.map(|index| &self.samples.columns[index]);
        let reference = match form.zero {
            Zero::None => 0.0,
            Zero::Column => known?.reference,
            Zero::Square => known?.reference_square,
            Zero::Time if family.follows() == Follows::Tone => self.origin_s(),
            Zero::Time => self.samples.middle_s,
        };
        let parameter = if form.searched.is_some() { parameter } else { 0.0 };
        let name = pair.map(|(name, _)| name).or(known.map(|column| column.name.as_str()));
        let made = Made::new(family, Parts { form, column: name.unwrap_or_default(), reference, parameter })?;
        let inputs = match family.follows() {
            Follows::Column if pair.is_some() => self.pair_inputs(pair?.1),
            Follows::Column => self.column_inputs(index?, made.parts().past())?,
            Follows::Tone => inputs(self.even_s.as_deref().unwrap_or(&self.time_s)),
            Follows::Time => inputs(&self.time_s),
            Follows::Attitude | Follows::Turning => Inputs::default(),
        };
        Some(Term::new(made, inputs))
    }

    /// An effect of other samples of the log, with its coefficients, over these.
    pub fn again(&self, term: &Term) -> Option<Term<'a>> {
        let parameter = term.searched().map_or(0.0, |(_, parameter)| parameter);
        let own = self.term(&term.named()?, parameter)?;
        let Term { id, coefficients, trials, odds, bends, .. } = term.clone();
        Some(Term { id, coefficients, trials, odds, bends, ..own })
    }

    /// The two columns that a form names, with what their pair is called.
    pub fn pair(&self, named: &Named) -> Option<(&'a str, [usize; 2])> {
        let mut columns =
            named.columns().map(|name| self.usable().find(|&i| self.samples.columns[i].name == name));
        let indices = [columns.next()??, columns.next()??];
        Some((self.samples.pairs.iter().find(|pair| *pair == named.column)?, indices))
    }

    /// Values of two columns as the inputs of an effect.
    pub fn pair_inputs(&self, indices: [usize; 2]) -> Inputs {
        let [one, other] = indices.map(|index| &self.samples.columns[index].values);
        Arc::new(one.iter().zip(other).map(|(one, other)| [*one, *other]).collect())
    }

    /// Values of a column, or of its past, as the input of an effect.
    pub fn column_inputs(&self, index: usize, past: Past<f64>) -> Option<Inputs> {
        let column = &self.samples.columns[index];
        let key = match past {
            Past::Now => Some((index, 0)),
            Past::LowPass(time_constant_s) => Some((index, time_constant_s.to_bits())),
            Past::Delayed(_) => None,
        };
        if let Some(known) = key.and_then(|key| self.kept.borrow().get(&key).cloned()) {
            return Some(known);
        }
        let found = match past.seconds() == 0.0 {
            true => inputs(&column.values),
            false => inputs(&self.samples.past(self.table, &column.name, past)?),
        };
        let mut kept = self.kept.borrow_mut();
        if let Some(key) = key.filter(|(_, bits)| *bits == 0 || kept.len() < MOST_KEPT) {
            kept.insert(key, found.clone());
        }
        Some(found)
    }
}

/// Values as the first input of an effect.
pub fn inputs(values: &[f64]) -> Inputs {
    Arc::new(values.iter().map(|value| [*value, 0.0]).collect())
}
