//! The study's own test of each effect that was put into a model, beside all others.

use crate::base::engine::Fitted;
use crate::base::piece::BadShape;
use crate::search::screen::stands;
use crate::search::shown::Shown;
use crate::search::state::{Greedy, held_out_rms};

impl Greedy<'_, '_> {
    /// Tests every effect of a model where the model stands; `searched` says how many places were tried for its shape.
    pub(crate) fn shown(
        &self,
        fitted: &Fitted,
        searched: impl Fn(&str) -> f64,
    ) -> Result<Vec<Shown>, BadShape> {
        let mut list = Vec::new();
        for index in 0..fitted.pieces.len() {
            let mut pieces = fitted.pieces.clone();
            let own = pieces.remove(index);
            let without = self.pass.fit(fitted.model, pieces.clone(), self.known)?;
            let id = own.id.clone();
            pieces.push(own);
            let last = self.pass.hold(fitted.model, pieces, self.known)?;
            let chance = stands(&self.pass, &last)?.map_or(1.0, |test| test.p_value);
            list.push(Shown {
                p_value: (chance * searched(&id)).min(1.0),
                without: without.as_ref().and_then(held_out_rms),
                with: held_out_rms(&last),
                unit: "µT",
                id,
            });
        }
        Ok(list)
    }
}
