//! The live correction against the study's model, and what it refuses.

use super::{Conditions, ExtendedCalibration, FittedEffect, Live, MAX_EFFECTS, NotCorrected};
use crate::calibration::Calibration;
use crate::effect::{
    AmbientField, Bends, BuiltIn, ColumnName, CrossAxis, Eddy, Effect, Gain, Lag, Nonlinearity, Offset, Past,
    Product, Quantities, Shape,
};
use crate::model::{Model, Observation, Residual, Term};
use crate::vector::{minus, norm, plus, times, turned};
use core::fmt;

fn fitted(effect: BuiltIn<f64>, size: f64) -> FittedEffect<f64> {
    FittedEffect::new(effect, core::array::from_fn(|i| size * (1.0 - 0.3 * i as f64)), [0.0; 9])
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
        bends: effects[i].bends,
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

#[test]
fn a_product_waits_for_both_of_its_columns() {
    let columns = ColumnName::new("servo*current_a").unwrap();
    let mut calibration = ExtendedCalibration::plain(Calibration::identity(50.0));
    calibration.effects.push(fitted(BuiltIn::Product(Product { columns, reference: 30.0 }), 0.5)).unwrap();
    let mut live = Live::new(&calibration).unwrap();
    assert!(live.set("servo", 34.0) && !live.set("servo*current_a", 1.0));
    assert_eq!(live.waits_for(), Some("current_a"));
    assert!(live.set("current_a", 2.0));
    let corrected = live.apply([20.0, 5.0, -40.0], None).unwrap();
    // (34 − 30) · 2 times the coefficients 0.5, 0.35, 0.2.
    let expected = [16.0, 2.2, -41.6];
    assert!((0..3).all(|axis| (corrected[axis] - expected[axis]).abs() < 1e-12), "{corrected:?}");
}

#[test]
fn a_column_is_outside_beyond_the_ends_of_its_range_and_not_at_them() {
    let column = |name| ColumnName::new(name).unwrap();
    let heat = fitted(BuiltIn::Offset(Offset::linear(column("temp_c"), 25.0)), 0.1);
    let late = Offset { past: Past::Delayed(0.5), ..Offset::linear(column("current_a"), 0.0) };
    let mut calibration = ExtendedCalibration::plain(Calibration::identity(50.0));
    calibration.effects.push(heat.over([Some([10.1, 35.7]), None])).unwrap();
    calibration.effects.push(fitted(BuiltIn::Offset(late), 0.1).over([Some([-1.0, 4.0]), None])).unwrap();
    // Of this one it is not known, and nothing is told.
    calibration
        .effects
        .push(fitted(BuiltIn::Gain(Gain { column: column("temp_c"), reference: 1.0 }), 0.1))
        .unwrap();
    let mut live = Live::new(&calibration.cast::<f32>()).unwrap();
    assert_eq!(live.outside().count(), 0, "nothing is known yet");
    for (temp_c, distance) in
        [(10.1, 0.0), (35.7, 0.0), (20.0, 0.0), (10.0, 0.1), (36.0, 0.3), (f32::NAN, 0.0)]
    {
        live.set("temp_c", temp_c);
        let found: Option<super::Outside<'_, f32>> = live.outside().next();
        let far = found.map_or(0.0, |one| one.distance());
        assert!((far - distance).abs() < 1e-5 && found.is_some() == (distance > 0.0), "{temp_c}: {found:?}");
        assert!(found.is_none_or(|one| (one.effect, one.input, one.column) == (0, 0, "temp_c")));
    }
    // A late column is outside when its value acts.
    live.set("temp_c", 20.0);
    for (now_s, current_a, outside) in
        [(0.0, 1.0, false), (0.5, 9.0, false), (0.75, 9.0, true), (1.5, 1.0, true)]
    {
        live.set("current_a", current_a);
        live.advance(now_s);
        let found = live.outside().next();
        assert_eq!(found.is_some(), outside, "{now_s}: {found:?}");
        assert!(found.is_none_or(|one| (one.effect, one.column, one.nearest()) == (1, "current_a", 4.0)));
    }
}

#[test]
fn the_time_is_outside_by_the_clock_and_not_by_its_phase() {
    let start_s = 1.7e9;
    let hum = crate::effect::Periodic { frequency_hz: 12.5, reference_s: start_s };
    let mut calibration = ExtendedCalibration::plain(Calibration::identity(50.0));
    let range = [Some([start_s - 5.0, start_s + 60.0]), None];
    calibration.effects.push(fitted(BuiltIn::Periodic(hum), 1.0).over(range)).unwrap();
    let (own, origin_s) = calibration.on_own_clock();
    let mut live = Live::new(&own.cast::<f32>()).unwrap();
    for (past_s, distance_s) in [(-6.0, 1.0), (-5.0, 0.0), (60.0, 0.0), (60.5, 0.5), (3660.0, 3600.0)] {
        live.advance(start_s + past_s - origin_s);
        let far = live.outside().next().map_or(0.0, |one| one.distance());
        assert!((far - distance_s).abs() < 1e-3, "{past_s}: {far}");
    }
    live.set(crate::effect::TIME, f32::NAN);
    assert_eq!(live.outside().count(), 0, "the clock is not known");
}

#[test]
fn the_error_of_an_effect_grows_with_the_distance_from_its_reference() {
    let heat = BuiltIn::Offset(Offset::linear(ColumnName::new("temp_c").unwrap(), 25.0));
    let known = FittedEffect::new(heat, [0.0; 9], [0.03, 0.04, 0.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0]);
    let base = Calibration {
        matrix: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]],
        ..Calibration::identity(50.0)
    };
    for (temp_c, error_ut) in [(25.0_f64, 0.0_f64), (35.0, 1.0), (5.0, 2.0)] {
        let found = known.error_ut(&base, [10.0, 20.0, 30.0], [temp_c, 0.0]).unwrap();
        assert!((found - error_ut).abs() < 1e-12, "{temp_c}: {found}");
    }
    let unknown = FittedEffect::new(heat, [0.0; 9], [f64::NAN; 9]);
    assert_eq!(unknown.error_ut(&base, [10.0, 20.0, 30.0], [35.0, 0.0]), None);
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
    let broken = FittedEffect::new(Broken, [1.0; 9], [0.0; 9]);
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

#[test]
fn a_periodic_interference_keeps_its_phase_for_three_days() {
    let mut calibration = ExtendedCalibration::plain(Calibration::identity(50.0));
    let tone = |frequency_hz, reference_s| {
        fitted(BuiltIn::Periodic(crate::effect::Periodic { frequency_hz, reference_s }), 1.0)
    };
    calibration.effects.push(tone(12.483_1, 3.7)).unwrap();
    calibration.effects.push(tone(1.07, 900.0)).unwrap();
    let mut live = Live::new(&calibration.cast::<f32>()).unwrap();
    // Behind a reference, as an effect from outside stands in a calibration.
    let mut behind = ExtendedCalibration::<f64, &dyn Effect<f64>>::plain(calibration.base);
    for FittedEffect { effect, coefficients, std_errors, ranges, bends } in calibration.effects.iter() {
        let one = FittedEffect::new(effect as _, *coefficients, *std_errors).over(*ranges).bending(*bends);
        behind.effects.push(one).ok().unwrap();
    }
    let mut behind = Live::new(&behind).unwrap();
    let mut conditions = Conditions::unknown();
    let measured = [10.0, 20.0, 30.0];
    let mut worst = 0.0f64;
    for hour in [0.0, 1.0, 10.0, 72.0] {
        for step in 0..200 {
            let now_s = 3600.0 * hour + 0.0137 * f64::from(step);
            live.advance(now_s);
            behind.advance(now_s);
            conditions.inputs = [[now_s, 0.0]; MAX_EFFECTS];
            let truth = calibration.apply(measured, &conditions).unwrap();
            let board = live.apply(measured.map(|v| v as f32), None).unwrap();
            let other = behind.apply(measured, None).unwrap();
            for axis in 0..3 {
                worst = worst.max((f64::from(board[axis]) - truth[axis]).abs());
                assert!((other[axis] - truth[axis]).abs() < 1e-6, "{hour} h: {other:?} {truth:?}");
            }
        }
    }
    // Singles of 30 µT are 2e-6 apart; a phase that is cast is off by a quarter of the amplitude after ten hours.
    assert!(worst < 2e-5, "{worst}");
}

/// What a sensor reads that is `delay_s` late on a board that turns steadily, and the field there is.
fn late(turn: [f64; 3], delay_s: f64) -> ([f64; 3], [f64; 3], Calibration<f64>) {
    let base = Calibration {
        offset_ut: [12.0, -7.0, 3.0],
        matrix: [[1.1, 0.1, -0.05], [0.02, 0.9, 0.2], [0.0, -0.1, 1.05]],
        field_ut: 50.0,
    };
    let field = [20.0, -30.0, 34.641_016];
    // As it stood in the board's axes when the board had yet to turn by so much.
    let before = turned(field, turn.map(|rate| rate * delay_s));
    let inverse = crate::vector::inverse_3x3(&base.matrix).unwrap();
    let raw = times(&inverse, before);
    (core::array::from_fn(|axis| raw[axis] + base.offset_ut[axis]), field, base)
}

#[test]
fn a_delay_is_a_rotation_however_fast_the_board_turns() {
    for (rate, delay_s) in [(0.1, 0.02), (3.0, 0.042), (12.0, 0.1), (20.0, 0.15), (8.0, 0.3)] {
        let turn = [0.6 * rate, -0.64 * rate, 0.48 * rate];
        let (measured, field, base) = late(turn, delay_s);
        let mut calibration = ExtendedCalibration::plain(base);
        calibration.effects.push(FittedEffect::new(BuiltIn::Lag(Lag), [delay_s; 9], [0.0; 9])).unwrap();
        let conditions = Conditions { turn_radps: Some(turn), ..Conditions::unknown() };
        let corrected = calibration.apply(measured, &conditions).unwrap();
        assert!(norm(minus(corrected, field)) < 1e-8, "{rate} {delay_s}: {corrected:?}");
        // The length is that without the effect: what a fit of the magnitude says holds of the correction.
        let plain = norm(base.apply(measured));
        assert!((norm(corrected) - plain).abs() < 1e-12 * plain, "{rate} {delay_s}");
        // In single precision, as on the board, too.
        let live = Live::new(&calibration.cast::<f32>()).unwrap();
        let board = live.apply(measured.map(|v| v as f32), Some(turn.map(|v| v as f32))).unwrap();
        assert!((0..3).all(|axis| (f64::from(board[axis]) - field[axis]).abs() < 1e-4), "{board:?}");
    }
}

#[test]
fn the_dip_s_derivatives_are_those_of_the_turned_vector() {
    let rotation = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let matrix = [[1.1, 0.1, -0.05], [0.0, 0.9, 0.2], [0.0, 0.0, 1.05]];
    let turn = [2.0, -3.0, 1.5];
    let down = [0.36, 0.48, 0.8];
    let model = Model::new([12.0, -7.0, 3.0], matrix, 50.0, rotation, 0.5).unwrap();
    // On the ellipsoid, where shapes are taken.
    let centred = [28.0, -23.0, 15.0];
    let size = 50.0 / norm(times(&matrix, centred));
    let measured_ut = core::array::from_fn(|axis| model.offset_ut[axis] + size * centred[axis]);
    let reading = Observation { measured_ut, turn_radps: Some(turn), down: Some(down) };
    let row_of = |model: &Model<f64>, delay_s: f64| {
        let mut coefficients = [0.0; 9];
        coefficients[0] = delay_s;
        let term =
            Term { effect: &Lag as &dyn Effect<f64>, coefficients, inputs: [0.0; 2], bends: Bends::Reading };
        let mut out = ([0.0; 5], 0.0);
        model.rows::<1, 5>(Residual::Dip, &reading, &[term], |row, r| out = (*row, r)).unwrap();
        out
    };
    for delay_s in [0.0, 0.08] {
        let (row, residual) = row_of(&model, delay_s);
        let step = 1e-6;
        let after = row_of(&model, delay_s + step).1;
        assert!((row[4] - (after - residual) / step).abs() < 1e-5, "delay: {row:?}");
        for axis in 0..4 {
            let mut delta = [0.0; 4];
            delta[axis] = step;
            let after = row_of(&model.aligned(&delta).unwrap(), delay_s).1;
            assert!((row[axis] - (after - residual) / step).abs() < 1e-5, "{axis} at {delay_s}: {row:?}");
        }
        // The same angle as of the corrected vector.
        let term = Term {
            effect: &Lag as &dyn Effect<f64>,
            coefficients: [delay_s; 9],
            inputs: [0.0; 2],
            bends: Bends::Reading,
        };
        let corrected = model.correct(&reading, &[term]).unwrap();
        let sine = crate::vector::dot(corrected, down) / norm(corrected);
        assert!((sine.asin() - 0.5_f64.asin() - residual).abs() < 1e-9);
    }
}

/// A strong effect of each kind that reads the field, with its inputs.
fn strong() -> [(BuiltIn<f64>, [f64; 9], [f64; 2]); 3] {
    let column = ColumnName::new("temp_c").unwrap();
    [
        (BuiltIn::CrossAxis(CrossAxis), [4e-3, -3e-3, 2e-3, 3e-3, -2e-3, 3e-3, 2e-3, 0.0, 0.0], [0.0; 2]),
        (
            BuiltIn::Nonlinearity(Nonlinearity),
            [2e-3, -3e-3, 2e-3, -4e-5, 3e-5, -3e-5, 0.0, 0.0, 0.0],
            [0.0; 2],
        ),
        (
            BuiltIn::Gain(Gain { column, reference: 20.0 }),
            [0.02, -0.03, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [30.0, 0.0],
        ),
    ]
}

#[test]
fn what_bends_the_field_is_taken_off_the_reading() {
    let base = Calibration {
        offset_ut: [12.0, -7.0, 9.0],
        matrix: [[1.05, 0.03, -0.02], [0.0, 0.97, 0.04], [0.0, 0.0, 1.01]],
        field_ut: 50.0,
    };
    let inverse = crate::vector::inverse_3x3(&base.matrix).unwrap();
    for (effect, theta, inputs) in strong() {
        for field in [[50.0, 0.0, 0.0], [0.0, -50.0, 0.0], [-28.0, 30.0, 28.6], [30.0, -24.0, -32.0]] {
            let undisturbed = plus(times(&inverse, field), base.offset_ut);
            let at = Quantities { inputs, ..Quantities::of_vector(undisturbed) };
            let measured = plus(undisturbed, effect.disturbance(&at, &theta));
            assert!(norm(minus(measured, undisturbed)) > 1.0, "it is strong");
            let mut calibration = ExtendedCalibration::plain(base);
            let fitted = FittedEffect::new(effect, theta, [0.0; 9]).bending(Bends::Field);
            calibration.effects.push(fitted).unwrap();
            let conditions = Conditions { turn_radps: None, inputs: [inputs; MAX_EFFECTS] };
            let corrected = calibration.apply(measured, &conditions).unwrap();
            assert!(norm(minus(corrected, field)) < 2e-3, "{fitted:?}: {corrected:?} for {field:?}");
        }
    }
}

#[test]
fn the_magnitude_s_derivatives_are_those_of_what_bends_the_field() {
    let matrix = [[1.05, 0.03, -0.02], [0.0, 0.97, 0.04], [0.0, 0.0, 1.01]];
    let turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let model = Model::new([12.0, -7.0, 9.0], matrix, 50.0, turned, 0.0).unwrap();
    let (h, k) = (1e-4, 6);
    let inverse = crate::vector::inverse_3x3(&matrix).unwrap();
    let undisturbed = plus(times(&inverse, [32.0, -24.0, 30.0]), model.offset_ut);
    for (effect, coefficients, inputs) in strong() {
        let at = Quantities { inputs, ..Quantities::of_vector(undisturbed) };
        // With some noise.
        let measured_ut = plus(plus(undisturbed, effect.disturbance(&at, &coefficients)), [0.2, 0.1, -0.1]);
        let rows = |model: &Model<f64>, coefficients: [f64; 9]| {
            let term =
                Term { effect: &effect as &dyn Effect<f64>, coefficients, inputs, bends: Bends::Field };
            let reading = Observation { measured_ut, turn_radps: None, down: None };
            let mut out = ([0.0; 16], 0.0);
            model.rows::<1, 16>(Residual::Magnitude, &reading, &[term], |row, r| out = (*row, r)).unwrap();
            out
        };
        let (row, _) = rows(&model, coefficients);
        for column in 0..9 + k.min(effect.coefficients()) {
            let moved = |sign: f64| {
                let (mut delta, mut theta) = ([0.0; 9], coefficients);
                // A coefficient's unit is as large as its disturbance is.
                let step = if column < 9 { h } else { h * theta[column - 9].abs() };
                match column.checked_sub(9) {
                    None => delta[column] = sign * step,
                    Some(place) => theta[place] += sign * step,
                }
                (rows(&model.stepped(&delta).unwrap(), theta).1, step)
            };
            let ((up, step), (down, _)) = (moved(1.0), moved(-1.0));
            let slope = (up - down) / (2.0 * step);
            // The columns are those of the closest point, which is off by the noise over the field.
            assert!(
                (row[column] - slope).abs() < 0.02 * slope.abs().max(0.1),
                "{effect:?} {column}: {} {slope}",
                row[column]
            );
        }
    }
}
