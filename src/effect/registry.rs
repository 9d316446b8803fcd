//! The families there are: those of this crate, and a program's own.

use super::built_in::{Typed, built_in_effects};
use super::column_name::ColumnName;
use super::definition::Effect;
use super::family::{Advice, Family, Need, Subject};
use super::parts::{Form, InParts, Parts};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape, TIME};
use super::{cross_axis, drift, field, gain, lag, nonlinearity, offset, periodic, product, soft_iron, step};
use crate::math::Real;
use core::fmt;

built_in_effects! {
    offset::Offsets => Offset(offset::Offset<ColumnName, T>);
    product::Products => Product(product::Product<ColumnName, T>);
    gain::Gains => Gain(gain::Gain<ColumnName, T>);
    field::AmbientFields => Field(field::AmbientField<ColumnName, T>);
    soft_iron::SoftIrons => SoftIron(soft_iron::SoftIron<ColumnName, T>);
    drift::Drifts => Drift(drift::Drift<T>);
    step::Steps => Step(step::Step<T>);
    periodic::Tones => Periodic(periodic::Periodic);
    lag::Lags => Lag(lag::Lag), Eddy(lag::Eddy);
    nonlinearity::Nonlinearities => Nonlinearity(nonlinearity::Nonlinearity);
    cross_axis::CrossAxes => CrossAxis(cross_axis::CrossAxis);
}

impl<T: Real> InParts for BuiltIn<T> {
    fn parts(&self) -> Parts<ColumnName> {
        self.parts()
    }
    fn with_numbers(&self, parts: &Parts<ColumnName>) -> Self {
        let Parts { reference, parameter, .. } = *parts;
        self.renewed(&Parts { reference, parameter, ..self.parts() })
    }
}

/// An id taken apart. Shown by its `Display` it is the id again.
#[derive(Clone, Copy)]
pub struct Named<'a> {
    /// The family.
    pub family: &'static dyn Family,
    /// The column; empty where the family has none.
    pub column: &'a str,
    /// The form that the id ends in, of several the first.
    pub form: &'static Form,
}

impl<'a> Named<'a> {
    /// The effect as another one sees it that is to be told from it.
    pub fn subject(&self) -> Subject<'a> {
        Subject { follows: self.family.follows(), column: self.column, form: self.form }
    }

    /// The recording that would tell two effects apart, whichever of the two knows one.
    pub fn apart(&self, other: &Named<'a>) -> Option<Advice<'a>> {
        let (one, two) = (self.subject(), other.subject());
        self.family.apart(&one, &two).or_else(|| other.family.apart(&two, &one))
    }

    /// The columns of the log that it reads.
    pub fn columns(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        let parts = Parts { form: self.form, column: self.column, reference: 0.0, parameter: 0.0 };
        let columns = self.family.columns(&parts).into_iter().flatten().map(|column| column.name);
        columns.filter(|name| *name != TIME)
    }

    /// Whether both follow the same column in the same way, though perhaps late or squared.
    pub fn is_variant_of(&self, other: &Named) -> bool {
        self.family.kind() == other.family.kind() && self.column == other.column
    }

    /// The same with the form of so many coefficients, where its family has one under the same id.
    pub fn of_coefficients(self, k: usize) -> Self {
        let alike = |form: &&&'static Form| form.suffix == self.form.suffix && form.coefficients == k;
        Named { form: self.family.forms().iter().find(alike).copied().unwrap_or(self.form), ..self }
    }

    /// Whether it is the form that its family offers first.
    pub fn is_plain(&self) -> bool {
        self.family.forms().first() == Some(&self.form)
    }
}

/// The families that a program knows. Copies are cheap.
#[derive(Clone, Copy, Default)]
pub struct Registry {
    own: &'static [&'static dyn Family],
}

impl Registry {
    /// The families of this crate.
    pub const BUILT_IN: Self = Registry { own: &[] };

    /// The families of this crate, then a program's own. Of two of one kind the first counts.
    pub const fn with(own: &'static [&'static dyn Family]) -> Self {
        Registry { own }
    }

    /// The families, in the order in which they are offered.
    pub fn families(&self) -> impl Iterator<Item = &'static dyn Family> + use<> {
        BUILT_IN.iter().chain(self.own).copied()
    }

    /// Takes an id apart; `None` if there is no such effect.
    pub fn parse<'a>(&self, id: &'a str) -> Option<Named<'a>> {
        // A second step or tone has the first one's id and a number.
        if let Some((first, "2" | "3" | "4")) = id.rsplit_once('#')
            && !first.contains(['#', ':'])
        {
            return self.parse(first).filter(|named| named.form.is_repeated());
        }
        let (kind, column) = match id.split_once(':') {
            Some((kind, column)) => (Some(kind), column),
            None => (None, id),
        };
        for family in self.families().filter(|family| kind.is_none_or(|kind| kind == family.kind())) {
            let forms = family.forms().iter().copied().filter(|form| form.column == kind.is_some());
            // The empty suffix fits all: the longest is meant.
            let found = forms
                .filter_map(|form| Some((form, column.strip_suffix(form.suffix)?)))
                .min_by_key(|(_, column)| column.len());
            match found {
                Some((form, rest)) if kind.is_none() && rest == family.kind() => {
                    return Some(Named { family, column: "", form });
                }
                // A suffix that is left is that of another family's form.
                Some((form, column)) if kind.is_some() && !column.is_empty() && !self.is_suffixed(column) => {
                    return Some(Named { family, column, form });
                }
                _ => {}
            }
        }
        None
    }

    /// Whether a word ends as some form's id does.
    fn is_suffixed(&self, word: &str) -> bool {
        let mut forms = self.families().flat_map(|family| family.forms());
        forms.any(|form| !form.suffix.is_empty() && word.ends_with(form.suffix))
    }

    /// Each effect that a log of these columns allows, in the order in which they are offered.
    pub fn known<'a>(
        &self,
        columns: impl Iterator<Item = &'a str>,
        has: impl Fn(Need) -> bool,
        mut use_it: impl FnMut(Named<'a>),
    ) {
        let mut offer = |column: &'a str, named: bool| {
            for family in self.families().filter(|family| family.suits(column)) {
                let mut last = None;
                for form in family.forms().iter().copied().filter(|form| form.column == named && form.offered)
                {
                    if last != Some(form.suffix) && family.need(form).is_none_or(&has) {
                        use_it(Named { family, column, form });
                    }
                    last = Some(form.suffix);
                }
            }
        };
        for column in columns {
            offer(column, true);
        }
        offer("", false);
    }
}

/// The kinds that it adds to this crate's.
impl fmt::Debug for Registry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.own.iter().map(|family| family.kind())).finish()
    }
}

/// Registries are the same if they add the same kinds in the same order.
impl PartialEq for Registry {
    fn eq(&self, other: &Self) -> bool {
        self.own.iter().map(|family| family.kind()).eq(other.own.iter().map(|family| family.kind()))
    }
}

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Named { family, column, form } = self;
        f.write_str(family.kind())?;
        if form.column {
            write!(f, ":{column}")?;
        }
        f.write_str(form.suffix)
    }
}
