//! Where the base model fails: its residual against columns, time, attitude and spectrum.

use crate::evidence::significance::Test;
use crate::outcome::outcome::Where;
use crate::samples::samples::Samples;
use crate::search::state::Explanation;
use ironout::effect::Follows;
use ironout::study::Model;

/// Bins of a shape.
const BINS: usize = 40;

/// Mean of `values` in equal bins of the order of `by`.
fn shape(by: &[f64], values: &[f64]) -> Vec<f64> {
    let low = by.iter().copied().fold(f64::INFINITY, f64::min);
    let high = by.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high <= low || !(high - low).is_finite() {
        return Vec::new();
    }
    let mut bins = [(0.0, 0.0); BINS];
    for (x, y) in by.iter().zip(values) {
        let bin = (((x - low) / (high - low)) * BINS as f64) as usize;
        let bin = &mut bins[bin.min(BINS - 1)];
        bin.0 += y;
        bin.1 += 1.0;
    }
    bins.iter().map(|(sum, count)| if *count > 0.0 { sum / count } else { f64::NAN }).collect()
}

/// How much of the base model's squared residual each cause explains, by the best of its candidates.
pub fn shows(
    samples: &Samples,
    residuals: &[f64],
    explanation: &Explanation,
    base: &Model<f64>,
) -> Vec<Where> {
    let best = |belongs: &dyn Fn(&Test) -> bool| -> (f64, f64) {
        let own = explanation.first.iter().filter(|one| belongs(one));
        own.map(|one| (one.share, (one.p_value * explanation.count as f64).min(1.0)))
            // Where numbers are so large that a test is none, it shows nothing.
            .filter(|(share, p_value)| !share.is_nan() && !p_value.is_nan())
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((0.0, 1.0))
    };
    let mut list = Vec::new();
    let n = samples.len();
    let one_a_sample = residuals.len() == n;
    let squares: Vec<f64> = residuals.iter().take(n).map(|r| r * r).collect();
    for column in samples.columns.iter().filter(|column| column.problem.is_none()) {
        let reads = |one: &Test| one.columns.contains(&column.name);
        let (explained, p_value) = best(&reads);
        let shape = if one_a_sample { root(shape(&column.values, &squares)) } else { Vec::new() };
        list.push(Where { against: column.name.clone(), explained, p_value, shape });
    }
    if let Some(time) = &samples.time {
        let (explained, p_value) = best(&|one| one.follows == Follows::Time);
        let shape = if one_a_sample { root(shape(time, &squares)) } else { Vec::new() };
        list.push(Where { against: "time".into(), explained, p_value, shape });
        let (explained, p_value) = best(&|one| one.follows == Follows::Tone);
        list.push(Where { against: "spectrum".into(), explained, p_value, shape: Vec::new() });
    }
    if one_a_sample {
        let (explained, p_value) = best(&|one| one.follows == Follows::Attitude);
        let z: Vec<f64> = samples
            .readings
            .iter()
            .map(|reading| {
                let v: [f64; 3] =
                    core::array::from_fn(|axis| reading.measured_ut[axis] - base.offset_ut[axis]);
                v[2] / v.iter().map(|value| value * value).sum::<f64>().sqrt()
            })
            .collect();
        list.push(Where { against: "attitude".into(), explained, p_value, shape: shape(&z, residuals) });
        let (explained, p_value) = best(&|one| one.follows == Follows::Turning);
        list.push(Where { against: "rate of turn".into(), explained, p_value, shape: Vec::new() });
    }
    list.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    list
}

fn root(bins: Vec<f64>) -> Vec<f64> {
    bins.into_iter().map(f64::sqrt).collect()
}
