//! What a finished search may be certain of: an effect that took less of the error than what remains unexplained may be
//! the shadow of a cause that the log does not hold, and a step must be sudden.

use crate::base::engine::Fitted;
use crate::base::piece::{BadShape, COLUMNS, Matrix, Piece, TERMS};
use crate::base::quality::residue;
use crate::noise::colour::Colour;
use crate::samples::series::Autocorrelation;
use crate::search::state::{Explanation, Greedy, Withdrawn, errors_applied};
use ironout::effect::{Effect, Quantities, Searched, Shape};
use ironout::study::f_tail;
use std::sync::Arc;

/// An effect stays if it takes at least this many times as much off the mean square as structure remains.
const OUTWEIGHS: f64 = 1.0;
/// What raises the error on unseen time by more than this is not recommended.
const RAISES: f64 = 1.05;
/// A step is looked at this far before and after it, s, the next further where the one before does not tell ...
const AROUND_STEP_S: [f64; 3] = [1.5, 3.0, 6.0];
/// ... with at least this many samples on each side; with fewer it is believed.
const AROUND_STEP: usize = 10;
/// A jump beside an offset that changes steadily is believed below this probability.
const SUDDEN: f64 = 1e-4;
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
    fn around<'a>(reference_s: f64, time: &[f64]) -> Piece<'a> {
        Piece {
            id: "steady change around the step".into(),
            made: None,
            effect: Arc::new(Steadily { reference_s }),
            coefficients: Default::default(),
            inputs: Arc::new(time.iter().map(|t| [*t, 0.0]).collect()),
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
        "The offset changes steadily. A step must stand beside that."
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

/// The effect that, added in its turn, raises the error on unseen time the most.
fn raises(explanation: &Explanation, asked: &[String]) -> Option<Withdrawn> {
    let steps = explanation.steps.windows(2).filter_map(|pair| {
        let id = pair[1].added.as_ref().filter(|id| !asked.contains(id))?;
        let (before, after) = (pair[0].held_out?, pair[1].held_out?);
        (after > RAISES * before).then_some((after / before, before, after, id))
    });
    let (_, before, after, id) = steps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Withdrawn {
        id: id.clone(),
        why: format!(
            "with it the error on unseen time rises from {before:.3} to {after:.3} µT: it does not hold there"
        ),
    })
}

impl<'a> Greedy<'_, 'a> {
    /// The explanation without the effects that are not certain. Those that were `asked` for stay.
    pub fn certain(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
    ) -> Result<Explanation<'a>, BadShape> {
        while let Some(doubtful) = self.doubtful(&explanation, asked)? {
            if !self.withdraw(&mut explanation, doubtful)? {
                break;
            }
        }
        explanation.renumber();
        Ok(explanation)
    }

    /// The explanation with its model fitted to the end. There an effect that a search found may yet raise the error on unseen
    /// time: then it goes, too.
    pub fn ended(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
        searched: bool,
    ) -> Result<Explanation<'a>, BadShape> {
        loop {
            explanation.fitted = self.to_the_end(explanation.fitted)?;
            if let (Some(last), false) = (explanation.steps.last_mut(), explanation.fitted.pieces.is_empty())
            {
                (last.rms, last.held_out) = errors_applied(&self.pass, &explanation.fitted)?;
            }
            let Some(worse) = raises(&explanation, asked).filter(|_| searched) else { break };
            if !self.withdraw(&mut explanation, worse)? {
                break;
            }
            explanation.renumber();
        }
        Ok(explanation)
    }

    /// Takes an effect out of the explanation; false where the model cannot be fitted without it.
    fn withdraw(&self, explanation: &mut Explanation<'a>, doubtful: Withdrawn) -> Result<bool, BadShape> {
        let mut pieces = explanation.fitted.pieces.clone();
        pieces.retain(|piece| piece.id != doubtful.id);
        let Some(without) = self.pass.fit(explanation.fitted.model, pieces, self.known)? else {
            return Ok(false);
        };
        explanation.fitted = self.aligned(without)?;
        explanation.confounded.retain(|group| !group.ids.contains(&doubtful.id));
        let order: Vec<String> = explanation
            .steps
            .iter()
            .filter_map(|step| step.added.clone())
            .filter(|id| *id != doubtful.id)
            .collect();
        explanation.steps = self.falling(&explanation.base, &explanation.fitted, &order)?;
        explanation.withdrawn.push(doubtful);
        Ok(true)
    }

    fn doubtful(
        &self,
        explanation: &Explanation<'a>,
        asked: &[String],
    ) -> Result<Option<Withdrawn>, BadShape> {
        let fitted = &explanation.fitted;
        if let Some(worse) = raises(explanation, asked) {
            return Ok(Some(worse));
        }
        let list: Vec<&Piece> = fitted.pieces.iter().collect();
        let residuals = self.pass.residuals(&fitted.model, &list)?;
        let samples = self.pass.samples;
        let left = residue(
            &residuals,
            fitted.columns(),
            samples.quantum_ut,
            samples.step_s(),
            &self.pass.turning(&fitted.model),
        );
        let remains = left.structure * left.rms * left.rms;
        let is_step = |piece: &&Piece| matches!(piece.searched(), Some((Searched::At, _)));
        // Where all is explained there is nothing to doubt, but several steps make a stair of any slow change, and 1/f noise
        // wanders so that a step takes part of it.
        let several = fitted.pieces.iter().filter(is_step).count() > 1;
        let wanders = matches!(left.colour, Colour::Flicker { .. });
        if remains <= 0.0 && !several && !wanders {
            return Ok(None);
        }
        let takes = |id: &str| {
            let own = explanation.steps.windows(2).find(|pair| pair[1].added.as_deref() == Some(id));
            own.map_or(f64::INFINITY, |pair| pair[0].rms.powi(2) - pair[1].rms.powi(2))
        };
        for piece in fitted.pieces.iter().filter(|piece| !asked.contains(&piece.id)) {
            let at = piece.searched().filter(|(searched, _)| *searched == Searched::At);
            if remains <= 0.0 && !several && takes(&piece.id) >= OUTWEIGHS * left.rms * left.rms {
                continue;
            }
            if let Some((_, at_s)) = at
                && !self.sudden(fitted, piece, at_s)?
            {
                let why = "the offset changes, but not at once: some slow cause that the log does not hold looks \
                           like a step";
                return Ok(Some(Withdrawn { id: piece.id.clone(), why: why.into() }));
            }
        }
        if remains <= 0.0 {
            return Ok(None);
        }
        let mut least: Option<(f64, &String)> = None;
        for pair in explanation.steps.windows(2) {
            let Some(id) = pair[1].added.as_ref().filter(|id| !asked.contains(id)) else { continue };
            // A square or a past beside the linear term of the same column blames no other cause.
            let own = fitted.pieces.iter().find(|piece| piece.id == *id && !piece.is_plain());
            let beside_plain =
                |own: &Piece| fitted.pieces.iter().any(|piece| piece.is_plain() && piece.is_variant_of(own));
            if own.is_some_and(beside_plain) {
                continue;
            }
            let takes = takes(id);
            if takes < OUTWEIGHS * remains && least.is_none_or(|(known, _)| takes < known) {
                least = Some((takes, id));
            }
        }
        Ok(least.map(|(takes, id)| Withdrawn {
            id: id.clone(),
            why: format!(
                "it takes {:.0} % off the squared error, but {:.0} % is structure that nothing in the log explains: a \
                 cause that the log does not hold may look like it",
                100.0 * takes / explanation.base.rms().powi(2).max(1e-300),
                100.0 * remains / explanation.base.rms().powi(2).max(1e-300),
            ),
        }))
    }

    /// Whether the offset jumps at a step, rather than changes steadily around it.
    fn sudden(&self, fitted: &Fitted<'a>, step: &Piece<'a>, at: f64) -> Result<bool, BadShape> {
        let mut told = Told::TooLittle;
        for around_s in AROUND_STEP_S {
            told = self.around(fitted, step, at, around_s)?;
            if matches!(told, Told::Jumps | Told::Steadily) {
                break;
            }
        }
        Ok(matches!(told, Told::Jumps | Told::TooLittle))
    }

    /// What the samples within `around_s` of a step tell.
    fn around(
        &self,
        fitted: &Fitted<'a>,
        step: &Piece<'a>,
        at: f64,
        around_s: f64,
    ) -> Result<Told, BadShape> {
        let Some(time) = &self.pass.samples.time else { return Ok(Told::TooLittle) };
        let place = |seconds: f64| time.partition_point(|t| *t < at + seconds);
        let (from, middle, to) = (place(-around_s), place(0.0), place(around_s));
        if middle - from < AROUND_STEP || to - middle < AROUND_STEP {
            return Ok(Told::TooLittle);
        }
        // The model without the step; around it the offset may lie elsewhere and change steadily.
        let absent = Piece { coefficients: Default::default(), ..step.clone() };
        let steadily = Steadily::around(self.pass.samples.middle_s, time);
        let others = fitted.pieces.iter().filter(|piece| piece.id != step.id);
        let all: Vec<&Piece> = others.chain([&steadily, &absent]).collect();
        let base = self.pass.residual.base_columns();
        let columns = base + all.iter().map(|piece| piece.k()).sum::<usize>();
        if columns > COLUMNS || all.len() > TERMS {
            return Ok(Told::TooLittle);
        }
        // The first three columns are those of the offset, of all residuals that know a step. The jump is the one that was
        // found, of a size that is free.
        let (mut matrix, mut stands) = (Matrix::new(7), Matrix::new(7));
        let mut residuals = Vec::with_capacity(to - from);
        let mut rows = Vec::with_capacity(to - from);
        self.pass.rows(from..to, &fitted.model, &all, |_, row, r| {
            let mut own = [0.0; COLUMNS];
            own[..3].copy_from_slice(&row[..3]);
            own[3..6].copy_from_slice(&row[columns - 6..columns - 3]);
            own[6] = row[columns - 3..columns].iter().zip(&step.coefficients).map(|(a, b)| a * b).sum();
            matrix.push(&own, r);
            stands.push(&own, r + own[6]);
            rows.push(own);
            residuals.push(r);
        })?;
        let Some(gain) = matrix.test(0..6, 6..7).filter(|gain| gain.directions > 0) else {
            return Ok(Told::TooLittle);
        };
        let Some(factor) = matrix.factor() else { return Ok(Told::TooLittle) };
        let delta = matrix.step(&factor);
        for (r, row) in residuals.iter_mut().zip(&rows) {
            *r += row.iter().zip(&delta).map(|(value, d)| value * d).sum::<f64>();
        }
        let count = residuals.len() as f64;
        let (f, k, freedom) = gain.f_statistic(6, count, count / Autocorrelation::of(&residuals).time);
        // The jump as found must fit here too.
        let with = stands.test(0..6, 6..7).map(|gain| gain.squares_before);
        let fits = with.is_some_and(|with| with <= gain.squares_before);
        if fits && f_tail(f, k, freedom) < SUDDEN {
            return Ok(Told::Jumps);
        }
        // How far the jump as found would stand out.
        let clear = f / (delta[6] * delta[6]).max(f64::MIN_POSITIVE) > CLEAR;
        Ok(if clear { Told::Steadily } else { Told::Nothing })
    }
}
