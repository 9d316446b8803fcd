//! Is the calibration in use still right? A watch over corrected samples, with figures of its own that never touch it.
//!
//! What is watched is the residual of the magnitude, against what the calibration itself predicts: `s² = noise² + error²`, with
//! its noise and its predicted error. Two sliding means of `residual² / s²` are kept:
//!
//! - **disturbed**: over [`DISTURBED_S`] = 2 s of time. Something near bends the field now: a car, a girder, a motor.
//! - **outdated**: over [`OUTDATED_S`] = 120 s of time *in which the board turned*, and only after as much of it. What stays
//!   wrong while the board goes through directions belongs to the board: a new magnet, a shock, another battery. A board that lies
//!   beside a girder for a day is disturbed, and its calibration is not outdated.
//!
//! Where there is an accelerometer, the *dip* is watched the same way: the sine of the angle between the corrected field and the level.
//! A car beside the board may turn the field and leave its magnitude. What the dip is here and how much it spreads (by the
//! calibration's own turn against the accelerometer, which magnitudes cannot tell, and by the hand that turns the board) is learned
//! from the first [`DIP_LEARNED_S`] = 60 s of turning, and then on while nothing is disturbed; before that the dip says nothing. A
//! sample taken while the board is accelerated, told by a specific force that is off by more than [`CALM_SHARE`] = 3 %, says nothing
//! of it either. *Disturbed* is either of the two, *outdated* the larger of the two values.
//!
//! *Disturbed* begins where its mean is above 9 (three times what is predicted) and ends below 4; one sample counts for no more
//! than 36 and has a weight of at most [`MOST_WEIGHT`] = 0.05, so that a single spike, however high, cannot begin it, nor can four in a
//! row. *Outdated* begins above 6 and ends below 3 of at most 12 a sample: after some 80 s of turning in which nothing was right.
//! Five minutes beside a girder do not reach it unless the board is turned for a third of them.

use crate::vector::{dot, norm};

/// Memory of *disturbed*, s.
pub const DISTURBED_S: f32 = 2.0;
/// Memory of *outdated*, s of turning.
pub const OUTDATED_S: f32 = 120.0;
/// Turning over which the dip is learned, s, before it counts.
pub const DIP_LEARNED_S: f32 = 60.0;
/// The specific force is gravity where it is this near to it.
pub const CALM_SHARE: f32 = 0.03;
/// Standard gravity, m/s².
const GRAVITY_MPS2: f32 = 9.806_65;
/// Half a degree: an accelerometer does not know better where down is.
const LEAST_DIP_SINE: f32 = 0.008_7;
/// Where a sliding mean of squared residuals over predicted ones begins to speak, where it ends, and what one sample adds at most.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Limits {
    begin: f32,
    end: f32,
    most: f32,
}

const DISTURBED: Limits = Limits { begin: 9.0, end: 4.0, most: 36.0 };
const OUTDATED: Limits = Limits { begin: 6.0, end: 3.0, most: 12.0 };
/// The weight of one sample at most.
pub const MOST_WEIGHT: f32 = 0.05;
/// The board turned where the field came from this far from where it last counted as turned: 5°.
const TURNED_COS: f32 = 0.996_194_7;
/// Turning counts for no more time than this a look, s: slower is no turning.
const LONGEST_LOOK_S: f32 = 2.0;
/// Of the field: below it a residual is no sign of anything, however quiet the sensor is.
const LEAST_SHARE: f32 = 0.002;

/// What the watch says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Condition {
    /// Nothing speaks against the calibration.
    #[default]
    Good,
    /// The field is bent where the board is now.
    Disturbed,
    /// The calibration no longer fits the board: calibrate again.
    Outdated,
}

impl Condition {
    /// The word of the console.
    pub const fn name(self) -> &'static str {
        match self {
            Condition::Good => "good",
            Condition::Disturbed => "disturbed",
            Condition::Outdated => "outdated",
        }
    }
}

/// A mean that slides, and whether it is above its limit, with hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
struct Sliding {
    mean: f32,
    above: bool,
}

impl Sliding {
    fn push(&mut self, value: f32, weight: f32, limits: &Limits) {
        self.mean += (value.min(limits.most) - self.mean) * weight.min(MOST_WEIGHT);
        self.above = self.mean > if self.above { limits.end } else { limits.begin };
    }
}

/// What the sine of the dip is where the board is used.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
struct Dip {
    mean: f32,
    variance: f32,
    /// Turning that it was learned from, s.
    learned_s: f32,
}

impl Dip {
    /// `sine² off the mean` over what is expected of it; `None` as long as that is not known.
    fn value(&self, sine: f32, predicted: f32) -> Option<f32> {
        let off = sine - self.mean;
        let expected = self.variance + predicted + LEAST_DIP_SINE * LEAST_DIP_SINE;
        (self.learned_s >= DIP_LEARNED_S).then(|| off * off / expected)
    }

    fn learn(&mut self, sine: f32, look_s: f32) {
        self.learned_s = (self.learned_s + look_s).min(OUTDATED_S);
        let weight = look_s / self.learned_s;
        let off = sine - self.mean;
        self.mean += weight * off;
        self.variance += weight * ((1.0 - weight) * off * off - self.variance);
    }
}

/// The sine of the dip of a field of this length, where the specific force says which way is down.
fn dip_sine(corrected_ut: [f32; 3], length_ut: f32, accel_mps2: Option<[f32; 3]>) -> Option<f32> {
    let force = accel_mps2?;
    let size = norm(force);
    let is_calm = (size - GRAVITY_MPS2).abs() < CALM_SHARE * GRAVITY_MPS2;
    // Down is against the force.
    (is_calm && length_ut > 0.0).then(|| -dot(corrected_ut, force) / (size * length_ut))
}

/// The watch over one calibration. A few words of memory, some thirty floating-point operations a sample, twice as many with the dip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitor {
    field_ut: f32,
    /// Of the predicted residual, 1/µT².
    per_square: f32,
    last_ms: Option<u64>,
    disturbed: Sliding,
    disturbed_dip: Sliding,
    outdated: Sliding,
    dip: Dip,
    /// Of the sine of the dip: what noise and predicted error alone make of it.
    dip_predicted: f32,
    /// Where the field came from when the board last turned, and when that was.
    turned: Option<([f32; 3], u64)>,
    /// Time of turning that was watched, s; counted up to the memory.
    turning_s: f32,
}

impl Monitor {
    /// Watches a calibration of this field, noise and predicted error, all µT.
    pub fn new(field_ut: f32, noise_ut: f32, predicted_error_ut: f32) -> Self {
        let least = LEAST_SHARE * field_ut;
        let square = noise_ut * noise_ut + predicted_error_ut * predicted_error_ut;
        // A NaN is no prediction: the least is used.
        let square = if square > least * least { square } else { least * least };
        Self {
            field_ut,
            per_square: 1.0 / square,
            last_ms: None,
            disturbed: Sliding::default(),
            disturbed_dip: Sliding::default(),
            outdated: Sliding::default(),
            dip: Dip::default(),
            dip_predicted: square / (field_ut * field_ut),
            turned: None,
            turning_s: 0.0,
        }
    }

    /// Takes a corrected sample, µT, of this time since power-up, and what the accelerometer said then, m/s² of specific force in the
    /// same axes, where there is one. A sample that is not finite is passed over, and so is a
    /// time that goes backwards: of a tick that wraps one sample, or none with [`Extended`](crate::clock::Extended).
    pub fn push(&mut self, t_ms: u64, corrected_ut: [f32; 3], accel_mps2: Option<[f32; 3]>) {
        let length = norm(corrected_ut);
        if !length.is_finite() {
            return;
        }
        let residual = length - self.field_ut;
        let value = residual * residual * self.per_square;
        let Some(last_ms) = self.last_ms.replace(t_ms) else {
            self.turned = Some((corrected_ut, t_ms));
            return;
        };
        let Some(passed_ms) = t_ms.checked_sub(last_ms) else { return };
        let weight = passed_ms as f32 / 1000.0 / DISTURBED_S;
        self.disturbed.push(value, weight, &DISTURBED);
        let sine = dip_sine(corrected_ut, length, accel_mps2);
        let dip_value = sine.and_then(|sine| self.dip.value(sine, self.dip_predicted));
        if let Some(dip_value) = dip_value {
            self.disturbed_dip.push(dip_value, weight, &DISTURBED);
        }
        let Some((then, then_ms)) = self.turned else { return };
        if dot(then, corrected_ut) < TURNED_COS * norm(then) * length {
            let look_s = t_ms.saturating_sub(then_ms) as f32 / 1000.0;
            self.turned = Some((corrected_ut, t_ms));
            if look_s <= LONGEST_LOOK_S {
                self.turning_s = (self.turning_s + look_s).min(OUTDATED_S);
                self.outdated.push(value.max(dip_value.unwrap_or(0.0)), look_s / OUTDATED_S, &OUTDATED);
                if let Some(sine) = sine
                    && !self.disturbed.above
                    && !self.disturbed_dip.above
                {
                    self.dip.learn(sine, look_s);
                }
            }
        }
    }

    /// What is to be said now.
    pub fn condition(&self) -> Condition {
        if self.outdated.above && self.turning_s >= OUTDATED_S {
            Condition::Outdated
        } else if self.disturbed.above || self.disturbed_dip.above {
            Condition::Disturbed
        } else {
            Condition::Good
        }
    }

    /// The rms residual of the last seconds, in multiples of what the calibration predicts.
    pub fn ratio(&self) -> f32 {
        crate::math::sqrtf(self.disturbed.mean)
    }

    /// The rms of the dip's distance from what it is here, over the last seconds, in multiples of what is expected; `None` as long as
    /// that is not known.
    pub fn dip_ratio(&self) -> Option<f32> {
        (self.dip.learned_s >= DIP_LEARNED_S).then(|| crate::math::sqrtf(self.disturbed_dip.mean))
    }
}

#[cfg(test)]
mod tests;
