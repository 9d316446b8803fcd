//! An effect of any family, as plain data: what an analysis fits and a calibration file holds.

use super::column_name::ColumnName;
use super::definition::Effect;
use super::family::Family;
use super::parts::{InParts, Parts};
use super::quantities::{Coefficients, Column, MAX_COEFFICIENTS, MAX_INPUTS, Quantities, Shape};
use core::fmt;

/// A family with the parts of one effect of it. `C` is the column's name: `&str`, or a [`ColumnName`] that owns it.
#[derive(Clone, Copy)]
pub struct Made<C> {
    family: &'static dyn Family,
    parts: Parts<C>,
}

impl<C> Made<C> {
    /// An effect of a family; `None` if the family has no such form.
    pub fn new(family: &'static dyn Family, parts: Parts<C>) -> Option<Self> {
        family.forms().contains(&parts.form).then_some(Made { family, parts })
    }

    /// Its family.
    pub fn family(&self) -> &'static dyn Family {
        self.family
    }

    /// Its parts.
    pub fn parts(&self) -> &Parts<C> {
        &self.parts
    }
}

impl<C: AsRef<str>> Made<C> {
    fn ask<R>(&self, otherwise: R, mut question: impl FnMut(&dyn Effect<f64>) -> R) -> R {
        let mut answer = otherwise;
        self.family.with(&self.parts.borrowed(), &mut |effect| answer = question(effect));
        answer
    }

    /// The columns it reads, with names that live as long as the parts.
    pub fn inputs(&self) -> [Option<Column<'_, f64>>; MAX_INPUTS] {
        self.family.columns(&self.parts.borrowed())
    }
}

impl<C: AsRef<str>> Effect<f64> for Made<C> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        let Parts { form, column, .. } = self.parts.borrowed();
        out.write_str(self.family.kind())?;
        if form.column {
            write!(out, ":{column}")?;
        }
        out.write_str(form.suffix)
    }
    fn name(&self) -> &'static str {
        self.ask("", |effect| effect.name())
    }
    fn explanation(&self) -> &'static str {
        self.ask("", |effect| effect.explanation())
    }
    fn columns(&self) -> [Option<Column<'_, f64>>; MAX_INPUTS] {
        self.inputs()
    }
    fn needs_gyro(&self) -> bool {
        self.ask(false, |effect| effect.needs_gyro())
    }
    fn coefficients(&self) -> usize {
        self.parts.form.coefficients.min(MAX_COEFFICIENTS)
    }
    fn unit(&self) -> &'static str {
        self.ask("", |effect| effect.unit())
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        self.family.with(&self.parts.borrowed(), &mut |effect| effect.shape(at, shape));
    }
    fn repeats(&self) -> bool {
        self.ask(false, |effect| effect.repeats())
    }
    fn reads_centre(&self) -> bool {
        self.ask(true, |effect| effect.reads_centre())
    }
    fn delay_s(&self, coefficients: &Coefficients<f64>) -> Option<f64> {
        self.ask(None, |effect| effect.delay_s(coefficients))
    }
    fn disturbance(&self, at: &Quantities<f64>, coefficients: &Coefficients<f64>) -> [f64; 3] {
        self.ask([0.0; 3], |effect| effect.disturbance(at, coefficients))
    }
}

impl InParts for Made<ColumnName> {
    fn parts(&self) -> Parts<ColumnName> {
        self.parts
    }
    fn with_numbers(&self, parts: &Parts<ColumnName>) -> Self {
        let Parts { reference, parameter, .. } = *parts;
        Made { family: self.family, parts: Parts { reference, parameter, ..self.parts } }
    }
}

impl<C: PartialEq> PartialEq for Made<C> {
    fn eq(&self, other: &Self) -> bool {
        self.family.kind() == other.family.kind() && self.parts == other.parts
    }
}

impl<C: fmt::Debug> fmt::Debug for Made<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Made").field("kind", &self.family.kind()).field("parts", &self.parts).finish()
    }
}
