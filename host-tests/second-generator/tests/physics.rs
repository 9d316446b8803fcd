//! Laws that the logs obey, checked from their columns and their truth.

use second_generator::linalg::{
    Span, Vec3, add_scaled, cross, inverse, mul_vec, norm, rms, rms_of_vectors, scale, sub, to_body,
};
use second_generator::{Drawn, Kind, Truth, draw};

/// Three columns as vectors.
fn vectors(drawn: &Drawn, names: [&str; 3]) -> Option<Vec<Vec3>> {
    let [x, y, z] = names.map(|name| drawn.column(name));
    let (x, y, z) = (x?, y?, z?);
    Some((0..x.len()).map(|i| [x[i], y[i], z[i]]).collect())
}

fn measured(drawn: &Drawn) -> Vec<Vec3> {
    vectors(drawn, ["mx_ut", "my_ut", "mz_ut"]).expect("every log has a magnetometer")
}

/// Columns whose cells may be empty.
fn has_gaps(truth: &Truth, name: &str) -> bool {
    truth.kind == "gaps" && truth.hidden[0].columns.iter().any(|c| c == name)
}

#[test]
fn every_kind_gives_complete_logs() {
    for kind in Kind::ALL {
        for number in 0..5 {
            let drawn = draw(kind, number);
            let truth = &drawn.truth;
            let n = truth.attitude.len();
            let label = format!("{} {number}", kind.name());
            for (name, values) in &drawn.columns {
                assert_eq!(values.len(), n, "{label} {name}");
                let finite = values.iter().filter(|v| v.is_finite()).count();
                if has_gaps(truth, name) {
                    assert!(finite > n / 50 && finite < n, "{label} {name}: {finite} of {n} cells");
                } else {
                    assert_eq!(finite, n, "{label} {name}");
                }
            }
            let mut names: Vec<&String> = drawn.columns.iter().map(|(name, _)| name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), drawn.columns.len(), "{label}: a name twice");
            let t = drawn.column("t_s").expect("every log has times");
            assert!(t.windows(2).all(|w| w[1] > w[0]), "{label}: times");
            assert!((1..=6).contains(&truth.decoys.len()), "{label}: {} decoys", truth.decoys.len());
            for h in &truth.hidden {
                let shown = h.columns.iter().all(|c| drawn.column(c).is_some());
                assert_eq!(shown, h.logged, "{label} {}", h.id);
            }
            assert_eq!(drawn.csv().lines().count(), n + 1);
            assert!(truth.json().ends_with("}\n"));
        }
    }
}

#[test]
fn a_log_depends_on_its_kind_and_number_alone() {
    let csv = draw(Kind::Two, 7).csv();
    assert_eq!(csv, draw(Kind::Two, 7).csv());
    assert_ne!(csv, draw(Kind::Two, 8).csv());
    assert_ne!(draw(Kind::White, 1).truth.matrix, draw(Kind::NothingWhite, 1).truth.matrix);
    draw(Kind::Quick, u64::MAX);
}

#[test]
fn without_noise_and_effects_the_true_calibration_gives_the_field() {
    for kind in Kind::ALL {
        let drawn = draw(kind, 11);
        let truth = &drawn.truth;
        let c = inverse(&truth.matrix);
        let disturbance = truth.disturbance_ut();
        let rest = measured(&drawn);
        let corrected = |i: usize| mul_vec(&c, sub(sub(rest[i], truth.offset_ut), disturbance[i]));
        let vectors: Vec<Vec3> = (0..rest.len()).map(corrected).collect();
        let errors = truth.vector_errors_ut(&vectors);
        let magnitudes: Vec<f64> = (0..rest.len()).map(|i| norm(corrected(i)) - truth.field_ut).collect();
        // Slow noise in a short log and heavy tails move the sample's rms.
        let limits = if truth.noise == "white" { [0.8, 1.3] } else { [0.3, 2.5] };
        let seen = rms_of_vectors(&errors) / 3.0_f64.sqrt() / truth.noise_ut;
        assert!(seen > limits[0] && seen < limits[1], "{} {}: {seen} of the noise", kind.name(), truth.noise);
        assert!(rms(&magnitudes) < 1.4 * limits[1] * truth.noise_ut, "{}", kind.name());
        let errors = truth.heading_errors_deg(&truth.field_body_ut);
        assert!(errors.iter().all(|e| e.abs() < 1e-9));
        assert!(truth.field_body_ut.iter().all(|&h| (norm(h) - truth.field_ut).abs() < 1e-9));
    }
}

#[test]
fn the_field_turns_against_the_gyro() {
    for kind in [Kind::Lag, Kind::Flight, Kind::Car, Kind::Boat, Kind::Quick] {
        let drawn = draw(kind, 3);
        let truth = &drawn.truth;
        let gyro = vectors(&drawn, ["gx_radps", "gy_radps", "gz_radps"]).expect("these kinds have a gyro");
        let t = drawn.column("t_s").expect("times");
        let (mut worst, mut sum) = (Vec::new(), Vec::new());
        for i in 1..t.len() - 1 {
            let step = 1.0 / (t[i + 1] - t[i - 1]);
            let change = scale(step, sub(truth.field_body_ut[i + 1], truth.field_body_ut[i - 1]));
            let law = scale(-1.0, cross(sub(gyro[i], truth.gyro_bias_radps), truth.field_body_ut[i]));
            worst.push(norm(sub(change, law)));
            sum.push(norm(change));
        }
        // The difference over two samples lags behind quick turns at low rates.
        let limit = 0.015 * truth.field_ut + rms(&sum) * if truth.rate_hz < 30.0 { 0.15 } else { 0.05 };
        assert!(rms(&worst) < limit, "{}: {} of {}", kind.name(), rms(&worst), rms(&sum));
    }
}

#[test]
fn a_resting_accelerometer_reads_minus_gravity_along_down() {
    let mut rests = 0;
    for number in 0..30 {
        let drawn = draw(Kind::One, number);
        let truth = &drawn.truth;
        let accel = vectors(&drawn, ["ax_mps2", "ay_mps2", "az_mps2"]);
        let (Some(accel), "JerkyHand") = (accel, truth.motion.as_str()) else { continue };
        for i in 1..truth.attitude.len() - 1 {
            if truth.attitude[i - 1] == truth.attitude[i] && truth.attitude[i] == truth.attitude[i + 1] {
                let expected = to_body(truth.attitude[i], [0.0, 0.0, -9.806_65]);
                let error = sub(sub(accel[i], truth.accel_bias_mps2), expected);
                assert!(norm(error) < 0.6, "{number} sample {i}: {error:?}");
                rests += 1;
            }
        }
    }
    assert!(rests > 100, "only {rests} samples at rest");
}

#[test]
fn strengths_are_as_stated() {
    for kind in [Kind::One, Kind::Strong, Kind::PlainOffset, Kind::Gain, Kind::Shape, Kind::Beyond, Kind::Lag]
    {
        for number in 20..23 {
            let drawn = draw(kind, number);
            let truth = &drawn.truth;
            let hidden = &truth.hidden[0];
            let label = format!("{} {number} {}", kind.name(), hidden.id);
            let [least, most] = match kind {
                Kind::Strong => [20.0, 60.0],
                Kind::One | Kind::Beyond => [1.5, 20.0],
                _ => [3.0, 10.0],
            };
            let stated = hidden.strength;
            assert!(stated > 0.99 * least && stated < 1.01 * most, "{label}: {stated}");
            let c = inverse(&truth.matrix);
            let disturbed =
                |i: usize| add_scaled(truth.field_body_ut[i], 1.0, mul_vec(&c, hidden.disturbance_ut[i]));
            let n = truth.field_body_ut.len();
            let change: Vec<f64> = if hidden.id == "lag" {
                let dip = |h: Vec3, i: usize| {
                    let down = to_body(truth.attitude[i], [0.0, 0.0, 1.0]);
                    (second_generator::linalg::dot(h, down) / norm(h)).asin()
                };
                (0..n).map(|i| truth.field_ut * (dip(disturbed(i), i) - truth.dip_deg.to_radians())).collect()
            } else {
                let magnitudes: Vec<f64> = (0..n).map(|i| norm(disturbed(i)) - truth.field_ut).collect();
                assert!(
                    (rms(&magnitudes) - hidden.magnitude_rms_ut).abs() < 1e-6 * truth.field_ut,
                    "{label}"
                );
                // What an offset and a symmetric matrix do to the magnitude, times the magnitude.
                let mut base = Vec::new();
                for a in 0..3 {
                    base.push(truth.field_body_ut.iter().map(|h| h[a]).collect::<Vec<f64>>());
                    for b in 0..=a {
                        base.push(truth.field_body_ut.iter().map(|h| h[a] * h[b]).collect());
                    }
                }
                Span::new(&base).project_out(&magnitudes)
            };
            let seen = rms(&change) / truth.noise_ut;
            assert!((seen / stated - 1.0).abs() < 1e-3, "{label}: {seen}, stated {stated}");
        }
    }
}

#[test]
fn noise_of_every_colour_has_the_stated_level() {
    let mut colours = std::collections::BTreeMap::new();
    for number in 0..40 {
        let drawn = draw(Kind::NothingColoured, number);
        let truth = &drawn.truth;
        assert!(truth.hidden.is_empty());
        let clean = |h: &Vec3| add_scaled(mul_vec(&truth.matrix, *h), 1.0, truth.offset_ut);
        let rest: Vec<Vec3> =
            measured(&drawn).iter().zip(&truth.field_body_ut).map(|(m, h)| sub(*m, clean(h))).collect();
        let ratio = rms_of_vectors(&rest) / 3.0_f64.sqrt() / truth.noise_ut;
        let word = truth.noise.split([' ', ',', ':']).next().unwrap_or_default().to_string();
        colours.entry(word).or_insert_with(Vec::new).push(ratio);
    }
    assert_eq!(colours.len(), 8, "{colours:?}");
    for (colour, ratios) in &colours {
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!(mean > 0.8 && mean < 1.2, "{colour}: {ratios:?}");
    }
}

#[test]
fn the_estimated_attitude_is_wrong_by_some_degrees() {
    for kind in [Kind::Flight, Kind::Car, Kind::Boat, Kind::Quick] {
        let drawn = draw(kind, 2);
        let q =
            ["q_w", "q_x", "q_y", "q_z"].map(|name| drawn.column(name).expect("vehicles log a quaternion"));
        let angle = |(i, true_q): (usize, &[f64; 4])| {
            let cosine: f64 = (0..4).map(|k| q[k][i] * true_q[k]).sum();
            2.0 * cosine.abs().min(1.0).acos().to_degrees()
        };
        let angles: Vec<f64> = drawn.truth.attitude.iter().enumerate().map(angle).collect();
        assert!(rms(&angles) > 0.2 && rms(&angles) < 6.0, "{}: {}", kind.name(), rms(&angles));
    }
}
