//! The predicted error of a corrected vector holds on logs of the second generator.

use ironout_host_tests::accuracy::predicted::ratio_of_second;
use second_generator::Kind;

/// Errors beyond so many predicted ones are no chance.
const MOST: f64 = 3.0;

fn holds(kind: Kind, numbers: [u64; 4]) {
    for number in numbers {
        let ratio = ratio_of_second(kind, number).expect("a calibration");
        assert!(
            ratio < MOST,
            "{} {number}: the true error is {ratio:.1} times the predicted one",
            kind.name()
        );
    }
}

/// Effects that follow the field were found at the undisturbed reading and applied at the reading: 10 to 28 times the predicted error.
#[test]
fn a_strong_gain_is_given_out_as_a_correction_applies_it() {
    holds(Kind::Gain, [5004, 5011, 5016, 5038]);
}

/// A gyro with a zero error of 1 to 2 °/s turned the direction of gravity, and the matrix with it: 3 to 15 times the predicted error.
#[test]
fn a_gyro_with_a_zero_error_turns_no_matrix() {
    holds(Kind::PlainOffset, [5005, 5006, 5017, 5026]);
    holds(Kind::NothingWhite, [5005, 5006, 5017, 5026]);
}
