//! What to fit, and what is asked of the data first.

/// Fewest samples in motion that a calibration is fitted to.
pub const MIN_SAMPLES: u64 = 20;
/// Thinner than this (least over greatest standard deviation of the cloud of samples), the attitude is planar.
pub const MIN_THICKNESS: f32 = 0.1;
/// Predicted 1σ error of the corrected vector, over the field, above which lower orders are tried and no calibration
/// is accepted.
pub const MAX_PREDICTED_ERROR: f64 = 0.01;

/// A field outside of this is a slip of the unit, µT.
pub const FIELD_RANGE_UT: core::ops::RangeInclusive<f32> = 1e-3..=1e6;

/// How the quadric is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// Adjusted least squares: the default.
    #[default]
    Adjusted,
    /// Least squares, trace normalisation.
    Trace,
    /// The paper's least squares, constant normalisation.
    Constant,
}

impl Method {
    /// The word of the command line and the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Adjusted => "adjusted",
            Self::Trace => "trace",
            Self::Constant => "constant",
        }
    }

    /// The method of a word; `None` for any other.
    pub fn parse(word: &str) -> Option<Self> {
        [Self::Adjusted, Self::Trace, Self::Constant].into_iter().find(|m| m.name() == word)
    }
}

/// What to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FitOptions {
    /// The method.
    pub method: Method,
    /// The true magnitude of the field, µT; `None` keeps the mean magnitude of the measurements about the offset.
    pub field_ut: Option<f64>,
    /// The number of independent samples, where noise is correlated, from 1 to all of them; `None` takes every sample as
    /// independent.
    pub effective_samples: Option<f64>,
    /// Whether lower orders may be chosen if the data do not determine nine parameters.
    pub lower_orders: bool,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { method: Method::Adjusted, field_ut: None, effective_samples: None, lower_orders: true }
    }
}
