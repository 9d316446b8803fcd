//! The live correction against the study's model, and what it refuses.

use super::{Conditions, ExtendedCalibration, FittedEffect, Live, MAX_EFFECTS, NotCorrected};
use crate::calibration::Calibration;
use crate::effect::{AmbientField, BuiltIn, ColumnName, Eddy, Effect, Gain, Offset, Quantities, Shape};
use crate::model::{Model, Observation, Term};
use core::fmt;

fn fitted(effect: BuiltIn<f64>, size: f64) -> FittedEffect<f64> {
    FittedEffect {
        effect,
        coefficients: core::array::from_fn(|i| size * (1.0 - 0.3 * i as f64)),
        std_errors: [0.0; 9],
    }
}

#[test]
fn the_study_and_the_correction_mean_the_same() {
    let rotation = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let matrix = [[1.1, 0.1, -0.05], [0.0, 0.9, 0.2], [0.0, 0.0, 1.05]];
    let model = Model::new([12.0, -7.0, 3.0], matrix, 50.0, rotation, 0.5).unwrap();
    let column = ColumnName::new("u").unwrap();
    let effects = [
        fitted(BuiltIn::Field(AmbientField { column, reference: 1.0 }), 0.05),
        fitted(BuiltIn::Eddy(Eddy), 0.02),
        fitted(BuiltIn::Gain(Gain { column, reference: 1.0 }), 0.01),
        fitted(BuiltIn::Offset(Offset::linear(column, 1.0)), 2.0),
    ];
    let calibration = ExtendedCalibration::from_model(&model, &effects).unwrap();
    let (turn, measured) = ([0.5, -1.5, 2.0], [40.0, -30.0, 18.0]);
    let conditions = Conditions { turn_radps: Some(turn), inputs: [[3.0, 0.0]; MAX_EFFECTS] };
    let here = calibration.apply(measured, &conditions).unwrap();
    let terms: [Term<'_, f64>; 4] = core::array::from_fn(|i| Term {
        effect: &effects[i].effect,
        coefficients: effects[i].coefficients,
        inputs: [3.0, 0.0],
    });
    let reading = Observation { measured_ut: measured, turn_radps: Some(turn), down: None };
    let there = model.correct(&reading, &terms).unwrap();
    for axis in 0..3 {
        assert!((here[axis] - there[axis]).abs() < 1e-12, "{here:?} against {there:?}");
    }
    // And at work, where columns come by name.
    let mut live = Live::new(&calibration).unwrap();
    assert_eq!(live.waits_for(), Some("u"));
    assert_eq!(live.apply(measured, Some(turn)), Err(NotCorrected::Column(0)));
    assert!(live.set("u", 3.0) && !live.set("v", 3.0));
    assert_eq!(live.apply(measured, None), Err(NotCorrected::RateOfTurn(1)));
    assert_eq!(live.apply(measured, Some(turn)), Ok(here));
    live.set("u", f64::NAN);
    assert_eq!(live.apply(measured, Some(turn)), Err(NotCorrected::Column(0)));
}

#[derive(Clone, Copy)]
struct Broken;

impl Effect<f64> for Broken {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("broken")
    }
    fn name(&self) -> &'static str {
        "broken"
    }
    fn explanation(&self) -> &'static str {
        "A shape that is not finite."
    }
    fn coefficients(&self) -> usize {
        1
    }
    fn unit(&self) -> &'static str {
        "uT"
    }
    fn shape(&self, _: &Quantities<f64>, shape: &mut Shape<f64>) {
        shape[0] = [f64::NAN; 3];
    }
}

#[test]
fn an_effect_that_is_not_finite_is_named_and_so_is_a_vector() {
    let mut calibration = ExtendedCalibration::<f64, Broken>::plain(Calibration::identity(50.0));
    let broken = FittedEffect { effect: Broken, coefficients: [1.0; 9], std_errors: [0.0; 9] };
    calibration.effects.push(broken).ok().unwrap();
    let live = Live::new(&calibration).unwrap();
    assert_eq!(live.apply([1.0, 2.0, 3.0], None), Err(NotCorrected::Shape(0)));
    assert_eq!(live.apply([1.0, f64::NAN, 3.0], None), Err(NotCorrected::NotFinite));
    for _ in 0..3 {
        calibration.effects.push(broken).ok().unwrap();
    }
    assert!(calibration.effects.push(broken).is_err(), "four at most");
}

#[test]
fn a_clock_of_its_own_keeps_what_a_single_would_lose() {
    let mut calibration = ExtendedCalibration::plain(Calibration::identity(50.0));
    // Seconds since 1970: a single counts them in steps of 128.
    let start_s = 1.7e9;
    let hum = crate::effect::Periodic { frequency_hz: 12.5, reference_s: start_s };
    calibration.effects.push(fitted(BuiltIn::Periodic(hum), 1.0)).unwrap();
    let (own, origin_s) = calibration.on_own_clock();
    let mut live = Live::new(&own.cast::<f32>()).unwrap();
    let mut conditions = Conditions::unknown();
    for i in 0..50 {
        let now_s = start_s + f64::from(i) * 0.013;
        live.advance(now_s - origin_s);
        conditions.inputs[0][0] = now_s;
        let board = live.apply([10.0, 20.0, 30.0], None).unwrap();
        let here = calibration.apply([10.0, 20.0, 30.0], &conditions).unwrap();
        for axis in 0..3 {
            assert!((f64::from(board[axis]) - here[axis]).abs() < 1e-4, "{board:?} {here:?}");
        }
    }
}
