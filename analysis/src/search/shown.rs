//! Whether a log shows the effects that were put into its model: the study's own test, of each beside all others.

use crate::base::engine::Fitted;
use crate::base::piece::BadShape;
use crate::search::screen::{ACCUSED, RELEVANCE, stands};
use crate::search::state::{Greedy, held_out_rms};
use serde::Serialize;

/// What the test of an effect in the model says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// Its id.
    pub id: String,
    /// Probability that chance does as well, its search counted.
    pub p_value: f64,
    /// Error on unseen time without it, all others in the model: µT, or degrees where only the dip sees it. `None` where
    /// some block of time cannot be predicted.
    pub without: Option<f64>,
    /// The same with it.
    pub with: Option<f64>,
    /// Unit of the two.
    pub unit: &'static str,
}

impl Shown {
    /// Whether chance hardly does as well.
    pub fn is_significant(&self) -> bool {
        self.p_value < ACCUSED
    }

    /// Whether the error on unseen time falls by what is relevant.
    pub fn falls(&self) -> bool {
        match (self.without, self.with) {
            (Some(without), Some(with)) => with * with < without * without * (1.0 - RELEVANCE),
            (None, with) => with.is_some(),
            (Some(_), None) => false,
        }
    }

    /// Whether the log shows the effect.
    pub fn is_shown(&self) -> bool {
        self.is_significant() && self.falls()
    }
}

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
