//! What the dip, and the way between two directions, say of a late sensor.

use super::late::{DIP, DIP_BASE, Late};
use super::solve::{Chosen, Factor};
use super::sums::Work;
use super::test::chance;
use super::turning::{TURNING, TURNING_BASE};
use crate::math;
use crate::study::rule::{RELEVANCE, falls, is_accepted};

/// Fewer samples say nothing.
const LEAST_ROWS: u32 = 300;
/// What is tested: a delay and a coupling of the axes, which the host tests too, and the delay in another way.
const TESTS: usize = 3;

/// A gyro that is read once a sample, or is the mean since the last one, is itself known to a part of the time between two: a shorter
/// delay says nothing of the magnetometer.
const LEAST_BEATS: f32 = 0.75;
/// By so many standard errors.
const SIGMAS: f32 = 3.0;

/// The delay's test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lateness {
    /// Held against a gyro's turning instead of gravity.
    pub(super) by_turning: bool,
    /// Rms of the dip, or of the way, without it, degrees, ...
    pub(super) rms_deg: f32,
    /// ... of the dip on held-out blocks of time, and that with it; NaN where some block cannot be predicted.
    pub(super) before_deg: f32,
    pub(super) after_deg: f32,
    /// p-value, corrected for all tests.
    pub(super) p_value: f64,
    /// Whether the sensor is late.
    pub(super) is_shown: bool,
    /// The delay, s, and its standard error.
    pub(super) delay_s: f32,
    pub(super) error_s: f32,
    /// A step of the columns: the rotation, the sine of the dip, the delay.
    pub(super) step: [f32; DIP],
}

fn degrees(squares: f32, rows: u32) -> f32 {
    math::sqrtf(squares.max(0.0) / rows as f32).to_degrees()
}

impl Lateness {
    /// By whichever tells the delay better: gravity, while a board is turned about its own middle, the gyro where it is waved, which an
    /// accelerometer takes for gravity. `None` where there is too little of either.
    pub(super) fn of(late: &Late) -> Option<Self> {
        match (Self::by_dip(late), Self::by_gyro(late)) {
            (Some(dip), Some(turning)) => Some(if turning.error_s < dip.error_s { turning } else { dip }),
            (dip, turning) => dip.or(turning),
        }
    }

    /// By the dip.
    // Apart from the other way: the stack carries the sums of one of them at a time.
    #[inline(never)]
    pub(super) fn by_dip(late: &Late) -> Option<Self> {
        let rows = late.blocks.rows();
        if rows < LEAST_ROWS {
            return None;
        }
        let mut total = Work::new();
        late.blocks.iter().for_each(|block| total.merge(block));
        let (alone, lag) = (Chosen::base(DIP_BASE), DIP_BASE);
        let with = alone.with(lag, 1);
        let base = Factor::of(&total, alone, false)?;
        let full = Factor::of(&total, with, false)?;
        let variance = f64::from(full.squares(&total)) / f64::from(rows - DIP as u32);
        let time = late.memory.time(variance, f64::from(rows), DIP as f64);
        let gained = base.test(&total, lag, 1, false);
        let p_value = chance(&gained, variance, time, rows, DIP_BASE);
        let without = base.squares(&total);
        let delta = full.step(&total);
        let mut held = |chosen: Chosen| {
            let mut squares = 0.0;
            for block in late.blocks.iter().filter(|block| block.rows > 0) {
                total.take_out(block);
                let delta = Factor::of(&total, chosen, true)?.step(&total);
                total.merge(block);
                let mut own = Work::new();
                own.merge(block);
                squares += own.squares_after(&delta).max(0.0);
            }
            Some(squares)
        };
        let (before, after) = (held(alone), held(with));
        let lowers = gained.decrease > RELEVANCE as f32 * without
            && falls(before.map(f64::from), after.map(f64::from));
        let [x, y, z, sine, delay_s, ..] = delta;
        Some(Self {
            by_turning: false,
            rms_deg: degrees(without, rows),
            before_deg: before.map_or(f32::NAN, |squares| degrees(squares, rows)),
            after_deg: after.map_or(f32::NAN, |squares| degrees(squares, rows)),
            p_value: (TESTS as f64 * p_value).min(1.0),
            // No sensor is early.
            is_shown: is_accepted(p_value, TESTS, lowers) && delay_s > 0.0,
            delay_s,
            error_s: math::sqrt(variance * time * f64::from(full.inverse(lag))) as f32,
            step: [x, y, z, sine, delay_s],
        })
    }

    /// By the gyro.
    #[inline(never)]
    fn by_gyro(late: &Late) -> Option<Self> {
        let sums = &late.by_gyro;
        let rows = sums.rows;
        if rows < LEAST_ROWS {
            return None;
        }
        let mut total = Work::new();
        total.merge(sums);
        let (alone, lag) = (Chosen::base(TURNING_BASE), TURNING_BASE);
        let base = Factor::of(&total, alone, false)?;
        let full = Factor::of(&total, alone.with(lag, 1), false)?;
        let gained = base.test(&total, lag, 1, false);
        let (without, with) = (base.squares(&total), full.squares(&total));
        let variance = f64::from(with) / f64::from(rows - TURNING as u32);
        // One way ends where the next begins: their noise cancels rather than adds, and no row counts for more than one.
        let p_value = chance(&gained, variance, 1.0, rows, TURNING_BASE);
        let [x, y, z, delay_s, ..] = full.step(&total);
        let lowers = gained.decrease > RELEVANCE as f32 * without;
        let error_s = math::sqrt(variance * f64::from(full.inverse(lag))) as f32;
        let least_s = LEAST_BEATS * late.turning.beat_s() + SIGMAS * error_s;
        Some(Self {
            by_turning: true,
            rms_deg: degrees(without, rows),
            before_deg: degrees(without, rows),
            after_deg: degrees(with, rows),
            p_value: (TESTS as f64 * p_value).min(1.0),
            is_shown: is_accepted(p_value, TESTS, lowers) && delay_s > least_s,
            delay_s,
            error_s,
            // The rotation that is to be taken off.
            step: [-x, -y, -z, 0.0, delay_s],
        })
    }
}
