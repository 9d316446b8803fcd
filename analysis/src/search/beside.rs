//! The test of each effect of a model beside all others.

use crate::base::engine::Fitted;
use crate::base::piece::{BadShape, Piece};
use crate::residual::spectrum::Verdict;
use crate::search::screen::each_stands;
use crate::search::shown::Shown;
use crate::search::state::{Greedy, held_out_rms};

impl<'a> Greedy<'_, 'a> {
    /// Probability that chance does as well as each effect of a model, where the model stands, all others in it, its search
    /// counted; by its id.
    pub(crate) fn chances(&self, fitted: &Fitted<'a>) -> Result<Vec<(String, f64)>, BadShape> {
        let tests = each_stands(&self.pass, fitted, 0..fitted.pieces.len())?;
        let chance = |(piece, test): (&Piece, Option<Verdict>)| {
            let p_value = test.map_or(1.0, |test| test.p_value);
            (piece.id.clone(), (p_value * piece.places).min(1.0))
        };
        Ok(fitted.pieces.iter().zip(tests).map(chance).collect())
    }

    /// Tests every effect of a model where the model stands. `chances` are those of this model, where they are known.
    pub(crate) fn shown(
        &self,
        fitted: &Fitted<'a>,
        chances: &[(String, f64)],
    ) -> Result<Vec<Shown>, BadShape> {
        let known = |piece: &Piece| chances.iter().any(|(id, _)| *id == piece.id);
        let worked_out;
        let chances = if fitted.pieces.iter().all(known) {
            chances
        } else {
            worked_out = self.chances(fitted)?;
            &worked_out
        };
        let with = held_out_rms(fitted);
        let mut list = Vec::new();
        for index in 0..fitted.pieces.len() {
            let mut pieces = fitted.pieces.clone();
            let id = pieces.remove(index).id;
            let without = self.pass.fit(fitted.model, pieces, self.known)?;
            let chance = chances.iter().find(|(other, _)| *other == id);
            list.push(Shown {
                p_value: chance.map_or(1.0, |(_, p_value)| *p_value),
                id,
                without: without.as_ref().and_then(held_out_rms),
                with,
                unit: "µT",
            });
        }
        Ok(list)
    }
}
