//! The candidates that the columns of a log allow, and those that it does not.

use crate::base::mounting;
use crate::base::term::Term;
use crate::evidence::log::Log;
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::effect::{Effect, Family, Form, Made, Named, Parts, Registry, TIME, Usual};

/// What a log allows to be tested.
pub struct Catalogue<'a> {
    log: Log<'a>,
    /// The families of effects.
    pub registry: Registry,
}

/// An effect that cannot be tested.
#[derive(Debug, Clone, PartialEq)]
pub struct Untestable {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: String,
    /// Why not, and what would allow it.
    pub why: String,
    /// Whether it would show in the dip.
    pub in_dip: bool,
}

/// The name of a family's effect of a column.
fn name_of(family: &'static dyn Family, form: &'static Form, column: &str) -> &'static str {
    let parts = Parts { form, column, reference: 0.0, parameter: 0.0 };
    Made::new(family, parts).map_or(family.kind(), |made| made.name())
}

impl<'a> Catalogue<'a> {
    /// Of a log.
    pub fn new(samples: &'a Samples, table: &'a Table<'a>, registry: Registry) -> Self {
        Catalogue { log: Log::new(samples, table, None, false), registry }
    }

    /// The log.
    pub fn table(&self) -> &'a Table<'a> {
        self.log.table
    }

    /// Names of the covariates that can be tested.
    pub fn usable_columns(&self) -> impl Iterator<Item = &'a str> + '_ {
        self.log.usable().map(|index| self.log.samples.columns[index].name.as_str())
    }

    /// The effect of an id, its searched parameter given (any number where it has none). `None` where the log lacks what
    /// it needs.
    pub fn build(&self, named: &Named, parameter: f64) -> Option<Term<'a>> {
        self.log.term(named, parameter)
    }

    /// The delay of the sensor that only the dip shows, where the log can tell one.
    pub fn late_sensor(&self) -> Option<Term<'a>> {
        let forms =
            self.registry.families().flat_map(|family| family.forms().iter().map(move |form| (family, form)));
        let mut hidden = forms.filter(|(_, form)| form.dip_only);
        hidden.find_map(|(family, form)| self.build(&Named { family, column: "", form }, 0.0))
    }

    /// Whether the log has directions down for most samples.
    pub fn has_down(&self) -> bool {
        self.log.samples.readings.iter().filter(|reading| reading.down.is_some()).count() * 10
            > 3 * self.log.samples.len()
    }

    /// The effects that the log allows: for each column every family's first form, then the others, then those of its past; then those
    /// without a column.
    pub fn offered(&self) -> impl Iterator<Item = Named<'a>> + '_ {
        let order = |form: &Form, place: usize| (form.is_late(), form.searched.is_some(), place > 0);
        let of = move |column: &'a str| {
            let mut list = Vec::new();
            for family in self.registry.families().filter(|family| column.is_empty() || family.suits(column))
            {
                for (place, form) in family.forms().iter().copied().enumerate() {
                    let named = Named { family, column, form };
                    let fits = form.offered && !form.dip_only && form.column != column.is_empty();
                    // Nothing of a past is asked here: any will do.
                    if fits && self.build(&named, 0.0).is_some() {
                        list.push((order(form, place), named));
                    }
                }
            }
            list.sort_by_key(|(order, _)| *order);
            list.into_iter().map(|(_, named)| named)
        };
        self.usable_columns().chain([""]).flat_map(of)
    }

    /// What the log does not allow, with the reason.
    pub fn untestable(&self) -> Vec<Untestable> {
        let mut list = Vec::new();
        let mut add = |named: &Named, name: String, why: String| {
            let in_dip = named.family.forms().iter().any(|form| form.dip_only);
            list.push(Untestable { id: named.to_string(), name, why, in_dip });
        };
        let first = |family: &'static dyn Family| family.forms().first().copied();
        let families = || self.registry.families().filter_map(|family| Some((family, first(family)?)));
        for column in &self.log.samples.columns {
            let Some(problem) = &column.problem else { continue };
            for (family, form) in families().filter(|(_, form)| form.column) {
                let named = Named { family, column: &column.name, form };
                let name = format!("{} with {}", family.kind(), column.name);
                let remedy = if column.causes_nothing { "" } else { ". Log it while it changes" };
                add(&named, name, format!("{problem}{remedy}"));
            }
        }
        let mut usual: Vec<Usual> = Vec::new();
        for one in families().flat_map(|(family, _)| family.usual_columns()) {
            if !usual.contains(one) {
                usual.push(*one);
            }
        }
        usual.retain(|usual| !self.log.samples.columns.iter().any(|column| usual.is_of(&column.name)));
        for usual in usual {
            for (family, form) in families().filter(|(family, _)| family.usual_columns().contains(&usual)) {
                let named = Named { family, column: usual.column, form };
                let why = format!("no {} column. Log {}", usual.what, usual.column);
                add(&named, name_of(family, form, usual.column).into(), why);
            }
        }
        for (family, form) in families().filter(|(_, form)| !form.column) {
            let named = Named { family, column: "", form };
            let hidden = family.forms().iter().copied().find(|form| form.dip_only);
            if let Some(need) = family.need(form).filter(|need| !self.log.has(*need)) {
                add(&named, name_of(family, form, "").into(), need.missing().into());
            } else if let Some(why) = self.lacks(&named) {
                add(&named, name_of(family, form, "").into(), why);
            } else if let (Some(form), false) = (hidden, self.has_down()) {
                add(&Named { form, ..named }, name_of(family, form, "").into(), family.without_down().into());
            }
        }
        if !self.has_down() {
            list.extend(mounting::ALL.iter().map(|one| Untestable {
                id: one.id.into(),
                name: one.name.into(),
                why: mounting::WITHOUT_DOWN.into(),
                in_dip: true,
            }));
        }
        list
    }

    /// Which column of its own an effect misses that names none in its id.
    fn lacks(&self, named: &Named) -> Option<String> {
        let parts = Parts::<&str>::of(named.form);
        let columns = named.family.columns(&parts);
        let mut missing = columns.iter().flatten().filter(|column| column.name != TIME);
        missing.find_map(|column| {
            match self.log.samples.columns.iter().find(|known| known.name == column.name) {
                None => Some(format!("no column {0}. Log {0}", column.name)),
                Some(known) => Some(format!("{}. Log it while it changes", known.problem.as_ref()?)),
            }
        })
    }
}
