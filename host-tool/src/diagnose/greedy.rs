//! Effects added one at a time until none helps, earlier ones dropped when they no longer do.

use super::candidates::Catalogue;
use super::engine::{BadShape, Fitted, Known, Pass, Piece};
use super::screen::{Candidate, SIGNIFICANCE, Screening, Tested, rivalry, screen};
use super::search;
use ironout::study::{Residual, held_out};

/// More effects than any log carries.
const MOST_EFFECTS: usize = 8;
/// Two candidates whose columns agree to this much, once the base is projected out, may be the same cause.
const ALIKE: f64 = 0.8;

/// The state of the model after one addition.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// The effect added; `None` for the base model.
    pub added: Option<String>,
    /// Rms residual, µT (rad for the dip).
    pub rms: f64,
    /// Rms residual on held-out blocks.
    pub held_out: Option<f64>,
}

/// Candidates that explain the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Confounded {
    /// Their ids, the one that stands in the model first.
    pub ids: Vec<String>,
}

/// A candidate of the last round.
#[derive(Clone)]
pub struct Judged<'a> {
    /// It.
    pub candidate: Candidate<'a>,
    /// Its test.
    pub tested: Tested,
}

/// What the search found.
#[derive(Clone)]
pub struct Explanation<'a> {
    /// The base model.
    pub base: Fitted<'a>,
    /// The model with everything found.
    pub fitted: Fitted<'a>,
    /// The error falling.
    pub steps: Vec<Step>,
    /// Groups that cannot be told apart.
    pub confounded: Vec<Confounded>,
    /// The candidates tested against the base model.
    pub first: Vec<Judged<'a>>,
    /// The candidates tested last, against the final model.
    pub last: Vec<Judged<'a>>,
    /// How many candidates a round has.
    pub count: usize,
}

/// Rms on held-out blocks.
pub fn held_out_rms(fitted: &Fitted) -> Option<f64> {
    let own: Vec<usize> = (0..fitted.columns()).collect();
    held_out(&fitted.blocks, Some(&fitted.prior), &own)?.rms()
}

fn state(added: Option<String>, fitted: &Fitted) -> Step {
    Step { added, rms: fitted.rms(), held_out: held_out_rms(fitted) }
}

/// The part of an id before `^` or `@`.
fn plain_id(id: &str) -> &str {
    id.split(['^', '@']).next().unwrap_or(id)
}

/// The candidates of one round, the searched ones at their best places.
fn candidates<'a>(
    pass: &Pass,
    catalogue: &Catalogue<'a>,
    fitted: &Fitted<'a>,
) -> Result<Vec<Candidate<'a>>, BadShape> {
    let at_rest = pass.residual == Residual::Vector;
    let mut list: Vec<Candidate> =
        catalogue.plain(at_rest).into_iter().map(|piece| Candidate { piece, searched: 1.0 }).collect();
    list.extend(search::step(pass, fitted, catalogue)?);
    list.extend(search::periodic(pass, fitted, catalogue)?);
    for (index, name) in catalogue.usable_columns() {
        let id = format!("offset:{name}");
        // A late column stands beside the prompt one, or shows through it.
        if fitted.pieces.iter().any(|piece| piece.id == id) {
            list.extend(search::delay(pass, fitted, catalogue, index)?);
        }
    }
    list.retain(|candidate| !fitted.pieces.iter().any(|piece| piece.id == candidate.piece.id));
    Ok(list)
}

/// The search.
pub struct Greedy<'p, 'a> {
    /// What it runs over.
    pub pass: Pass<'p>,
    /// What it may add.
    pub catalogue: &'p Catalogue<'a>,
    /// What is known besides.
    pub known: &'p Known,
}

impl<'a> Greedy<'_, 'a> {
    fn judge(&self, fitted: &Fitted<'a>) -> Result<(Vec<Judged<'a>>, usize, Option<f64>), BadShape> {
        let list = candidates(&self.pass, self.catalogue, fitted)?;
        let count = list.len();
        let Screening { held_out, tested } = screen(&self.pass, fitted, &list, count)?;
        let judged = tested
            .into_iter()
            .filter_map(|tested| Some(Judged { candidate: list.get(tested.index)?.clone(), tested }))
            .collect();
        Ok((judged, count, held_out))
    }

    /// The model with one more effect, fully refitted.
    fn with(&self, fitted: &Fitted<'a>, piece: &Piece<'a>) -> Result<Option<Fitted<'a>>, BadShape> {
        let mut pieces = fitted.pieces.clone();
        pieces.push(piece.clone());
        self.pass.fit(fitted.model, pieces, self.known)
    }

    /// A late or squared column against the plain one: the plain wins unless the variant is significantly better.
    fn best_variant(
        &self,
        fitted: &Fitted<'a>,
        leader: &Judged<'a>,
        judged: &[Judged<'a>],
        count: usize,
    ) -> Result<Judged<'a>, BadShape> {
        let plain = plain_id(&leader.candidate.piece.id).to_string();
        let Some(column) = plain.strip_prefix("offset:") else { return Ok(leader.clone()) };
        let mut best = leader.clone();
        if let Some(prompt) = judged.iter().find(|other| other.candidate.piece.id == plain)
            && prompt.candidate.piece.id != leader.candidate.piece.id
            && prompt.tested.accepted
            && let Some(rivals) =
                rivalry(&self.pass, fitted, &leader.candidate.piece, &prompt.candidate.piece)?
            && rivals.first * count as f64 > SIGNIFICANCE
        {
            best = prompt.clone();
        }
        if let Some(index) = self.catalogue.usable(column)
            && let Some(late) = search::delay(&self.pass, fitted, self.catalogue, index)?
            && !fitted.pieces.iter().any(|piece| piece.id == late.piece.id)
            && let Some(rivals) = rivalry(&self.pass, fitted, &late.piece, &best.candidate.piece)?
            && rivals.first * late.searched * (count as f64) < SIGNIFICANCE
            && rivals.second > 1e3 * rivals.first
        {
            let screening = screen(&self.pass, fitted, std::slice::from_ref(&late), count)?;
            if let Some(tested) = screening.tested.into_iter().next()
                && tested.accepted
                && tested.decrease > best.tested.decrease
            {
                return Ok(Judged { candidate: late, tested });
            }
        }
        Ok(best)
    }

    /// Runs the search from a base model and the effects that stand in it from the beginning.
    pub fn run(&self, base: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        let mut fitted = base.clone();
        let mut steps = vec![state(None, &fitted)];
        let mut confounded: Vec<Confounded> = Vec::new();
        let mut first = None;
        let (mut last, mut count);
        loop {
            let (judged, tried, _) = self.judge(&fitted)?;
            count = tried;
            first.get_or_insert_with(|| judged.clone());
            last = judged;
            if fitted.pieces.len() >= MOST_EFFECTS {
                break;
            }
            let Some((winner, next, rivals)) = self.choose(&fitted, &last, count, &confounded)? else {
                break;
            };
            fitted = next;
            if !rivals.is_empty() {
                let ids = std::iter::once(winner.clone()).chain(rivals).collect();
                confounded.push(Confounded { ids });
            }
            steps.push(state(Some(winner), &fitted));
            if let Some((dropped, without)) = self.drop_one(&fitted)? {
                confounded.retain(|group| group.ids.first() != Some(&dropped));
                steps.retain(|step| step.added.as_ref() != Some(&dropped));
                fitted = without;
            }
        }
        Ok(Explanation { base, fitted, steps, confounded, first: first.unwrap_or_default(), last, count })
    }

    /// The next effect: the three leaders fully refitted, the best by its held-out error, the fewer coefficients where
    /// one contains the other, and its rivals.
    #[allow(clippy::type_complexity)]
    fn choose(
        &self,
        fitted: &Fitted<'a>,
        judged: &[Judged<'a>],
        count: usize,
        confounded: &[Confounded],
    ) -> Result<Option<(String, Fitted<'a>, Vec<String>)>, BadShape> {
        let known_rival = |id: &str| confounded.iter().any(|group| group.ids.iter().any(|other| other == id));
        let mut passing: Vec<&Judged> = judged
            .iter()
            .filter(|one| one.tested.accepted && !known_rival(&one.candidate.piece.id))
            .collect();
        passing.sort_by(|a, b| {
            let key = |one: &Judged| one.tested.held_out.unwrap_or(f64::INFINITY);
            key(a).total_cmp(&key(b))
        });
        let mut leaders: Vec<(Judged<'a>, Fitted<'a>, f64)> = Vec::new();
        for one in passing.iter().take(3) {
            if let Some(next) = self.with(fitted, &one.candidate.piece)?
                && let Some(held) = held_out_rms(&next)
            {
                leaders.push(((*one).clone(), next, held));
            }
        }
        leaders.sort_by(|a, b| a.2.total_cmp(&b.2));
        let Some((leader, mut next, _)) = leaders.into_iter().next() else { return Ok(None) };
        let mut winner = self.best_variant(fitted, &leader, judged, count)?;
        let mut rivals = Vec::new();
        for other in &passing {
            let id = &other.candidate.piece.id;
            let same_family = plain_id(id) == plain_id(&winner.candidate.piece.id);
            if id == &winner.candidate.piece.id
                || same_family
                || other.tested.decrease < 0.3 * winner.tested.decrease
            {
                continue;
            }
            let Some(pair) = rivalry(&self.pass, fitted, &winner.candidate.piece, &other.candidate.piece)?
            else {
                continue;
            };
            if pair.first * (count as f64) < SIGNIFICANCE {
                continue;
            }
            // The other explains all that the winner does.
            if other.tested.directions < winner.tested.directions {
                winner = (*other).clone();
                rivals.clear();
            } else if other.tested.directions == winner.tested.directions && pair.correlation > ALIKE {
                rivals.push(id.clone());
            }
        }
        if winner.candidate.piece.id != leader.candidate.piece.id {
            match self.with(fitted, &winner.candidate.piece)? {
                Some(fit) => next = fit,
                None => winner = leader,
            }
        }
        Ok(Some((winner.candidate.piece.id.clone(), next, rivals)))
    }

    /// The earlier effect that the later ones have made superfluous, and the model without it.
    fn drop_one(&self, fitted: &Fitted<'a>) -> Result<Option<(String, Fitted<'a>)>, BadShape> {
        let newest = fitted.pieces.len().saturating_sub(1);
        for index in 0..newest {
            let mut pieces = fitted.pieces.clone();
            let removed = pieces.remove(index);
            let Some(without) = self.pass.fit(fitted.model, pieces, self.known)? else { continue };
            let candidate = Candidate {
                piece: Piece { coefficients: Default::default(), ..removed.clone() },
                searched: 1.0,
            };
            let screening = screen(&self.pass, &without, &[candidate], 1)?;
            if screening.tested.first().is_none_or(|tested| !tested.accepted) {
                return Ok(Some((removed.id, without)));
            }
        }
        Ok(None)
    }
}
