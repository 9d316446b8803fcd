//! Columns next to the magnetometer: what they are in truth and what the log shows of them.

use crate::linalg::{Span, rms, standardised};
use crate::motion::Motion;
use crate::noise::{ar1, white};
use crate::random::{Source, choose, log_uniform, normal, uniform};
use std::f64::consts::TAU;

/// Time before the log for which signals exist, s: late columns and thermal masses need a past.
const PAST_S: f64 = 60.0;
/// Time between two values of a signal, s.
const STEP_S: f64 = 0.01;

/// Quantity over time, before and during the log.
#[derive(Clone)]
pub struct Signal(Vec<f64>);

impl Signal {
    /// Value at a time in s, between two values by a straight line.
    pub fn at(&self, t: f64) -> f64 {
        let place = ((t + PAST_S) / STEP_S).clamp(0.0, self.0.len() as f64 - 1.001);
        let (whole, part) = (place as usize, place.fract());
        (1.0 - part) * self.0[whole] + part * self.0[whole + 1]
    }

    /// Values at the times in s.
    pub fn sample(&self, times: &[f64]) -> Vec<f64> {
        times.iter().map(|&t| self.at(t)).collect()
    }

    /// First-order low-pass with a time constant in s, at rest before its first value.
    pub fn low_pass(&self, tau_s: f64) -> Signal {
        let new = 1.0 - (-STEP_S / tau_s).exp();
        let mut state = self.0[0];
        let follow = |&v: &f64| {
            state += new * (v - state);
            state
        };
        Signal(self.0.iter().map(follow).collect())
    }

    /// Function of time.
    pub fn from_fn(length: f64, f: impl FnMut(f64) -> f64) -> Signal {
        Signal(grid(length).into_iter().map(f).collect())
    }
}

fn grid(length: f64) -> Vec<f64> {
    let n = ((length + PAST_S) / STEP_S) as usize + 100;
    (0..n).map(|i| i as f64 * STEP_S - PAST_S).collect()
}

/// Course of a signal over time, between about 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// Exponential approach after switching on, half of the time with a later return.
    WarmUp,
    /// Smooth random walk.
    SlowRandom,
    /// Levels held for some seconds.
    Steps,
    /// Lively, like a pilot's throttle.
    Throttle,
    /// On and off with a changing duty.
    Pulses,
    /// Noise with a memory.
    Coloured,
    /// Steady rise or fall with small noise.
    Ramp,
    /// One sine.
    Sine,
    /// White noise.
    White,
}

impl Course {
    fn draw(self, rng: &mut Source, length: f64) -> Signal {
        let times = grid(length);
        let n = times.len();
        match self {
            Course::WarmUp => {
                let on = uniform(rng, -25.0, 0.1 * length);
                let (rise, fall) = (length * uniform(rng, 0.1, 0.5), length * uniform(rng, 0.1, 0.5));
                let off = length * uniform(rng, 0.4, 1.6);
                let wander = smooth_walk(rng, n, length / 20.0);
                let value = |(&t, w): (&f64, &f64)| {
                    let up = |t: f64| 1.0 - (-(t - on).max(0.0) / rise).exp();
                    let level = if t < off { up(t) } else { up(off) * (-(t - off) / fall).exp() };
                    level + 0.05 * (w - 0.5)
                };
                Signal(times.iter().zip(&wander).map(value).collect())
            }
            Course::SlowRandom => {
                let time_s = length * log_uniform(rng, 0.02, 0.12);
                Signal(smooth_walk(rng, n, time_s))
            }
            Course::Steps => {
                let hold = log_uniform(rng, 1.0, (length / 10.0).max(2.0));
                let lag = log_uniform(rng, 0.02, 0.3);
                let (mut level, mut next) = (0.0, -PAST_S);
                let steps = Signal::from_fn(length, |t| {
                    if t >= next {
                        level = uniform(rng, 0.0, 1.0);
                        next += hold * uniform(rng, 0.3, 2.0);
                    }
                    level
                });
                steps.low_pass(lag)
            }
            Course::Throttle => {
                let memory = log_uniform(rng, 0.4, 3.0) / STEP_S;
                let steps = Course::Steps.draw(rng, length);
                let lively = ar1(rng, n, memory);
                let mixed =
                    steps.0.iter().zip(&lively).map(|(s, l)| (0.2 + 0.6 * s + 0.15 * l).clamp(0.0, 1.0));
                Signal(mixed.collect()).low_pass(0.05)
            }
            Course::Pulses => {
                let period = log_uniform(rng, 0.4, 4.0);
                let duty = smooth_walk(rng, n, length / 8.0);
                let mut duties = duty.iter();
                Signal::from_fn(length, |t| {
                    let duty = duties.next().copied().unwrap_or(0.5);
                    f64::from((t / period).rem_euclid(1.0) < 0.15 + 0.7 * duty)
                })
            }
            Course::Coloured => {
                let memory = log_uniform(rng, 0.2, (length / 15.0).max(1.0)) / STEP_S;
                Signal(ar1(rng, n, memory).iter().map(|v| 0.5 + 0.2 * v).collect())
            }
            Course::Ramp => {
                let wander = smooth_walk(rng, n, length / 20.0);
                Signal(times.iter().zip(wander).map(|(t, w)| t / length + 0.1 * w).collect())
            }
            Course::Sine => {
                let (period, phase) = (log_uniform(rng, 1.5, length / 3.0), uniform(rng, 0.0, TAU));
                Signal::from_fn(length, |t| 0.5 + 0.5 * (TAU * t / period + phase).sin())
            }
            Course::White => Signal(white(rng, n).iter().map(|v| 0.5 + 0.2 * v).collect()),
        }
    }
}

/// Noise through two low-passes of a time constant in s, stretched to 0 to 1.
fn smooth_walk(rng: &mut Source, n: usize, time_s: f64) -> Vec<f64> {
    let smooth = Signal(ar1(rng, n, time_s / STEP_S)).low_pass(0.3 * time_s);
    let least = smooth.0.iter().copied().fold(f64::INFINITY, f64::min);
    let most = smooth.0.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    smooth.0.iter().map(|v| (v - least) / (most - least).max(1e-12)).collect()
}

/// Quantity that a log may hold: limits in the unit of its name, resolution, and the courses it may take.
#[derive(Clone, Copy)]
pub struct Quantity {
    pub name: &'static str,
    range: [f64; 2],
    resolution: f64,
    courses: &'static [Course],
}

const fn quantity(
    name: &'static str,
    range: [f64; 2],
    resolution: f64,
    courses: &'static [Course],
) -> Quantity {
    Quantity { name, range, resolution, courses }
}

const THERMAL: &[Course] = &[Course::WarmUp, Course::WarmUp, Course::SlowRandom];
const ELECTRIC: &[Course] = &[Course::Steps, Course::Throttle, Course::Pulses, Course::Coloured];
const LIVELY: &[Course] = &[Course::Steps, Course::Throttle, Course::Coloured];
const CALM: &[Course] = &[Course::SlowRandom, Course::Coloured];
const ANY: &[Course] =
    &[Course::SlowRandom, Course::Steps, Course::Sine, Course::White, Course::Coloured, Course::Ramp];

pub const TEMPERATURE: Quantity = quantity("temp_c", [18.0, 45.0], 0.0625, THERMAL);
pub const CURRENT: Quantity = quantity("current_a", [0.2, 18.0], 0.01, ELECTRIC);
pub const THROTTLE: Quantity = quantity("throttle", [0.0, 1.0], 0.001, LIVELY);
pub const VOLTAGE: Quantity = quantity("voltage_v", [14.2, 16.6], 0.01, CALM);
pub const FAN: Quantity = quantity("fan_rpm", [900.0, 6200.0], 10.0, &[Course::Steps, Course::SlowRandom]);
const SERVO: Quantity = quantity("servo_deg", [-45.0, 45.0], 0.1, LIVELY);
pub const PUMP: Quantity = quantity("pump_a", [0.0, 3.0], 0.005, ELECTRIC);
const ALTITUDE: Quantity = quantity("altitude_m", [2.0, 90.0], 0.1, CALM);
const COIL: Quantity = quantity("coil_a", [-1.0, 1.0], 0.001, LIVELY);

/// Quantities whose field adds to the measured one.
pub const FOR_OFFSET: [Quantity; 9] =
    [TEMPERATURE, CURRENT, CURRENT, THROTTLE, VOLTAGE, FAN, SERVO, PUMP, COIL];
/// Quantities that may change the sensitivity.
pub const FOR_GAIN: [Quantity; 4] = [TEMPERATURE, TEMPERATURE, VOLTAGE, PUMP];
/// Quantities along which the ambient field may change.
pub const FOR_FIELD: [Quantity; 3] = [ALTITUDE, COIL, TEMPERATURE];
/// Quantities that only ever stand in the log.
const IDLE: [Quantity; 7] = [
    quantity("humidity_pct", [30.0, 60.0], 0.1, CALM),
    quantity("pressure_hpa", [985.0, 1020.0], 0.01, ANY),
    quantity("cpu_load", [0.05, 0.95], 0.01, ANY),
    quantity("rssi_dbm", [-90.0, -40.0], 1.0, ANY),
    quantity("light_lux", [50.0, 900.0], 1.0, ANY),
    quantity("sat_count", [7.0, 19.0], 1.0, &[Course::SlowRandom, Course::Steps]),
    quantity("case_c", [20.0, 35.0], 0.1, THERMAL),
];

/// One column: the true quantity, and how the log shows it.
#[derive(Clone)]
pub struct Column {
    /// Name in the log.
    pub name: String,
    /// The quantity in the unit of its name.
    pub signal: Signal,
    /// Age of what the log shows, s.
    pub late_s: f64,
    /// Time between two filled cells, s; 0 fills all.
    pub every_s: f64,
    /// Stretches of the log without a value: from and to, s.
    pub gaps: Vec<[f64; 2]>,
    noise: f64,
    resolution: f64,
}

impl Column {
    /// Draws a column of a quantity for a log of a length in s.
    pub fn draw(rng: &mut Source, quantity: Quantity, length: f64) -> Column {
        let course = choose(rng, quantity.courses);
        let shape = course.draw(rng, length);
        let [low, high] = quantity.range;
        let (centre, reach) = (0.5 * (low + high), 0.5 * (high - low) * uniform(rng, 0.4, 1.0));
        let signal = Signal(shape.0.iter().map(|z| centre + reach * (2.0 * z - 1.0)).collect());
        Column::new(quantity.name, signal, 0.004 * reach, quantity.resolution)
    }

    /// Column of a known signal; noise and resolution in its unit.
    pub fn new(name: &str, signal: Signal, noise: f64, resolution: f64) -> Column {
        Column { name: name.into(), signal, late_s: 0.0, every_s: 0.0, gaps: Vec::new(), noise, resolution }
    }

    /// Throttle and battery current of a drone in a motion; `None` for what does not fly.
    pub fn of_flight(rng: &mut Source, motion: &Motion, length: f64) -> Option<(Column, Column)> {
        motion.thrust(0.0)?;
        let (hover, hover_a) = (uniform(rng, 0.35, 0.55), log_uniform(rng, 5.0, 25.0));
        let thrust = |t: f64| motion.thrust(t).unwrap_or(1.0).max(0.0);
        // Thrust grows with the square of the throttle; the power to hover with its power 1.5.
        let throttle = Signal::from_fn(length, |t| (hover * thrust(t).sqrt()).min(1.0));
        let current = Signal::from_fn(length, |t| 0.4 + hover_a * thrust(t).powf(1.5)).low_pass(0.03);
        Some((
            Column::new("throttle", throttle, 0.002, 0.001),
            Column::new("current_a", current, 0.01 * hover_a, 0.01),
        ))
    }

    /// The cells of the log at the times in s; NaN where a cell is empty.
    pub fn cells(&self, rng: &mut Source, times: &[f64]) -> Vec<f64> {
        let mut next = times[0];
        let mut cell = |t: f64| {
            let missing = t < next || self.gaps.iter().any(|[from, to]| t >= *from && t < *to);
            if missing {
                return f64::NAN;
            }
            while self.every_s > 0.0 && next <= t {
                next += self.every_s;
            }
            let value = self.signal.at(t - self.late_s) + self.noise * normal(rng);
            (value / self.resolution).round() * self.resolution
        };
        times.iter().map(|&t| cell(t)).collect()
    }
}

/// Names for columns that cause nothing, without those in use, in random order.
pub fn decoys(rng: &mut Source, used: &[String], count: usize, length: f64) -> Vec<Column> {
    let mut all: Vec<Quantity> = IDLE.to_vec();
    all.extend([TEMPERATURE, CURRENT, VOLTAGE, FAN, SERVO, PUMP, ALTITUDE]);
    all.retain(|quantity| !used.iter().any(|name| name == quantity.name));
    crate::random::shuffle(rng, &mut all);
    all.into_iter().take(count).map(|quantity| Column::draw(rng, quantity, length)).collect()
}

/// Column whose correlation with another over the log is exactly `correlation`.
pub fn twin(rng: &mut Source, of: &Column, correlation: f64, times: &[f64]) -> Vec<f64> {
    let values = of.signal.sample(times);
    let cause = standardised(&values);
    let length = times[times.len() - 1];
    let own = choose(rng, &[Course::SlowRandom, Course::Coloured, Course::Steps, Course::White]);
    let own = standardised(&own.draw(rng, length).sample(times));
    let own = standardised(&Span::new(std::slice::from_ref(&cause)).project_out(&own));
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let (reach, rest) = (rms(&centred), (1.0 - correlation * correlation).sqrt());
    let mixed = cause.iter().zip(&own).map(|(c, o)| mean + reach * (correlation * c + rest * o));
    mixed.collect()
}
