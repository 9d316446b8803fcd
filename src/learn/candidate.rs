//! What the learner can tell: candidates, their columns, and the effects that they are.

use super::columns::MAX_TESTED;
use super::layout::{DRIFT, STEP};
use super::learner::Learner;
use super::solve::Chosen;
use crate::effect::{BuiltIn, Drift, Lag, Offset, Past, Power, Step};

/// An effect that a board tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Candidate {
    /// An offset that goes with the time.
    Drift,
    /// An offset that follows the column at this place.
    Column(u8),
    /// An offset from some moment on.
    Step,
    /// A late sensor; the dip shows it.
    Lag,
}

/// How many candidates there are, and thus places for what is found of each.
pub(super) const CANDIDATES: usize = MAX_TESTED + 3;
/// Those that the magnitude shows stand before [`Candidate::Lag`].
pub(super) const SHOWN_BY_MAGNITUDE: usize = CANDIDATES - 1;

impl Candidate {
    /// All, each at the place that [`Candidate::place`] says.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        (0..CANDIDATES).filter_map(Self::at)
    }

    pub(super) fn at(place: usize) -> Option<Self> {
        Some(match place {
            0 => Self::Drift,
            1..=MAX_TESTED => Self::Column(place as u8 - 1),
            _ if place == MAX_TESTED + 1 => Self::Step,
            _ if place == MAX_TESTED + 2 => Self::Lag,
            _ => return None,
        })
    }

    /// Its place among all.
    pub fn place(self) -> usize {
        match self {
            Self::Drift => 0,
            Self::Column(place) => 1 + usize::from(place),
            Self::Step => MAX_TESTED + 1,
            Self::Lag => MAX_TESTED + 2,
        }
    }

    /// Its three columns, of those of the magnitude.
    pub(super) fn first_column(self) -> Option<usize> {
        match self {
            Self::Drift => Some(DRIFT),
            Self::Column(place) => Some(DRIFT + 3 + 3 * usize::from(place)),
            Self::Step => Some(STEP),
            Self::Lag => None,
        }
    }

    /// Whether it goes by the clock.
    pub fn goes_by_time(self) -> bool {
        self.is_in_time()
    }

    /// Whether it is a shape in time, with no logged cause behind it.
    pub(super) fn is_in_time(self) -> bool {
        matches!(self, Self::Drift | Self::Step)
    }
}

/// Some of the candidates, by their places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Found(u8);

impl Found {
    /// None of them.
    pub const fn none() -> Self {
        Self(0)
    }
    /// The same with one more.
    pub fn with(self, candidate: Candidate) -> Self {
        Self(self.0 | 1 << candidate.place())
    }
    /// The same without one.
    pub fn without(self, candidate: Candidate) -> Self {
        Self(self.0 & !(1 << candidate.place()))
    }
    /// Whether it is among them.
    pub fn has(self, candidate: Candidate) -> bool {
        self.0 & 1 << candidate.place() != 0
    }
    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
    /// How many there are.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }
    /// They, in their order.
    pub fn iter(self) -> impl Iterator<Item = Candidate> {
        Candidate::all().filter(move |one| self.has(*one))
    }

    /// The base and the columns of these.
    pub(super) fn chosen(self) -> Chosen {
        self.iter()
            .filter_map(Candidate::first_column)
            .fold(Chosen::base(super::point::BASE), |chosen, first| chosen.with(first, 3))
    }
}

impl Learner {
    /// The effect that a candidate is, as far as the study knows it: referred to the mean of its column. `None` where there is no
    /// such column, or no moment for a step.
    pub fn effect(&self, candidate: Candidate) -> Option<BuiltIn<f64>> {
        Some(match candidate {
            Candidate::Drift => {
                BuiltIn::Drift(Drift { reference_s: 0.5e-3 * (self.first_ms + self.last_ms) as f64 })
            }
            Candidate::Column(place) => {
                let column = self.columns.get(usize::from(place))?;
                let reference = column.mean(self.rows());
                BuiltIn::Offset(Offset {
                    column: column.name,
                    reference,
                    power: Power::Linear,
                    past: Past::Now,
                })
            }
            Candidate::Step => BuiltIn::Step(Step { at_s: self.marks.best_ms(self.last_ms)? as f64 * 1e-3 }),
            Candidate::Lag => BuiltIn::Lag(Lag),
        })
    }

    /// The candidate that an effect is; `None` for one that is not tested here.
    pub fn candidate(&self, effect: &BuiltIn<f64>) -> Option<Candidate> {
        match effect {
            BuiltIn::Drift(_) => Some(Candidate::Drift),
            BuiltIn::Offset(Offset { column, power: Power::Linear, past: Past::Now, .. }) => {
                self.columns.place(column.as_str()).map(|place| Candidate::Column(place as u8))
            }
            BuiltIn::Step(_) => Some(Candidate::Step),
            BuiltIn::Lag(_) => Some(Candidate::Lag),
            _ => None,
        }
    }
}
