//! The terms that a log allows: fixed forms, and those with a place, a frequency or a delay to be searched.

use crate::bounds::{
    ALONE_ODDS, DERIVED_ODDS, MAX_COLUMNS_PAIRED, MAX_DELAY_S, MAX_LEAD_S, MAX_TIME_CONSTANT_S, MIN_TONE_HZ,
};
use crate::evidence::fit::Fit;
use crate::evidence::log::Log;
use crate::evidence::screen::Screen;
use crate::evidence::term::Term;
use crate::samples::fft;
use ironout::effect::{ColumnKind, Follows, Named, Registry, Searched};

/// Places of a first look for a step.
const STEP_PLACES: usize = 48;

/// The forms of effects on a log.
pub struct Catalogue<'l, 'a> {
    log: &'l Log<'a>,
    registry: Registry,
    /// Terms without anything to search.
    pub fixed: Vec<Term<'a>>,
    /// How many candidates there are in all.
    pub count: f64,
}

impl<'l, 'a> Catalogue<'l, 'a> {
    /// Of a log.
    pub fn new(log: &'l Log<'a>, registry: Registry) -> Self {
        let mut fixed = Vec::new();
        let mut count = 0.0;
        for family in registry.families().filter(|family| log.tells(family.acts())) {
            for (place, form) in family.forms().iter().copied().enumerate() {
                if !form.offered || form.dip_only {
                    continue;
                }
                let suits = |index: &usize| family.suits(&log.samples.columns[*index].name);
                let columns: Vec<Option<usize>> =
                    if form.column { log.usable().filter(suits).map(Some).collect() } else { vec![None] };
                for column in columns {
                    let named = Named { family, column: "", form };
                    let Some(mut term) = Term::new(log, &named, column, 0.0) else { continue };
                    count += 1.0;
                    if form.searched.is_some() {
                        continue;
                    }
                    term.odds = if form.column && place > 0 { DERIVED_ODDS } else { 0.0 };
                    fixed.push(term);
                }
            }
        }
        Catalogue { log, registry, fixed, count }
    }

    /// The best places of the searched forms at a fit.
    pub fn searched(&self, fit: &Fit<'a>, screen: &Screen) -> Vec<Term<'a>> {
        let mut list = Vec::new();
        for family in self.registry.families().filter(|family| self.log.tells(family.acts())) {
            for form in family.forms().iter().copied().filter(|form| form.offered && !form.dip_only) {
                let named = Named { family, column: "", form };
                match form.searched {
                    Some(Searched::At) => list.extend(self.step(&named, fit, screen)),
                    Some(Searched::Frequency) => list.extend(self.tone(&named, fit, screen)),
                    Some(Searched::Delay) if form.column => {
                        list.extend(
                            self.log.usable().filter_map(|column| self.late(&named, column, fit, screen)),
                        );
                    }
                    Some(Searched::TimeConstant) if form.column => {
                        let columns = self.log.usable().filter_map(|column| {
                            let odds = self.low_pass_odds(column, fit)?;
                            let mut term = self.low_pass(&named, column, fit, screen)?;
                            term.odds = odds;
                            Some(term)
                        });
                        list.extend(columns);
                    }
                    _ => {}
                }
            }
        }
        list.extend(self.products(fit));
        list
    }

    /// Whether a column acts as an offset in the model, through no past of it.
    fn acts_alone(fit: &Fit<'a>, column: &str) -> bool {
        let alone = |term: &Term| term.made.family().kind() == "offset" && term.form().searched.is_none();
        fit.model.terms.iter().any(|term| alone(term) && term.column() == column)
    }

    /// Odds against a low-pass of a column. What is warmed, and what a power module filters, has a temperature or a current behind it: any
    /// other column only where it acts itself, since through a low-pass all are smooth, and smooth columns imitate each other.
    fn low_pass_odds(&self, column: usize, fit: &Fit<'a>) -> Option<f64> {
        let name = &self.log.samples.columns[column].name;
        if Self::acts_alone(fit, name) {
            return Some(DERIVED_ODDS);
        }
        (ColumnKind::behind(name) != ColumnKind::Other).then_some(ALONE_ODDS)
    }

    /// Products of two columns: of a column that acts with any other, and of what may be a current with any other.
    fn products(&self, fit: &Fit<'a>) -> Vec<Term<'a>> {
        let names: Vec<&str> =
            self.log.usable().map(|index| self.log.samples.columns[index].name.as_str()).collect();
        let mut list = Vec::new();
        for own in &names {
            let inherited = Self::acts_alone(fit, own);
            let is_current =
                ColumnKind::behind(own) == ColumnKind::Current && names.len() <= MAX_COLUMNS_PAIRED;
            if !inherited && !is_current {
                continue;
            }
            for other in names.iter().filter(|other| *other != own) {
                let id = format!("product:{other}*{own}");
                let Some(mut term) =
                    self.registry.parse(&id).and_then(|named| Term::new(self.log, &named, None, 0.0))
                else {
                    continue;
                };
                term.odds = if inherited { DERIVED_ODDS } else { ALONE_ODDS };
                list.push(term);
            }
        }
        let count = list.len() as f64;
        list.iter_mut().for_each(|term| term.places = count);
        list
    }

    /// The best of several parameters, with how much it gains.
    fn best(
        &self,
        named: &Named<'_>,
        column: Option<usize>,
        parameters: impl IntoIterator<Item = f64>,
        fit: &Fit<'a>,
        screen: &Screen,
    ) -> Option<(f64, f64)> {
        let terms: Vec<Term<'a>> = parameters
            .into_iter()
            .filter_map(|parameter| Term::new(self.log, named, column, parameter))
            .collect();
        let refs: Vec<&Term<'a>> = terms.iter().collect();
        let gains = screen.gains(fit, &refs);
        let best = (0..terms.len()).max_by(|&i, &j| gains[i].total_cmp(&gains[j]))?;
        Some((terms[best].searched()?.1, gains[best]))
    }

    fn step(&self, named: &Named<'_>, fit: &Fit<'a>, screen: &Screen) -> Option<Term<'a>> {
        let (first, length) = (*self.log.time_s.first()?, self.log.length_s());
        let grid = (1..STEP_PLACES).map(|i| first + length * i as f64 / STEP_PLACES as f64);
        let (mut at, _) = self.best(named, None, grid, fit, screen)?;
        let mut width = length / STEP_PLACES as f64;
        while width > 0.5 * self.log.step_s() {
            let near = (-4..=4).map(|i| at + width * f64::from(i) / 4.0);
            at = self.best(named, None, near, fit, screen)?.0;
            width /= 4.0;
        }
        let mut term = Term::new(self.log, named, None, at)?;
        term.places = STEP_PLACES as f64;
        Some(term)
    }

    fn late(&self, named: &Named<'_>, column: usize, fit: &Fit<'a>, screen: &Screen) -> Option<Term<'a>> {
        let step = self.log.step_s();
        let most = MAX_DELAY_S.min(0.2 * self.log.length_s());
        let mut grid = Vec::new();
        let (mut a, mut b) = (1.0, 2.0);
        while a * step <= most {
            grid.push(a * step);
            // A slower bus, or a rolling mean behind the column: then the cause acts before it is logged.
            if a * step <= MAX_LEAD_S {
                grid.push(-a * step);
            }
            (a, b) = (b, a + b);
        }
        self.past(named, column, (grid, [0.3, 0.08]), fit, screen)
    }

    fn low_pass(&self, named: &Named<'_>, column: usize, fit: &Fit<'a>, screen: &Screen) -> Option<Term<'a>> {
        let step = self.log.step_s();
        let most = MAX_TIME_CONSTANT_S.min(0.5 * self.log.length_s());
        // The shapes of two low-passes whose time constants are twice each other's are alike by 97 % at least.
        let grid: Vec<f64> =
            std::iter::successors(Some(2.0 * step), |s| Some(2.0 * s)).take_while(|s| *s <= most).collect();
        self.past(named, column, (grid, [0.5, 0.15]), fit, screen)
    }

    /// The best past of a column: of a grid, then nearer by shares of it.
    fn past(
        &self,
        named: &Named<'_>,
        column: usize,
        (grid, nearer): (Vec<f64>, [f64; 2]),
        fit: &Fit<'a>,
        screen: &Screen,
    ) -> Option<Term<'a>> {
        let places = grid.len() as f64;
        let (mut seconds, _) = self.best(named, Some(column), grid, fit, screen)?;
        for width in nearer {
            let near = (-3..=3).map(|i| seconds * (1.0 + width * f64::from(i) / 3.0));
            seconds = self.best(named, Some(column), near, fit, screen)?.0;
        }
        let mut term = Term::new(self.log, named, Some(column), seconds)?;
        (term.places, term.odds) = (places.max(1.0), DERIVED_ODDS);
        Some(term)
    }

    fn tone(&self, named: &Named<'_>, fit: &Fit<'a>, screen: &Screen) -> Option<Term<'a>> {
        if named.family.follows() != Follows::Tone || !self.log.is_timed {
            return None;
        }
        let (step, length) = (screen.block_s(), self.log.length_s());
        let highest = 0.5 / step;
        if highest <= MIN_TONE_HZ {
            return None;
        }
        let whitened = screen.residual();
        let n = whitened.len();
        let size = (4 * n).next_power_of_two();
        let mut power = vec![0.0; size / 2];
        for axis in 0..3 {
            let mut data: Vec<(f64, f64)> = whitened
                .iter()
                .zip(&fit.track.direction)
                .map(|(value, direction)| (value * direction[axis], 0.0))
                .collect();
            data.resize(size, (0.0, 0.0));
            fft::forward(&mut data);
            power.iter_mut().zip(&data).for_each(|(sum, (re, im))| *sum += re * re + im * im);
        }
        let hertz = |bin: usize| bin as f64 / (size as f64 * step);
        let bins = (0..power.len()).filter(|&bin| hertz(bin) >= MIN_TONE_HZ);
        let top = bins.max_by(|&a, &b| power[a].total_cmp(&power[b]))?;
        let mut frequency = hertz(top);
        let mut width = 1.0 / length;
        for _ in 0..3 {
            let near = (-3..=3)
                .map(|i| frequency + width * f64::from(i) / 3.0)
                .filter(|hertz| *hertz >= MIN_TONE_HZ && *hertz <= highest);
            frequency = self.best(named, None, near, fit, screen)?.0;
            width /= 3.0;
        }
        let mut term = Term::new(self.log, named, None, frequency)?;
        term.places = ((highest - MIN_TONE_HZ) * length).max(1.0);
        Some(term)
    }
}
