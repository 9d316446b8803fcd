//! What the dip says of a late sensor.

use super::late::{DIP, DIP_BASE, Late};
use super::solve::{Chosen, Factor};
use super::sums::Work;
use super::test::chance;
use crate::math;
use crate::study::rule::{RELEVANCE, falls, is_accepted};

/// Fewer samples say nothing.
const LEAST_ROWS: u32 = 300;

/// The delay's test.
pub(super) struct Lateness {
    /// Rms of the dip without it, degrees, ...
    pub(super) rms_deg: f32,
    /// ... the same on held-out blocks of time, and that with it; NaN where some block cannot be predicted.
    pub(super) before_deg: f32,
    pub(super) after_deg: f32,
    /// Probability that chance does as well: once for the delay and once for a coupling of the axes, which the host tests too.
    pub(super) p_value: f64,
    /// Whether the sensor is late.
    pub(super) is_shown: bool,
}

impl Lateness {
    /// `None` where there is too little of it.
    pub(super) fn of(late: &Late) -> Option<Self> {
        let rows = late.blocks.rows();
        if rows < LEAST_ROWS {
            return None;
        }
        let mut total = Work::new();
        late.blocks.iter().for_each(|block| total.merge(block));
        let (alone, lag) = (Chosen::base(DIP_BASE), DIP_BASE);
        let with = alone.with(lag, 1);
        let base = Factor::of(&total, alone, false)?;
        let full = Factor::of(&total, with, true)?;
        let variance = f64::from(full.squares(&total)) / f64::from(rows - DIP as u32);
        let time = late.memory.time(variance, f64::from(rows), DIP as f64);
        let gained = base.test(&total, lag, 1, false);
        let p_value = chance(&gained, variance, time, rows, DIP_BASE);
        let without = base.squares(&total);
        let delay_s = full.step(&total).get(lag).copied().unwrap_or(0.0);
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
        let degrees = |squares: f32| math::sqrtf(squares.max(0.0) / rows as f32).to_degrees();
        let lowers = gained.decrease > RELEVANCE as f32 * without
            && falls(before.map(f64::from), after.map(f64::from));
        Some(Self {
            rms_deg: degrees(without),
            before_deg: before.map_or(f32::NAN, degrees),
            after_deg: after.map_or(f32::NAN, degrees),
            p_value: (2.0 * p_value).min(1.0),
            // No sensor is early.
            is_shown: is_accepted(p_value, 2, lowers) && delay_s > 0.0,
        })
    }
}
