//! Model against measurement over time, in pieces short enough to be drawn: least and greatest of each.

use serde::Serialize;

/// Pieces of a log.
const PIECES: usize = 700;

/// A series in pieces of time: its least and greatest value in each.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Band {
    /// The least.
    pub low: Vec<f32>,
    /// The greatest.
    pub high: Vec<f32>,
}

/// What is drawn over time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timeline {
    /// The middle of each piece, s.
    pub at_s: Vec<f32>,
    /// Measured magnitude, µT.
    pub measured_ut: Band,
    /// Residual of offset and matrix only, µT.
    pub without_ut: Band,
    /// Residual of the whole model, µT.
    pub residual_ut: Band,
    /// Dip of the corrected field below the horizon, degrees, where there is an accelerometer.
    pub dip_deg: Option<Band>,
    /// Heading minus its reference, degrees, where there is one.
    pub heading_error_deg: Option<Band>,
}

/// Cuts `time_s` into pieces of equal length; empty ones are left out.
pub struct Pieces {
    /// The piece of each sample.
    of: Vec<usize>,
    /// The middle of each piece, s.
    pub at_s: Vec<f32>,
}

impl Pieces {
    /// Of samples in the order of time.
    pub fn of(time_s: &[f64]) -> Option<Self> {
        let (first, last) = (*time_s.first()?, *time_s.last()?);
        if last <= first || !(last - first).is_finite() {
            return None;
        }
        let width = (last - first) / PIECES.min(time_s.len()) as f64;
        let mut pieces = Pieces { of: Vec::with_capacity(time_s.len()), at_s: Vec::new() };
        let mut current = None;
        for t in time_s {
            let place = ((t - first) / width).floor();
            if current != Some(place) {
                current = Some(place);
                pieces.at_s.push((first + (place + 0.5) * width) as f32);
            }
            pieces.of.push(pieces.at_s.len() - 1);
        }
        Some(pieces)
    }

    /// Least and greatest of a series in each piece; NaN (null) where there is none.
    pub fn band(&self, values: impl IntoIterator<Item = f64>) -> Band {
        let empty = vec![f32::NAN; self.at_s.len()];
        let mut band = Band { low: empty.clone(), high: empty };
        for (value, piece) in values.into_iter().zip(&self.of) {
            let value = value as f32;
            if let (Some(low), Some(high), true) =
                (band.low.get_mut(*piece), band.high.get_mut(*piece), value.is_finite())
            {
                *low = low.min(value);
                *high = high.max(value);
            }
        }
        band
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_sticks_out_is_lost() {
        let time: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 0.01).collect();
        let pieces = Pieces::of(&time).expect("it has a length");
        let band = pieces.band(time.iter().map(|t| if (*t - 500.0).abs() < 1e-9 { 9.0 } else { -t }));
        assert_eq!(band.high.iter().copied().fold(f32::MIN, f32::max), 9.0);
        assert!((band.low.iter().copied().fold(f32::MAX, f32::min) + 999.99).abs() < 1e-3);
        assert!(pieces.at_s.len() <= PIECES + 1);
        assert!(Pieces::of(&[1.0, 1.0]).is_none());
        assert!(Pieces::of(&[]).is_none());
    }
}
