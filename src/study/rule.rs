//! The rule by which an effect is said to be missing: one for the board and the host.
//!
//! A candidate is tested against chance with the noise's memory counted, it must lower the held-out error by what is
//! relevant, and of two that explain the same none is named alone.

/// What chance does less often than this, all that was searched counted, is not chance.
pub const SIGNIFICANCE: f64 = 0.01;

/// A candidate is added only below this: a whole log is to be falsely accused once in some hundred, also where the noise's
/// memory is itself uncertain. What is worth adding lies far below.
pub const ACCUSED: f64 = 0.002;

/// ... and if it takes at least this share off the squared held-out error: less is true perhaps, but not relevant.
pub const RELEVANCE: f64 = 0.02;

/// An effect that explains a logged cause, or has fewer coefficients, may leave this much more held-out error than a shape in
/// time.
pub const NEARLY: f64 = 1.1;

/// Two candidates whose columns agree to this much, once the base is projected out, may be the same cause.
pub const ALIKE: f64 = 0.8;

/// A rival is looked at if it takes this share of what the better one takes off the squared error.
pub const RIVAL_SHARE: f64 = 0.3;

/// Places where a step is looked for: so many independent tests its search is.
pub const STEP_PLACES: usize = 48;

/// Whether the squared held-out error falls by what is relevant; `None` where some block of time cannot be predicted.
pub fn falls(before: Option<f64>, after: Option<f64>) -> bool {
    match (before, after) {
        (Some(before), Some(after)) => after < before * (1.0 - RELEVANCE),
        // Without the candidate some block cannot be predicted at all; with it, it can.
        (None, Some(_)) => true,
        _ => false,
    }
}

/// Whether a candidate with this probability under chance (its own search counted), one of `count`, is added.
pub fn is_accepted(p_value: f64, count: usize, falls: bool) -> bool {
    falls && p_value * (count as f64) < ACCUSED
}

/// Whether chance hardly gives this probability among `count` candidates.
pub fn is_significant(p_value: f64, count: usize) -> bool {
    p_value * (count as f64) < SIGNIFICANCE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_accepted_is_improbable_and_relevant() {
        assert!(falls(Some(1.0), Some(0.9)) && !falls(Some(1.0), Some(0.99)));
        assert!(falls(None, Some(5.0)) && !falls(Some(1.0), None) && !falls(None, None));
        assert!(is_accepted(1e-4, 10, true) && !is_accepted(1e-4, 10, false) && !is_accepted(1e-3, 10, true));
        assert!(is_significant(9e-4, 10) && !is_significant(2e-3, 10));
    }
}
