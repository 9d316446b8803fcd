//! The test of each effect of a model beside all others.

use crate::base::engine::Fitted;
use crate::base::piece::BadShape;
use crate::search::screen::stands;
use crate::search::shown::Shown;
use crate::search::state::{Greedy, held_out_rms};

impl<'a> Greedy<'_, 'a> {
    /// Probability that chance does as well as an effect where the model stands, all others in it, its search counted; and the
    /// model with that effect as its last.
    fn chance_beside(&self, fitted: &Fitted<'a>, index: usize) -> Result<(f64, Fitted<'a>), BadShape> {
        let places = fitted.pieces[index].places;
        // The last one is where it has to be.
        let last = if index + 1 == fitted.pieces.len() {
            fitted.clone()
        } else {
            let mut pieces = fitted.pieces.clone();
            let own = pieces.remove(index);
            pieces.push(own);
            self.pass.hold(fitted.model, pieces, self.known)?
        };
        let chance = stands(&self.pass, &last)?.map_or(1.0, |test| test.p_value);
        Ok(((chance * places).min(1.0), last))
    }

    /// That probability of every effect of a model, by its id.
    pub(crate) fn chances(&self, fitted: &Fitted<'a>) -> Result<Vec<(String, f64)>, BadShape> {
        let chance =
            |index: usize| Ok((fitted.pieces[index].id.clone(), self.chance_beside(fitted, index)?.0));
        (0..fitted.pieces.len()).map(chance).collect()
    }

    /// Tests every effect of a model where the model stands.
    pub(crate) fn shown(&self, fitted: &Fitted<'a>) -> Result<Vec<Shown>, BadShape> {
        let mut list = Vec::new();
        for index in 0..fitted.pieces.len() {
            let mut pieces = fitted.pieces.clone();
            let id = pieces.remove(index).id;
            let without = self.pass.fit(fitted.model, pieces, self.known)?;
            let (p_value, last) = self.chance_beside(fitted, index)?;
            list.push(Shown {
                id,
                p_value,
                without: without.as_ref().and_then(held_out_rms),
                with: held_out_rms(&last),
                unit: "µT",
            });
        }
        Ok(list)
    }
}
