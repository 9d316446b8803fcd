//! The learner on synthetic samples, without a device.

use super::sums::{WIDEST, Work};
use super::*;
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, ColumnName};
use crate::extended::ExtendedCalibration;
use crate::math;
use crate::study::Normal;

/// Seeded noise, mean zero and variance one.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        // Twelve uniform numbers: near enough to a normal one.
        (0..12).map(|_| uniform()).sum()
    }
}

const OFFSET_UT: [f64; 3] = [20.0, -8.0, 3.0];
/// Of the hidden effect, µT per unit.
const THETA: [f64; 3] = [0.8, -0.5, 0.3];

/// A current that is on and off.
fn current(i: u64) -> f64 {
    if (i / 170).is_multiple_of(2) { 0.0 } else { 2.0 }
}

fn column(name: &str) -> ColumnName {
    ColumnName::new(name).expect("a name")
}

/// Eighty seconds at 50 Hz with noise of 0.25 µT, the effect as large as `size`.
fn learned(seed: u64, size: f64) -> Learner {
    learned_from(OFFSET_UT, seed, |i| THETA.map(|theta| size * theta * current(i)))
}

/// The same with another disturbance, µT, from another point.
fn learned_from(offset_ut: [f64; 3], seed: u64, disturbance: impl Fn(u64) -> [f64; 3]) -> Learner {
    learned_since(0, offset_ut, seed, disturbance)
}

/// The same of a board that has been on for a while, ms.
fn learned_since(
    begin_ms: u64,
    offset_ut: [f64; 3],
    seed: u64,
    disturbance: impl Fn(u64) -> [f64; 3],
) -> Learner {
    let mut noise = Noise(seed);
    let mut learner = Learner::new();
    assert!(!learner.is_learning());
    learner.begin(&Calibration { offset_ut, ..Calibration::identity(50.0) });
    for i in 0..4000u64 {
        assert_eq!(learner.feed(&column("current_a"), current(i) as f32), Fed::Tested);
        let (turn, tilt) = (0.017 * i as f64, 1.5 * math::sin(0.0061 * i as f64));
        let field = [
            50.0 * math::cos(tilt) * math::cos(turn),
            50.0 * math::cos(tilt) * math::sin(turn),
            50.0 * math::sin(tilt),
        ];
        let measured = core::array::from_fn(|axis| {
            (field[axis] + OFFSET_UT[axis] + disturbance(i)[axis] + 0.25 * noise.next()) as f32
        });
        learner.push(measured, begin_ms + 20 * i, &Motion::UNKNOWN);
    }
    learner
}

fn asked(learner: &Learner, in_use: InUse) -> Outcome {
    let mut inquiry = Inquiry::new(learner, in_use);
    loop {
        if let Some(outcome) = inquiry.step(learner) {
            return outcome;
        }
    }
}

#[test]
fn what_is_fed_is_named_added_and_removed_again() {
    let mut learner = learned(5, 1.0);
    let outcome = asked(&learner, InUse::default());
    assert_eq!(outcome.verdict, Verdict::Missing, "{outcome:?}");
    let (first, finding) = outcome.ranked().next().expect("candidates");
    assert_eq!((first, finding.status), (Candidate::Column(0), Status::Missing), "{outcome:?}");
    assert!((0.22..0.28).contains(&outcome.floor_ut), "{outcome:?}");

    let base = Calibration { offset_ut: OFFSET_UT, ..Calibration::identity(50.0) };
    let plain = ExtendedCalibration::plain(base);
    let with = learner.add(first, &plain).expect("it is shown");
    let fitted = with.effects.iter().next().expect("an effect");
    for axis in 0..3 {
        let error = fitted.coefficients[axis] - THETA[axis];
        assert!(math::abs(error) < 4.0 * fitted.std_errors[axis], "{fitted:?}");
        assert!(fitted.std_errors[axis] < 0.03, "{fitted:?}");
    }
    assert!(learner.rms_ut() < 0.28 && outcome.rms_ut > 0.4, "{} {}", outcome.rms_ut, learner.rms_ut());

    // In use it is told with what it takes off, and nothing more is missing.
    let in_use = learner.in_use(&with.effects);
    let again = asked(&learner, in_use);
    assert_eq!(again.verdict, Verdict::Complete, "{again:?}");
    let own = again.of(first);
    assert_eq!(own.status, Status::InUse);
    assert!((own.before / outcome.rms_ut - 1.0).abs() < 0.02, "{} {}", own.before, outcome.rms_ut);

    let effect = fitted.effect;
    let without = learner.remove(&effect, &with);
    assert!(without.effects.is_empty());
    assert!((learner.rms_ut() / outcome.rms_ut - 1.0).abs() < 0.02, "the old error is back");
}

#[test]
fn without_an_effect_nothing_is_missing() {
    let wrong = (0..40)
        .filter(|seed| asked(&learned(100 + seed, 0.0), InUse::default()).verdict != Verdict::Complete);
    assert!(wrong.count() <= 1);
}

#[test]
fn a_study_that_begins_far_away_comes_to_where_the_truth_is() {
    // Five µT away: made linear there, coefficients would be wrong by many standard errors.
    let far = OFFSET_UT.map(|offset| offset + 3.0);
    let mut learner = learned_from(far, 5, |i| THETA.map(|theta| theta * current(i)));
    assert!(learner.rows() > 2500, "{}", learner.rows());
    let outcome = asked(&learner, InUse::default());
    assert_eq!(outcome.verdict, Verdict::Missing, "{outcome:?}");
    let plain = ExtendedCalibration::plain(learner.calibration().expect("it learns"));
    let with = learner.add(Candidate::Column(0), &plain).expect("it is shown");
    let fitted = with.effects.iter().next().expect("an effect");
    for axis in 0..3 {
        let error = fitted.coefficients[axis] - THETA[axis];
        assert!(math::abs(error) < 4.0 * fitted.std_errors[axis], "{fitted:?}");
    }
    assert!(learner.rms_ut() < 0.26, "{}", learner.rms_ut());
}

#[test]
fn the_moment_of_a_jump_is_found_between_the_snapshots() {
    for (seed, row) in [(31, 1307), (32, 2011), (33, 2902)] {
        let jump = [1.5, -2.0, 1.0];
        let mut learner = learned_from(OFFSET_UT, seed, |i| if i < row { [0.0; 3] } else { jump });
        learner.settle();
        let outcome = asked(&learner, InUse::default());
        let (first, _) = outcome.ranked().next().expect("candidates");
        assert_eq!((first, outcome.verdict), (Candidate::Step, Verdict::Missing), "{outcome:?}");
        let Some(crate::effect::BuiltIn::Step(step)) = learner.effect(Candidate::Step) else {
            panic!("a step")
        };
        let error_s = step.at_s - 0.02 * row as f64;
        // Snapshots stand 0.64 s apart, and some have given way: without what is between them it would be one of theirs.
        assert!(math::abs(error_s) < 1.28, "{seed}: {error_s} s");
    }
}

#[test]
fn a_gyro_tells_the_delay_of_a_field_that_turns() {
    use super::solve::{Chosen, Factor};
    use super::sums::Sums;
    use super::turning::{ByGyro, TURNING_BASE};
    // To and fro about one axis, and slowly about another.
    let direction = |t: f64| {
        let (angle, tilt) = (1.4 * math::sin(2.1 * t), 0.5 * math::sin(0.7 * t));
        let (x, y) = (math::cos(angle), -math::sin(angle));
        [math::cos(tilt) * x, math::cos(tilt) * y, math::sin(tilt)].map(|value| value as f32)
    };
    let rate = |t: f64| {
        let step = 1e-4;
        let (n, before, after) = (direction(t), direction(t - step), direction(t + step));
        let way: [f32; 3] = core::array::from_fn(|axis| (after[axis] - before[axis]) / (2.0 * step) as f32);
        // What turns the field there the shortest way, and some more about the field itself, which does not show.
        let [x, y, z] = crate::vector::cross(way, n);
        core::array::from_fn(|axis| [x, y, z][axis] + 0.3 * n[axis])
    };
    let mut noise = Noise(77);
    for delay_s in [0.0, 0.03] {
        let (mut gyro, mut sums) = (ByGyro::new(), Sums::new());
        for i in 0..6000u64 {
            let t = 0.01 * i as f64;
            let late = direction(t - delay_s).map(|value| value + 0.005 * noise.next() as f32);
            gyro.push(late, rate(t), 10 * i, &mut sums);
        }
        let mut work = Work::new();
        work.merge(&sums);
        let factor =
            Factor::of(&work, Chosen::base(TURNING_BASE).with(TURNING_BASE, 1), false).expect("regular");
        let found_s = f64::from(factor.step(&work)[TURNING_BASE]);
        assert!(math::abs(found_s - delay_s) < 0.0015, "{found_s} for {delay_s}");
    }
}

#[test]
fn too_many_columns_are_refused_and_one_that_is_forgotten_makes_room() {
    let mut learner = learned(6, 0.0);
    let rows = learner.rows();
    assert_eq!(learner.feed(&column("a"), 1.0), Fed::Tested);
    assert_eq!((rows, learner.rows()), (4000, 0), "what was learned without it is forgotten");
    assert_eq!(learner.feed(&column("b"), 1.0), Fed::Tested);
    assert_eq!(learner.feed(&column("c"), 1.0), Fed::Full);
    assert!(learner.drop_column("a") && !learner.drop_column("a"));
    assert_eq!(learner.feed(&column("c"), 1.0), Fed::Tested);
    assert_eq!(learner.tested().count(), MAX_TESTED);
}

#[test]
fn packed_sums_are_the_studys_normal_matrix() {
    let mut noise = Noise(9);
    let (mut packed, mut full): (Work, Normal<f64, WIDEST>) = (Work::new(), Normal::new(WIDEST));
    for _ in 0..500 {
        let row: [f32; WIDEST] = core::array::from_fn(|_| noise.next() as f32);
        let residual = row[3] * 0.5 + 0.1 * noise.next() as f32;
        packed.push(&row, residual);
        full.push(&row.map(f64::from), f64::from(residual));
    }
    let chosen = super::solve::Chosen::base(WIDEST);
    let step = super::solve::Factor::of(&packed, chosen, false).expect("regular").step(&packed);
    let expected = full.step(&full.factor().expect("regular"));
    for (got, right) in step.into_iter().zip(expected) {
        assert!(math::abs(f64::from(got) - right) < 1e-5, "{got} for {right}");
    }
    let after = f64::from(packed.squares_after(&step));
    assert!((after / full.squares_after(&expected) - 1.0).abs() < 1e-4);
    packed.shift(&step);
    assert!(math::abs(f64::from(packed.squares) / after - 1.0) < 1e-6);
}

/// The chip warms and cools by eight degrees and nobody says so, in quick and in slow motion, from near and from far.
#[test]
fn a_slow_cause_that_nobody_feeds_is_no_noise() {
    for (hz, turn_radps, far_ut) in
        [(100u64, 16.8, 0.0), (100, 16.8, 2.0), (100, 16.8, 6.0), (50, 1.6, 0.0), (50, 1.6, 2.0)]
    {
        let mut noise = Noise(3);
        let mut learner = Learner::new();
        let offset_ut = OFFSET_UT.map(|axis| axis + far_ut);
        learner.begin(&Calibration { offset_ut, ..Calibration::identity(50.0) });
        for i in 0..40 * hz {
            let t_s = i as f64 / hz as f64;
            let current_a = if ((t_s / 0.37) as u64).is_multiple_of(2) { 0.0 } else { 4.0 };
            let _ = learner.feed(&column("current_a"), current_a);
            let phase = t_s / 8.0 - math::floor(t_s / 8.0);
            let z = if phase < 0.5 { 1.0 - 4.0 * phase } else { 4.0 * phase - 3.0 };
            let (turn, across) = (turn_radps * t_s, math::sqrt(1.0 - z * z));
            let direction = [across * math::cos(turn), across * math::sin(turn), z];
            let warm_c = 8.0 * math::sin(0.21 * t_s);
            let measured = core::array::from_fn(|axis| {
                let hidden_ut = [-0.15, 0.2, 0.25][axis] * warm_c;
                (50.0 * direction[axis] + OFFSET_UT[axis] + hidden_ut + 0.15 * noise.next()) as f32
            });
            learner.push(measured, 1000 * i / hz, &Motion::UNKNOWN);
        }
        learner.settle();
        let outcome = asked(&learner, InUse::default());
        assert_ne!(outcome.verdict, Verdict::Complete, "{hz} Hz, {turn_radps} rad/s, {far_ut}: {outcome:?}");
        assert!(outcome.floor_ut > 0.1, "{hz} Hz, {turn_radps} rad/s, {far_ut}: {outcome:?}");
    }
}

#[test]
fn a_step_is_found_where_it_is_on_a_board_that_has_been_on_for_months() {
    // The lower half of the clock wraps in the middle, a little before the step, a little after it, and between snapshots beside it.
    for wraps_at in [0_u64, 40_000, 49_900, 50_100, 49_400, 60_000] {
        let begin_ms = 2 * (1 << 32) - wraps_at;
        let learner =
            learned_since(begin_ms, OFFSET_UT, 3, |i| if i < 2500 { [0.0; 3] } else { [1.5, -1.0, 0.5] });
        let outcome = asked(&learner, InUse::default());
        let (first, finding) = outcome.ranked().next().expect("candidates");
        assert_eq!((first, finding.status), (Candidate::Step, Status::Missing), "{outcome:?}");
        let Some(BuiltIn::Step(step)) = learner.effect(first) else { panic!("a step") };
        let since_s = step.at_s - begin_ms as f64 * 1e-3;
        assert!((since_s - 50.0).abs() < 1.0, "{wraps_at}: {since_s} s");
    }
}
