//! Searches over the parameter that fixes a shape: when a step happened, how late a column acts, at what frequency.

use crate::base::engine::{Fitted, Pass};
use crate::base::piece::{BadShape, COLUMNS, Matrix, Piece};
use crate::samples::fft;
use crate::samples::samples::Samples;
use crate::samples::series::median;
use crate::search::candidates::Catalogue;
use crate::search::screen::{Candidate, WORTH_NAMING};
use ironout::effect::{Named, Searched};
/// Places where a step is looked for at first.
use ironout::study::rule::STEP_PLACES as STEP_SEGMENTS;

/// The lowest frequency of periodic interference, Hz: two slower sinusoids imitate almost any covariate.
const LOWEST_HZ: f64 = 1.0;

/// A column that takes so many times more off the error late than at once is worth a closer look.
const LATE_OVER_PROMPT: f64 = 1.2;

/// Delays are looked for up to this, s: what follows later than a motor or a power module does has a time of its own to show.
const LONGEST_DELAY_S: f64 = 5.0;

/// The best place of an effect of which something is searched for. `None` where nothing is, or the log does not allow it.
pub fn best<'a>(
    pass: &Pass,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Candidate<'a>>, BadShape> {
    match named.form.searched {
        Some(Searched::At) => step(pass, fitted, catalogue, named),
        Some(Searched::Frequency) => periodic(pass, fitted, catalogue, named),
        Some(Searched::Delay) => delay(pass, fitted, catalogue, named),
        None => Ok(None),
    }
}

/// Where an offset step takes the most off the squared error.
fn step<'a>(
    pass: &Pass,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Candidate<'a>>, BadShape> {
    let Some(time) = &pass.samples.time else { return Ok(None) };
    let n = pass.samples.len();
    let base = fitted.columns();
    if n < 4 * STEP_SEGMENTS || base + 3 > COLUMNS {
        return Ok(None);
    }
    let pieces: Vec<&Piece> = fitted.pieces.iter().collect();
    let mut bounds: Vec<usize> = (0..=STEP_SEGMENTS).map(|k| n * k / STEP_SEGMENTS).collect();
    let mut total: Option<Matrix> = None;
    let mut after = Matrix::new(base);
    let mut best = (0.0, 0);
    loop {
        let segments = pass.blocks(&bounds, &fitted.model, &pieces)?;
        let whole = total.get_or_insert_with(|| Matrix::total(&segments, Some(&fitted.prior)));
        let mut suffix = Matrix::new(base);
        suffix.merge(&after);
        let mut sums = vec![suffix.clone()];
        for segment in segments.iter().rev() {
            suffix.merge(segment);
            sums.push(suffix.clone());
        }
        sums.reverse();
        best = (0.0, best.1);
        // The first and last bound are no places for a step unless they lie inside the log.
        for (place, bound) in bounds.iter().enumerate() {
            if *bound < n / 50 || *bound > n - n / 50 {
                continue;
            }
            let masked = with_steps(whole, &[&sums[place]], base);
            let decrease = masked.test(0..base, base..base + 3).map_or(0.0, |gain| gain.decrease);
            if decrease > best.0 {
                best = (decrease, place);
            }
        }
        if best.0 <= 0.0 {
            return Ok(None);
        }
        let (low, high) = (bounds[best.1.saturating_sub(1)], bounds[(best.1 + 1).min(bounds.len() - 1)]);
        let at = bounds[best.1];
        if bounds.windows(2).all(|pair| pair[1] - pair[0] <= 1) || high - low <= 2 {
            let at_s = if at == 0 { time[0] } else { 0.5 * (time[at - 1] + time[at]) };
            let piece = catalogue.build(named, at_s);
            return Ok(piece.map(|piece| Candidate { piece, searched: STEP_SEGMENTS as f64 }));
        }
        // Finer around the best place.
        after = sums[(best.1 + 1).min(sums.len() - 1)].clone();
        let parts = (high - low).min(32);
        bounds = (0..=parts).map(|k| low + (high - low) * k / parts).collect();
    }
}

/// The normal matrix with three more columns for each of `suffixes`: those of the offset from some time on, whose own matrix the
/// suffix is. A later one lies within an earlier one.
fn with_steps(whole: &Matrix, suffixes: &[&Matrix], base: usize) -> Matrix {
    let mut out = Matrix::new(base + 3 * suffixes.len());
    out.merge(whole);
    for (place, suffix) in suffixes.iter().enumerate() {
        let at = base + 3 * place;
        for axis in 0..3 {
            for column in 0..base {
                out.inform(column, at + axis, suffix.entry(column, axis));
            }
            for other in axis..3 {
                out.inform(at + axis, at + other, suffix.entry(axis, other));
            }
            for later in place + 1..suffixes.len() {
                for other in 0..3 {
                    let both = suffixes[later].entry(axis, other);
                    out.inform(at + axis, base + 3 * later + other, both);
                }
            }
            out.pull(at + axis, suffix.right(axis));
        }
    }
    out
}

/// Where two offset steps together take the most off the squared error, roughly: there and back each alone takes little.
pub(crate) fn two_steps<'a>(
    pass: &Pass,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<[Candidate<'a>; 2]>, BadShape> {
    let Some(time) = &pass.samples.time else { return Ok(None) };
    let (n, base) = (pass.samples.len(), fitted.columns());
    if n < 4 * STEP_SEGMENTS || base + 6 > COLUMNS {
        return Ok(None);
    }
    let pieces: Vec<&Piece> = fitted.pieces.iter().collect();
    let bounds: Vec<usize> = (0..=STEP_SEGMENTS).map(|k| n * k / STEP_SEGMENTS).collect();
    let segments = pass.blocks(&bounds, &fitted.model, &pieces)?;
    let whole = Matrix::total(&segments, Some(&fitted.prior));
    let mut suffixes = vec![Matrix::new(base)];
    for segment in segments.iter().rev() {
        let mut next = suffixes[suffixes.len() - 1].clone();
        next.merge(segment);
        suffixes.push(next);
    }
    suffixes.reverse();
    let inside: Vec<usize> =
        (1..STEP_SEGMENTS).filter(|place| (n / 50..=n - n / 50).contains(&bounds[*place])).collect();
    let mut best: Option<(f64, usize, usize)> = None;
    for (index, &first) in inside.iter().enumerate() {
        for &second in &inside[index + 1..] {
            let both = with_steps(&whole, &[&suffixes[first], &suffixes[second]], base);
            let decrease = both.test(0..base, base..base + 6).map_or(0.0, |gain| gain.decrease);
            if best.is_none_or(|(most, ..)| decrease > most) {
                best = Some((decrease, first, second));
            }
        }
    }
    let at = |place: usize| 0.5 * (time[bounds[place] - 1] + time[bounds[place]]);
    let step = |place: usize| {
        let piece = catalogue.build(named, at(place))?;
        Some(Candidate { piece, searched: STEP_SEGMENTS as f64 })
    };
    Ok(best.and_then(|(_, first, second)| Some([step(first)?, step(second)?])))
}

/// How much each candidate alone takes off the squared error.
pub(crate) fn decreases(pass: &Pass, fitted: &Fitted, candidates: &[Piece]) -> Result<Vec<f64>, BadShape> {
    let base = fitted.columns();
    let mut out = Vec::new();
    let width = candidates.iter().map(Piece::k).max().unwrap_or(1);
    let batch = ((COLUMNS - base) / width).clamp(1, crate::base::piece::TERMS - fitted.pieces.len());
    for chunk in candidates.chunks(batch) {
        let all: Vec<&Piece> = fitted.pieces.iter().chain(chunk).collect();
        let blocks = pass.blocks(&pass.samples.bounds(2), &fitted.model, &all)?;
        let total = Matrix::total(&blocks, Some(&fitted.prior));
        let mut column = base;
        for piece in chunk {
            let span = column..column + piece.k();
            column = span.end;
            out.push(total.test(0..base, span).map_or(0.0, |gain| gain.decrease));
        }
    }
    Ok(out)
}

fn largest(values: &[f64]) -> usize {
    values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(index, _)| index)
}

/// Delays that are tried at first: whole samples, ever fewer the longer.
fn delays(samples: &Samples) -> Option<Vec<f64>> {
    let time = samples.time.as_ref()?;
    let mut gaps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 0.0).collect();
    let step = median(&mut gaps) / samples.stride as f64;
    let seconds = time.last().unwrap_or(&0.0) - time.first().unwrap_or(&0.0);
    if step.is_nan() || step <= 0.0 {
        return None;
    }
    let longest = LONGEST_DELAY_S.max(10.0 * step).min(seconds / 10.0);
    let mut delays = Vec::new();
    let (mut one, mut two) = (1.0, 2.0);
    while one * step <= longest {
        delays.push(one * step);
        (one, two) = (two, one + two);
    }
    (!delays.is_empty()).then_some(delays)
}

/// Whether a column takes clearly more off the error late than at once.
pub fn acts_late<'a>(
    pass: &Pass,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<bool, BadShape> {
    let Some(mut delays) = delays(pass.samples) else { return Ok(false) };
    delays.insert(0, 0.0);
    let pieces: Vec<Piece> = delays.iter().filter_map(|d| catalogue.build(named, *d)).collect();
    let taken = decreases(pass, fitted, &pieces)?;
    let Some((prompt, late)) = taken.split_first() else { return Ok(false) };
    let most = late.iter().copied().fold(0.0, f64::max);
    Ok(most > LATE_OVER_PROMPT * prompt && most > WORTH_NAMING * fitted.squares)
}

/// How late a column acts, if it acts late.
fn delay<'a>(
    pass: &Pass,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Candidate<'a>>, BadShape> {
    let Some(mut delays) = delays(pass.samples) else { return Ok(None) };
    let searched = delays.len() as f64;
    for round in 0..3 {
        let pieces: Vec<Piece> = delays.iter().filter_map(|d| catalogue.build(named, *d)).collect();
        let gains = decreases(pass, fitted, &pieces)?;
        let best = largest(&gains);
        if round == 2 || gains.get(best).is_none_or(|gain| *gain <= 0.0) {
            return Ok(pieces.into_iter().nth(best).map(|piece| Candidate { piece, searched }));
        }
        let low = if best == 0 { 0.5 * delays[0] } else { delays[best - 1] };
        let high = delays.get(best + 1).copied().unwrap_or(delays[best]);
        delays = (0..9).map(|k| low + (high - low) * f64::from(k) / 8.0).collect();
    }
    Ok(None)
}

/// A gap of more steps than this tells nothing about the step ...
const MOST_STEPS: f64 = 20.0;
/// ... and stamps tell it if it is within this share of the usual one.
const FEW_DIGITS: f64 = 0.02;

/// Cells of the grid that tones are looked for on, for each row of the log.
const MOST_CELLS: f64 = 8.0;

/// The usual time from one of the sensor's samples to the next. Rows that arrive in bursts have a short median step: the mean
/// one tells the sensor's rate, by the rows of the log, of which many may be set aside. Thinned rows stand on the grid of all.
fn usual_step(gaps: &[f64], samples: &Samples) -> f64 {
    let mut apart: Vec<f64> = samples.row.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let median_gap = median(&mut gaps.to_vec());
    let mean = gaps.iter().sum::<f64>() / gaps.len().max(1) as f64;
    // Where the logger paused the rows say nothing of the rate.
    let running = gaps.iter().zip(&apart).filter(|(gap, _)| **gap <= MOST_STEPS * median_gap.max(mean));
    let (time, rows) = running.fold((0.0, 0.0), |(time, rows), (gap, apart)| (time + gap, rows + apart));
    median_gap.max(0.9 * time / rows * median(&mut apart)) / samples.stride as f64
}

/// The step of which the gaps are whole multiples, near `usual`. Stamps of few digits have a median gap that is off by part
/// of their last one, and over a log that is a wave and more.
fn whole_steps(gaps: &[f64], usual: f64) -> f64 {
    let counted = gaps.iter().map(|gap| (gap, (gap / usual).round())).filter(|(_, k)| *k <= MOST_STEPS);
    let (time, steps) = counted.fold((0.0, 0.0), |(time, steps), (gap, k)| (time + gap, steps + k));
    let step = time / steps;
    if (step / usual - 1.0).abs() < FEW_DIGITS { step } else { usual }
}

/// The frequency of the strongest periodic disturbance.
fn periodic<'a>(
    pass: &Pass,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Candidate<'a>>, BadShape> {
    let samples = pass.samples;
    let Some(stamps) = &samples.time else { return Ok(None) };
    let grid = catalogue.grid();
    let time = grid.as_ref().unwrap_or(stamps);
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
    let mut series = vec![vec![(0.0, 0.0); size]; 3];
    let pieces: Vec<&Piece> = fitted.pieces.iter().collect();
    let vector = pass.residual == ironout::study::Residual::Vector;
    pass.rows(0..n, &fitted.model, &pieces, |sample, row, r| {
        let cell = if uniform { sample } else { ((time[sample] - first) / step).round() as usize };
        for (axis, out) in series.iter_mut().enumerate() {
            let weight = if vector { -row[axis] } else { row[axis] };
            if let Some(value) = out.get_mut(cell) {
                value.0 += weight * r;
            }
        }
    })?;
    for line in &mut series {
        fft::forward(line);
    }
    let resolution = 1.0 / (size as f64 * step);
    let from = (LOWEST_HZ / resolution).ceil() as usize;
    let to = ((nyquist / resolution).floor() as usize).min(size / 2);
    let power: Vec<f64> = (0..=to)
        .map(|bin| series.iter().map(|line| line[bin].0 * line[bin].0 + line[bin].1 * line[bin].1).sum())
        .collect();
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
        let pieces: Vec<Piece> = frequencies.iter().filter_map(|hz| catalogue.build(named, *hz)).collect();
        let gains = decreases(pass, fitted, &pieces)?;
        let at = largest(&gains);
        let Some(hz) = frequencies.get(at).copied() else { break };
        best = Some(hz);
        spacing *= 0.25;
        frequencies = (-3..=3)
            .map(|k| hz + f64::from(k) * spacing)
            .filter(|hz| (LOWEST_HZ..=nyquist).contains(hz))
            .collect();
    }
    Ok(best.and_then(|hz| catalogue.build(named, hz)).map(|piece| Candidate { piece, searched }))
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
