//! The fits against an independent program: `oracle/oracle.py` (numpy, scipy) wrote `oracle/oracle.json`.

use ironout::fit::{FitOptions, FitReport, Method, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use serde_json::Value;

struct Case {
    name: String,
    value: Value,
    moments: Moments,
    ut_per_count: f64,
}

fn cases() -> Vec<Case> {
    let oracle: Value = serde_json::from_str(include_str!("../../oracle/oracle.json")).unwrap();
    let ut_per_count = 1.0 / oracle["counts_per_field"].as_f64().unwrap();
    oracle["cases"]
        .as_array()
        .unwrap()
        .iter()
        .map(|value| {
            let mut moments = Moments::new();
            for row in value["counts"].as_array().unwrap() {
                moments.push(std::array::from_fn(|a| row[a].as_i64().unwrap() as i16));
            }
            Case { name: value["name"].as_str().unwrap().into(), value: value.clone(), moments, ut_per_count }
        })
        .collect()
}

fn solve(case: &Case, method: Method) -> FitReport {
    let options = FitOptions { method, field_ut: Some(1.0), lower_orders: false, ..FitOptions::default() };
    fit(&Scatter::from_moments(&case.moments, [case.ut_per_count; 3]).unwrap(), &options).unwrap()
}

#[test]
fn every_method_is_the_independent_programs() {
    for case in cases() {
        for method in [Method::Constant, Method::Trace, Method::Adjusted] {
            let report = solve(&case, method);
            let oracle = &case.value["methods"][method.name()];
            let offset_error = (0..3)
                .map(|a| {
                    let right = oracle["offset"][a].as_f64().unwrap() * case.ut_per_count;
                    (report.calibration.offset_ut[a] - right).abs()
                })
                .fold(0.0, f64::max);
            let matrix_error = (0..9)
                .map(|i| {
                    let right = oracle["matrix"][i / 3][i % 3].as_f64().unwrap() / case.ut_per_count;
                    (report.calibration.matrix[i / 3][i % 3] - right).abs()
                })
                .fold(0.0, f64::max);
            println!("{} {}: b {offset_error:.1e}, C {matrix_error:.1e}", case.name, method.name());
            // Both programs round: with double precision there is nothing else between them.
            assert!(offset_error < 1e-8 && matrix_error < 1e-8, "{} {}", case.name, method.name());
        }
    }
}

#[test]
fn the_noise_is_the_independent_programs() {
    for case in cases() {
        let report = solve(&case, Method::Adjusted);
        let right = case.value["methods"]["adjusted"]["noise"].as_f64().unwrap() * case.ut_per_count;
        assert!((report.noise_ut / right - 1.0).abs() < 1e-5, "{}: {} {right}", case.name, report.noise_ut);
    }
}

#[test]
fn standard_errors_are_the_spread_of_many_logs() {
    for case in cases() {
        let report = solve(&case, Method::Adjusted);
        let (b, c) = (report.std_errors.offset_ut, report.std_errors.matrix);
        let predicted = [b[0], b[1], b[2], c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]];
        for (i, predicted) in predicted.iter().enumerate() {
            let unit = if i < 3 { case.ut_per_count } else { 1.0 / case.ut_per_count };
            let right = case.value["spread"][i].as_f64().unwrap() * unit;
            let ratio = predicted / right;
            println!("{} {i}: {ratio:.2}", case.name);
            // 200 logs know their own spread to 5 %; the prediction comes from one log's noise and directions.
            assert!((0.75..1.3).contains(&ratio), "{} {i}: {predicted} against {right}", case.name);
        }
    }
}
