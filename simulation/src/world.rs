//! A world that can be asked at any instant.

use crate::attitude::Attitude;
use crate::covariate::Covariates;
use crate::draw::{MOST_ROUNDS, draw};
use crate::effects::HiddenEffect;
use crate::options::WorldOptions;
use crate::scenery::Scenery;
use nalgebra::{Matrix3, Vector3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Standard gravity in m/s².
pub const GRAVITY_MPS2: f64 = 9.806_65;

/// A simulated world, ready to be sampled.
#[derive(Clone, Debug)]
pub struct World {
    pub(crate) scenery: Scenery,
    pub(crate) hidden: Vec<HiddenEffect>,
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
        let mut scenery = Scenery {
            attitude,
            covariates,
            field_ned_ut,
            soft_iron: Matrix3::from_fn(|i, j| soft[i][j]),
            hard_iron_ut: Vector3::from(hard),
            to_accelerometer: Matrix3::identity(),
            options,
        };
        let mut hidden = Vec::new();
        let specs = scenery.options.effects.clone();
        for spec in &specs {
            let effect = draw(spec, &scenery, &mut rng);
            match effect.drawn.rotation {
                Some(rows) => scenery.to_accelerometer *= Matrix3::from_fn(|i, j| rows[i][j]),
                None => hidden.push(effect),
            }
        }
        World { scenery, hidden }
    }

    /// Another recording of the same board with the same hidden effects: other motion, other histories of the covariates,
    /// other noise. The first recording is the world itself.
    pub fn recording(&self, number: u64) -> World {
        let mut world = self.clone();
        if number > 1 {
            let scenery = &mut world.scenery;
            scenery.options.seed ^= number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mut rng = ChaCha8Rng::seed_from_u64(scenery.options.seed);
            scenery.attitude = Attitude::draw(scenery.options.motion, scenery.field_ned_ut, &mut rng);
            scenery.covariates = Covariates::draw(&scenery.options, &mut rng);
        }
        world
    }

    /// The options it was drawn from.
    pub fn options(&self) -> &WorldOptions {
        &self.scenery.options
    }

    /// The hidden effects with their true coefficients.
    pub fn hidden(&self) -> &[HiddenEffect] {
        &self.hidden
    }

    /// How much the hidden effects disturb the measured vector: rms about the mean, µT.
    pub fn disturbance_ut(&self) -> f64 {
        let n = 400;
        let at = |i: i32| self.scenery.options.seconds * (f64::from(i) + 0.5) / f64::from(n);
        let off = |t: f64| self.sensor(t) - self.scenery.clean(t) - self.scenery.hard_iron_ut;
        let vectors: Vec<Vector3<f64>> = (0..n).map(|i| off(at(i))).collect();
        let mean = vectors.iter().sum::<Vector3<f64>>() / f64::from(n);
        (vectors.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / f64::from(n)).sqrt()
    }

    /// Whether every field has one reading: a disturbance may be so strong that readings fold over, and then there is none.
    pub fn is_settled(&self) -> bool {
        let n = 2000;
        (0..n).map(|i| self.scenery.options.seconds * f64::from(i) / f64::from(n)).all(|t_s| {
            let clean = self.scenery.clean(t_s) + self.scenery.hard_iron_ut;
            self.scenery.settled(&self.hidden, t_s, clean, MOST_ROUNDS).is_some()
        })
    }

    /// True field in the body frame at time `t_s`, µT.
    pub fn body_field_ut(&self, t_s: f64) -> [f64; 3] {
        self.scenery.body_field(t_s).into()
    }

    /// Rate of turn in the body frame at time `t_s`, rad/s.
    pub fn rates_radps(&self, t_s: f64) -> [f64; 3] {
        self.scenery.attitude.rates(t_s).into()
    }

    /// What an accelerometer without noise measures at time `t_s`, m/s²: gravity, and what a hand's lever arm adds.
    pub fn accel_mps2(&self, t_s: f64) -> [f64; 3] {
        let attitude = &self.scenery.attitude;
        let up = attitude.body_to_world(t_s).transpose() * Vector3::new(0.0, 0.0, -GRAVITY_MPS2);
        (up + attitude.lever_acceleration(t_s)).into()
    }

    /// What a noise-free magnetometer of infinite resolution measures at time `t_s`, µT: the source of a simulated chip.
    pub fn sensor_ut(&self, t_s: f64) -> [f64; 3] {
        self.sensor(t_s).into()
    }

    pub(crate) fn sensor(&self, t_s: f64) -> Vector3<f64> {
        let delay: f64 = self.hidden.iter().map(HiddenEffect::pure_delay_s).sum();
        let clean = self.scenery.clean(t_s - delay) + self.scenery.hard_iron_ut;
        if self.hidden.is_empty() {
            return clean;
        }
        self.scenery.settled(&self.hidden, t_s, clean, MOST_ROUNDS).unwrap_or(clean)
    }

    /// Value of a covariate at time `t_s`. Every name has a history of its own, drawn from the seed.
    pub fn covariate(&self, name: &str, t_s: f64) -> f64 {
        self.scenery.covariates.at(name, t_s)
    }

    /// Direction from the body frame to the truth: heading of the body's x axis, degrees east of magnetic north.
    pub fn heading_deg(&self, t_s: f64) -> f64 {
        let r = self.scenery.attitude.body_to_world(t_s);
        r[(1, 0)].atan2(r[(0, 0)]).to_degrees().rem_euclid(360.0)
    }
}
