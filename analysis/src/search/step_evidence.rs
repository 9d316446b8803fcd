//! A step must be sudden: a jump, and not a slow cause that the log lacks.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, COLUMNS, Clock, Matrix, TERMS, Term};
use crate::samples::samples::Samples;
use crate::samples::series::Autocorrelation;
use crate::search::state::Greedy;
use ironout::effect::{Effect, Quantities, Shape};
use ironout::study::f_tail;
use std::sync::Arc;

/// A step is looked at this far before and after it, s, the next further where the one before does not tell ...
const AROUND_STEP_S: [f64; 3] = [1.5, 3.0, 6.0];
/// ... with at least this many samples on each side; with fewer it is believed.
const AROUND_STEP: usize = 10;
/// A jump beside an offset that changes steadily is believed below this probability.
const SUDDEN: f64 = 1e-4;
/// In fewer readings no jump is looked for.
const FEWEST_READINGS: usize = 40;
/// A step may be moved to a jump of the readings where it leaves at most this many times the error.
const AS_WELL: f64 = 1.05;
/// The readings jump by the step if they jump by its size to this share, ...
const ITS_SIZE: f64 = 0.5;
/// ... and by so many times as much as anywhere else around.
const ABOVE_OTHERS: f64 = 1.5;
/// A jump that should stand out by so many variances and does not is none.
const CLEAR: f64 = 30.0;

/// What the samples around a step tell of it.
enum Told {
    /// The offset jumps.
    Jumps,
    /// It changes steadily.
    Steadily,
    /// The noise hides which.
    Nothing,
    /// There are too few samples or attitudes to look, or no columns for it.
    TooLittle,
}

/// An offset that changes steadily: what a step is held against.
struct Steadily {
    reference_s: f64,
}

impl Steadily {
    fn around<'a>(reference_s: f64, time: &[f64]) -> Term<'a> {
        Term {
            id: "steady change around the step".into(),
            made: None,
            effect: Arc::new(Steadily { reference_s }),
            coefficients: Default::default(),
            inputs: Arc::new(time.iter().map(|t| [*t, 0.0]).collect()),
            trials: 1.0,
            clock: Clock::Stamps,
            known_at: None,
        }
    }
}

impl Effect<f64> for Steadily {
    fn id(&self, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
        out.write_str("steady")
    }
    fn name(&self) -> &'static str {
        "steady change"
    }
    fn explanation(&self) -> &'static str {
        "The offset changes steadily. A step must be significant in addition to that."
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn unit(&self) -> &'static str {
        "µT/s"
    }
    fn reads_centre(&self) -> bool {
        false
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        let [time, _] = at.inputs;
        for (axis, vector) in shape.iter_mut().take(3).enumerate() {
            *vector = [0.0; 3];
            vector[axis] = time - self.reference_s;
        }
    }
}

/// The samples around a step as a model without it leaves them.
struct Around {
    /// By the offset, three numbers, its steady change, three, and the offset that the step adds.
    rows: Vec<[f64; COLUMNS]>,
    /// What the model leaves.
    residuals: Vec<f64>,
    /// The first sample that has the step.
    middle: usize,
}

impl Around {
    /// What they tell of the jump beside an offset that changes steadily.
    fn told(&self) -> Told {
        let rows = self.rows.iter().enumerate().map(|(place, row)| {
            let mut row = *row;
            row[6] *= f64::from(u8::from(place >= self.middle));
            row
        });
        let rows: Vec<[f64; COLUMNS]> = rows.collect();
        let (mut matrix, mut stands) = (Matrix::new(7), Matrix::new(7));
        for (row, r) in rows.iter().zip(&self.residuals) {
            matrix.push(row, *r);
            stands.push(row, r + row[6]);
        }
        let Some(gain) = matrix.test(0..6, 6..7).filter(|gain| gain.directions > 0) else {
            return Told::TooLittle;
        };
        let Some(factor) = matrix.factor() else { return Told::TooLittle };
        let delta = matrix.step(&factor);
        let after = |(r, row): (&f64, &[f64; COLUMNS])| {
            r + row.iter().zip(&delta).map(|(value, d)| value * d).sum::<f64>()
        };
        let left: Vec<f64> = self.residuals.iter().zip(&rows).map(after).collect();
        let count = left.len() as f64;
        let (f, k, freedom) = gain.f_statistic(6, count, count / Autocorrelation::of(&left).time);
        // The jump as found must fit here too.
        let with = stands.test(0..6, 6..7).map(|gain| gain.squares_before);
        let fits = with.is_some_and(|with| with <= gain.squares_before);
        if fits && f_tail(f, k, freedom) < SUDDEN {
            return Told::Jumps;
        }
        // How far the jump as found would stand out.
        let clear = f / (delta[6] * delta[6]).max(f64::MIN_POSITIVE) > CLEAR;
        if clear { Told::Steadily } else { Told::Nothing }
    }
}

/// When the readings themselves jump by the step, near its time, and nowhere around by nearly as much: the magnitude does not
/// see a step that happens across the field, and places it where it begins to.
pub(crate) fn readings_jump(samples: &Samples, step: &Term, at: f64) -> Option<f64> {
    let time = samples.time.as_ref()?;
    let [.., widest] = AROUND_STEP_S;
    let place = |seconds: f64| time.partition_point(|t| *t < at + seconds);
    let (from, to) = (place(-widest).max(2), place(widest).min(time.len().saturating_sub(1)));
    let size: f64 = step.coefficients.iter().take(3).map(|value| value * value).sum();
    if to < from + FEWEST_READINGS || size <= 0.0 {
        return None;
    }
    // From one sample to the next, less what the board's motion makes of it on either side; in sizes of the step.
    let along = |a: usize, b: usize| -> f64 {
        let (a, b) = (samples.readings[a].measured_ut, samples.readings[b].measured_ut);
        (0..3).map(|axis| (b[axis] - a[axis]) * step.coefficients[axis]).sum::<f64>() / size
    };
    let jumps: Vec<f64> =
        (from..to).map(|i| along(i - 1, i) - 0.5 * (along(i - 2, i - 1) + along(i, i + 1))).collect();
    let best = (0..jumps.len()).max_by(|a, b| jumps[*a].total_cmp(&jumps[*b]))?;
    // The sample before and the one after see half of the jump the other way round.
    let elsewhere = jumps.iter().enumerate().filter(|(i, _)| i.abs_diff(best) > 1);
    let most = elsewhere.fold(0.0, |most: f64, (_, jump)| most.max(jump.abs()));
    let jumps = (jumps[best] - 1.0).abs() < ITS_SIZE && jumps[best] > ABOVE_OTHERS * most;
    jumps.then(|| 0.5 * (time[from + best - 1] + time[from + best]))
}

impl<'a> Greedy<'_, 'a> {
    /// Whether the offset jumps at a step, rather than changes steadily around it.
    pub(crate) fn is_sudden(&self, fitted: &Fitted<'a>, step: &Term<'a>, at: f64) -> Result<bool, BadShape> {
        if readings_jump(self.design.samples, step, at)
            .is_some_and(|jump| self.as_well_at(fitted, step, jump))
        {
            return Ok(true);
        }
        let mut told = Told::TooLittle;
        for around_s in AROUND_STEP_S {
            told = self.around(fitted, step, at, around_s)?.map_or(Told::TooLittle, |around| around.told());
            if matches!(told, Told::Jumps | Told::Steadily) {
                break;
            }
        }
        Ok(matches!(told, Told::Jumps | Told::TooLittle))
    }

    /// Whether a step that is moved explains nearly as much.
    fn as_well_at(&self, fitted: &Fitted<'a>, step: &Term<'a>, at_s: f64) -> bool {
        let there = step.named().and_then(|named| self.catalogue.build(&named, at_s));
        let terms = fitted.terms.iter().map(|term| match (&there, term.id == step.id) {
            (Some(there), true) => {
                Term { id: step.id.clone(), coefficients: step.coefficients, ..there.clone() }
            }
            _ => term.clone(),
        });
        let moved = self.design.fit(fitted.model, terms.collect(), self.known);
        there.is_some()
            && matches!(moved, Ok(Some(moved)) if moved.squares < AS_WELL * AS_WELL * fitted.squares)
    }

    /// The samples within `around_s` of a step; `None` where they are too few.
    fn around(
        &self,
        fitted: &Fitted<'a>,
        step: &Term<'a>,
        at: f64,
        around_s: f64,
    ) -> Result<Option<Around>, BadShape> {
        let Some(time) = &self.design.samples.time else { return Ok(None) };
        let place = |seconds: f64| time.partition_point(|t| *t < at + seconds);
        let (from, middle, to) = (place(-around_s), place(0.0), place(around_s));
        if middle - from < AROUND_STEP || to - middle < AROUND_STEP {
            return Ok(None);
        }
        // The model without the step; around it the offset may lie elsewhere and change steadily.
        let steadily = Steadily::around(self.design.samples.middle_s, time);
        let others = fitted.terms.iter().filter(|term| term.id != step.id);
        let all: Vec<&Term> = others.chain([&steadily]).collect();
        let base = self.design.residual.base_columns();
        let columns = base + all.iter().map(|term| term.k()).sum::<usize>();
        if columns > COLUMNS || all.len() > TERMS {
            return Ok(None);
        }
        let mut around = Around {
            rows: Vec::with_capacity(to - from),
            residuals: Vec::with_capacity(to - from),
            middle: middle - from,
        };
        self.design.rows(from..to, &fitted.model, &all, |_, row, r| {
            let mut own = [0.0; COLUMNS];
            // The first three columns are those of the offset, of all residuals that know a step.
            own[..3].copy_from_slice(&row[..3]);
            own[3..6].copy_from_slice(&row[columns - 3..columns]);
            // The jump is the one that was found, of a size that is free.
            own[6] = row[..3].iter().zip(&step.coefficients).map(|(a, b)| a * b).sum();
            around.rows.push(own);
            around.residuals.push(r);
        })?;
        Ok(Some(around))
    }
}
