//! The candidates that the columns of a log allow, and those that it does not.

use crate::base::mounting;
use crate::base::term::{Clock, Term};
use crate::samples::clock::even;
use crate::samples::families::Families;
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::effect::{
    Acts, Column, Effect, Family, Follows, Form, MAX_INPUTS, Made, Named, Need, Parts, Registry, TIME, Usual,
    Zero,
};
use std::sync::Arc;

/// The values of an effect's columns, a row a sample.
type Inputs = Arc<Vec<[f64; MAX_INPUTS]>>;

/// Times that begin this near to zero, s, have a zero of their own that phases may count from.
const OWN_ZERO_S: f64 = 1000.0;

/// What a log allows to be tested.
pub struct Catalogue<'a> {
    samples: &'a Samples,
    table: &'a Table<'a>,
    time: Option<Inputs>,
    /// The even grid behind stamps of arrival, for tones.
    grid: Option<Inputs>,
    columns: Vec<Inputs>,
    none: Inputs,
    /// Every covariate's name.
    names: Vec<&'a str>,
    /// Which covariates move together.
    pub families: Families,
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

fn inputs(values: &[f64]) -> Inputs {
    Arc::new(values.iter().map(|value| [*value, 0.0]).collect())
}

/// The name of a family's effect of a column.
fn name_of(family: &'static dyn Family, form: &'static Form, column: &str) -> &'static str {
    let parts = Parts { form, column, reference: 0.0, parameter: 0.0 };
    Made::new(family, parts).map_or(family.kind(), |made| made.name())
}

impl<'a> Catalogue<'a> {
    /// Of a log.
    pub fn new(samples: &'a Samples, table: &'a Table<'a>, registry: Registry) -> Self {
        Catalogue {
            samples,
            table,
            time: samples.time.as_deref().map(inputs),
            grid: table
                .time_s
                .and_then(even)
                .map(|grid| Arc::new(samples.row.iter().map(|&row| [grid[row], 0.0]).collect::<Vec<_>>())),
            columns: samples.columns.iter().map(|column| inputs(&column.values)).collect(),
            none: Arc::new(Vec::new()),
            names: samples.columns.iter().map(|column| column.name.as_str()).collect(),
            families: Families::of(samples),
            registry,
        }
    }

    /// The log.
    pub fn table(&self) -> &'a Table<'a> {
        self.table
    }

    /// The same of other samples of the log.
    pub fn over<'b>(&self, samples: &'b Samples) -> Catalogue<'b>
    where
        'a: 'b,
    {
        Catalogue::new(samples, self.table, self.registry)
    }

    /// An effect of other samples of the log, with its coefficients, over these.
    pub fn again(&self, term: &Term) -> Option<Term<'a>> {
        let parameter = term.searched().map_or(0.0, |(_, value)| value);
        let own = self.by(term.clock, &term.named()?, parameter)?;
        Some(Term { coefficients: term.coefficients, id: term.id.clone(), trials: term.trials, ..own })
    }

    /// Index of a covariate that can be tested.
    pub fn usable(&self, name: &str) -> Option<usize> {
        let index = self.names.iter().position(|known| *known == name)?;
        self.samples.columns[index].problem.is_none().then_some(index)
    }

    /// Names of the covariates that can be tested.
    pub fn usable_columns(&self) -> impl Iterator<Item = &'a str> + '_ {
        let fine = |index: &usize| self.samples.columns[*index].problem.is_none();
        (0..self.names.len()).filter(fine).map(|index| self.names[index])
    }

    /// The effect of an id, its searched parameter given (any number where it has none). `None` where the log lacks what
    /// it needs.
    pub fn build(&self, named: &Named, parameter: f64) -> Option<Term<'a>> {
        self.by(Clock::Even, named, parameter)
    }

    /// The same by one of the clocks, which is the only one for all but tones.
    pub fn by(&self, clock: Clock, named: &Named, parameter: f64) -> Option<Term<'a>> {
        let Named { family, form, .. } = *named;
        if family.need(form).is_some_and(|need| !self.has(need)) {
            return None;
        }
        let index = if form.column { Some(self.usable(named.columns().next()?)?) } else { None };
        let column = index.map(|index| &self.samples.columns[index]);
        let reference = match form.zero {
            Zero::None => 0.0,
            Zero::Column => column?.reference,
            Zero::Square => column?.reference_square,
            Zero::Time if family.follows() == Follows::Tone => self.origin_s()?,
            Zero::Time => self.samples.middle_s,
        };
        let parameter = if form.searched.is_some() { parameter } else { 0.0 };
        let column = match index {
            Some(index) if self.names[index] == named.column => self.names[index],
            Some(_) => self.samples.pairs.iter().find(|pair| *pair == named.column)?,
            None => "",
        };
        let made = Made::new(family, Parts { form, column, reference, parameter })?;
        let is_even = clock == Clock::Even && family.follows() == Follows::Tone;
        if let Some(grid) = self.grid.as_ref().filter(|_| is_even) {
            return Some(Term { clock, ..Term::new(made, grid.clone()) });
        }
        Some(Term::new(made, self.inputs(family.columns(made.parts()))?))
    }

    /// The times that tones go by, where they are not those of the samples.
    pub fn grid(&self) -> Option<Vec<f64>> {
        Some(self.grid.as_ref()?.iter().map(|[time, _]| *time).collect())
    }

    /// Where phases count from: the log's own zero if that is near its beginning.
    fn origin_s(&self) -> Option<f64> {
        let first = self.samples.time.as_ref()?.first().copied()?;
        Some(if first.abs() < OWN_ZERO_S { 0.0 } else { first })
    }

    fn inputs(&self, columns: [Option<Column<f64>>; MAX_INPUTS]) -> Option<Inputs> {
        match columns {
            [None, None] => Some(self.none.clone()),
            [Some(column), None] => self.input(&column),
            [None, Some(column)] => {
                let second = self.input(&column)?;
                Some(Arc::new(second.iter().map(|[value, _]| [0.0, *value]).collect()))
            }
            [Some(one), Some(two)] => {
                let (one, two) = (self.input(&one)?, self.input(&two)?);
                Some(Arc::new(one.iter().zip(two.iter()).map(|([a, _], [b, _])| [*a, *b]).collect()))
            }
        }
    }

    fn input(&self, column: &Column<f64>) -> Option<Inputs> {
        if column.name == TIME {
            return self.time.clone();
        }
        let index = self.usable(column.name)?;
        if column.past.seconds() != 0.0 {
            let values = self.samples.past(self.table, self.names[index], column.past)?;
            return Some(inputs(&values));
        }
        Some(self.columns[index].clone())
    }

    /// The delay of the sensor that only the dip shows, where the log can tell one.
    pub fn late_sensor(&self) -> Option<Term<'a>> {
        let forms =
            self.registry.families().flat_map(|family| family.forms().iter().map(move |form| (family, form)));
        let mut hidden = forms.filter(|(_, form)| form.dip_only);
        hidden.find_map(|(family, form)| self.build(&Named { family, column: "", form }, 0.0))
    }

    /// Whether the log has what effects may need besides columns.
    pub fn has(&self, need: Need) -> bool {
        match need {
            Need::Time => self.time.is_some(),
            Need::Gyro => {
                self.samples.readings.iter().filter(|reading| reading.turn_radps.is_some()).count() * 2
                    > self.samples.len()
            }
        }
    }

    /// Whether the log has directions down for most samples.
    pub fn has_down(&self) -> bool {
        self.samples.readings.iter().filter(|reading| reading.down.is_some()).count() * 10
            > 3 * self.samples.len()
    }

    /// The fixed-shape candidates of the magnitude (or of the vector of a board at rest): for each column every family's
    /// first form and then the others, then those without a column.
    pub fn plain(&self, at_rest: bool) -> Vec<Term<'a>> {
        let fixed = |form: &&'static Form| form.offered && !form.dip_only && form.searched.is_none();
        let shows = |family: &&'static dyn Family| !at_rest || family.acts() == Acts::Added;
        let mut list = Vec::new();
        for column in self.usable_columns() {
            for first in [true, false] {
                for family in self.registry.families().filter(shows).filter(|family| family.suits(column)) {
                    let forms = family.forms().iter().copied().enumerate();
                    let forms =
                        forms.filter(|(place, form)| form.column && (*place == 0) == first && fixed(form));
                    list.extend(
                        forms.filter_map(|(_, form)| self.build(&Named { family, column, form }, 0.0)),
                    );
                }
            }
        }
        for family in self.registry.families().filter(shows) {
            let forms = family.forms().iter().copied().filter(|form| !form.column && fixed(form));
            list.extend(forms.filter_map(|form| self.build(&Named { family, column: "", form }, 0.0)));
        }
        list
    }

    /// The forms without a column of which something is searched for.
    pub fn searched(&self) -> Vec<Named<'static>> {
        let mut list = Vec::new();
        for family in self.registry.families() {
            let forms = family.forms().iter().copied();
            let forms = forms.filter(|form| form.offered && !form.column && form.searched.is_some());
            list.extend(forms.map(|form| Named { family, column: "", form }));
        }
        list
    }

    /// The forms that follow the past of a column.
    pub fn late(&self, column: &'a str) -> Vec<Named<'a>> {
        let mut list = Vec::new();
        for family in self.registry.families() {
            let late = |form: &&'static Form| form.offered && form.column && form.is_late();
            list.extend(family.forms().iter().copied().filter(late).map(|form| Named {
                family,
                column,
                form,
            }));
        }
        list
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
        for column in &self.samples.columns {
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
        usual.retain(|usual| !self.names.iter().any(|name| usual.is_of(name)));
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
            if let Some(need) = family.need(form).filter(|need| !self.has(*need)) {
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
        missing.find_map(|column| match self.samples.columns.iter().find(|known| known.name == column.name) {
            None => Some(format!("no column {0}. Log {0}", column.name)),
            Some(known) => Some(format!("{}. Log it while it changes", known.problem.as_ref()?)),
        })
    }
}
