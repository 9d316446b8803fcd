//! The simulated world: a board that turns in the Earth's field, its sensors, and what disturbs them.
//!
//! Everything is a function of time fixed by one seed, so that the same world can be sampled into a log
//! ([`World::run`]) or read by a simulated chip at any instant ([`World::sensor_ut`]). The measured vector obeys the
//! program's own model `ĥ = A h + b + Σ Φ(sample) θ + w`, with `Φ` taken at the noise-free measured vector.

mod attitude;
mod covariate;
mod effects;
mod faults;
mod log;
pub mod paper;
mod scale;

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use attitude::Motion;
pub use effects::{EffectKind, EffectSpec, HiddenEffect, SpecError};
pub use faults::FaultSpec;
pub use log::{Log, Truth};

use attitude::Attitude;
use covariate::Covariates;
use nalgebra::{Matrix3, Vector3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The measured vector of a disturbed sensor has settled when a round moves it by less than this, µT ...
const SETTLED_UT: f64 = 1e-10;
/// ... and does not settle if that takes more rounds than this.
const MOST_ROUNDS: usize = 300;

/// Standard gravity in m/s².
pub const GRAVITY_MPS2: f64 = 9.806_65;

/// How the temperature of the simulated board goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Temperature {
    /// Exponential warm-up with a slow wander on top that is independent of time.
    WarmUp,
    /// A steady ramp: the same column as time, up to a scale.
    Ramp,
}

/// What to simulate. `Default` is a clean 80 s log at 50 Hz with every column.
#[derive(Clone, Debug)]
pub struct WorldOptions {
    /// Seed of everything random.
    pub seed: u64,
    /// Length of the log in seconds.
    pub seconds: f64,
    /// Samples a second.
    pub rate_hz: f64,
    /// Standard deviation of the magnetometer's noise on each axis, µT.
    pub noise_ut: f64,
    /// Correlation of that noise from one sample to the next (0 is white).
    pub noise_correlation: f64,
    /// Step of the magnetometer's quantisation in µT; 0 turns it off.
    pub lsb_ut: f64,
    /// Magnitude of the Earth's field, µT.
    pub field_ut: f64,
    /// Dip of the Earth's field below the horizon, degrees.
    pub dip_deg: f64,
    /// Hard iron in µT; drawn within ±30 µT where absent.
    pub hard_iron_ut: Option<[f64; 3]>,
    /// Soft iron (rows of `A`); drawn within 10 % of the identity where absent.
    pub soft_iron: Option<[[f64; 3]; 3]>,
    /// How the board is turned.
    pub motion: Motion,
    /// How the temperature goes.
    pub temperature: Temperature,
    /// Noise of the accelerometer on each axis, m/s².
    pub accel_noise_mps2: f64,
    /// Noise of the gyro on each axis, rad/s.
    pub gyro_noise_radps: f64,
    /// The hidden effects.
    pub effects: Vec<EffectSpec>,
    /// The hidden faults of the data.
    pub faults: Vec<FaultSpec>,
    /// Columns left out of the log.
    pub drop_columns: Vec<String>,
}

impl Default for WorldOptions {
    fn default() -> Self {
        WorldOptions {
            seed: 1,
            seconds: 80.0,
            rate_hz: 50.0,
            noise_ut: 0.25,
            noise_correlation: 0.0,
            lsb_ut: 0.1,
            field_ut: 50.0,
            dip_deg: 60.0,
            hard_iron_ut: None,
            soft_iron: None,
            motion: Motion::Sphere,
            temperature: Temperature::WarmUp,
            accel_noise_mps2: 0.05,
            gyro_noise_radps: 0.005,
            effects: Vec::new(),
            faults: Vec::new(),
            drop_columns: Vec::new(),
        }
    }
}

/// A simulated world, ready to be sampled.
#[derive(Clone, Debug)]
pub struct World {
    options: WorldOptions,
    attitude: Attitude,
    covariates: Covariates,
    field_ned_ut: Vector3<f64>,
    soft_iron: Matrix3<f64>,
    hard_iron_ut: Vector3<f64>,
    hidden: Vec<HiddenEffect>,
    to_accelerometer: Matrix3<f64>,
}

impl World {
    /// Draws the world that `options` describe. The same options give the same world, to the bit.
    pub fn new(options: WorldOptions) -> World {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        let dip = options.dip_deg.to_radians();
        let field_ned_ut = Vector3::new(dip.cos(), 0.0, dip.sin()) * options.field_ut;
        let hard: [f64; 3] = core::array::from_fn(|_| rng.random_range(-30.0..30.0));
        let soft: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                f64::from(i == j) + rng.random_range(-0.1..0.1) / if i == j { 1.0 } else { 2.0 }
            })
        });
        let hard = options.hard_iron_ut.unwrap_or(hard);
        let soft = options.soft_iron.unwrap_or(soft);
        let attitude = Attitude::draw(options.motion, field_ned_ut, &mut rng);
        let covariates = Covariates::draw(&options, &mut rng);
        let mut world = World {
            attitude,
            covariates,
            field_ned_ut,
            soft_iron: Matrix3::from_fn(|i, j| soft[i][j]),
            hard_iron_ut: Vector3::from(hard),
            hidden: Vec::new(),
            to_accelerometer: Matrix3::identity(),
            options,
        };
        let specs = world.options.effects.clone();
        for spec in &specs {
            let hidden = HiddenEffect::draw(spec, &world, &mut rng);
            match hidden.kind {
                EffectKind::Misalignment | EffectKind::AxisOrder => {
                    world.to_accelerometer *= hidden.rotation()
                }
                _ => world.hidden.push(hidden),
            }
        }
        world
    }

    /// Another recording of the same board with the same hidden effects: other motion, other histories of the covariates,
    /// other noise. The first recording is the world itself.
    pub fn recording(&self, number: u64) -> World {
        let mut world = self.clone();
        if number > 1 {
            world.options.seed ^= number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mut rng = ChaCha8Rng::seed_from_u64(world.options.seed);
            world.attitude = Attitude::draw(world.options.motion, world.field_ned_ut, &mut rng);
            world.covariates = Covariates::draw(&world.options, &mut rng);
        }
        world
    }

    /// The options it was drawn from.
    pub fn options(&self) -> &WorldOptions {
        &self.options
    }

    /// The hidden effects with their true coefficients.
    pub fn hidden(&self) -> &[HiddenEffect] {
        &self.hidden
    }

    /// True field in the body frame at time `t_s`, µT.
    pub fn body_field_ut(&self, t_s: f64) -> [f64; 3] {
        self.body_field(t_s).into()
    }

    fn body_field(&self, t_s: f64) -> Vector3<f64> {
        self.attitude.body_to_world(t_s).transpose() * self.field_ned_ut
    }

    /// Rate of turn in the body frame at time `t_s`, rad/s.
    pub fn rates_radps(&self, t_s: f64) -> [f64; 3] {
        self.attitude.rates(t_s).into()
    }

    /// What a noise-free magnetometer of infinite resolution measures at time `t_s`, µT: the source of a simulated chip.
    pub fn sensor_ut(&self, t_s: f64) -> [f64; 3] {
        self.sensor(t_s).into()
    }

    fn sensor(&self, t_s: f64) -> Vector3<f64> {
        let delay: f64 = self.hidden.iter().map(HiddenEffect::pure_delay_s).sum();
        let h = self.to_accelerometer * self.body_field(t_s - delay);
        let clean = self.soft_iron * h + self.hard_iron_ut;
        if self.hidden.is_empty() {
            return clean;
        }
        self.settled(&self.hidden, t_s, clean, MOST_ROUNDS).unwrap_or(clean)
    }

    /// The disturbed vector. The shapes are functions of the measured vector itself, so it is a fixed point. A nonlinearity
    /// that shows with four times the noise moves it by 20 µT, since the base model absorbs most of that, and its slope
    /// comes near 1: the rounds go on until nothing moves. `None` where they do not end.
    fn settled(
        &self,
        hidden: &[HiddenEffect],
        t_s: f64,
        clean: Vector3<f64>,
        most_rounds: usize,
    ) -> Option<Vector3<f64>> {
        let mut measured = clean;
        for _ in 0..most_rounds {
            let mut next = clean;
            for effect in hidden {
                next += effect.disturbance(self, t_s, &measured);
            }
            let moved = (next - measured).amax();
            measured = next;
            if moved < SETTLED_UT {
                return Some(measured);
            }
        }
        None
    }

    /// Value of a covariate at time `t_s`. Every name has a history of its own, drawn from the seed.
    pub fn covariate(&self, name: &str, t_s: f64) -> f64 {
        self.covariates.at(name, t_s)
    }

    /// Direction from the body frame to the truth: heading of the body's x axis, degrees east of magnetic north.
    pub fn heading_deg(&self, t_s: f64) -> f64 {
        let r = self.attitude.body_to_world(t_s);
        r[(1, 0)].atan2(r[(0, 0)]).to_degrees().rem_euclid(360.0)
    }
}
