//! The predicted error of a stored calibration, in the one byte that every layout has left.

use crate::math;

/// The least share that is told from none.
const LEAST: f64 = 1e-6;
/// Codes for each factor of ten.
const CODES_A_DECADE: f64 = 40.0;

/// The predicted 1σ error of a calibration's corrected vector in the worst direction, as a share of its field; or that it is not
/// known. Kept in steps of 6 %, rounded up, from a millionth to twice the field.
///
/// ```
/// use ironout::record::PredictedError;
/// let half_a_percent = PredictedError::of_share(0.005);
/// let share = half_a_percent.share().expect("it is known");
/// assert!((0.005..=0.0053).contains(&share));
/// assert_eq!(PredictedError::of_share(f64::NAN), PredictedError::UNKNOWN);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PredictedError(u8);

impl PredictedError {
    /// Nothing is known of it: a record of older firmware, or a calibration from elsewhere.
    pub const UNKNOWN: Self = Self(0);

    /// Of a share of the field; [`Self::UNKNOWN`] for what is negative or not finite.
    pub fn of_share(share: f64) -> Self {
        if !share.is_finite() || share < 0.0 {
            return Self::UNKNOWN;
        }
        let decades = math::ln(share.max(LEAST) / LEAST) / core::f64::consts::LN_10;
        // Just above a step is that step: a share that was read back keeps its code.
        let code = 1.0 + ceil(decades * CODES_A_DECADE - 1e-9);
        Self(code.min(255.0) as u8)
    }

    /// The share of the field.
    pub fn share(self) -> Option<f64> {
        let steps = f64::from(self.0.checked_sub(1)?);
        Some(LEAST * math::exp(steps / CODES_A_DECADE * core::f64::consts::LN_10))
    }

    pub(super) const fn code(self) -> u8 {
        self.0
    }

    pub(super) const fn of_code(code: u8) -> Self {
        Self(code)
    }
}

fn ceil(x: f64) -> f64 {
    -math::floor(-x)
}

#[cfg(test)]
mod tests {
    use super::PredictedError;

    #[test]
    fn every_code_is_read_back_and_shares_are_rounded_up() {
        for code in 1..=255 {
            let error = PredictedError::of_code(code);
            assert_eq!(PredictedError::of_share(error.share().unwrap()), error, "{code}");
        }
        for share in [1e-6, 3.3e-5, 0.0099, 0.01, 1.0] {
            let kept = PredictedError::of_share(share).share().unwrap();
            assert!(kept >= share * (1.0 - 1e-9) && kept < share * 1.06, "{share} {kept}");
        }
        assert_eq!(PredictedError::of_share(1e9).code(), 255);
        assert_eq!(PredictedError::of_share(0.0).code(), 1);
        assert_eq!(PredictedError::of_share(-1.0), PredictedError::UNKNOWN);
        assert_eq!(PredictedError::UNKNOWN.share(), None);
    }
}
