//! From the stream of samples to the pairs that count.

use super::lagged::{Lagged, Weights};
use super::share::{Observed, effective_share};
use crate::calibration::Calibration;
use crate::fit::FitReport;
use crate::gate::Gated;

/// Samples between the two of a pair further apart. Odd, so that the pairs of every other sample reach all of them.
const LAG: usize = 7;

/// The residual of a fit, and what it is the residual of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual<'a> {
    /// The calibration.
    pub calibration: &'a Calibration<f64>,
    /// What the noise makes of the corrected magnitude, rms, µT.
    pub rms_ut: f64,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: f64,
    /// Samples.
    pub samples: f64,
    /// Parameters of the fit.
    pub parameters: f64,
}

/// Sums over pairs of neighbouring samples, and of samples seven apart, of a board that moves. At most 450 bytes.
///
/// Every sample adds one pair, of the one kind and the other in turn.
#[derive(Clone, Debug)]
pub struct Whiteness {
    near: Lagged,
    far: Lagged,
    /// The last samples; the oldest is at `next`.
    last: [[i16; 3]; LAG],
    next: u8,
    /// Samples in a row, up to [`LAG`].
    in_a_row: u8,
    centre: Option<[i16; 3]>,
    number: u16,
    /// Samples that count before the rest gate speaks again.
    trusted: u16,
    samples_per_block: u16,
}

const _: () = assert!(core::mem::size_of::<Whiteness>() <= 450, "the memory is a promise");

impl Whiteness {
    /// Nothing seen yet. `samples_per_block` is that of the rest gate.
    pub const fn new(samples_per_block: u16) -> Self {
        Self {
            near: Lagged::new(),
            far: Lagged::new(),
            last: [[0; 3]; LAG],
            next: 0,
            in_a_row: 0,
            centre: None,
            number: 0,
            trusted: samples_per_block,
            samples_per_block,
        }
    }

    /// Takes a sample, before the rest gate does.
    pub fn push(&mut self, counts: [i16; 3]) {
        let centre = *self.centre.get_or_insert(counts);
        let next = usize::from(self.next) % LAG;
        // A board at rest would drown the noise of the moving one; a block after one that moved is taken as moving.
        if self.trusted > 0 {
            self.trusted -= 1;
            let pair = self.number >> 1;
            if self.number & 1 == 0 {
                if self.in_a_row > 0 && self.near.takes(pair) {
                    self.near.push(&self.last[(next + LAG - 1) % LAG], &counts, &centre);
                }
            } else if usize::from(self.in_a_row) == LAG && self.far.takes(pair) {
                self.far.push(&self.last[next], &counts, &centre);
            }
        }
        self.number = self.number.wrapping_add(1);
        self.last[next] = counts;
        self.next = ((next + 1) % LAG) as u8;
        self.in_a_row = (self.in_a_row + 1).min(LAG as u8);
    }

    /// Samples are missing here: no pair reaches across the gap.
    pub fn interrupt(&mut self) {
        self.in_a_row = 0;
    }

    /// Hears what the rest gate did with the sample.
    pub fn heed(&mut self, gated: Gated) {
        match gated {
            Gated::Pending => {}
            Gated::Added(_) => self.trusted = self.samples_per_block,
            Gated::Dropped(_) => self.trusted = 0,
        }
    }

    /// The share of independent samples, above 0 and at most 1, for the fit of these samples with every one taken as
    /// independent. `quantisation_ut2` is the variance of the sensor's steps, µT². `None` where too few pairs were seen.
    pub fn independent_share(
        &self,
        report: &FitReport,
        ut_per_count: [f64; 3],
        quantisation_ut2: f64,
    ) -> Option<f64> {
        let residual = Residual {
            calibration: &report.calibration,
            rms_ut: report.residual_floor_ut,
            noise_ut: report.noise_ut,
            samples: report.samples as f64,
            parameters: report.model.parameters() as f64,
        };
        self.share_of(&residual, ut_per_count, quantisation_ut2)
    }

    /// The same for the residual of another fit.
    pub(crate) fn share_of(
        &self,
        residual: &Residual<'_>,
        ut_per_count: [f64; 3],
        quantisation_ut2: f64,
    ) -> Option<f64> {
        let Residual { calibration, rms_ut, noise_ut, samples, parameters } = *residual;
        let weights = Weights::of(calibration, ut_per_count, self.centre?);
        // The quadric is twice the residual over the field.
        let relative = 2.0 * rms_ut / calibration.field_ut;
        let observed = Observed {
            variance: relative * relative,
            quantisation: relative * relative * quantisation_ut2 / (noise_ut * noise_ut),
            gradient2: relative * relative / (noise_ut * noise_ut),
            near: self.near.of(&weights)?,
            far: self.far.of(&weights),
            lag: LAG as i32,
            samples,
            parameters,
        };
        effective_share(&observed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of neighbours and of samples seven apart.
    fn pairs(whiteness: &Whiteness) -> [usize; 2] {
        [&whiteness.near, &whiteness.far].map(|lagged| usize::from(lagged.pairs()))
    }

    #[test]
    fn a_board_at_rest_adds_a_block_and_a_moving_one_every_sample() {
        let mut whiteness = Whiteness::new(16);
        for i in 0..160i16 {
            whiteness.push([i, 2 * i, -i]);
            if i % 16 == 15 {
                whiteness.heed(Gated::Added(16));
            }
        }
        // Half of the samples each, less the first that have no partner.
        assert_eq!(pairs(&whiteness), [79, 77]);
        for i in 0..800i16 {
            // The gate does not know yet, and then it drops all.
            whiteness.push([i % 2, 0, 0]);
            whiteness.heed(if i % 112 == 111 { Gated::Dropped(112) } else { Gated::Pending });
        }
        assert_eq!(pairs(&whiteness), [79 + 8, 77 + 8]);
    }

    #[test]
    fn no_pair_reaches_across_a_gap() {
        let mut whiteness = Whiteness::new(100);
        for i in 0..60i16 {
            if i % 6 == 0 {
                whiteness.interrupt();
            }
            whiteness.push([i, 0, 0]);
        }
        assert_eq!(pairs(&whiteness), [20, 0]);
    }
}
