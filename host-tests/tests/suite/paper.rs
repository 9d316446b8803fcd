//! The paper's simulation: what each reading recovers, with and without noise.

use ironout::fit::{FitError, FitOptions, FitReport, Method, fit};
use ironout::moments::{Moments, Normalisation};
use ironout::scatter::{Scatter, ScatterBuilder};
use ironout_simulation::paper::{Sampler, Truth, eq_16};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

fn scatter(samples: &[[f64; 3]]) -> Scatter {
    let mut builder = ScatterBuilder::new(samples[0]);
    samples.iter().for_each(|s| builder.push(*s));
    builder.finish(0.0).unwrap()
}

/// Truth in a unit field from a report, as the paper states it: b and A = C⁻¹.
fn truth_of(report: &FitReport) -> Truth {
    let m = report.calibration.matrix;
    let c = Matrix3::from_fn(|r, k| m[r][k]);
    Truth { b: report.calibration.offset_ut.into(), a: c.try_inverse().unwrap() }
}

fn options(method: Method) -> FitOptions {
    FitOptions { method, field_ut: Some(1.0), ..FitOptions::default() }
}

const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

#[test]
fn noise_free_simulation_is_recovered_exactly() {
    let truth = eq_16();
    let samples = truth.samples(&mut Sampler::new(1), 500, 0.0, UP, 1.0);
    for method in [Method::Constant, Method::Trace, Method::Adjusted] {
        let report = fit(&scatter(&samples), &options(method)).unwrap();
        let error = (truth_of(&report).nine() - truth.nine()).amax();
        println!("{method:?}: largest error of b and A {error:.1e}");
        assert!(error < 1e-9, "{method:?}: {error:e}");
    }
}

#[test]
fn noise_free_simulation_through_16_bit_counts() {
    let truth = eq_16();
    let samples = truth.samples(&mut Sampler::new(2), 2000, 0.0, UP, 1.0);
    let step = 1.0 / 10_000.0;
    let mut moments = Moments::new();
    for s in &samples {
        moments.push(s.map(|v| (v / step).round() as i16));
    }
    for method in [Method::Constant, Method::Trace, Method::Adjusted] {
        let report = fit(&Scatter::from_moments(&moments, [step; 3]).unwrap(), &options(method)).unwrap();
        let error = (truth_of(&report).nine() - truth.nine()).amax();
        println!("{method:?}: largest error of b and A {error:.1e}");
        assert!(error < 1e-4, "{method:?}: {error:e}");
    }
}

#[test]
fn an_ellipsoid_through_the_origin_is_singular_for_the_constant_reading_only() {
    let mut truth = eq_16();
    // Move the offset onto the ellipsoid: b = −A u for a unit u.
    truth.b = -(truth.a * Vector3::new(0.6, 0.0, 0.8));
    let samples = truth.samples(&mut Sampler::new(3), 500, 0.0, UP, 1.0);
    let refused = fit(&scatter(&samples), &options(Method::Constant));
    assert!(matches!(refused, Err(FitError::ThroughOrigin { .. })), "{refused:?}");
    let report = fit(&scatter(&samples), &options(Method::Trace)).unwrap();
    assert!((truth_of(&report).nine() - truth.nine()).amax() < 1e-9);
}

/// Eq. (14) read literally: `Ĥ²` as the squared norm of the *measurement*. Then `x² + y² + z²` is itself a combination of
/// the nine columns, so `p = (1,0,1,0,1,0,0,0,0)` solves `Ĥ² = D p` without any error, whatever the data: with eqs. (11) and
/// (12), `C` is the identity and `b` is zero. The measurement is declared to be right and nothing is calibrated.
#[test]
fn eq_14_read_literally_calibrates_nothing() {
    for seed in 0..5 {
        let truth = Sampler::new(seed).mild_truth(0.3);
        let mut moments = Moments::new();
        for s in truth.samples(&mut Sampler::new(seed + 100), 400, 0.01, UP, 1.0) {
            moments.push(s.map(|v| (v * 4000.0).round() as i16));
        }
        let normal = moments.normal_matrix(Normalisation::Constant);
        // DᵀĤ² with Ĥ² = x² + y² + z² of the measurement, row by row from the same sums.
        let columns = [
            [2, 0, 0],
            [1, 0, 0],
            [0, 2, 0],
            [0, 1, 0],
            [0, 0, 2],
            [0, 0, 1],
            [1, 1, 0],
            [0, 1, 1],
            [1, 0, 1],
        ];
        let literal = SVector::<f64, 9>::from_fn(|row, _| {
            let [i, j, k] = columns[row];
            [[2, 0, 0], [0, 2, 0], [0, 0, 2]]
                .iter()
                .map(|[a, b, c]| moments.sum(i + a, j + b, k + c).unwrap())
                .sum::<i128>() as f64
        });
        let dtd = SMatrix::<f64, 9, 9>::from_fn(|r, c| normal.dtd[r][c]);
        // Unit diagonal, or the solve would drown in the counts' range.
        let unit = SVector::<f64, 9>::from_fn(|i, _| 1.0 / dtd[(i, i)].sqrt());
        let scaled = SMatrix::<f64, 9, 9>::from_fn(|r, c| dtd[(r, c)] * unit[r] * unit[c]);
        let p = scaled.cholesky().unwrap().solve(&literal.component_mul(&unit)).component_mul(&unit);
        let identity = SVector::<f64, 9>::from_column_slice(&[1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        // In units of the data: linear terms are compared over a field of 4000 counts.
        let weight = [1.0, 4e3, 1.0, 4e3, 1.0, 4e3, 1.0, 1.0, 1.0];
        for i in 0..9 {
            assert!(((p[i] - identity[i]) / weight[i]).abs() < 1e-6, "p{} = {}", i + 1, p[i]);
        }
    }
}

struct Sweep {
    over_bound: f64,
    noise_ratio: f64,
    inside_one_sigma: f64,
    refused: usize,
}

fn sweep(
    seeds: u64,
    n: usize,
    sigma: f64,
    fraction: f64,
    truth_of_seed: impl Fn(&mut Sampler) -> Truth,
) -> Sweep {
    let (mut over, mut noise, mut inside, mut count, mut refused) = (0.0, 0.0, 0usize, 0usize, 0);
    for seed in 0..seeds {
        let mut sampler = Sampler::new(1000 + seed);
        let truth = truth_of_seed(&mut sampler);
        let pole = sampler.direction(UP, 1.0);
        let samples = truth.samples(&mut sampler, n, sigma, pole, fraction);
        let options = FitOptions { lower_orders: false, ..options(Method::Adjusted) };
        let Ok(report) = fit(&scatter(&samples), &options) else {
            refused += 1;
            continue;
        };
        let estimate = truth_of(&report);
        over +=
            (estimate.nine() - truth.nine()).norm_squared() / truth.bound(n, sigma, pole, fraction).powi(2);
        noise += report.noise_ut / sigma;
        // δC against the predicted standard errors: C is what the report states.
        let c = truth.a.try_inverse().unwrap();
        for (i, v) in report.calibration.offset_ut.iter().enumerate() {
            inside += usize::from((v - truth.b[i]).abs() < report.std_errors.offset_ut[i]);
            count += 1;
        }
        for r in 0..3 {
            for k in r..3 {
                let off = (report.calibration.matrix[r][k] - c[(r, k)]).abs();
                inside += usize::from(off < report.std_errors.matrix[r][k]);
                count += 1;
            }
        }
    }
    let solved = (seeds as usize - refused) as f64;
    Sweep {
        over_bound: (over / solved).sqrt(),
        noise_ratio: noise / solved,
        inside_one_sigma: inside as f64 / count as f64,
        refused,
    }
}

#[test]
fn adjusted_reaches_the_bound_on_the_papers_simulation() {
    for (sigma, limit) in [(0.01, 1.12), (0.05, 1.20)] {
        for n in [500, 5000] {
            let s = sweep(200, n, sigma, 1.0, |_| eq_16());
            println!(
                "sigma {sigma} n {n}: {:.3} of the bound, noise {:.3}, inside 1 SE {:.2}",
                s.over_bound, s.noise_ratio, s.inside_one_sigma
            );
            assert_eq!(s.refused, 0);
            assert!(s.over_bound <= limit, "sigma {sigma}, n {n}: {}", s.over_bound);
            assert!((s.noise_ratio - 1.0).abs() < 0.02, "sigma {sigma}, n {n}: {}", s.noise_ratio);
        }
    }
}

#[test]
fn adjusted_reaches_the_bound_on_part_of_the_sphere() {
    let (mut inside, mut total) = (0.0, 0.0);
    for fraction in [0.7, 0.5, 0.35, 0.25] {
        let s = sweep(100, 2000, 0.01, fraction, |sampler| sampler.mild_truth(0.1));
        println!("cap {fraction}: {:.3} of the bound, inside 1 SE {:.2}", s.over_bound, s.inside_one_sigma);
        assert_eq!(s.refused, 0);
        assert!(s.over_bound <= 1.25, "cap {fraction}: {}", s.over_bound);
        inside += s.inside_one_sigma;
        total += 1.0;
    }
    let pooled = inside / total;
    assert!((0.60..=0.76).contains(&pooled), "{pooled} of the errors are inside one standard error");
}
