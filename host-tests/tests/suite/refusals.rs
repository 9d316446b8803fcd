//! What must not become a calibration, and says why; and what must, although it looks poor.

use ironout::fit::{FitError, FitOptions, Method, Order, fit};
use ironout::moments::Moments;
use ironout::quality::{Reason, Verdict, judge};
use ironout::scatter::{Scatter, ScatterBuilder};
use ironout::sensor::Sample;
use ironout::session::{Hint, Session, SessionConfig, State};
use ironout_simulation::paper::{Sampler, Truth};
use nalgebra::{Matrix3, Vector3};

const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);
const FIELD_UT: f64 = 50.0;

fn scatter(samples: &[[f64; 3]]) -> Result<Scatter, FitError> {
    let mut builder = ScatterBuilder::new(samples[0]);
    samples.iter().for_each(|s| builder.push(*s));
    builder.finish(0.0)
}

fn verdict(samples: &[[f64; 3]]) -> Verdict {
    let fitted = scatter(samples).and_then(|s| fit(&s, &FitOptions::default()));
    fitted.map_or_else(Verdict::of_error, |report| judge(&report, None, 0, None))
}

/// Samples in µT over a cap about the vertical.
fn samples(truth: &Truth, seed: u64, n: usize, sigma: f64, fraction: f64) -> Vec<[f64; 3]> {
    let unit = truth.samples(&mut Sampler::new(seed), n, sigma, UP, fraction);
    unit.into_iter().map(|s| s.map(|v| v * FIELD_UT)).collect()
}

fn mild(seed: u64) -> Truth {
    Sampler::new(seed).mild_truth(0.1)
}

#[test]
fn a_cap_of_a_seventh_of_the_sphere_is_refused_for_its_predicted_error() {
    for seed in 0..40 {
        let v = verdict(&samples(&mild(seed), seed, 2000, 0.01, 0.15));
        assert!(!v.accepted, "seed {seed}");
        let named = v.reasons.iter().any(|r| {
            matches!(r, Reason::ErrorTooLarge { percent, .. } if *percent > 1.0)
                || matches!(r, Reason::Fit(FitError::NotAnEllipsoid))
        });
        assert!(named, "seed {seed}: {:?}", v.reasons);
    }
}

#[test]
fn the_whole_sphere_is_accepted() {
    for seed in 0..40 {
        let v = verdict(&samples(&mild(seed), seed, 1000, 0.01, 1.0));
        assert!(v.accepted, "seed {seed}: {:?}", v.reasons);
    }
}

#[test]
fn a_turn_about_one_axis_is_planar() {
    for seed in 0..20 {
        let truth = mild(seed);
        let mut sampler = Sampler::new(seed);
        let flat: Vec<[f64; 3]> = (0..1000)
            .map(|i| {
                let angle = f64::from(i) * 0.05;
                let wobble = sampler.normal() * 0.02;
                let u = Vector3::new(0.4 * angle.cos(), 0.4 * angle.sin(), 0.9 + wobble).normalize();
                ((truth.a * u + truth.b + sampler.normal3() * 0.005) * FIELD_UT).into()
            })
            .collect();
        let v = verdict(&flat);
        assert!(!v.accepted);
        assert!(matches!(v.reasons[0], Reason::Fit(FitError::Planar { .. })), "{:?}", v.reasons);
    }
}

#[test]
fn stuck_and_copied_axes_are_named() {
    let data = samples(&mild(1), 1, 500, 0.01, 1.0);
    let broken = |change: fn([f64; 3]) -> [f64; 3]| {
        let data: Vec<[f64; 3]> = data.iter().map(|s| change(*s)).collect();
        fit(&scatter(&data).unwrap(), &FitOptions::default()).unwrap_err()
    };
    assert_eq!(broken(|[x, _, z]| [x, 7.0, z]), FitError::StuckAxis { axis: 1 });
    assert_eq!(broken(|[x, y, _]| [x, y, -y]), FitError::CopiedAxis { axis: 2, of: 1 });
    assert_eq!(broken(|[x, y, _]| [x, y, x]), FitError::CopiedAxis { axis: 2, of: 0 });
    let resting = vec![[1.0, 2.0, 3.0]; 100];
    assert!(matches!(scatter(&resting), Err(FitError::StuckAxis { .. })));
}

#[test]
fn shapes_no_magnetometer_has_are_refused() {
    let far = Truth { b: Vector3::new(25.0, 0.0, 0.0), a: Matrix3::identity() };
    let error =
        fit(&scatter(&samples(&far, 1, 500, 0.001, 1.0)).unwrap(), &FitOptions::default()).unwrap_err();
    assert!(matches!(error, FitError::OffsetTooLarge { fields } if (fields - 25.0).abs() < 0.2), "{error:?}");

    let long = Truth { b: Vector3::zeros(), a: Matrix3::from_diagonal(&Vector3::new(9.0, 1.0, 1.0)) };
    let error =
        fit(&scatter(&samples(&long, 1, 500, 0.001, 1.0)).unwrap(), &FitOptions::default()).unwrap_err();
    assert!(matches!(error, FitError::AxisRatio { ratio } if (ratio - 9.0).abs() < 0.2), "{error:?}");
}

#[test]
fn input_that_is_no_number_is_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut data = samples(&mild(1), 1, 500, 0.01, 1.0);
        data[77][1] = bad;
        assert_eq!(scatter(&data).unwrap_err(), FitError::NotFinite);
        let good = scatter(&samples(&mild(1), 1, 500, 0.01, 1.0)).unwrap();
        let options = FitOptions { field_ut: Some(bad), ..FitOptions::default() };
        assert_eq!(fit(&good, &options).unwrap_err(), FitError::NotFinite);
        assert_eq!(Scatter::from_moments(&Moments::new(), [0.1, bad, 0.1]).unwrap_err(), FitError::NotFinite);
    }
    let few = fit(&scatter(&samples(&mild(1), 1, 19, 0.01, 1.0)).unwrap(), &FitOptions::default());
    assert_eq!(few.unwrap_err(), FitError::TooFewSamples { samples: 19 });
}

/// Where the data do not carry nine parameters, fewer are fitted, by evidence; and the verdict still knows what was left out.
#[test]
fn lower_orders_are_chosen_by_evidence_and_judged_with_what_they_leave_out() {
    let hard_iron_only = Truth { b: Vector3::new(0.4, -0.3, 0.2), a: Matrix3::identity() };
    let mut spheres = 0;
    let mut improved = 0;
    for seed in 0..50 {
        let data = samples(&hard_iron_only, seed, 60, 0.02, 0.3);
        let full =
            fit(&scatter(&data).unwrap(), &FitOptions { lower_orders: false, ..FitOptions::default() });
        let chosen = fit(&scatter(&data).unwrap(), &FitOptions::default()).unwrap();
        let error = |offset: [f64; 3]| (Vector3::from(offset) - hard_iron_only.b * FIELD_UT).norm();
        let full_error = full.map_or(f64::INFINITY, |r| error(r.calibration.offset_ut));
        spheres += usize::from(chosen.model == Order::Sphere);
        improved += usize::from(error(chosen.calibration.offset_ut) <= full_error);
        assert!(!judge(&chosen, None, 0, None).accepted, "a cap and 60 samples say nothing of the soft iron");
    }
    assert!(spheres >= 45, "sphere chosen in {spheres} of 50");
    assert!(improved >= 40, "at least as good an offset in {improved} of 50");
    // With a soft iron that the data show, the evidence is for nine.
    let bent = Truth { a: Matrix3::new(1.2, 0.15, -0.1, 0.0, 0.9, 0.1, 0.0, 0.0, 1.0), ..hard_iron_only };
    let report = fit(&scatter(&samples(&bent, 3, 200, 0.02, 0.6)).unwrap(), &FitOptions::default()).unwrap();
    assert_eq!(report.model, Order::Ellipsoid);
}

fn session() -> Session {
    let mut session = Session::new(SessionConfig {
        ut_per_count: [0.1; 3],
        field_ut: Some(FIELD_UT),
        method: Method::Adjusted,
        samples_per_block: 16,
        axes: None,
    });
    session.start();
    session
}

fn counts(sample: [f64; 3]) -> [i16; 3] {
    sample.map(|v| (v / 0.1).round() as i16)
}

#[test]
fn a_railed_axis_is_refused_with_the_remedy() {
    let mut session = session();
    for s in samples(&mild(2), 2, 1000, 0.01, 1.0) {
        let c = counts(s);
        session.push(if c[2].abs() > 400 { Sample::out_of_range(c) } else { Sample::valid(c) });
    }
    let outcome = session.stop().unwrap();
    assert!(!outcome.verdict.accepted);
    let railed = outcome.verdict.reasons.iter().find(|r| r.code() == "saturated").expect("named");
    assert!(railed.to_string().contains("wider range"), "{railed}");
    assert_eq!(session.state(), State::Refused);
    assert!(session.accept().is_err());
}

#[test]
fn status_leads_through_a_calibration() {
    let mut session = session();
    assert_eq!(session.status().hint, Hint::Move);
    let data = samples(&mild(3), 3, 2000, 0.005, 1.0);
    // First only the upper half, then everything.
    for s in data.iter().filter(|s| s[2] > mild(3).b[2] * FIELD_UT).take(300) {
        session.push(Sample::valid(counts(*s)));
    }
    let half = session.status();
    assert!(half.coverage < 0.7 && half.gap_deg > 60.0, "{half:?}");
    assert!(matches!(half.hint, Hint::Turn { missing, .. } if missing.contains("top")), "{half:?}");
    for s in &data {
        session.push(Sample::valid(counts(*s)));
    }
    let all = session.status();
    assert!(all.coverage > 0.9 && all.gap_deg < 40.0, "{all:?}");
    assert_eq!(all.hint, Hint::Stop);
    assert!(session.stop().unwrap().verdict.accepted);
    assert_eq!(session.status().hint, Hint::Accept);
    assert!(session.accept().unwrap().calibration.is_sound());
    assert_eq!(session.status().state, State::Idle);
}
