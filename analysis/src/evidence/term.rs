//! A term of the model: an effect of the registry with its inputs and coefficients.

use crate::base::looked_at::Shared;
use crate::base::term::{Term as BaseTerm, ready};
use crate::evidence::log::{Inputs, Log, inputs};
use ironout::effect::{
    Acts, Follows, Form, Id, MAX_COEFFICIENTS, Made, Named, Parts, Quantities, Searched, Zero, no_shape,
};
use nalgebra::Vector3;

/// One term.
#[derive(Clone)]
pub struct Term<'a> {
    /// Id, as a calibration holds it.
    pub id: String,
    /// Family and parts.
    pub made: Made<&'a str>,
    effect: Shared<'a>,
    inputs: Inputs,
    /// Coefficients in the effect's own units.
    pub theta: [f64; MAX_COEFFICIENTS],
    /// Places tried for what was searched.
    pub places: f64,
    /// Twice the log of the prior odds against this form.
    pub odds: f64,
}

impl<'a> Term<'a> {
    /// The effect of an id on a log, with what was searched. `None` where the log lacks what it needs.
    pub fn new(log: &Log<'a>, named: &Named<'_>, column: Option<usize>, parameter: f64) -> Option<Self> {
        let Named { family, form, .. } = *named;
        if family.need(form).is_some_and(|need| !log.has(need)) {
            return None;
        }
        let pair = if form.column && column.is_none() { Some(log.pair(named)?) } else { None };
        let column = column.or(pair.map(|(_, [first, _])| first));
        let known = column.map(|index| &log.samples.columns[index]);
        let reference = match form.zero {
            Zero::None => 0.0,
            Zero::Column => known?.reference,
            Zero::Square => known?.reference_square,
            Zero::Time if family.follows() == Follows::Tone => log.origin_s(),
            Zero::Time => log.samples.middle_s,
        };
        let parameter = if form.searched.is_some() { parameter } else { 0.0 };
        let name =
            pair.map(|(name, _)| name).or(known.map(|column| column.name.as_str())).unwrap_or_default();
        let made = Made::new(family, Parts { form, column: name, reference, parameter })?;
        let inputs = match family.follows() {
            Follows::Column if pair.is_some() => log.pair_inputs(pair?.1),
            Follows::Column => log.column_inputs(column?, made.parts().past())?,
            Follows::Tone => inputs(log.even_s.as_deref().unwrap_or(&log.time_s)),
            Follows::Time => inputs(&log.time_s),
            Follows::Attitude | Follows::Turning => Inputs::default(),
        };
        Some(Term {
            id: Id(&made).to_string(),
            effect: ready(made),
            made,
            inputs,
            theta: [0.0; MAX_COEFFICIENTS],
            places: 1.0,
            odds: 0.0,
        })
    }

    /// The same effect as another engine has it, with its coefficients.
    pub fn standing(log: &Log<'a>, term: &BaseTerm) -> Option<Self> {
        let named = term.named()?;
        let column = match named.column {
            "" => None,
            name => log.samples.columns.iter().position(|column| column.name == name),
        };
        let parameter = term.searched().map_or(0.0, |(_, parameter)| parameter);
        Some(Term { theta: term.coefficients, ..Term::new(log, &named, column, parameter)? })
    }

    /// The same term on other samples of the log.
    pub fn rebound<'b>(&self, log: &Log<'b>) -> Option<Term<'b>> {
        let family = self.made.family();
        let column = match self.column() {
            "" => None,
            name => log.samples.columns.iter().position(|column| column.name == name),
        };
        let parameter = self.searched().map_or(0.0, |(_, parameter)| parameter);
        let named = Named { family, column: self.column(), form: self.form() };
        let new = Term::new(log, &named, column, parameter)?;
        Some(Term { theta: self.theta, places: self.places, odds: self.odds, ..new })
    }

    /// The form.
    pub fn form(&self) -> &'static Form {
        self.made.parts().form
    }

    /// What was searched, and where it was found.
    pub fn searched(&self) -> Option<(Searched, f64)> {
        self.made.parts().parameter()
    }

    /// Name of the column; empty where it has none.
    pub fn column(&self) -> &'a str {
        self.made.parts().column
    }

    /// What it goes by.
    pub fn follows(&self) -> Follows {
        self.made.family().follows()
    }

    /// Number of coefficients.
    pub fn k(&self) -> usize {
        self.form().coefficients.min(MAX_COEFFICIENTS)
    }

    /// Coefficients that the magnitude can show: a pure delay among them is hidden.
    pub fn visible(&self) -> usize {
        self.k() - usize::from(!self.made.family().delay_coefficients(self.form()).is_empty())
    }

    /// Whether its shape depends on the reading.
    pub fn reads(&self) -> bool {
        self.made.family().acts() != Acts::Added
    }

    /// Whether it stands for the same cause as another: one family and column, or several in time alone.
    pub fn is_variant_of(&self, other: &Term) -> bool {
        self.made.family().kind() == other.made.family().kind() && self.column() == other.column()
    }

    /// Vectors per unit of each coefficient at a sample, µT.
    pub fn shape(&self, sample: usize, at: &Quantities<f64>) -> [[f64; 3]; MAX_COEFFICIENTS] {
        let mut shape = no_shape();
        let at = Quantities { inputs: self.inputs.get(sample).copied().unwrap_or_default(), ..*at };
        self.effect.shape(&at, &mut shape);
        shape
    }

    /// Disturbance at a sample, µT.
    pub fn disturbance(&self, sample: usize, at: &Quantities<f64>) -> Vector3<f64> {
        let shape = self.shape(sample, at);
        (0..self.k()).map(|c| Vector3::from(shape[c]) * self.theta[c]).sum()
    }
}
