//! Tones that block means do not show: a long log is gathered into blocks, and a tone above half of their rate is lost in them.
//!
//! Such a tone is faster than all columns and than the wander. Its squares are those of six columns at the rate of the samples; the noise
//! around it is what the same columns take at frequencies nearby.

use crate::base::term::Term;
use crate::bounds::{MIN_ODDS, MIN_SHARE, MIN_TONE_HZ};
use crate::evidence::design::{Blocks, candidate_rows};
use crate::evidence::fit::{Fit, Setting};
use crate::evidence::log::Log;
use crate::evidence::solve::Sums;
use crate::samples::fft;
use crate::samples::samples::Samples;
use ironout::effect::{Follows, Named, Registry, Searched};
use nalgebra::DVector;

/// Share of half the rate of the blocks from which tones are looked for here.
const FROM_SHARE: f64 = 0.6;
/// Frequencies on each side that the noise is taken from.
const NEIGHBOURS: usize = 20;
/// Their distance, in lines of the log's length.
const DISTANCE: f64 = 2.0;

struct Line<'a> {
    term: Term<'a>,
    theta: DVector<f64>,
    squares: f64,
}

fn line<'a>(log: &Log<'a>, named: &Named<'_>, fit: &Fit<'a>, hertz: f64) -> Option<Line<'a>> {
    let term = log.term(named, hertz)?;
    let all = Blocks { size: 1, samples: log.len() };
    let columns = candidate_rows(&all, &fit.model, &fit.points, &[&term]);
    let k = term.k();
    let rows: Vec<f64> = columns
        .chunks_exact(k)
        .zip(&fit.points)
        .flat_map(|(row, point)| row.iter().copied().chain([point.residual]))
        .collect();
    let sums = Sums::of(&rows, k);
    let theta = -sums.factor()?.solve(&sums.right);
    let squares = -sums.right.dot(&theta);
    Some(Line { term, theta, squares })
}

/// The strongest fast tone in what a fit leaves, if there is one; its coefficients are set.
pub fn fast_tone<'a>(
    log: &Log<'a>,
    registry: Registry,
    setting: &Setting,
    fit: &Fit<'a>,
) -> Option<Term<'a>> {
    if setting.blocks.size < 2 || !log.is_timed {
        return None;
    }
    let (family, form) = registry
        .families()
        .filter(|family| family.follows() == Follows::Tone)
        .flat_map(|family| family.forms().iter().map(move |form| (family, *form)))
        .find(|(_, form)| matches!(form.searched, Some(Searched::Frequency)))?;
    let named = Named { family, column: "", form };
    let (step, length) = (log.step_s(), log.length_s());
    let lowest = (FROM_SHARE * 0.5 / (step * setting.blocks.size as f64)).max(MIN_TONE_HZ);
    let highest = 0.5 / step;
    let size = (2 * log.len()).next_power_of_two();
    let mut power = vec![0.0; size / 2];
    for axis in 0..3 {
        let mut data: Vec<(f64, f64)> =
            fit.points.iter().map(|point| (point.residual * point.direction[axis], 0.0)).collect();
        data.resize(size, (0.0, 0.0));
        fft::forward(&mut data);
        power.iter_mut().zip(&data).for_each(|(sum, (re, im))| *sum += re * re + im * im);
    }
    let hertz = |bin: usize| bin as f64 / (size as f64 * step);
    let bins = (0..power.len()).filter(|&bin| hertz(bin) >= lowest);
    let mut top = hertz(bins.max_by(|&a, &b| power[a].total_cmp(&power[b]))?);
    let mut width = 1.0 / length;
    for _ in 0..4 {
        let near = (-3..=3).map(|i| top + width * f64::from(i) / 3.0).filter(|hertz| *hertz < highest);
        let best = near
            .filter_map(|hertz| Some((line(log, &named, fit, hertz)?.squares, hertz)))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        top = best.1;
        width /= 3.0;
    }
    let mut best = line(log, &named, fit, top)?;
    let k = best.term.k() as f64;
    let (mut sum, mut count) = (0.0, 0.0);
    for i in 2..2 + NEIGHBOURS {
        for side in [-1.0, 1.0] {
            let hertz = top + side * DISTANCE * i as f64 / length;
            if hertz > MIN_TONE_HZ && hertz < highest {
                sum += line(log, &named, fit, hertz)?.squares;
                count += 1.0;
            }
        }
    }
    let gain = best.squares / (sum / count / k);
    let trials = ((highest - MIN_TONE_HZ) * length).max(1.0);
    let price = k * (log.len() as f64).ln() + 2.0 * (trials * setting.candidates).ln();
    if !(gain > price + MIN_ODDS && best.squares > MIN_SHARE * fit.squares) {
        return None;
    }
    best.term.coefficients.iter_mut().zip(best.theta.iter()).for_each(|(theta, value)| *theta = *value);
    best.term.trials = trials;
    Some(best.term)
}

/// The samples without a tone.
pub fn without_tone(samples: &Samples, term: &Term, fit: &Fit) -> Samples {
    let mut samples = samples.clone();
    for (sample, (reading, point)) in samples.readings.iter_mut().zip(&fit.points).enumerate() {
        let tone = term.disturbance(sample, &point.quantities(&fit.model.offset));
        reading.measured_ut.iter_mut().zip(tone.iter()).for_each(|(value, tone)| *value -= tone);
    }
    samples
}
