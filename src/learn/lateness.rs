//! What the dip, and the way between two directions, say of a late sensor.

use super::bounds::{DELAY_SIGMAS, DIP_TESTS, LEAST_BEATS, LEAST_ROWS};
use super::evidence::{Evidence, holds, is_worth};
use super::late::{DIP, Late};
use crate::math;
use crate::study::{Factor, Normal, Role};

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
    /// Probability that chance does as well, all tests counted.
    pub(super) p_value: f32,
    /// Whether the sensor is late.
    pub(super) is_shown: bool,
    /// The delay, s, and its standard error.
    pub(super) delay_s: f32,
    pub(super) error_s: f32,
    /// A step of the dip's columns: the rotation, the sine of the dip, the delay.
    pub(super) step: [f32; DIP],
}

/// The factor of all columns, or of all but the delay's, which is the last.
fn factor<const P: usize>(total: &Normal<f32, P>, with: bool) -> Option<Factor<f32, P>> {
    let mut factor = Factor::new();
    factor.extend(total, if with { P } else { P - 1 }, 0.0, &|_| Role::Required)?;
    Some(factor)
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
    pub(super) fn by_dip(late: &Late) -> Option<Self> {
        let total = late.total();
        let rows = f64::from(total.rows());
        let full = factor(&total, true)?;
        let variance = f64::from(full.squares(&total)) / (rows - DIP as f64);
        let time = late.memory.time(variance, rows, DIP as f64);
        let held_out = |with: bool| {
            let mut squares = 0.0;
            for block in late.blocks.iter().filter(|block| block.rows() > 0) {
                let rest = total.without(block);
                let Some(factor) = factor(&rest, with) else { return f32::NAN };
                squares += block.squares_after(&rest.step(&factor)).max(0.0);
            }
            squares
        };
        let (lateness, step) = Self::tested(&total, time, [false, true].map(held_out))?;
        Some(Self { step, ..lateness })
    }

    /// By the gyro.
    fn by_gyro(late: &Late) -> Option<Self> {
        // One way ends where the next begins: their noise cancels rather than adds, and no row counts for more than one.
        let (lateness, [x, y, z, delay_s]) = Self::tested(&late.by_gyro, 1.0, [f32::NAN; 2])?;
        let least_s = LEAST_BEATS * late.turning.beat_s() + DELAY_SIGMAS * lateness.error_s;
        Some(Self {
            by_turning: true,
            is_shown: lateness.is_shown && delay_s > least_s,
            // The rotation that is to be taken off.
            step: [-x, -y, -z, 0.0, delay_s],
            ..lateness
        })
    }

    /// Tests the last column, of rows `time` of which count as one.
    #[inline(never)]
    fn tested<const P: usize>(
        total: &Normal<f32, P>,
        time: f64,
        held_out: [f32; 2],
    ) -> Option<(Self, [f32; P])> {
        let rows = total.rows();
        if rows < LEAST_ROWS {
            return None;
        }
        let full = factor(total, true)?;
        let base = factor(total, false)?;
        let squares = [&base, &full].map(|factor| factor.squares(total));
        let [without, with] = squares;
        let evidence = Evidence::new(rows, time, P, DIP_TESTS);
        let [before, after] = held_out;
        let variance = f64::from(with) / f64::from(rows - P as u32);
        let delta = total.step(&full);
        let delay_s = *delta.last()?;
        let degrees = |squares: f32| math::sqrtf(squares.max(0.0) / rows as f32).to_degrees();
        let lateness = Self {
            by_turning: false,
            rms_deg: degrees(without),
            before_deg: degrees(before),
            after_deg: degrees(after),
            p_value: evidence.p_value(squares, 1.0, 1.0) as f32,
            // No sensor is early.
            is_shown: is_worth(evidence.fall(squares, 1.0), squares) && holds(held_out) && delay_s > 0.0,
            delay_s,
            error_s: math::sqrt(variance * time * f64::from(full.inverse_diagonal(P - 1))) as f32,
            step: [0.0; DIP],
        };
        Some((lateness, delta))
    }
}
