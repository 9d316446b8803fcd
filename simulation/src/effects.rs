//! Hidden effects: what is asked for, and what was drawn.

use super::scale::unit_coefficients;
use super::{MOST_ROUNDS, World};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use std::fmt;

/// Draws of one effect until its readings are unique.
const MOST_DRAWS: usize = 50;

/// Shape of a hidden effect.
#[derive(Clone, Debug, PartialEq)]
pub enum EffectKind {
    /// An additive vector in proportion to a column: `offset:COLUMN`, `offset:COLUMN^2`, `offset:COLUMN@delay`.
    Offset {
        /// The column.
        column: String,
        /// Power of the column, 1 or 2.
        power: i32,
        /// Whether the column acts late.
        delayed: bool,
    },
    /// A gain of each axis in proportion to a column: `gain:COLUMN`.
    Gain(String),
    /// The field's magnitude follows a column: `field:COLUMN`.
    Field(String),
    /// An offset that drifts steadily.
    Drift,
    /// An offset that jumps once.
    Step,
    /// A pure delay of the sensor, strength in multiples of the noise of the whole vector (`lag=18ms` states it in time).
    Lag,
    /// Eddy currents: a 3×3 coupling to the rate of change of the field.
    Eddy,
    /// Squares and cubes of each axis.
    Nonlinearity,
    /// Products of axes.
    CrossAxis,
    /// A sinusoid in time.
    Periodic,
    /// A rotation between the magnetometer and the accelerometer, strength in degrees.
    Misalignment,
    /// The x and y axes swapped: a mirror image, not a rotation.
    AxisOrder,
}

impl EffectKind {
    /// The id under which `diagnose` names this effect.
    pub fn id(&self) -> String {
        match self {
            EffectKind::Offset { column, power, delayed } => {
                let square = if *power == 2 { "^2" } else { "" };
                format!("offset:{column}{}{square}", if *delayed { "@delay" } else { "" })
            }
            EffectKind::Gain(column) => format!("gain:{column}"),
            EffectKind::Field(column) => format!("field:{column}"),
            EffectKind::Drift => "drift".into(),
            EffectKind::Step => "step".into(),
            EffectKind::Lag | EffectKind::Eddy => "lag".into(),
            EffectKind::Nonlinearity => "nonlinearity".into(),
            EffectKind::CrossAxis => "cross-axis".into(),
            EffectKind::Periodic => "periodic".into(),
            EffectKind::Misalignment => "misalignment".into(),
            EffectKind::AxisOrder => "axis-order".into(),
        }
    }
}

/// One hidden effect to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectSpec {
    /// Shape.
    pub kind: EffectKind,
    /// The disturbance's rms as a multiple of the noise in the residual that sees it, beyond what the base model absorbs.
    pub strength: f64,
    /// A delay given in seconds instead (`lag=18ms`).
    pub delay_s: Option<f64>,
}

/// Why a specification was not understood.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecError(pub String);

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}; known effects: offset:COLUMN, offset:COLUMN^2, offset:COLUMN@delay, gain:COLUMN, field:COLUMN, drift, \
             step, lag, eddy, nonlinearity, cross-axis, periodic, misalignment, axis-order, each with =STRENGTH \
             (multiples of the noise; degrees for misalignment; lag=18ms is a time)",
            self.0
        )
    }
}

impl std::error::Error for SpecError {}

impl EffectSpec {
    /// Reads `ID[=STRENGTH]`; the strength is 3 times the noise where absent (6° for `misalignment`).
    pub fn parse(text: &str) -> Result<EffectSpec, SpecError> {
        let (id, value) = text.split_once('=').map_or((text, None), |(id, value)| (id, Some(value)));
        let column = |name: &str| {
            if name.is_empty() {
                Err(SpecError(format!("effect `{id}` names no column")))
            } else {
                Ok(name.to_string())
            }
        };
        let kind = match id.split_once(':') {
            Some(("offset", name)) => {
                let (name, power) = name.strip_suffix("^2").map_or((name, 1), |name| (name, 2));
                let (name, delayed) = name.strip_suffix("@delay").map_or((name, false), |name| (name, true));
                EffectKind::Offset { column: column(name)?, power, delayed }
            }
            Some(("gain", name)) => EffectKind::Gain(column(name)?),
            Some(("field", name)) => EffectKind::Field(column(name)?),
            Some(_) => return Err(SpecError(format!("unknown effect `{id}`"))),
            None => match id {
                "drift" => EffectKind::Drift,
                "step" => EffectKind::Step,
                "lag" => EffectKind::Lag,
                "eddy" => EffectKind::Eddy,
                "nonlinearity" => EffectKind::Nonlinearity,
                "cross-axis" => EffectKind::CrossAxis,
                "periodic" => EffectKind::Periodic,
                "misalignment" => EffectKind::Misalignment,
                "axis-order" => EffectKind::AxisOrder,
                _ => return Err(SpecError(format!("unknown effect `{id}`"))),
            },
        };
        let (number, in_ms) = match value {
            Some(value) => {
                value.strip_suffix("ms").map_or((Some(value), false), |number| (Some(number), true))
            }
            None => (None, false),
        };
        if in_ms && kind != EffectKind::Lag {
            return Err(SpecError(format!("only `lag` takes a time, not `{id}`")));
        }
        let default = if kind == EffectKind::Misalignment { 6.0 } else { 3.0 };
        let strength = match number {
            None => default,
            Some(number) => number
                .parse::<f64>()
                .ok()
                .filter(|value| value.is_finite() && *value >= 0.0)
                .ok_or_else(|| SpecError(format!("`{number}` is no strength for `{id}`")))?,
        };
        Ok(EffectSpec { kind, strength, delay_s: in_ms.then_some(strength / 1e3) })
    }

    /// The id under which `diagnose` names this effect.
    pub fn id(&self) -> String {
        self.kind.id()
    }

    /// The column this effect follows, if any.
    pub fn column(&self) -> Option<&str> {
        match &self.kind {
            EffectKind::Offset { column, .. } | EffectKind::Gain(column) | EffectKind::Field(column) => {
                Some(column)
            }
            _ => None,
        }
    }
}

/// A hidden effect with its true coefficients.
#[derive(Clone, Debug)]
pub struct HiddenEffect {
    /// Shape.
    pub kind: EffectKind,
    /// True coefficients, in the order and units of the effect of the same id in the library's catalogue.
    pub coefficients: Vec<f64>,
    /// Value of the column (or the time) at which the effect vanishes.
    pub reference: f64,
    /// When a step happens, s.
    pub at_s: f64,
    /// Frequency of a periodic disturbance, Hz.
    pub frequency_hz: f64,
    /// Delay of a late column or of a lag, s.
    pub delay_s: f64,
    rotation: Matrix3<f64>,
}

impl HiddenEffect {
    pub(super) fn draw(spec: &EffectSpec, world: &World, rng: &mut ChaCha8Rng) -> HiddenEffect {
        let mut effect = HiddenEffect::draw_any(spec, world, rng);
        // A strong nonlinearity may fold back, so that two fields give one reading: no sensor that anybody would use.
        for _ in 0..MOST_DRAWS {
            if effect.settles(world) {
                break;
            }
            effect = HiddenEffect::draw_any(spec, world, rng);
        }
        effect
    }

    /// Whether every true field has a reading of its own, with a margin: between the instants looked at, too.
    fn settles(&self, world: &World) -> bool {
        let n = 1000;
        let alone = std::slice::from_ref(self);
        (0..n).all(|i| {
            let t = world.options.seconds * f64::from(i) / f64::from(n);
            let clean = world.soft_iron * (world.to_accelerometer * world.body_field(t)) + world.hard_iron_ut;
            world.settled(alone, t, clean, MOST_ROUNDS / 3).is_some()
        })
    }

    fn draw_any(spec: &EffectSpec, world: &World, rng: &mut ChaCha8Rng) -> HiddenEffect {
        let seconds = world.options.seconds;
        let count = match &spec.kind {
            EffectKind::Offset { .. } | EffectKind::Gain(_) | EffectKind::Drift | EffectKind::Step => 3,
            EffectKind::Field(_) | EffectKind::Lag => 1,
            EffectKind::Eddy => 9,
            EffectKind::Nonlinearity | EffectKind::Periodic => 6,
            EffectKind::CrossAxis => 7,
            EffectKind::Misalignment | EffectKind::AxisOrder => 0,
        };
        let mut coefficients: Vec<f64> = (0..count).map(|_| StandardNormal.sample(rng)).collect();
        if spec.kind == EffectKind::Nonlinearity {
            // Squares are in µT per µT², cubes in µT per µT³: as shares of the field they are drawn alike.
            for cube in &mut coefficients[3..] {
                *cube /= world.options.field_ut;
            }
        }
        let nyquist = world.options.rate_hz / 2.0;
        let mut effect = HiddenEffect {
            kind: spec.kind.clone(),
            coefficients,
            reference: 0.0,
            at_s: seconds * rng.random_range(0.25..0.75),
            frequency_hz: rng.random_range(1.5..(nyquist * 0.95).max(1.6)),
            delay_s: rng.random_range(0.15..0.6),
            rotation: Matrix3::identity(),
        };
        match spec.kind {
            EffectKind::Misalignment => {
                let axis = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
                let angle = spec.strength.to_radians();
                effect.rotation = *Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).matrix();
            }
            EffectKind::AxisOrder => {
                effect.rotation = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
            }
            _ => {
                effect.reference = effect.mean_input(world);
                let scale = match spec.delay_s {
                    Some(delay) => delay / effect.coefficients[0],
                    None => spec.strength * world.options.noise_ut * unit_coefficients(&effect, world),
                };
                for coefficient in &mut effect.coefficients {
                    *coefficient *= scale;
                }
                if spec.kind == EffectKind::Lag {
                    effect.coefficients[0] = effect.coefficients[0].abs();
                    effect.delay_s = effect.coefficients[0];
                }
            }
        }
        effect
    }

    /// The truth in words: id, coefficients, and what else the effect has of time, frequency, delay or rotation.
    pub fn describe(&self) -> String {
        let mut text = format!("{} coefficients = {:?}", self.kind.id(), self.coefficients);
        match &self.kind {
            EffectKind::Offset { .. } | EffectKind::Gain(_) | EffectKind::Field(_) | EffectKind::Drift => {
                text += &format!(", zero at {}", self.reference);
            }
            EffectKind::Step => text += &format!(", at_s = {}", self.at_s),
            EffectKind::Periodic => text += &format!(", frequency_hz = {}", self.frequency_hz),
            EffectKind::Eddy => text += " (eddy currents)",
            EffectKind::Misalignment | EffectKind::AxisOrder => {
                let rows: Vec<[f64; 3]> =
                    self.rotation.row_iter().map(|row| [row[0], row[1], row[2]]).collect();
                text += &format!(", rotation = {rows:?}");
            }
            _ => {}
        }
        if matches!(self.kind, EffectKind::Lag | EffectKind::Offset { delayed: true, .. }) {
            text += &format!(", delay_s = {}", self.delay_s);
        }
        text
    }

    /// The rotation of a misalignment or of swapped axes.
    pub fn rotation(&self) -> Matrix3<f64> {
        self.rotation
    }

    pub(super) fn pure_delay_s(&self) -> f64 {
        if self.kind == EffectKind::Lag { self.delay_s } else { 0.0 }
    }

    fn input(&self, world: &World, t: f64) -> f64 {
        match &self.kind {
            EffectKind::Offset { column, power, delayed } => {
                world.covariate(column, if *delayed { t - self.delay_s } else { t }).powi(*power)
            }
            EffectKind::Gain(column) | EffectKind::Field(column) => world.covariate(column, t),
            EffectKind::Drift => t,
            _ => 0.0,
        }
    }

    fn mean_input(&self, world: &World) -> f64 {
        let n = 2000;
        (0..n).map(|i| self.input(world, world.options.seconds * f64::from(i) / f64::from(n))).sum::<f64>()
            / f64::from(n)
    }

    /// The disturbance of the measured vector at time `t`, where the noise-free measured vector is `measured`.
    pub(super) fn disturbance(&self, world: &World, t: f64, measured: &Vector3<f64>) -> Vector3<f64> {
        let c = &self.coefficients;
        let first = || Vector3::new(c[0], c[1], c[2]);
        let input = || self.input(world, t) - self.reference;
        let m = measured;
        match &self.kind {
            EffectKind::Offset { .. } | EffectKind::Drift => first() * input(),
            EffectKind::Gain(_) => first().component_mul(m) * input(),
            // The field itself is stronger, whatever else disturbs the sensor.
            EffectKind::Field(_) => {
                world.soft_iron * (world.to_accelerometer * world.body_field(t)) * (c[0] * input())
            }
            EffectKind::Step => first() * f64::from(t >= self.at_s),
            EffectKind::Eddy => Matrix3::from_row_slice(c) * self.lag_shape(world, t),
            EffectKind::Nonlinearity => {
                let square = m.component_mul(m);
                first().component_mul(&square)
                    + Vector3::new(c[3], c[4], c[5]).component_mul(&square.component_mul(m))
            }
            EffectKind::CrossAxis => {
                let (xy, xz, yz) = (m.x * m.y, m.x * m.z, m.y * m.z);
                Vector3::new(c[0] * xy + c[1] * xz + c[6] * yz, c[2] * xy + c[3] * yz, c[4] * xz + c[5] * yz)
            }
            EffectKind::Periodic => {
                let (sin, cos) = (TAU * self.frequency_hz * t).sin_cos();
                first() * sin + Vector3::new(c[3], c[4], c[5]) * cos
            }
            EffectKind::Lag | EffectKind::Misalignment | EffectKind::AxisOrder => Vector3::zeros(),
        }
    }

    /// `A (ω × h)`: how fast the noise-free measured vector falls behind, µT/s.
    pub(super) fn lag_shape(&self, world: &World, t: f64) -> Vector3<f64> {
        let h = world.to_accelerometer * world.body_field(t);
        let turn = world.to_accelerometer * world.attitude.rates(t);
        world.soft_iron * turn.cross(&h)
    }
}
