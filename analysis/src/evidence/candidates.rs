//! The terms that a log allows: fixed forms, and those with a place, a frequency or a delay to be searched.

use crate::base::term::Term;
use crate::bounds::{
    ALONE_ODDS, DERIVED_ODDS, MAX_COLUMNS_PAIRED, MAX_DELAY_S, MAX_LEAD_S, MAX_TIME_CONSTANT_S, MIN_TONE_HZ,
};
use crate::evidence::fit::Fit;
use crate::evidence::log::Log;
use crate::evidence::screen::Screen;
use crate::samples::fft;
use ironout::effect::{ColumnKind, Family, Follows, Form, Named, Registry, Searched};

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

/// The columns that a form of an effect suits; the empty one where it has none.
fn columns_of<'a>(log: &Log<'a>, family: &dyn Family, form: &Form) -> Vec<&'a str> {
    if !form.column {
        return vec![""];
    }
    let names = log.usable().map(|index| log.samples.columns[index].name.as_str());
    names.filter(|name| family.suits(name)).collect()
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
                for column in columns_of(log, family, form) {
                    let Some(mut term) = log.term(&Named { family, column, form }, 0.0) else { continue };
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

    /// The best places of the searched forms at a fit, and products of columns.
    pub fn searched(&self, fit: &Fit<'a>, screen: &Screen) -> Vec<Term<'a>> {
        let mut list = Vec::new();
        for named in self.forms_searched() {
            let odds = match named.form.searched {
                Some(Searched::TimeConstant) => self.low_pass_odds(named.column, fit),
                _ => Some(if named.form.column { DERIVED_ODDS } else { 0.0 }),
            };
            let Some(odds) = odds else { continue };
            // Nearer to its best place a hopeless candidate would gain some percent more: of many it stays coarse.
            let least = named.form.coefficients as f64 * (fit.track.weight.len() as f64).ln();
            list.extend(self.at_best(&named, fit, screen, least).map(|term| Term { odds, ..term }));
        }
        list.extend(self.products(fit));
        list
    }

    /// What is told of a log beside a fit: the fixed forms, steps and tones, and the past of columns that act in the model. The past of any
    /// other column shows through the column.
    pub fn detected(&self, fit: &Fit<'a>, screen: &Screen) -> Vec<Term<'a>> {
        let mut list = self.fixed.clone();
        let is_told = |named: &Named| !named.form.column || Self::acts_alone(fit, named.column);
        let searched = self.forms_searched().into_iter().filter(is_told);
        list.extend(searched.filter_map(|named| self.asked(&named, fit, screen)));
        list.retain(|term| term.is_repeated() || !fit.model.terms.iter().any(|own| own.id == term.id));
        list
    }

    /// The forms of which something is searched, of each column that they suit.
    fn forms_searched(&self) -> Vec<Named<'a>> {
        let mut list = Vec::new();
        for family in self.registry.families().filter(|family| self.log.tells(family.acts())) {
            for form in family.forms().iter().copied() {
                if form.offered && !form.dip_only && form.searched.is_some() {
                    let columns = columns_of(self.log, family, form);
                    list.extend(columns.into_iter().map(|column| Named { family, column, form }));
                }
            }
        }
        list
    }

    /// An effect at a fit, what is searched of it at its likeliest place.
    pub fn asked(&self, named: &Named, fit: &Fit<'a>, screen: &Screen) -> Option<Term<'a>> {
        self.at_best(named, fit, screen, f64::NEG_INFINITY)
    }

    /// The same; only the place of what gains more than `least` is searched to the end.
    fn at_best(&self, named: &Named, fit: &Fit<'a>, screen: &Screen, least: f64) -> Option<Term<'a>> {
        match named.form.searched {
            Some(Searched::At) => self.step(named, fit, screen, least),
            Some(Searched::Frequency) => self.tone(named, fit, screen, least),
            Some(Searched::Delay) => self.late(named, fit, screen, least),
            Some(Searched::TimeConstant) => self.low_pass(named, fit, screen, least),
            None => self.log.term(named, 0.0),
        }
    }

    /// Whether a column acts as an offset in the model, through no past of it.
    fn acts_alone(fit: &Fit<'a>, column: &str) -> bool {
        let alone = |named: Named| named.family.kind() == "offset" && named.form.searched.is_none();
        let named = fit.model.terms.iter().filter_map(Term::named);
        named.into_iter().any(|named| alone(named) && named.column == column)
    }

    /// Odds against a low-pass of a column. What is warmed, and what a power module filters, has a temperature or a current behind it: any
    /// other column only where it acts itself, since through a low-pass all are smooth, and smooth columns imitate each other.
    fn low_pass_odds(&self, name: &str, fit: &Fit<'a>) -> Option<f64> {
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
                let Some(mut term) = self.registry.parse(&id).and_then(|named| self.log.term(&named, 0.0))
                else {
                    continue;
                };
                term.odds = if inherited { DERIVED_ODDS } else { ALONE_ODDS };
                list.push(term);
            }
        }
        let count = list.len() as f64;
        list.iter_mut().for_each(|term| term.trials = count);
        list
    }

    /// The best of several parameters, with how much it gains.
    fn best(
        &self,
        named: &Named<'_>,
        parameters: impl IntoIterator<Item = f64>,
        fit: &Fit<'a>,
        screen: &Screen,
    ) -> Option<(f64, f64)> {
        let terms: Vec<Term<'a>> =
            parameters.into_iter().filter_map(|parameter| self.log.term(named, parameter)).collect();
        let refs: Vec<&Term<'a>> = terms.iter().collect();
        let gains = screen.gains(fit, &refs);
        let best = (0..terms.len()).max_by(|&i, &j| gains[i].total_cmp(&gains[j]))?;
        Some((terms[best].searched()?.1, gains[best]))
    }

    fn step(&self, named: &Named<'_>, fit: &Fit<'a>, screen: &Screen, least: f64) -> Option<Term<'a>> {
        let (first, length) = (*self.log.time_s.first()?, self.log.length_s());
        let grid = (1..STEP_PLACES).map(|i| first + length * i as f64 / STEP_PLACES as f64);
        let (mut at, mut gain) = self.best(named, grid, fit, screen)?;
        let mut width = length / STEP_PLACES as f64;
        while gain > least && width > 0.5 * self.log.step_s() {
            let near = (-4..=4).map(|i| at + width * f64::from(i) / 4.0);
            (at, gain) = self.best(named, near, fit, screen)?;
            width /= 4.0;
        }
        let mut term = self.log.term(named, at)?;
        term.trials = STEP_PLACES as f64;
        Some(term)
    }

    fn late(&self, named: &Named<'_>, fit: &Fit<'a>, screen: &Screen, least: f64) -> Option<Term<'a>> {
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
        self.past(named, (grid, [0.3, 0.08]), fit, screen, least)
    }

    fn low_pass(&self, named: &Named<'_>, fit: &Fit<'a>, screen: &Screen, least: f64) -> Option<Term<'a>> {
        let step = self.log.step_s();
        let most = MAX_TIME_CONSTANT_S.min(0.5 * self.log.length_s());
        // The shapes of two low-passes whose time constants are twice each other's are alike by 97 % at least.
        let grid: Vec<f64> =
            std::iter::successors(Some(2.0 * step), |s| Some(2.0 * s)).take_while(|s| *s <= most).collect();
        self.past(named, (grid, [0.5, 0.15]), fit, screen, least)
    }

    /// The best past of a column: of a grid, then nearer by shares of it.
    fn past(
        &self,
        named: &Named<'_>,
        (grid, nearer): (Vec<f64>, [f64; 2]),
        fit: &Fit<'a>,
        screen: &Screen,
        least: f64,
    ) -> Option<Term<'a>> {
        let trials = grid.len() as f64;
        let (mut seconds, mut gain) = self.best(named, grid, fit, screen)?;
        for width in nearer {
            if gain < least {
                break;
            }
            let near = (-3..=3).map(|i| seconds * (1.0 + width * f64::from(i) / 3.0));
            (seconds, gain) = self.best(named, near, fit, screen)?;
        }
        let mut term = self.log.term(named, seconds)?;
        (term.trials, term.odds) = (trials.max(1.0), DERIVED_ODDS);
        Some(term)
    }

    fn tone(&self, named: &Named<'_>, fit: &Fit<'a>, screen: &Screen, least: f64) -> Option<Term<'a>> {
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
            let gain;
            (frequency, gain) = self.best(named, near, fit, screen)?;
            if gain < least {
                break;
            }
            width /= 3.0;
        }
        let mut term = self.log.term(named, frequency)?;
        term.trials = ((highest - MIN_TONE_HZ) * length).max(1.0);
        Some(term)
    }
}
