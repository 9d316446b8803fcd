//! Whether a study drops nothing of what it is given.

use super::pass::Study;
use super::refit::refit;
use crate::effect::{BuiltIn, ColumnName, Offset};
use crate::extended::FittedEffect;
use crate::math;
use crate::model::{Model, NoRow, Observation, Residual, Term};

const ONE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRUTH: [f64; 3] = [3.0, 2.0, 1.0];

/// A study of an offset that follows a current, refitted: the coefficients, or why a sample was refused.
fn fitted<const P: usize, const N: usize>(coefficients: usize) -> Result<[f64; 3], NoRow> {
    let effect = BuiltIn::<f64>::Offset(Offset::linear(ColumnName::new("current_a").unwrap(), 0.0));
    let mut effects = [FittedEffect::new(effect, [0.0; 9], [0.0; 9])];
    let mut model = Model::new([0.0; 3], ONE, 50.0, ONE, 0.0).unwrap();
    for _ in 0..4 {
        let mut study: Study<f64, P, 1, N> = Study::new(Residual::Magnitude, model, coefficients);
        for i in 0..500 {
            let (turn, tilt) = (0.23 * f64::from(i), 0.071 * f64::from(i));
            let current = math::sin(0.9 * f64::from(i));
            let field =
                [math::cos(tilt) * math::cos(turn), math::cos(tilt) * math::sin(turn), math::sin(tilt)];
            let measured_ut = core::array::from_fn(|axis| 50.0 * field[axis] + TRUTH[axis] * current);
            let inputs = [current, 0.0];
            let FittedEffect { effect, coefficients, bends, .. } = &effects[0];
            let term = Term { effect, coefficients: *coefficients, inputs, bends: *bends };
            study.push(0, &Observation { measured_ut, turn_radps: None, down: None }, &[term])?;
        }
        model = refit(&study, None, &mut effects).expect("determined");
    }
    let [x, y, z, ..] = effects[0].coefficients;
    Ok([x, y, z])
}

#[test]
fn columns_that_do_not_fit_are_refused_and_never_dropped() {
    let found = fitted::<12, 1>(3).unwrap();
    assert!(found.iter().zip(TRUTH).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    // Before, the last columns fell off: a coefficient off by its error and two of zero, all with small errors.
    for width in [fitted::<10, 1>(3), fitted::<11, 1>(3), fitted::<9, 1>(3)] {
        assert!(matches!(width, Err(NoRow::TooWide { columns: 12, width: 9..=11 })), "{width:?}");
    }
    // Made for fewer coefficients than its terms have.
    assert_eq!(fitted::<12, 1>(1), Err(NoRow::TooWide { columns: 12, width: 10 }));
    assert_eq!(fitted::<12, 1>(usize::MAX), Err(NoRow::TooWide { columns: usize::MAX, width: 12 }));
    assert_eq!(fitted::<12, 0>(3), Err(NoRow::TooManyTerms { terms: 1, most: 0 }));
}

#[test]
fn a_number_known_when_compiled_is_checked_then() {
    let model = Model::new([0.0; 3], ONE, 50.0, ONE, 0.0).unwrap();
    let study = Study::<f64, 12, 2, 1>::sized::<3>(Residual::Magnitude, model);
    assert_eq!(study.blocks()[1].columns(), 12);
}
