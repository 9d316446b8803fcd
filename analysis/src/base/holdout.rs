//! The error on data the fit has not seen: contiguous blocks of time are left out in turn.

use crate::samples::data::Data;
use crate::samples::data::Sums;
use ironout::calibration::norm;
use ironout::fit::{FitOptions, fit};

/// Blocks of time.
const BLOCKS: usize = 10;
/// A block shorter than this proves nothing.
const LEAST: usize = 20;

/// Rms residual, µT, of each block of time under the fit of all others, in the scale of `field_ut`; `None` where the
/// log is too short, or where it has no calibration without one of its blocks.
pub fn rms_ut(data: &Data, samples: &[u32], options: &FitOptions, field_ut: f64) -> Option<f64> {
    if samples.len() < BLOCKS * LEAST {
        return None;
    }
    let blocks: Vec<&[u32]> =
        (0..BLOCKS).map(|k| &samples[k * samples.len() / BLOCKS..(k + 1) * samples.len() / BLOCKS]).collect();
    let sums: Vec<Sums> = blocks
        .iter()
        .map(|block| {
            let mut sums = data.sums();
            block.iter().for_each(|&sample| sums.push(data, sample));
            sums
        })
        .collect();
    let mut squares = 0.0;
    for (k, block) in blocks.iter().enumerate() {
        let mut others = data.sums();
        sums.iter().enumerate().filter(|(other, _)| *other != k).for_each(|(_, sums)| others.merge(sums));
        let calibration = fit(&others.finish(data).ok()?, options).ok()?.calibration;
        let unit = field_ut / calibration.field_ut;
        for &sample in *block {
            let residual = (norm(calibration.apply(data.field(sample))) - calibration.field_ut) * unit;
            squares += residual * residual;
        }
    }
    Some((squares / samples.len() as f64).sqrt())
}
