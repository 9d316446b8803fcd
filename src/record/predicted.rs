//! The predicted error of a stored calibration, in the one byte that every layout has left.

/// The least share that is told from none.
const LEAST: f64 = 1e-6;
/// From one code to the next, forty of which are a factor of ten.
const STEP: f64 = 1.059_253_725_177_288_9;

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
        // Just above a step is that step: a share that was read back keeps its code.
        let within = share * (1.0 - 1e-9);
        let code = (1..u8::MAX).zip(Self::steps()).find(|(_, step)| *step >= within);
        Self(code.map_or(u8::MAX, |(code, _)| code))
    }

    /// The share of the field.
    pub fn share(self) -> Option<f64> {
        Self::steps().nth(self.0.checked_sub(1)?.into())
    }

    /// The shares of all codes, multiplied up: a logarithm and an exponential would be 1.6 KB of `libm`.
    fn steps() -> impl Iterator<Item = f64> {
        core::iter::successors(Some(LEAST), |step| Some(step * STEP))
    }

    #[cfg(feature = "record")]
    pub(super) const fn code(self) -> u8 {
        self.0
    }

    #[cfg(feature = "record")]
    pub(super) const fn of_code(code: u8) -> Self {
        Self(code)
    }
}

#[cfg(all(test, feature = "record"))]
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
