//! What must hold for any data: a fit moves with its data, a correction undoes its distortion, and whatever comes in is
//! refused or answered, never a panic and never a NaN.

use ironout::calibration::Calibration;
use ironout::coverage::Sketch;
use ironout::fit::{FitOptions, FitReport, Method, fit};
use ironout::moments::Moments;
use ironout::scatter::{Scatter, ScatterBuilder};
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig};
use ironout_simulation::paper::Sampler;
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

const METHODS: [Method; 3] = [Method::Constant, Method::Trace, Method::Adjusted];

fn method() -> impl Strategy<Value = Method> {
    (0usize..3).prop_map(|i| METHODS[i])
}

/// Samples of a board that was turned well, in a unit field, and an offset that keeps the constant method away from its
/// singular place.
fn good(seed: u64, n: usize) -> Vec<[f64; 3]> {
    let mut sampler = Sampler::new(seed);
    let mut truth = sampler.mild_truth(0.15);
    truth.b = truth.b.normalize() * sampler.uniform(0.1, 0.6);
    let pole = sampler.direction(Vector3::z(), 1.0);
    let fraction = sampler.uniform(0.5, 1.0);
    truth.samples(&mut sampler, n, 0.01, pole, fraction)
}

fn solve(samples: &[[f64; 3]], method: Method) -> FitReport {
    let mut builder = ScatterBuilder::new(samples[0]);
    samples.iter().for_each(|s| builder.push(*s));
    let options = FitOptions { method, lower_orders: false, ..FitOptions::default() };
    fit(&builder.finish(0.0).unwrap(), &options).unwrap()
}

/// Offset and `Q = CᵀC` over F², which know nothing of the gauge of `C`.
fn shape(report: &FitReport) -> (Vector3<f64>, Matrix3<f64>) {
    let c = Matrix3::from_fn(|r, k| report.calibration.matrix[r][k]) / report.calibration.field_ut;
    (report.calibration.offset_ut.into(), c.transpose() * c)
}

fn close(a: &Matrix3<f64>, b: &Matrix3<f64>, tolerance: f64) -> bool {
    (a - b).amax() <= tolerance * a.amax().max(b.amax())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn a_fit_turns_with_its_data(seed in 0u64..1 << 40, angles in prop::array::uniform3(-3.0f64..3.0), method in method()) {
        let samples = good(seed, 300);
        let r = *Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).matrix();
        let turned: Vec<[f64; 3]> = samples.iter().map(|s| (r * Vector3::from(*s)).into()).collect();
        let ((b, q), (bt, qt)) = (shape(&solve(&samples, method)), shape(&solve(&turned, method)));
        prop_assert!((r * b - bt).amax() < 2e-5, "{b} {bt}");
        prop_assert!(close(&(r * q * r.transpose()), &qt, 2e-5), "{q} {qt}");
    }

    #[test]
    fn a_fit_scales_with_its_data(seed in 0u64..1 << 40, log10 in -3.0f64..4.0, method in method()) {
        let samples = good(seed, 300);
        let k = 10f64.powf(log10);
        let scaled: Vec<[f64; 3]> = samples.iter().map(|s| s.map(|v| v * k)).collect();
        let (one, other) = (solve(&samples, method), solve(&scaled, method));
        let ((b, q), (bk, qk)) = (shape(&one), shape(&other));
        prop_assert!((b * k - bk).amax() < 2e-5 * k);
        prop_assert!(close(&(q / (k * k)), &qk, 2e-5));
        for (value, scaled) in [
            (one.noise_ut, other.noise_ut),
            (one.rms_ut, other.rms_ut),
            (one.predicted_error_ut, other.predicted_error_ut),
            (one.measured_field_ut, other.measured_field_ut),
            (one.std_errors.offset_ut[1], other.std_errors.offset_ut[1]),
        ] {
            prop_assert!((value * k / scaled - 1.0).abs() < 1e-3, "{value} {scaled}");
        }
    }

    #[test]
    fn a_fit_does_not_care_which_axis_is_which(seed in 0u64..1 << 40, order in 0usize..6, method in method()) {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let p = ORDERS[order];
        let samples = good(seed, 300);
        let permuted: Vec<[f64; 3]> = samples.iter().map(|s| p.map(|a| s[a])).collect();
        let ((b, q), (bp, qp)) = (shape(&solve(&samples, method)), shape(&solve(&permuted, method)));
        for i in 0..3 {
            prop_assert!((b[p[i]] - bp[i]).abs() < 2e-5);
            for j in 0..3 {
                prop_assert!((q[(p[i], p[j])] - qp[(i, j)]).abs() < 5e-5);
            }
        }
    }

    #[test]
    fn trace_and_adjusted_move_with_their_data(seed in 0u64..1 << 40, by in prop::array::uniform3(-3.0f64..3.0)) {
        let samples = good(seed, 300);
        let moved: Vec<[f64; 3]> = samples.iter().map(|s| std::array::from_fn(|a| s[a] + by[a])).collect();
        for method in [Method::Trace, Method::Adjusted] {
            let ((b, q), (bm, qm)) = (shape(&solve(&samples, method)), shape(&solve(&moved, method)));
            prop_assert!((b + Vector3::from(by) - bm).amax() < 2e-5);
            prop_assert!(close(&q, &qm, 2e-5));
        }
    }

    #[test]
    fn correcting_undoes_distorting(
        offset_ut in prop::array::uniform3(-400.0f64..400.0),
        diagonal in prop::array::uniform3(0.2f64..5.0),
        upper in prop::array::uniform3(-0.8f64..0.8),
        angles in prop::array::uniform3(-3.0f64..3.0),
        field in prop::array::uniform3(-80.0f64..80.0),
    ) {
        let [x, y, z] = diagonal;
        let [xy, xz, yz] = upper;
        // Turned to an accelerometer: a full matrix.
        let turned = *Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).matrix()
            * Matrix3::new(x, xy, xz, 0.0, y, yz, 0.0, 0.0, z);
        let matrix = std::array::from_fn(|i| std::array::from_fn(|j| turned[(i, j)]));
        let calibration = Calibration { offset_ut, matrix, field_ut: 50.0 };
        let back = calibration.apply(calibration.distort(field).unwrap());
        for axis in 0..3 {
            prop_assert!((back[axis] - field[axis]).abs() < 1e-9, "{back:?} {field:?}");
        }
    }
}

/// Every number a report shows.
fn check(report: &FitReport) {
    let cal = &report.calibration;
    let numbers = cal
        .offset_ut
        .iter()
        .chain(cal.matrix.iter().flatten())
        .chain(report.std_errors.offset_ut.iter())
        .chain(report.std_errors.matrix.iter().flatten())
        .chain([
            &cal.field_ut,
            &report.noise_ut,
            &report.residual_floor_ut,
            &report.rms_ut,
            &report.predicted_error_ut,
            &report.axis_ratio,
            &report.measured_field_ut,
            &report.effective_samples,
            &report.condition_number,
        ]);
    for (place, value) in numbers.enumerate() {
        assert!(value.is_finite(), "number {place} is {value}: {report:?}");
    }
    assert!(report.spread.covariance().iter().flatten().all(|v| v.is_finite()), "{report:?}");
    assert!(report.noise_ut >= 0.0 && report.predicted_error_ut >= 0.0 && cal.field_ut > 0.0);
}

/// Counts as they come from broken or unlucky sensors: anything, few values, a plane, a line, a constant axis, copies.
fn odd_counts() -> impl Strategy<Value = Vec<[i16; 3]>> {
    let any_counts = prop::collection::vec(prop::array::uniform3(any::<i16>()), 0..120);
    let small = prop::collection::vec(prop::array::uniform3(-3i16..4), 0..200);
    let extremes = prop::collection::vec(
        prop::array::uniform3(prop_oneof![Just(i16::MIN), Just(i16::MAX), Just(0i16), Just(1)]),
        0..60,
    );
    (prop_oneof![any_counts, small, extremes], 0u8..7).prop_map(|(mut counts, change)| {
        for [x, y, z] in &mut counts {
            match change {
                1 => *z = 77,
                2 => *z = *y,
                3 => *z = x.wrapping_neg(),
                4 => (*y, *z) = (*x, *x),
                5 => *z = x.saturating_add(*y),
                6 => (*x, *y, *z) = (*x % 2, *y % 2, *z % 2),
                _ => {}
            }
        }
        counts
    })
}

/// Floats as they come from files: of any size, and none at all.
fn odd_float() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -100.0f64..100.0,
        1 => any::<f64>(),
        1 => prop_oneof![
            Just(0.0),
            Just(-0.0),
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(f64::NEG_INFINITY),
            Just(f64::MIN_POSITIVE / 8.0),
            Just(f64::MAX),
            Just(1e-300),
            Just(1e150)
        ],
    ]
}

fn odd_options() -> impl Strategy<Value = FitOptions> {
    (method(), prop::option::of(odd_float()), prop::option::of(odd_float()), any::<bool>()).prop_map(
        |(method, field_ut, effective_samples, lower_orders)| FitOptions {
            method,
            field_ut,
            effective_samples,
            lower_orders,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn any_counts_are_refused_or_answered(
        counts in odd_counts(),
        scale in prop_oneof![3 => Just([0.1; 3]), 1 => prop::array::uniform3(odd_float())],
        options in odd_options(),
    ) {
        let mut moments = Moments::new();
        counts.iter().for_each(|c| moments.push(*c));
        let solved = Scatter::from_moments(&moments, scale).and_then(|s| Ok((fit(&s, &options)?, s)));
        if let Ok((mut report, scatter)) = solved {
            check(&report);
            report.add_noise_bias(&scatter);
            check(&report);
        } else if let Err(error) = solved {
            prop_assert!(!error.to_string().contains("NaN") || !error.code().is_empty());
        }
    }

    #[test]
    fn any_floats_are_refused_or_answered(
        centre in prop::array::uniform3(odd_float()),
        samples in prop::collection::vec(prop::array::uniform3(odd_float()), 0..60),
        tame in any::<bool>(),
        seed in any::<u64>(),
        unit in -160.0f64..160.0,
        options in odd_options(),
        quantum in odd_float(),
    ) {
        // Half of the cases are a good log in an odd unit, so that there is something to answer.
        let k = 10f64.powf(unit);
        let samples = if tame { good(seed, 60).iter().map(|s| s.map(|v| v * k)).collect() } else { samples };
        let centre = if tame { samples[0] } else { centre };
        let mut builder = ScatterBuilder::new(centre);
        samples.iter().for_each(|s| builder.push(*s));
        if let Ok(scatter) = builder.finish(quantum)
            && let Ok(report) = fit(&scatter, &options)
        {
            check(&report);
        }
    }
}

/// What whoever owns a session may call.
#[derive(Clone, Debug)]
enum Call {
    Start,
    Push(Vec<[i16; 3]>, bool),
    Turn(u64, usize),
    Stop,
    Accept,
    Cancel,
    Status,
    Method(Method),
    Field(Option<f64>),
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        2 => Just(Call::Start),
        3 => (odd_counts(), any::<bool>()).prop_map(|(c, s)| Call::Push(c, s)),
        3 => (any::<u64>(), 10usize..400).prop_map(|(seed, n)| Call::Turn(seed, n)),
        2 => Just(Call::Stop),
        1 => Just(Call::Accept),
        1 => Just(Call::Cancel),
        2 => Just(Call::Status),
        1 => method().prop_map(Call::Method),
        1 => prop::option::of(odd_float()).prop_map(Call::Field),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn a_session_survives_any_calls(
        calls in prop::collection::vec(call(), 0..25),
        scale in prop_oneof![3 => Just([0.1; 3]), 1 => prop::array::uniform3(odd_float())],
        field_ut in prop::option::of(odd_float()),
        samples_per_block in any::<u16>(),
        method in method(),
    ) {
        let mut session = Session::new(SessionConfig {
            ut_per_count: scale,
            field_ut,
            method,
            samples_per_block,
            axes: None,
        });
        for call in calls {
            match call {
                Call::Start => session.start(),
                Call::Push(counts, saturated) => counts.iter().for_each(|c| {
                    session.push(if saturated { Sample::out_of_range(*c) } else { Sample::valid(*c) });
                }),
                Call::Turn(seed, n) => {
                    for s in good(seed, n) {
                        session.push(Sample::valid(s.map(|v| (v * 500.0).round() as i16)));
                    }
                }
                Call::Stop => {
                    if let Ok(outcome) = session.stop() {
                        prop_assert!(!outcome.verdict.accepted || outcome.report.is_some());
                        prop_assert!(outcome.verdict.accepted || !outcome.verdict.reasons.is_empty());
                        prop_assert!(outcome.coverage.fraction.is_finite() && outcome.coverage.gap_deg.is_finite());
                        outcome.report.iter().for_each(check);
                    }
                }
                Call::Accept => {
                    if let Ok(record) = session.accept() {
                        prop_assert!(record.calibration.is_sound(), "{record:?}");
                    }
                }
                Call::Cancel => session.cancel(),
                Call::Status => {
                    let status = session.status();
                    prop_assert!((0.0..=1.0).contains(&status.coverage), "{status:?}");
                    prop_assert!((0.0..=180.0).contains(&status.gap_deg), "{status:?}");
                    prop_assert!(status.rms_ut.is_none_or(f64::is_finite) && status.noise_ut.is_none_or(f64::is_finite));
                    let hint = status.hint.to_string();
                    prop_assert!(!hint.is_empty());
                }
                Call::Method(method) => session.set_method(method),
                Call::Field(field_ut) => {
                    session.set_field_ut(field_ut);
                }
            }
        }
    }

    #[test]
    fn a_sketch_takes_any_counts(counts in odd_counts(), scale in prop::array::uniform3(any::<f32>())) {
        let mut sketch = Sketch::new(scale);
        counts.iter().for_each(|c| sketch.add(*c));
        let coverage = sketch.coverage_about_middle(scale);
        prop_assert!((0.0..=1.0).contains(&coverage.fraction));
        prop_assert!((0.0..=180.0).contains(&coverage.gap_deg));
    }
}
