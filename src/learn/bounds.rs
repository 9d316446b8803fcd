//! The bounds of the board's study, each with its reason: probabilities, relevance, and what a sensor or single precision can do.

use crate::study::rule::STEP_PLACES;

/// Twice the logarithm of odds of 100 to 1: one effect in a hundred is added wrongly. As in the host's score (docs/method.md).
pub(super) const MIN_SCORE_FALL: f32 = 9.210_34;
/// Twice the logarithm of odds of 19 to 1: another cause that is likelier than one in twenty is not excluded.
pub(super) const RIVAL_SCORE_FALL: f32 = 5.888_878;
/// An effect that explains less of the squared residual changes no correction by more than 3 %. As in the host's score.
pub(super) const MIN_SHARE: f32 = 0.05;
/// A block of time is predicted with an effect if a tenth of what is known of it comes from the others: else their noise is too large.
pub(super) const MIN_SHARE_ELSEWHERE: f32 = 0.1;
/// A direction that is a smaller share of its column has no digits in single precision.
pub(super) const MIN_DIRECTION: f32 = 1e-4;
/// A column tells its cause to a tenth of its variation (its steps, its delay): of 1 % of the square two causes are not told apart.
pub(super) const COLUMN_ERROR: f32 = 0.01;
/// Independent places at which a jump is looked for.
pub(super) const JUMP_PLACES: f64 = STEP_PLACES as f64;
/// Twice the logarithm of their number.
pub(super) const JUMP_PLACES_PRICE: f64 = 7.742_402_021_815_782;
/// Noise is told from structure if the error would fall by an eighth without it.
pub(super) const STRUCTURE_SHARE: f64 = 0.25;
/// By so many standard errors of the noise's variance more: one chance in forty.
pub(super) const NOISE_SIGMAS: f64 = 2.0;
/// Samples of the shortest turn in all directions: fewer say nothing.
pub(super) const LEAST_ROWS: u32 = 300;
/// Standard error of a base parameter, over the field, beyond which an effect of the usual size is not seen.
pub(super) const MOST_BASE_ERROR: f32 = 0.03;

/// A pause longer than this is a gap, ms: no sensor is read less often than four times a second.
pub(super) const GAP_MS: u64 = 250;

/// A mark is looked at with so many rows before and after it: five times the parameters of a base and a jump.
pub(super) const LEAST_JUMP_ROWS: u32 = 48;
/// A step has at least this part of all rows (one of so many) before and after it: as many as there are places.
pub(super) const LEAST_JUMP_SHARE: u32 = 50;
/// A jump that explains this share stays in view: none of chance does in [`LEAST_JUMP_ROWS`] on either side.
pub(super) const FIRM_SHARE: f32 = 0.2;

/// Rows of a dip before the first look whether its model is linear at a good point: forty for each of its parameters.
pub(super) const LOOK_AT: u32 = 200;
/// A rotation from where the dip is linear that makes errors of 0.1 %: half the square, rad.
pub(super) const FAR_RAD: f32 = 0.04;
/// No step of a linear model is right to a third from here on, rad.
pub(super) const ABSURD_RAD: f32 = 0.8;
/// The dip begins again so often at most: an accelerometer that is waved shows another rotation each time.
pub(super) const TRIES: u8 = 3;
/// A direction is held against where a gyro turns it over this time, s: long against the sensor's noise, short against a movement.
pub(super) const SPAN_S: f32 = 0.1;
/// Of three moments between which the field shows how it turns, one is at least so long after the other, ms.
pub(super) const APART_MS: u32 = 40;
/// A gyro that is read once a sample, or is the mean since the last one, is itself known to a part of the time between two: a shorter
/// delay says nothing of the magnetometer.
pub(super) const LEAST_BEATS: f32 = 0.75;
/// By so many standard errors more: one chance in a thousand.
pub(super) const DELAY_SIGMAS: f32 = 3.0;
/// What is tested of the dip: a delay and a coupling of the axes, which the host tests too, and the delay in another way.
pub(super) const DIP_TESTS: usize = 3;

/// Up to so many rows it is early: little is lost where all of them are forgotten for a better point.
pub(super) const EARLY_ROWS: u32 = 1024;
/// Rows between two looks where the study stands.
pub(super) const LOOK_EVERY: u32 = 256;
/// A point further than this from what the sums say, relative to the field, is left, and everything begins anew, while no more rows
/// than that would be lost with those that were lost so before: what is wrong for long is rather an effect.
pub(super) const FAR: [(f32, u32); 3] = [(0.008, 400), (0.05, 1600), (0.25, u32::MAX)];
/// An effect may be as many times as far: it goes there only when its column does.
pub(super) const EFFECT_SHARE: f32 = 0.5;
/// A point nearer than this is near enough: its square is below every noise.
pub(super) const NEAR: f32 = 0.002;
/// No base is that far: as far as the field is large.
pub(super) const ABSURD: f32 = 1.0;
/// The samples tell the base once its standard errors are this small, ...
pub(super) const TOLD: f32 = 0.01;
/// ... and well enough to begin anew where they are so many times smaller than the way there: one chance in two thousand.
pub(super) const WELL_TOLD: f32 = 3.5;
/// The dip is of another direction once the base has moved by more than this: half a degree.
pub(super) const ANOTHER_DIRECTION: f32 = 0.01;
/// An effect stands at the point from odds of 5·10⁸ to 1 on: with fewer, early on, it is what the model's own curvature looks like.
pub(super) const POINT_SCORE_FALL: f32 = 40.0;
/// An effect's columns at their ends are known to this, relative to the field, before it stands at the point.
pub(super) const EFFECT_TOLD: f32 = 0.004;
