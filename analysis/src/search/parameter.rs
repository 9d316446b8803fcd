//! What fixes the shape of a searched effect as a parameter of its own: the frequency of a periodic disturbance, the
//! lateness of a column. Their refinement, and their share in the errors.

use crate::base::engine::{Design, Fitted};
use crate::base::prior::Prior;
use crate::base::term::{BadShape, COLUMNS, Matrix, Term};
use crate::search::candidates::Catalogue;
use ironout::effect::{
    Bends, Column, Effect, MAX_COEFFICIENTS, MAX_INPUTS, Quantities, Searched, Shape, TIME,
};
use ironout::extended::LowPass;
use std::f64::consts::TAU;
use std::sync::Arc;

/// How a disturbance changes with its parameter: one column, the coefficient is a change of the parameter.
enum Slope {
    /// A change of frequency, Hz.
    Frequency { frequency_hz: f64, reference_s: f64, coefficients: [f64; 6] },
    /// A change of delay or of a time constant, s; the input is the rate of change of the column's past, or its low-pass.
    Past { coefficients: [f64; 3] },
}

impl Effect<f64> for Slope {
    fn id(&self, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
        out.write_str("parameter")
    }
    fn name(&self) -> &'static str {
        "parameter of a shape"
    }
    fn explanation(&self) -> &'static str {
        "A small error of a frequency, a delay or a time constant changes the shape. It is estimated together with the amplitudes."
    }
    fn columns(&self) -> [Option<Column<'_, f64>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }
    fn coefficients(&self) -> usize {
        1
    }
    fn unit(&self) -> &'static str {
        match self {
            Slope::Frequency { .. } => "Hz",
            Slope::Past { .. } => "s",
        }
    }
    fn reads_centre(&self) -> bool {
        false
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        let [input, _] = at.inputs;
        shape[0] = match self {
            Slope::Frequency { frequency_hz, reference_s, coefficients: c } => {
                let since = input - reference_s;
                let (sin, cos) = (TAU * frequency_hz * since).sin_cos();
                core::array::from_fn(|axis| TAU * since * (c[axis] * cos - c[3 + axis] * sin))
            }
            Slope::Past { coefficients } => coefficients.map(|c| -c * input),
        };
    }
}

/// A step or a tone with its place and size: "step of 2.1 µT at 40.30 s".
pub fn in_words(term: &Term) -> String {
    let norm = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let c = &term.coefficients;
    let (size, word) = (norm(&c[..term.k()]), term.named().map_or("effect", |named| named.family.word()));
    match term.searched() {
        Some((Searched::At, at_s)) => format!("{word} of {size:.2} µT at {at_s:.2} s"),
        Some((Searched::Frequency, hz)) => format!("{word} of {size:.2} µT at {hz:.3} Hz"),
        _ => term.id.clone(),
    }
}

/// Rate of change of a term's first input over the samples.
fn rates(term: &Term, time: &[f64]) -> Vec<[f64; MAX_INPUTS]> {
    let n = term.inputs.len().min(time.len());
    (0..n)
        .map(|at| {
            let (from, to) = (at.saturating_sub(1), (at + 1).min(n - 1));
            let span = time[to] - time[from];
            [if span > 0.0 { (term.inputs[to][0] - term.inputs[from][0]) / span } else { 0.0 }, 0.0]
        })
        .collect()
}

/// The column of a term's parameter, if it has one that is not a time of its own.
fn slope<'a>(design: &Design, term: &Term<'a>) -> Option<Term<'a>> {
    let c = &term.coefficients;
    let (effect, inputs) = match term.searched()? {
        (Searched::Frequency, frequency_hz) => {
            let mut coefficients = [0.0; 6];
            coefficients.copy_from_slice(&c[..6]);
            let reference_s = term.parts()?.reference;
            (Slope::Frequency { frequency_hz, reference_s, coefficients }, term.inputs.clone())
        }
        (searched @ (Searched::Delay | Searched::TimeConstant), now) => {
            let time = design.samples.time.as_deref()?;
            let mut rates = rates(term, time);
            if searched == Searched::TimeConstant {
                // By τ, τ dy/dt = x − y gives τ dz/dt = −z − dy/dt: z is minus the low-pass of dy/dt.
                let mut filter = LowPass::<f64>::new(now);
                // The filter begins at its column's value, whatever τ is.
                if let Some(first) = rates.first_mut() {
                    first[0] = 0.0;
                }
                for (rate, at) in rates.iter_mut().zip(time) {
                    rate[0] = filter.push(*at, rate[0]).unwrap_or_default();
                }
            }
            (Slope::Past { coefficients: [c[0], c[1], c[2]] }, Arc::new(rates))
        }
        (Searched::At, _) => return None,
    };
    Some(Term {
        id: format!("parameter of {}", term.id),
        made: None,
        effect: Arc::new(effect),
        coefficients: [0.0; MAX_COEFFICIENTS],
        inputs,
        trials: 1.0,
        odds: 0.0,
        bends: Bends::Reading,
    })
}

/// Normal matrix with one more column for every searched parameter of the model, the last columns in the order of the
/// terms. `None` where there is none.
pub fn with_slopes(design: &Design, fitted: &Fitted) -> Result<Option<Matrix>, BadShape> {
    let slopes: Vec<Term> = fitted.terms.iter().filter_map(|term| slope(design, term)).collect();
    if slopes.is_empty() || fitted.columns() + slopes.len() > COLUMNS {
        return Ok(None);
    }
    let all: Vec<&Term> = fitted.terms.iter().chain(&slopes).collect();
    let blocks = design.blocks(&design.samples.bounds(2), &fitted.model, &all)?;
    Ok(Some(Matrix::total(&blocks, Some(&fitted.prior))))
}

/// The same effect with another parameter, with the name and coefficients that it had.
fn carried<'a>(term: &Term<'a>, next: Term<'a>) -> Term<'a> {
    Term {
        coefficients: term.coefficients,
        id: term.id.clone(),
        trials: term.trials,
        bends: term.bends,
        ..next
    }
}

/// The term with its parameter moved.
fn moved<'a>(term: &Term<'a>, change: f64, catalogue: &Catalogue<'a>) -> Option<Term<'a>> {
    let next = match term.searched()? {
        (Searched::Frequency, now) => catalogue.build(&term.named()?, now + change)?,
        // Neither a time constant nor a delay changes its sign on the way.
        (Searched::Delay | Searched::TimeConstant, now) => {
            catalogue.build(&term.named()?, now * ((now + change) / now).max(0.2))?
        }
        (Searched::At, _) => return None,
    };
    Some(carried(term, next))
}

/// How often parameters are moved, at most.
const ROUNDS: usize = 6;

/// Moves searched parameters to where the error is least, and refits.
pub fn refine<'a>(
    design: &Design,
    mut fitted: Fitted<'a>,
    catalogue: &Catalogue<'a>,
    known: &Prior,
) -> Result<Fitted<'a>, BadShape> {
    for _ in 0..ROUNDS {
        let mut terms = fitted.terms.clone();
        if let Some(total) = with_slopes(design, &fitted)?
            && let Some(factor) = total.factor()
        {
            let step = total.step(&factor);
            let mut changes = step[fitted.columns()..].iter();
            for term in &mut terms {
                if !matches!(term.searched(), None | Some((Searched::At, _)))
                    && let Some(change) = changes.next()
                    && let Some(next) = moved(term, *change, catalogue)
                {
                    *term = next;
                }
            }
        }
        for place in 0..terms.len() {
            if let Some(at_s) = likeliest_time(design, &fitted, place)?
                && let Some(named) = terms[place].named()
                && let Some(next) = catalogue.build(&named, at_s)
            {
                terms[place] = carried(&terms[place], next);
            }
        }
        if terms.iter().zip(&fitted.terms).all(|(next, now)| next.parts() == now.parts()) {
            break;
        }
        let before = fitted.squares;
        match design.fit(fitted.model, terms, known)? {
            Some(next) if next.squares < before => fitted = next,
            _ => return Ok(fitted),
        }
        if before - fitted.squares < 1e-4 * before / fitted.rows.max(1.0) {
            break;
        }
    }
    Ok(fitted)
}

/// The time between two samples at which a step of this size leaves the least error, if all else stays. `None` for what is no step.
fn likeliest_time(design: &Design, fitted: &Fitted, place: usize) -> Result<Option<f64>, BadShape> {
    let term = &fitted.terms[place];
    let (Some((Searched::At, at_s)), Some(time)) = (term.searched(), &design.samples.time) else {
        return Ok(None);
    };
    let n = design.samples.len();
    if n < 2 {
        return Ok(None);
    }
    let now = time.partition_point(|t| *t < at_s);
    // A step before all samples is moved behind one sample after the other; each entry is by how much that raises the squares.
    let mut rises = vec![0.0; n + 1];
    let list: Vec<&Term> = fitted.terms.iter().collect();
    design.rows(0..n, &fitted.model, &list, |sample, row, r| {
        let by: f64 = (0..3).map(|axis| row[axis] * term.coefficients[axis]).sum();
        // Before the time where the step is now, the residual is free of it.
        let (without, with) = if sample < now { (r, r + by) } else { (r - by, r) };
        rises[sample + 1] += without * without - with * with;
    })?;
    let (mut sum, mut best) = (0.0, (f64::INFINITY, now));
    for (index, rise) in rises.iter().enumerate() {
        sum += rise;
        if index > 0 && index < n && sum < best.0 {
            best = (sum, index);
        }
    }
    let index = best.1.clamp(1, n - 1);
    Ok(Some(0.5 * (time[index - 1] + time[index])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::ground::Ground;
    use crate::table::Table;
    use ironout::effect::Registry;
    use ironout::fit::Method;
    use ironout::study::Residual;
    use ironout_simulation::{EffectSpec, World, WorldOptions};

    #[test]
    fn a_step_moves_to_the_gap_between_two_samples_where_it_was() {
        let step = EffectSpec::parse("step=6").expect("an effect");
        let options = WorldOptions { seed: 8, seconds: 40.0, effects: vec![step], ..WorldOptions::default() };
        let log = World::new(options).run();
        let table = Table::from_columns(log.named()).expect("columns");
        let ground = Ground::of(&table, Method::default(), None, None);
        let model = ground.base.as_ref().ok().and_then(|base| base.model()).expect("a base model");
        let samples = ground.counted.with_bursts.as_ref().unwrap_or(&ground.counted.samples);
        let catalogue = Catalogue::new(samples, &table, Registry::BUILT_IN);
        let (design, known) = (Design::new(samples, Residual::Magnitude), Prior::default());
        let named = Registry::BUILT_IN.parse("step").expect("a step");
        let found_from = |at_s: f64| {
            let begun = catalogue.build(&named, at_s).expect("a step");
            let fitted = design.fit(model, vec![begun], &known).ok().flatten().expect("a fit");
            let refined = refine(&design, fitted, &catalogue, &known).expect("shapes");
            (refined.terms[0].searched().expect("a time").1, refined.rms())
        };
        // From either side it comes to one place, whatever the fit began with, and to the noise.
        let time = samples.time.as_ref().expect("times");
        let best =
            (1..39).map(|s| found_from(f64::from(s))).min_by(|a, b| a.1.total_cmp(&b.1)).expect("fits");
        assert!(best.1 < 0.27, "{best:?}");
        for off_s in [-2.0, 2.0] {
            assert_eq!(found_from(best.0 + off_s).0, best.0, "{off_s} s");
        }
        let next = time.partition_point(|t| *t < best.0);
        assert_eq!(best.0, 0.5 * (time[next - 1] + time[next]));
    }
}
