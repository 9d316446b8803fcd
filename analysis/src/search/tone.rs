//! The search for a tone: at what frequency something hums, by the stamps and by the even grid behind them.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Clock, Term};
use crate::samples::fft;
use crate::samples::samples::Samples;
use crate::samples::series::median;
use crate::search::candidates::Catalogue;
use crate::search::gains::{decreases, largest};
use ironout::effect::Named;

/// The lowest frequency of periodic interference, Hz: two slower sinusoids imitate almost any covariate.
const LOWEST_HZ: f64 = 1.0;

/// A gap of more steps than this tells nothing about the step ...
const MOST_STEPS: f64 = 20.0;
/// ... and stamps tell it if it is within this share of the usual one.
const FEW_DIGITS: f64 = 0.02;

/// Cells of the grid that tones are looked for on, for each row of the log.
const MOST_CELLS: f64 = 8.0;

/// The usual time from row to row, however many between two samples are set aside or left out.
fn usual_step(gaps: &[f64], samples: &Samples) -> f64 {
    let apart = samples.row.windows(2).map(|pair| (pair[1] - pair[0]).max(1) as f64);
    median(&mut gaps.iter().zip(apart).map(|(gap, apart)| gap / apart).collect::<Vec<f64>>())
}

/// The step of which the gaps are whole multiples, near `usual`. Stamps of few digits have a median gap that is off by part
/// of their last one, and over a log that is a wave and more.
fn whole_steps(gaps: &[f64], usual: f64) -> f64 {
    let counted = gaps.iter().map(|gap| (gap, (gap / usual).round())).filter(|(_, k)| *k <= MOST_STEPS);
    let (time, steps) = counted.fold((0.0, 0.0), |(time, steps), (gap, k)| (time + gap, steps + k));
    let step = time / steps;
    if (step / usual - 1.0).abs() < FEW_DIGITS { step } else { usual }
}

/// The strongest periodic disturbance, by the clock that shows it best.
pub fn periodic<'a>(
    design: &Design,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Term<'a>>, BadShape> {
    let Some(stamps) = &design.samples.time else { return Ok(None) };
    let mut found = Vec::from_iter(tone(design, fitted, catalogue, named, (Clock::Stamps, stamps))?);
    if let Some(grid) = catalogue.grid() {
        found.extend(tone(design, fitted, catalogue, named, (Clock::Even, &grid))?);
    }
    let trials = found.iter().map(|(_, term)| term.trials).sum();
    let best = found.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map(|(_, term)| Term { trials, ..term }))
}

/// The strongest tone by one clock, and what it takes off the squared error.
fn tone<'a>(
    design: &Design,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
    (clock, time): (Clock, &[f64]),
) -> Result<Option<(f64, Term<'a>)>, BadShape> {
    let samples = design.samples;
    let n = samples.len();
    let (Some(&first), Some(&last)) = (time.first(), time.last()) else { return Ok(None) };
    let seconds = last - first;
    if n < 64 || seconds <= 2.0 || fitted.columns() + 6 > COLUMNS {
        return Ok(None);
    }
    let gaps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // Where pauses are nearly all of a log the grid is coarser: it costs so many cells a row at most.
    let finest = seconds / (MOST_CELLS * n as f64 * samples.stride as f64);
    let step = whole_steps(&gaps, usual_step(&gaps, samples)).max(finest);
    let nyquist = 0.5 / step;
    if nyquist <= LOWEST_HZ {
        return Ok(None);
    }
    let cells = (seconds / step).ceil() as usize + 1;
    let size = (2 * cells).next_power_of_two();
    let uniform = samples.stride == 1 && gaps.iter().all(|gap| (gap / step - 1.0).abs() < 0.2);
    let terms: Vec<&Term> = fitted.terms.iter().collect();
    let vector = design.residual == ironout::study::Residual::Vector;
    let resolution = 1.0 / (size as f64 * step);
    let from = (LOWEST_HZ / resolution).ceil() as usize;
    let to = ((nyquist / resolution).floor() as usize).min(size / 2);
    let mut power = vec![0.0; to + 1];
    // Two real axes are one complex series: their powers are the mean of those at a frequency and at minus it. One series at a time: on
    // a long log it is the largest thing in memory.
    for axes in [&[0, 1][..], &[2]] {
        let mut series = vec![fft::Complex::new(0.0_f32, 0.0); size];
        design.rows(0..n, &fitted.model, &terms, |sample, row, r| {
            let cell = if uniform { sample } else { ((time[sample] - first) / step).round() as usize };
            let Some(value) = series.get_mut(cell) else { return };
            let part = |axis: usize| if vector { -row[axis] * r } else { row[axis] * r };
            value.re += part(axes[0]) as f32;
            value.im += axes.get(1).map_or(0.0, |axis| part(*axis)) as f32;
        })?;
        let square = fft::powers(series);
        for (bin, sum) in power.iter_mut().enumerate() {
            *sum += 0.5 * (square(bin) + square((size - bin) % size));
        }
    }
    let mut peaks: Vec<usize> = (from.max(1)..to)
        .filter(|&bin| power[bin] >= power[bin - 1] && power[bin] >= power[bin + 1])
        .collect();
    peaks.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    peaks.truncate(2);
    if peaks.is_empty() {
        return Ok(None);
    }
    let searched = ((nyquist - LOWEST_HZ) * seconds).max(1.0);
    let width = 1.0 / seconds;
    let mut frequencies: Vec<f64> = peaks
        .iter()
        .flat_map(|bin| (-2..=2).map(move |k| *bin as f64 * resolution + f64::from(k) * 0.3 * width))
        .filter(|hz| (LOWEST_HZ..=nyquist).contains(hz))
        .collect();
    let mut spacing = 0.3 * width;
    let mut best = None;
    for _ in 0..3 {
        let terms: Vec<Term> = frequencies.iter().filter_map(|hz| catalogue.by(clock, named, *hz)).collect();
        let gains = decreases(design, fitted, &terms)?;
        let at = largest(&gains);
        let (Some(&hz), Some(&gain)) = (frequencies.get(at), gains.get(at)) else { break };
        best = Some((gain, hz));
        spacing *= 0.25;
        frequencies = (-3..=3)
            .map(|k| hz + f64::from(k) * spacing)
            .filter(|hz| (LOWEST_HZ..=nyquist).contains(hz))
            .collect();
    }
    let found = best.and_then(|(gain, hz)| Some((gain, catalogue.by(clock, named, hz)?)));
    Ok(found.map(|(gain, term)| (gain, Term { trials: searched, ..term })))
}

#[cfg(test)]
mod tests {
    use super::whole_steps;

    #[test]
    fn stamps_of_few_digits_do_not_move_the_step() {
        // 46.7 samples a second, stamped to 0.1 ms: the median gap is 0.0214 s, which over 270 s is off by 3.6 waves of 21 Hz.
        let stamp = |row: usize| (row as f64 / 46.7 * 1e4).round() / 1e4;
        for stride in [1, 3] {
            let time: Vec<f64> = (0..12_600).step_by(stride).map(stamp).collect();
            let gaps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let step = whole_steps(&gaps, 0.0214);
            let waves = 21.3 * 270.0 * (step * 46.7 - 1.0);
            assert!(waves.abs() < 0.05, "stride {stride}: {waves} waves");
        }
        // Where the gaps are no multiples the usual one stands.
        let odd: Vec<f64> = (0..100).map(|i| if i % 2 == 0 { 0.014 } else { 0.027 }).collect();
        assert_eq!(whole_steps(&odd, 0.02), 0.02);
    }
}
