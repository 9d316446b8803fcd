//! Two magnetometers in one log: which of them is disturbed, and what both see, on logs of the second generator.

use ironout_analysis::fit::pair::of_table;
use ironout_analysis::unlogged::pair::{Disturbed, Pair};
use ironout_analysis::{Options, Table};
use second_generator::{Drawn, Kind, draw};

/// Logs of each kind.
const LOGS: u64 = 24;
const FIRST: u64 = 8500;
/// The second sensor.
const OFFSET_UT: [f64; 3] = [-14.0, 22.0, 9.0];
const MATRIX: [[f64; 3]; 3] = [[1.04, -0.03, 0.01], [0.02, 0.97, 0.02], [-0.01, 0.03, 1.02]];

type Field = [Vec<f64>; 3];

/// What the hidden effects act on.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Neither,
    First,
    Second,
    Both,
}

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|r: usize| (0..3).map(|c| matrix[r][c] * v[c]).sum())
}

/// Time and the readings of both sensors. The second has the noise of the first from the end to the beginning, with the same colour.
fn readings(drawn: &Drawn, on: On) -> (Vec<f64>, Field, Field) {
    let truth = &drawn.truth;
    let measured = ["mx_ut", "my_ut", "mz_ut"].map(|name| drawn.column(name).expect("a magnetometer"));
    let (disturbance, rows) = (truth.disturbance_ut(), measured[0].len());
    let undisturbed = |row: usize| times(&truth.matrix, truth.field_body_ut[row]);
    let noise = |row: usize| {
        let clean = undisturbed(row);
        [0, 1, 2].map(|a: usize| measured[a][row] - clean[a] - truth.offset_ut[a] - disturbance[row][a])
    };
    let (mut first, mut second) = (Field::default(), Field::default());
    for row in 0..rows {
        let (own, mirrored) = (noise(row), noise(rows - 1 - row));
        let (one, two) = (undisturbed(row), times(&MATRIX, truth.field_body_ut[row]));
        for a in 0..3 {
            let acts = |here: bool| if here { disturbance[row][a] } else { 0.0 };
            first[a].push(one[a] + truth.offset_ut[a] + own[a] + acts(matches!(on, On::First | On::Both)));
            second[a].push(two[a] + OFFSET_UT[a] + mirrored[a] + acts(matches!(on, On::Second | On::Both)));
        }
    }
    (drawn.column("t_s").expect("a time").to_vec(), first, second)
}

fn compared(drawn: &Drawn, on: On) -> Option<Pair> {
    let (time_s, first, second) = readings(drawn, on);
    let [field_ut, other_ut] = [&first, &second].map(|field| field.each_ref().map(Vec::as_slice));
    let other_ut = Some(other_ut);
    of_table(&Table { time_s: Some(&time_s), field_ut, other_ut, ..Table::default() }, &Options::default())
}

fn pairs(kind: Kind, on: On) -> Vec<Pair> {
    let pairs: Vec<Pair> =
        (FIRST..FIRST + LOGS).filter_map(|number| compared(&draw(kind, number), on)).collect();
    let count = |is: fn(&Pair) -> bool| pairs.iter().filter(|pair| is(pair)).count();
    println!(
        "{} of {LOGS}: this {}, other {}, common {}",
        pairs.len(),
        count(|pair| pair.disturbed == Some(Disturbed::This)),
        count(|pair| pair.disturbed == Some(Disturbed::Other)),
        count(|pair| pair.common.significant)
    );
    pairs
}

#[test]
fn nothing_is_said_of_two_sensors_with_noise_only() {
    for kind in [Kind::White, Kind::Coloured] {
        let pairs = pairs(kind, On::Neither);
        assert!(pairs.len() >= 20, "{kind:?}: {}", pairs.len());
        for pair in pairs {
            assert!(pair.disturbed.is_none() && !pair.common.significant, "{kind:?}: {pair:?}");
        }
    }
}

#[test]
fn the_disturbed_sensor_is_named_and_never_the_other_one() {
    for (on, is) in [(On::First, Disturbed::This), (On::Second, Disturbed::Other)] {
        let pairs = pairs(Kind::PlainOffset, on);
        let named = pairs.iter().filter(|pair| pair.disturbed == Some(is)).count();
        assert!(pairs.len() >= 20 && named >= 20, "{named} of {}", pairs.len());
        assert!(pairs.iter().all(|pair| pair.disturbed.is_none_or(|named| named == is)), "{pairs:?}");
        assert!(pairs.iter().all(|pair| !pair.common.significant), "{pairs:?}");
    }
}

#[test]
fn a_field_that_both_see_is_common() {
    let pairs = pairs(Kind::PlainOffset, On::Both);
    let common = pairs.iter().filter(|pair| pair.common.significant).count();
    assert!(pairs.len() >= 20 && common >= 20, "{common} of {}", pairs.len());
    assert!(pairs.iter().all(|pair| pair.disturbed.is_none()), "{pairs:?}");
}
