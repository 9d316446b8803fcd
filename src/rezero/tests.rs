//! Offsets from turns that do not go all round.

use super::*;
use crate::math::{cos, sin};
use crate::vector::{minus, norm, plus, scaled, times, turned};

/// Readings while a board turns to and fro by this much about all its axes, with an offset and noise.
fn to_and_fro(most_deg: f64, offset_ut: [f32; 3], sigma_ut: f32, seconds: u32) -> Rezero {
    let mut rezero = Rezero::new();
    let mut state = 7_u64;
    let mut normal = || {
        let mut sum = -6.0_f32;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 40) as f32 / (1_u32 << 24) as f32;
        }
        sum
    };
    for i in 0..50 * seconds {
        let t = f64::from(i) * 0.02;
        let most = most_deg.to_radians();
        let (a, b) = (most * sin(1.1 * t), most * sin(0.7 * t + 1.0));
        let field = [cos(a) * cos(b), sin(a) * cos(b), sin(b)].map(|value| (50.0 * value) as f32);
        let reading = [0, 1, 2].map(|axis| field[axis] + offset_ut[axis] + sigma_ut * normal());
        rezero.push(u64::from(i) * 20, reading, None);
    }
    rezero
}

#[test]
fn small_turns_show_the_offset_within_its_error() {
    let truth = [4.0, -7.0, 2.5];
    let mut last = f32::INFINITY;
    for most_deg in [20.0, 30.0, 60.0] {
        let found = to_and_fro(most_deg, truth, 0.2, 60).solve(0.01).expect("an offset");
        let off = norm(minus(found.change_ut, truth));
        assert!(off < 3.0 * found.error_ut, "{most_deg}: {off} {found:?}");
        assert!(found.error_ut < last && found.least_error_ut < 0.2, "{most_deg}: {found:?}");
        last = found.error_ut;
    }
    assert!(last < 0.2, "{last}");
}

#[test]
fn a_matrix_that_is_wrong_widens_the_error() {
    let rezero = to_and_fro(30.0, [4.0, -7.0, 2.5], 0.1, 60);
    let of = |error_ut| rezero.solve(error_ut).expect("an offset").error_ut;
    assert!(of(0.1) > 3.0 * of(0.0), "{} {}", of(0.1), of(0.0));
}

#[test]
fn a_board_at_rest_and_one_that_turns_in_a_plane_show_none() {
    assert_eq!(to_and_fro(0.0, [1.0; 3], 0.2, 600).solve(0.0), Err(NoOffset::TooFewLooks(0)));
    let mut level = Rezero::new();
    for i in 0..3000_u32 {
        let angle = f64::from(i) * 0.02;
        level.push(
            u64::from(i) * 20,
            [(20.0 * cos(angle)) as f32, (20.0 * sin(angle)) as f32, 45.0 + 0.01 * (i % 3) as f32],
            None,
        );
    }
    assert_eq!(level.solve(0.0), Err(NoOffset::Planar(GyroUse::None)));
}

/// A board with a magnetometer and a gyro, and what is wrong with them.
#[derive(Clone, Copy)]
struct Board {
    /// How far the gyro's zero is off, its gains and axes, and how much later the magnetometer is.
    zero_radps: [f32; 3],
    gains: [[f32; 3]; 3],
    delay_s: f64,
    /// The rest that the matrix of the calibration leaves.
    matrix: [[f32; 3]; 3],
    speaks: bool,
}

impl Board {
    /// A gyro with 1 % of gain, 1° of axes and 0.01 rad/s of zero error, a magnetometer that is late by 15 ms, and a matrix that is wrong
    /// by 0.3 %.
    const TYPICAL: Self = Self {
        zero_radps: [0.01, -0.01, 0.01],
        gains: [[1.01, 0.0, 0.017], [0.0, 0.99, 0.0], [-0.017, 0.0, 1.01]],
        delay_s: 0.015,
        matrix: [[1.002, 0.001, 0.0], [0.001, 0.998, -0.001], [0.0, -0.001, 1.0]],
        speaks: true,
    };
    const WITHOUT_GYRO: Self = Self { speaks: false, ..Self::TYPICAL };

    /// A minute of readings at 50 Hz in a field of 20 µT north and 45 µT down, while the board turns at this rate.
    fn turned(self, rate: impl Fn(f64) -> [f64; 3], seed: u64) -> Rezero {
        let mut rezero = Rezero::new();
        let mut state = seed;
        let mut normal = || {
            let mut sum = -6.0_f32;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 40) as f32 / (1_u32 << 24) as f32;
            }
            sum
        };
        let mut field = [20.0, 0.0, 45.0_f64];
        for i in 0..3000_u32 {
            let t = f64::from(i) * 0.02;
            let turn = rate(t + self.delay_s).map(|rate| rate as f32);
            let noise = scaled([normal(), normal(), normal()], 0.003);
            let said = plus(plus(times(&self.gains, turn), self.zero_radps), noise);
            let right = times(&self.matrix, field.map(|value| value as f32));
            let noise = scaled([normal(), normal(), normal()], 0.2);
            let reading = plus(plus(right, OFFSET_UT), noise);
            rezero.push(u64::from(i) * 20, reading, self.speaks.then_some(said));
            for step in 0..20 {
                let turn = rate(t + (f64::from(step) + 0.5) * 1e-3).map(|rate| -1e-3 * rate);
                field = turned(field, turn);
            }
        }
        rezero
    }
}

const OFFSET_UT: [f32; 3] = [4.0, -7.0, 2.5];
/// 0.2 % of the field.
const MATRIX_UT: f32 = 0.1;

/// A hand that turns a board to and fro by this much about all its axes.
fn hand(most_deg: f64) -> impl Fn(f64) -> [f64; 3] {
    let most = most_deg.to_radians();
    move |t| [1.9, 1.3, 2.3].map(|pace| most * pace * cos(pace * t + pace))
}

fn off(found: &OffsetChange) -> f32 {
    norm(minus(found.change_ut, OFFSET_UT))
}

#[test]
fn a_gyro_makes_small_turns_more_exact() {
    // Errors of 10.4, 4.5, 2.5 and 1.2 µT without a gyro, and of 1.7, 1.5, 1.2 and 0.8 µT with it.
    for (most_deg, share) in [(10.0, 0.2), (15.0, 0.35), (20.0, 0.5), (30.0, 0.7)] {
        let (mut off_with, mut off_without) = (0.0, 0.0);
        for seed in 1..9 {
            let of = |board: Board| board.turned(hand(most_deg), seed).solve(MATRIX_UT).expect("an offset");
            let (without, with) = (of(Board::WITHOUT_GYRO), of(Board::TYPICAL));
            assert_eq!((without.gyro, with.gyro), (GyroUse::None, GyroUse::Used));
            assert!(with.error_ut < share * without.error_ut, "{most_deg}: {with:?} {without:?}");
            assert!(off(&with) < 2.0 * with.error_ut, "{most_deg}: {with:?}");
            (off_with, off_without) = (off_with + off(&with), off_without + off(&without));
        }
        assert!(off_with < off_without, "{most_deg}: {off_with} {off_without}");
    }
}

#[test]
fn level_turns_show_the_horizontal_offset_to_a_gyro() {
    for pace in [0.3, 1.0, 3.0] {
        let constant = move |_| [0.0, 0.0, pace];
        let to_and_fro = move |t| [0.0, 0.0, pace * cos(pace * t)];
        for rezero in [Board::TYPICAL.turned(constant, 3), Board::TYPICAL.turned(to_and_fro, 4)] {
            let found = rezero.solve(MATRIX_UT).expect("an offset");
            assert_eq!(found.gyro, GyroUse::Used);
            let [x, y, _] = minus(found.change_ut, OFFSET_UT);
            assert!(x.abs().max(y.abs()) < 3.0 * found.least_error_ut, "{pace}: {found:?}");
            assert!(found.least_error_ut < 0.6 && found.error_ut > 20.0, "{pace}: {found:?}");
        }
    }
}

#[test]
fn a_gyro_that_disagrees_changes_nothing() {
    let of = |gains, zero_radps, delay_s| Board { gains, zero_radps, delay_s, ..Board::TYPICAL };
    let diagonal = |gain| [[gain, 0.0, 0.0], [0.0, gain, 0.0], [0.0, 0.0, gain]];
    let zero = [0.0; 3];
    for (what, board) in [
        ("degrees", of(diagonal(57.3), zero, 0.0)),
        ("sign", of(diagonal(-1.0), zero, 0.0)),
        ("stuck", of(diagonal(0.0), zero, 0.0)),
        ("one axis", of([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], zero, 0.0)),
        ("axes", of([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], zero, 0.0)),
        ("zero", of(diagonal(1.0), [1.0, -1.0, 1.0], 0.0)),
        ("late", of(diagonal(1.0), zero, 0.3)),
    ] {
        for most_deg in [10.0, 20.0, 40.0] {
            let rezero = board.turned(hand(most_deg), 5);
            let alone = Board { speaks: false, ..board }.turned(hand(most_deg), 5).solve(MATRIX_UT);
            let found = rezero.solve(MATRIX_UT);
            let alone = alone.map(|alone| OffsetChange { gyro: GyroUse::Disagrees, ..alone });
            assert_eq!(found, alone, "{what} {most_deg}");
        }
    }
}

#[test]
fn a_gyro_that_is_somewhat_wrong_gives_no_false_certainty() {
    // Small turns do not show the gyro's gain: the error is then too large to be accepted.
    for (what, gain, axes_deg, zero_radps, delay_s) in [
        ("gain", 0.5, 0.0, 0.01, 0.0),
        ("gain", 0.8, 0.0, 0.01, 0.0),
        ("gain", 0.9, 0.0, 0.01, 0.0),
        ("gain", 1.2, 0.0, 0.01, 0.0),
        ("gain", 1.5, 0.0, 0.01, 0.0),
        ("axes", 1.0, 5.0, 0.01, 0.0),
        ("axes", 1.0, 10.0, 0.01, 0.0),
        ("axes", 1.0, 20.0, 0.01, 0.0),
        ("zero", 1.0, 0.0, 0.1, 0.0),
        ("zero", 1.0, 0.0, 0.3, 0.0),
        ("late", 1.0, 0.0, 0.01, 0.05),
        ("late", 1.0, 0.0, 0.01, 0.1),
    ] {
        let axis = |place: usize| {
            let mut axis = [0.0_f32; 3];
            axis[place] = gain;
            turned(axis, [0.0, f32::to_radians(axes_deg), 0.0])
        };
        let gains = [axis(0), axis(1), axis(2)];
        let board =
            Board { gains, zero_radps: [zero_radps, -zero_radps, zero_radps], delay_s, ..Board::TYPICAL };
        for most_deg in [10.0, 15.0, 20.0, 30.0, 40.0, 60.0] {
            let found = board.turned(hand(most_deg), 7).solve(MATRIX_UT).expect("an offset");
            let is_refused = found.error_ut > 0.01 * found.field_ut;
            assert!(is_refused || off(&found) < 2.0 * found.error_ut, "{what} {most_deg}: {found:?}");
        }
    }
}

#[test]
fn a_silent_gyro_is_none() {
    let rate = hand(30.0);
    let mut rezero = Rezero::new();
    let mut field = [20.0, 0.0, 45.0_f64];
    for i in 0..3000_u32 {
        let rate = rate(f64::from(i) * 0.02);
        // It says something twice a second, and then the looks between are not linked.
        let said = (i % 25 == 0).then(|| rate.map(|rate| rate as f32));
        rezero.push(u64::from(i) * 20, field.map(|value| value as f32), said);
        field = turned(field, rate.map(|rate| -0.02 * rate));
    }
    assert_eq!(rezero.solve(MATRIX_UT).expect("an offset").gyro, GyroUse::None);
}
