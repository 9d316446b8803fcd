//! 1/f noise wanders, the slower the more, and the offset seems to: what a shape in time takes is held against that.

use crate::base::engine::Fitted;
use crate::base::piece::{BadShape, Piece};
use crate::search::along::offset_along;
use crate::search::gains::decreases;
use crate::search::state::Greedy;
use ironout::effect::Searched;
use ironout::study::{Residual, f_tail};

/// Half waves over the log that the wandering is read from.
const WAVES: usize = 8;
/// A wave that the shape itself is made of by so much tells nothing of the rest.
const ITS_OWN: f64 = 0.5;

/// Share of the variance of `course` that a wave has.
fn shared(course: &[f64], wave: &[f64]) -> f64 {
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len().max(1) as f64;
    let (a, b) = (mean(course), mean(wave));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in course.iter().zip(wave) {
        ab += (x - a) * (y - b);
        aa += (x - a) * (x - a);
        bb += (y - b) * (y - b);
    }
    ab * ab / (aa * bb).max(f64::MIN_POSITIVE)
}

impl<'a> Greedy<'_, 'a> {
    /// Probability that 1/f noise of this exponent takes as much of the form of `piece` as it does, read from how the offset wanders
    /// otherwise. `None` where it is no shape in time.
    pub(crate) fn by_wandering(
        &self,
        fitted: &Fitted<'a>,
        piece: &Piece<'a>,
        exponent: f64,
    ) -> Result<Option<f64>, BadShape> {
        let Some(time) = &self.pass.samples.time else { return Ok(None) };
        let (Some(first), Some(last)) = (time.first(), time.last()) else { return Ok(None) };
        if self.pass.residual != Residual::Magnitude || last <= first {
            return Ok(None);
        }
        let course: Vec<f64> = match piece.searched() {
            Some((Searched::At, at_s)) => time.iter().map(|t| f64::from(u8::from(*t >= at_s))).collect(),
            None if piece.is_in_time() => time.clone(),
            _ => return Ok(None),
        };
        let mut pieces = fitted.pieces.clone();
        pieces.retain(|other| other.id != piece.id);
        let Some(without) = self.pass.fit(fitted.model, pieces, self.known)? else { return Ok(None) };
        let takes = without.squares - fitted.squares;
        let waves: Vec<Vec<f64>> = (1..=WAVES)
            .map(|k| {
                let per_s = std::f64::consts::PI * k as f64 / (last - first);
                time.iter().map(|t| ((t - first) * per_s).cos()).collect()
            })
            .collect();
        let shares: Vec<f64> = waves.iter().map(|wave| shared(&course, wave)).collect();
        let others: Vec<Piece> = waves.into_iter().map(|wave| offset_along("slow wave", wave)).collect();
        let taken = decreases(&self.pass, fitted, &others)?;
        let steeper = |k: usize| (k as f64).powf(exponent);
        let (mut sum, mut count, mut own) = (0.0, 0.0, 0.0);
        for (place, (share, taken)) in shares.iter().zip(&taken).enumerate() {
            own += share / steeper(place + 1);
            if *share < ITS_OWN {
                sum += taken * steeper(place + 1);
                count += 3.0;
            }
        }
        own += (1.0 - shares.iter().sum::<f64>()).max(0.0) / steeper(WAVES + 1);
        let k = piece.k() as f64;
        let chance = f_tail((takes / k) / (own * sum / count).max(f64::MIN_POSITIVE), k, count);
        Ok(Some(chance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_is_of_the_slowest_wave_and_a_step_of_many() {
        let n = 1000;
        let wave = |k: usize| -> Vec<f64> {
            (0..n).map(|i| (std::f64::consts::PI * k as f64 * (i as f64 + 0.5) / n as f64).cos()).collect()
        };
        let of = |course: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let course: Vec<f64> = (0..n).map(course).collect();
            (1..=WAVES).map(|k| shared(&course, &wave(k))).collect()
        };
        // A line's share of wave k, if odd, is 96 / (π k)⁴.
        let drift = of(&|i| 5.0 - 0.1 * i as f64);
        let first = 96.0 / std::f64::consts::PI.powi(4);
        assert!((drift[0] - first).abs() < 1e-3 && drift[1] < 1e-9, "{drift:?}");
        assert!((drift[2] - first / 81.0).abs() < 1e-3, "{drift:?}");
        // One in the middle: 8 / (π k)².
        let step = of(&|i| f64::from(u8::from(i >= n / 2)));
        assert!((step[0] - 8.0 / std::f64::consts::PI.powi(2)).abs() < 1e-3, "{step:?}");
        assert!(step.iter().sum::<f64>() < 1.0);
        assert_eq!(shared(&[3.0; 4], &[0.0, 1.0, 2.0, 3.0]), 0.0);
    }
}
