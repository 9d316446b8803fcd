//! False alarms over simulated days, and what must be noticed.

extern crate std;
use super::{Condition, Monitor};
use std::vec::Vec;

/// Uniform numbers from a seed: splitmix64.
struct Draws(u64);

impl Draws {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Twelve of them are as good as normal but for the far tails; the spikes of these tests are put in by hand.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

const NOISE_UT: f64 = 0.3;
const ERROR_UT: f64 = 0.15;

/// Days of a board that turns now and then, its noise of memory `rho`, its calibration off by its predicted error. Calls back with
/// each sample, which may change it, and the condition after it.
fn run(
    seed: u64,
    hours: f64,
    rate_hz: f64,
    rho: f64,
    mut change: impl FnMut(f64, &mut [f64; 3]),
) -> Vec<(f64, Condition)> {
    let mut draws = Draws(seed);
    let mut monitor = Monitor::new(50.0, NOISE_UT as f32, ERROR_UT as f32);
    let mut noise = [0.0; 3];
    let mut changes = Vec::new();
    let (mut yaw, mut tilt) = (0.0_f64, 0.0_f64);
    for sample in 0..(hours * 3600.0 * rate_hz) as u64 {
        let t_s = sample as f64 / rate_hz;
        // Turns for ten seconds of each minute.
        if t_s % 60.0 < 10.0 {
            yaw += 1.1 / rate_hz;
            tilt += 0.7 / rate_hz;
        }
        let own = (1.0 - rho * rho).sqrt() * NOISE_UT;
        noise = noise.map(|value| rho * value + own * draws.normal());
        let direction = [tilt.cos() * yaw.cos(), tilt.cos() * yaw.sin(), tilt.sin()];
        let mut field = direction.map(|axis| axis * 50.0);
        field[0] += ERROR_UT;
        change(t_s, &mut field);
        let t_ms = (sample as f64 * 1000.0 / rate_hz) as u64;
        monitor.push(t_ms, core::array::from_fn(|axis| (field[axis] + noise[axis]) as f32), None);
        let condition = monitor.condition();
        if changes.last().map_or(Condition::Good, |&(_, last)| last) != condition {
            changes.push((t_s, condition));
        }
    }
    changes
}

#[test]
fn no_false_alarm_in_simulated_days_of_any_noise() {
    let mut days = 0.0;
    for (seed, rate_hz, rho) in
        [(1, 10.0, 0.0), (2, 50.0, 0.0), (3, 50.0, 0.6), (4, 50.0, 0.95), (5, 10.0, 0.9), (6, 100.0, 0.95)]
    {
        let changes = run(seed, 24.0, rate_hz, rho, |_, _| ());
        assert_eq!(changes, [], "{rate_hz} Hz, rho {rho}");
        days += 1.0;
    }
    assert_eq!(days, 6.0);
}

#[test]
fn single_spikes_are_passed_over() {
    // Every ten seconds one sample is as wrong as it can be.
    let changes = run(7, 6.0, 50.0, 0.0, |t_s, field| {
        if ((t_s * 50.0).round() as u64).is_multiple_of(500) {
            field[2] += 4000.0;
        }
    });
    assert_eq!(changes, []);
}

#[test]
fn a_girder_disturbs_for_as_long_as_the_board_is_there() {
    let near = |t_s: f64| (100.0..400.0).contains(&t_s);
    let changes = run(8, 0.5, 50.0, 0.5, |t_s, field| {
        if near(t_s) {
            let length = field.iter().map(|axis| axis * axis).sum::<f64>().sqrt();
            *field = field.map(|axis| axis * (1.0 + 3.0 / length));
        }
    });
    let [(begin, Condition::Disturbed), (end, Condition::Good)] = changes[..] else { panic!("{changes:?}") };
    assert!((100.0..106.0).contains(&begin) && (400.0..412.0).contains(&end), "{changes:?}");
}

#[test]
fn a_magnet_on_the_board_outdates_its_calibration_and_lying_still_does_not() {
    let changes = run(9, 3.0, 50.0, 0.0, |t_s, field| {
        if t_s > 600.0 {
            field[0] += 6.0;
            field[2] += 4.0;
        }
    });
    let outdated =
        changes.iter().find(|(_, condition)| *condition == Condition::Outdated).expect("it was noticed");
    // Ten seconds of turning a minute: two minutes of turning are twelve minutes.
    assert!(outdated.0 > 600.0 && outdated.0 < 600.0 + 45.0 * 60.0, "{changes:?}");
    assert_eq!(changes.last().map(|(_, condition)| *condition), Some(Condition::Outdated));

    let mut monitor = Monitor::new(50.0, 0.3, 0.15);
    (0..2_000_000_u64).for_each(|sample| monitor.push(sample * 20, [56.0, 0.0, 0.0], None));
    assert_eq!(monitor.condition(), Condition::Disturbed, "it never turned");
}

#[test]
fn what_is_no_number_changes_nothing() {
    let mut monitor = Monitor::new(50.0, f32::NAN, f32::NAN);
    monitor.push(0, [50.0, 0.0, 0.0], None);
    let before = monitor;
    monitor.push(20, [f32::NAN, 0.0, 0.0], None);
    monitor.push(40, [f32::INFINITY, 0.0, 0.0], None);
    assert_eq!(monitor, before);
    monitor.push(60, [50.0, 0.0, 0.0], None);
    monitor.push(10, [90.0, 0.0, 0.0], None);
    assert_eq!(monitor.condition(), Condition::Good);
}

/// How a board with an accelerometer is carried: hours of it, and what the field does.
struct Carried {
    seed: u64,
    hours: f64,
    /// The calibration's axes against those of the accelerometer, degrees.
    misaligned_deg: f64,
    /// The hand's accelerations while it turns, m/s².
    hand_mps2: f64,
}

impl Carried {
    /// Changes of the condition; `turn_deg` turns the field in the vertical plane, its magnitude as it was.
    fn run(&self, turn_deg: impl Fn(f64) -> f64) -> Vec<(f64, Condition)> {
        const RATE_HZ: f64 = 50.0;
        let mut draws = Draws(self.seed);
        let mut monitor = Monitor::new(50.0, NOISE_UT as f32, ERROR_UT as f32);
        let mut changes = Vec::new();
        let mut hand = [0.0; 3];
        let (mut yaw, mut pitch, mut roll) = (0.0_f64, 0.0_f64, 0.0_f64);
        for sample in 0..(self.hours * 3600.0 * RATE_HZ) as u64 {
            let t_s = sample as f64 / RATE_HZ;
            let turns = t_s % 60.0 < 10.0;
            if turns {
                (yaw, pitch, roll) = (yaw + 1.1 / RATE_HZ, pitch + 0.7 / RATE_HZ, roll + 0.4 / RATE_HZ);
            }
            // The hand's acceleration has a memory of a fifth of a second.
            hand = hand.map(|axis: f64| {
                0.9 * axis + if turns { 0.44 * self.hand_mps2 * draws.normal() } else { 0.0 }
            });
            let to_body = |[n, e, d]: [f64; 3]| {
                let (n, e) = (n * yaw.cos() + e * yaw.sin(), e * yaw.cos() - n * yaw.sin());
                let (n, d) = (n * pitch.cos() - d * pitch.sin(), d * pitch.cos() + n * pitch.sin());
                [n, e * roll.cos() + d * roll.sin(), d * roll.cos() - e * roll.sin()]
            };
            let dip = (65.0 + turn_deg(t_s)).to_radians();
            let [x, y, z] = to_body([50.0 * dip.cos(), 0.0, 50.0 * dip.sin()]);
            let off = self.misaligned_deg.to_radians();
            let field = [x * off.cos() - z * off.sin() + ERROR_UT, y, z * off.cos() + x * off.sin()];
            let force = to_body([0.0, 0.0, -9.80665]);
            let measured = field.map(|axis| (axis + NOISE_UT * draws.normal()) as f32);
            let felt = core::array::from_fn(|axis| (force[axis] + hand[axis] + 0.03 * draws.normal()) as f32);
            monitor.push((t_s * 1000.0) as u64, measured, Some(felt));
            let condition = monitor.condition();
            if changes.last().map_or(Condition::Good, |&(_, last)| last) != condition {
                changes.push((t_s, condition));
            }
        }
        changes
    }
}

#[test]
fn the_dip_gives_no_false_alarm_in_simulated_days_however_the_board_is_held() {
    for (seed, misaligned_deg, hand_mps2) in [(11, 0.0, 0.0), (12, 4.0, 0.3), (13, 8.0, 1.0), (14, 2.0, 3.0)]
    {
        let carried = Carried { seed, hours: 24.0, misaligned_deg, hand_mps2 };
        assert_eq!(carried.run(|_| 0.0), [], "{misaligned_deg} degrees, {hand_mps2} m/s2");
    }
}

#[test]
fn a_field_that_turns_and_keeps_its_magnitude_disturbs_by_its_dip() {
    let carried = Carried { seed: 15, hours: 1.0, misaligned_deg: 1.0, hand_mps2: 0.2 };
    let changes = carried.run(|t_s| if (1200.0..1500.0).contains(&t_s) { 12.0 } else { 0.0 });
    let [(begin, Condition::Disturbed), (end, Condition::Good)] = changes[..] else { panic!("{changes:?}") };
    assert!((1200.0..1210.0).contains(&begin) && (1500.0..1515.0).contains(&end), "{changes:?}");
    // Before the dip is known, it says nothing.
    let changes = carried.run(|t_s| if (20.0..80.0).contains(&t_s) { 12.0 } else { 0.0 });
    assert_eq!(changes, []);
}
