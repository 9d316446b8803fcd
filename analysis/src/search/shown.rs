//! Whether a log shows the effects that were put into its model.

use crate::bounds::RAISES;
use crate::search::screen::{ACCUSED, RELEVANCE};
use serde::Serialize;

/// What the test of an effect in the model says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// Its id.
    pub id: String,
    /// p-value, corrected for its search.
    pub p_value: f64,
    /// Error on held-out time without it, all others in the model: µT, or degrees where only the dip sees it. `None` where
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

    /// Whether the held-out error falls by what is relevant.
    pub fn falls(&self) -> bool {
        match (self.without, self.with) {
            (Some(without), Some(with)) => with * with < without * without * (1.0 - RELEVANCE),
            (None, with) => with.is_some(),
            (Some(_), None) => false,
        }
    }

    /// The held-out error with it, over that without it.
    pub(crate) fn rise(&self) -> f64 {
        self.without.zip(self.with).map_or(0.0, |(without, with)| with / without)
    }

    /// Whether it raises the held-out error.
    pub(crate) fn raises(&self) -> bool {
        self.rise() > RAISES
    }

    /// Why it is left out.
    pub(crate) fn why_not(&self, is_asked: bool) -> String {
        let rms = |rms: Option<f64>| rms.map_or("unknown".into(), |rms| format!("{rms:.3} {}", self.unit));
        let (with, without) = (rms(self.with), rms(self.without));
        if !is_asked {
            return format!("it increases the held-out error from {without} to {with}");
        }
        let p = if self.p_value < 0.01 {
            format!("{:.0e}", self.p_value)
        } else {
            format!("{:.2}", self.p_value)
        };
        format!(
            "requested, but not significant in this log (p = {p}; held-out error {with} with it, {without} without)"
        )
    }

    /// Whether the log shows the effect.
    pub fn is_shown(&self) -> bool {
        self.is_significant() && self.falls()
    }
}
