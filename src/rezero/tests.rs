//! Offsets from turns that do not go all round.

extern crate std;

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

/// What is wrong with a gyro.
#[derive(Clone, Copy)]
struct Gyro {
    zero_radps: [f32; 3],
    gains: [[f32; 3]; 3],
    delay_s: f64,
    sigma_radps: f32,
}

impl Gyro {
    /// A gyro with 1 % of gain, 1° of axes and 0.01 rad/s of zero error, and a magnetometer that is late by 15 ms.
    const TYPICAL: Self = Self {
        zero_radps: [0.01, -0.01, 0.01],
        gains: [[1.01, 0.0, 0.017], [0.0, 0.99, 0.0], [-0.017, 0.0, 1.01]],
        delay_s: 0.015,
        sigma_radps: 0.003,
    };
}

const OFFSET_UT: [f32; 3] = [4.0, -7.0, 2.5];

/// Readings at 50 Hz of a field of 20 µT north and 45 µT down while a board turns at this rate.
fn with_gyro(
    rate: impl Fn(f64) -> [f64; 3],
    gyro: Option<Gyro>,
    offset_ut: [f32; 3],
    seconds: u32,
    seed: u64,
) -> Rezero {
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
    for i in 0..50 * seconds {
        let t = f64::from(i) * 0.02;
        let said = gyro.map(|gyro| {
            let rate = rate(t + gyro.delay_s).map(|rate| rate as f32);
            let noise = scaled([normal(), normal(), normal()], gyro.sigma_radps);
            plus(plus(times(&gyro.gains, rate), gyro.zero_radps), noise)
        });
        let reading = [0, 1, 2].map(|axis| field[axis] as f32 + offset_ut[axis] + 0.2 * normal());
        rezero.push(u64::from(i) * 20, reading, said);
        for step in 0..20 {
            let turn = rate(t + (f64::from(step) + 0.5) * 1e-3).map(|rate| -1e-3 * rate);
            field = turned(field, turn);
        }
    }
    rezero
}

/// A hand that turns a board to and fro by this much about all its axes.
fn hand(most_deg: f64) -> impl Fn(f64) -> [f64; 3] {
    let most = most_deg.to_radians();
    move |t| [1.9, 1.3, 2.3].map(|pace| most * pace * cos(pace * t + pace))
}

#[test]
fn a_gyro_makes_small_turns_exact() {
    for most_deg in [10.0, 15.0, 20.0, 30.0] {
        for seed in 1..5 {
            let of = |gyro| with_gyro(hand(most_deg), gyro, OFFSET_UT, 60, seed).solve(0.1);
            let off = |found: &OffsetChange| norm(minus(found.change_ut, OFFSET_UT));
            let (without, with) = (of(None), of(Some(Gyro::TYPICAL)));
            std::eprintln!("{most_deg} {:?} {without:?}", without.as_ref().map(off));
            std::eprintln!("      {:?} {with:?}", with.as_ref().map(off));
        }
    }
}

#[test]
fn level() {
    for pace in [0.3, 0.7, 1.5, 3.0] {
    let yaw = move |_| [0.0, 0.0, pace];
    let of = |gyro| with_gyro(yaw, gyro, OFFSET_UT, 60, 3).solve(0.1);
    std::eprintln!("{:?} {:?}", of(None), of(Some(Gyro::TYPICAL)));
    let yaw = move |t| [0.0, 0.0, pace * cos(pace * t)];
    let of = |gyro| with_gyro(yaw, gyro, OFFSET_UT, 60, 3).solve(0.1);
    std::eprintln!("{:?} {:?}", of(None), of(Some(Gyro::TYPICAL)));
    }
}
