//! Circles that were driven, and what comes of them.

use super::{Forces, InUse, LevelFit, LevelPrior, MAX_HEADING_ERROR_DEG, NotLevel, fit_level};
use crate::calibration::Calibration;
use crate::gate::Gated;
use crate::math::{cos, sin, sqrt};
use crate::moments::Moments;
use crate::record::HoldsFor;
use crate::scatter::Scatter;
use crate::vector::{inverse_3x3, minus, norm, times, turned};
use crate::whiteness::Whiteness;

const DEG: f64 = 180.0 / core::f64::consts::PI;

/// Seeded numbers of variance one.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 40) as f64 / (1_u64 << 24) as f64;
        }
        sum
    }
}

/// A vehicle that drives circles: its sensor, and how it drives.
#[derive(Clone, Copy)]
struct Drive {
    seed: u64,
    /// Part of a turn to the left and to the right.
    turns: [f64; 2],
    /// Size of hard iron, µT, and of soft iron.
    iron: (f64, f64),
    /// Rms tilt, degrees.
    tilt_deg: f64,
    sideways_mps2: f64,
    /// Size of a second field that turns with the place, µT.
    disturbed_ut: f64,
    accelerometer: bool,
}

const USUAL: Drive = Drive {
    seed: 1,
    turns: [2.0, 2.0],
    iron: (25.0, 0.05),
    tilt_deg: 1.0,
    sideways_mps2: 0.3,
    disturbed_ut: 0.0,
    accelerometer: true,
};
const SCALE: f64 = 0.05;
const FIELD: [f64; 3] = [20.0, 0.0, 45.0];

/// What the sensor does to the field.
struct Truth {
    distortion: [[f64; 3]; 3],
    offset_ut: [f64; 3],
}

impl Drive {
    fn truth(&self) -> Truth {
        let mut random = Random(self.seed.wrapping_mul(7919).wrapping_add(3));
        let (hard_ut, soft) = self.iron;
        let distortion = core::array::from_fn(|r| {
            core::array::from_fn(|c| f64::from(u8::from(r == c)) + soft * random.next())
        });
        Truth { distortion, offset_ut: [0; 3].map(|_| hard_ut * random.next()) }
    }

    /// The field in the board's axes at a heading and a tilt, rad.
    fn field(heading: f64, pitch: f64, roll: f64) -> [f64; 3] {
        let [north, _, down] = FIELD;
        let level = [north * cos(heading), -north * sin(heading), down];
        turned(turned(level, [0.0, -pitch, 0.0]), [-roll, 0.0, 0.0])
    }

    fn fit(&self, prior: &LevelPrior) -> Result<LevelFit, NotLevel> {
        let Truth { distortion, offset_ut } = self.truth();
        let mut random = Random(self.seed);
        let (mut moments, mut whiteness, mut forces) =
            (Moments::new(), Whiteness::new(16), Forces::default());
        let samples = (self.turns[0] + self.turns[1]) * 600.0;
        let (mut heading, mut pitch, mut roll) = (random.next(), 0.0, 0.0);
        for i in 0..samples as u32 {
            let sense = if f64::from(i) < self.turns[0] * 600.0 { -1.0 } else { 1.0 };
            heading += sense * core::f64::consts::TAU / 600.0;
            // Slopes and bumps with a memory of half a second.
            let step = self.tilt_deg / DEG * sqrt(1.0 - 0.96 * 0.96);
            pitch = 0.96 * pitch + step * random.next();
            roll = 0.96 * roll + step * random.next();
            let mut field = Self::field(heading, pitch, roll);
            field[0] += self.disturbed_ut * sin(2.7 * heading + 0.3 * f64::from(i) / 100.0);
            let read = times(&distortion, field);
            let counts = core::array::from_fn(|a| {
                crate::math::round((read[a] + offset_ut[a] + 0.3 * random.next()) / SCALE) as i16
            });
            whiteness.push(counts);
            whiteness.heed(Gated::Added(1));
            moments.push(counts);
            let down = turned(turned([0.0, 0.0, 9.81], [0.0, -pitch, 0.0]), [-roll, 0.0, 0.0]);
            let force = minus([0.0, sense * self.sideways_mps2, 0.0], down);
            let force = force.map(|axis| (axis + 0.05 * random.next()) as f32);
            let measured = counts.map(|count| f32::from(count) * SCALE as f32);
            forces.push(measured, self.accelerometer.then_some(force));
        }
        let scatter = Scatter::from_moments(&moments, [SCALE; 3]).expect("it moved");
        fit_level(&scatter, &whiteness, [SCALE; 3], prior, &forces)
    }

    /// Errors of headings at a tilt, degrees, rms over the headings without their mean.
    fn heading_error_deg(&self, fitted: &LevelFit, tilt_deg: f64) -> f64 {
        let Truth { distortion, offset_ut } = self.truth();
        let tilt = tilt_deg / DEG;
        let (mut sine, mut square) = (0.0, 0.0);
        let mut errors = [0.0; 192];
        for (i, error) in errors.iter_mut().enumerate() {
            let heading = i as f64 * core::f64::consts::TAU / 24.0;
            let way = (i / 24) as f64 * core::f64::consts::TAU / 8.0;
            let (pitch, roll) = (tilt * cos(way), tilt * sin(way));
            let read = times(&distortion, Self::field(heading, pitch, roll));
            let corrected = fitted.calibration.apply(core::array::from_fn(|a| read[a] + offset_ut[a]));
            let down = turned(turned([0.0, 0.0, 9.81], [0.0, -pitch, 0.0]), [-roll, 0.0, 0.0]);
            let force = down.map(|axis| -axis);
            let got = crate::heading::heading_deg(corrected, force, 0.0).unwrap_or(f64::NAN);
            let off = got - heading * DEG;
            *error = off - 360.0 * crate::math::floor(off / 360.0 + 0.5);
            sine += *error / 192.0;
        }
        for error in errors {
            let off = error - sine;
            square += off * off / 192.0;
        }
        sqrt(square)
    }
}

fn identity() -> LevelPrior {
    LevelPrior { calibration: Calibration::identity(50.0), error: None, holds_for: None }
}

/// Accepted of 40, and the rms of the true heading error over the predicted one: level, and at the largest tilt.
fn of_forty(of: impl Fn(u64) -> Drive, prior: impl Fn(&Drive) -> LevelPrior) -> (u32, f64, f64) {
    let (mut level2, mut limit2, mut accepted) = (0.0, 0.0, 0_u32);
    for seed in 1..=40 {
        let drive = of(seed);
        let Ok(fitted) = drive.fit(&prior(&drive)) else { continue };
        accepted += 1;
        let [level_deg, ..] = fitted.holds_for.heading_errors_deg.map(f64::from);
        level2 += (drive.heading_error_deg(&fitted, 0.0) / level_deg).powi(2);
        limit2 += (drive.heading_error_deg(&fitted, fitted.holds_for.tilt_deg.into())
            / MAX_HEADING_ERROR_DEG)
            .powi(2);
    }
    let rms = |sum: f64| sqrt(sum / f64::from(accepted));
    (accepted, rms(level2), rms(limit2))
}

/// The calibration that the vehicle had before something moved the offset by 4 µT along each axis.
fn earlier(drive: &Drive) -> LevelPrior {
    let Truth { distortion, offset_ut } = drive.truth();
    let matrix = inverse_3x3(&distortion).expect("it is near one");
    let offset_ut = offset_ut.map(|axis| axis + 4.0);
    let calibration = Calibration { offset_ut, matrix, field_ut: norm(FIELD) };
    LevelPrior { calibration, error: Some(0.003), holds_for: None }
}

#[test]
fn circles_give_level_headings_within_their_error_and_tilted_ones_as_far_as_said() {
    type Prior = fn(&Drive) -> LevelPrior;
    let cases: [(&str, Drive, Prior, u32); 4] = [
        ("no calibration", Drive { iron: (5.0, 0.03), ..USUAL }, |_| identity(), 36),
        (
            "no calibration, slopes",
            Drive { iron: (15.0, 0.03), tilt_deg: 2.5, turns: [4.0, 4.0], ..USUAL },
            |_| identity(),
            20,
        ),
        ("a calibration", USUAL, earlier, 40),
        ("no accelerometer", Drive { accelerometer: false, iron: (5.0, 0.03), ..USUAL }, |_| identity(), 36),
    ];
    for (name, usual, prior, least) in cases {
        let (accepted, level, limit) = of_forty(|seed| Drive { seed, ..usual }, prior);
        assert!(accepted >= least, "{name}: {accepted}");
        assert!((0.3..1.3).contains(&level) && limit < 1.3, "{name}: {level} {limit}");
    }
}

#[test]
fn what_does_not_show_a_level_heading_is_refused_with_the_reason() {
    let cases = [
        ("a quarter", Drive { turns: [0.0, 0.25], ..USUAL }, "error-too-large"),
        ("another field", Drive { disturbed_ut: 12.0, ..USUAL }, "residual-too-large"),
        ("a hand", Drive { tilt_deg: 60.0, ..USUAL }, "not-level"),
        ("fast to the left", Drive { turns: [2.0, 0.0], sideways_mps2: 4.0, ..USUAL }, "leaning"),
        (
            "one sense, no calibration",
            Drive { turns: [2.0, 0.0], iron: (5.0, 0.03), ..USUAL },
            "error-too-large",
        ),
    ];
    for (name, drive, code) in cases {
        let prior = if name.contains("no calibration") { identity() } else { earlier(&drive) };
        let refused = drive.fit(&prior).map(|fitted| fitted.holds_for);
        assert_eq!(refused.map_err(|why| why.code()).err(), Some(code), "{name}");
    }
}

/// A calibration that predicts an error over the field, and has it.
fn with_error(drive: &Drive, share: f64) -> LevelPrior {
    let Truth { distortion, offset_ut } = drive.truth();
    let mut random = Random(drive.seed.wrapping_mul(104_729).wrapping_add(5));
    let offset_ut = offset_ut.map(|axis| axis + share * norm(FIELD) * random.next());
    let matrix = inverse_3x3(&distortion).expect("it is near one");
    let calibration = Calibration { offset_ut, matrix, field_ut: norm(FIELD) };
    LevelPrior { calibration, error: Some(share), holds_for: None }
}

#[test]
fn the_calibration_in_use_stays_where_its_level_headings_are_as_good() {
    // Name, drive, error of the calibration in use, how far the offset moved along an axis, µT, and how many of 40 keep it.
    let short = Drive { turns: [1.0, 1.0], ..USUAL };
    let cases: [(&str, Drive, f64, f64, core::ops::RangeInclusive<u32>); 4] = [
        ("nothing has changed", USUAL, 0.0005, 0.0, 38..=40),
        ("a few circles, nothing has changed", short, 0.0005, 0.0, 38..=40),
        ("something has moved", USUAL, 0.0005, 3.0, 0..=0),
        ("it was rough", USUAL, 0.01, 0.0, 0..=10),
    ];
    for (name, usual, share, moved_ut, kept_range) in cases {
        let (mut kept, mut worse, mut ratio2, mut all) = (0_u32, 0_u32, 0.0, 0_u32);
        for seed in 1..=40 {
            let drive = Drive { seed, ..usual };
            let mut prior = with_error(&drive, share);
            prior.calibration.offset_ut[0] += moved_ut;
            let Ok(fitted) = drive.fit(&prior) else { continue };
            let InUse { heading_error_deg, is_as_good } = fitted.in_use.expect("there is one");
            let old = LevelFit { calibration: prior.calibration, ..fitted };
            let (new_deg, old_deg) =
                (drive.heading_error_deg(&fitted, 0.0), drive.heading_error_deg(&old, 0.0));
            all += 1;
            ratio2 += (old_deg / heading_error_deg).powi(2);
            kept += u32::from(is_as_good);
            // What stays is worse by more than anybody sees.
            let (stays, goes) = if is_as_good { (old_deg, new_deg) } else { (new_deg, old_deg) };
            worse += u32::from(stays > goes + 0.15);
        }
        let ratio = sqrt(ratio2 / f64::from(all));
        assert!(all >= 38 && kept_range.contains(&kept) && worse == 0, "{name}: {all} {kept} {worse}");
        assert!((0.3..1.3).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn a_level_calibration_in_use_that_holds_for_less_tilt_is_replaced() {
    let mut prior = with_error(&USUAL, 0.0005);
    let Ok(fitted) = USUAL.fit(&prior) else { panic!("two circles to each side") };
    assert!(fitted.in_use.is_some_and(|in_use| in_use.is_as_good), "{:?}", fitted.in_use);
    let tilts = HoldsFor { heading_errors_deg: [0.05; 4], ..fitted.holds_for };
    for (tilt_deg, stays) in [(fitted.holds_for.tilt_deg - 1.0, false), (fitted.holds_for.tilt_deg, true)] {
        prior.holds_for = Some(HoldsFor { tilt_deg, ..tilts });
        let in_use = USUAL.fit(&prior).ok().and_then(|fitted| fitted.in_use).expect("as before");
        assert_eq!(in_use.is_as_good, stays, "{tilt_deg} {in_use:?}");
    }
    assert_eq!(USUAL.fit(&identity()).ok().and_then(|fitted| fitted.in_use), None);
}
