//! The world without its hidden effects: a board that turns in a field, and the columns beside it.

use crate::attitude::Attitude;
use crate::covariate::Covariates;
use crate::effects::{HiddenEffect, Scene};
use crate::options::WorldOptions;
use nalgebra::{Matrix3, Vector3};

/// The measured vector of a disturbed sensor has settled when a round moves it by less than this, µT.
const SETTLED_UT: f64 = 1e-10;

#[derive(Clone, Debug)]
pub(crate) struct Scenery {
    pub(crate) options: WorldOptions,
    pub(crate) attitude: Attitude,
    pub(crate) covariates: Covariates,
    pub(crate) field_ned_ut: Vector3<f64>,
    pub(crate) soft_iron: Matrix3<f64>,
    pub(crate) hard_iron_ut: Vector3<f64>,
    pub(crate) to_accelerometer: Matrix3<f64>,
}

impl Scene for Scenery {
    fn covariate(&self, name: &str, t_s: f64) -> f64 {
        self.covariates.at(name, t_s)
    }
    fn clean_ut(&self, t_s: f64) -> [f64; 3] {
        self.clean(t_s).into()
    }
    fn turning_ut_per_s(&self, t_s: f64) -> [f64; 3] {
        let h = self.to_accelerometer * self.body_field(t_s);
        let turn = self.to_accelerometer * self.attitude.rates(t_s);
        (self.soft_iron * turn.cross(&h)).into()
    }
}

impl Scenery {
    pub(crate) fn body_field(&self, t_s: f64) -> Vector3<f64> {
        self.attitude.body_to_world(t_s).transpose() * self.field_ned_ut
    }

    /// `A h`.
    pub(crate) fn clean(&self, t_s: f64) -> Vector3<f64> {
        self.soft_iron * (self.to_accelerometer * self.body_field(t_s))
    }

    /// The disturbed vector. The shapes are functions of the measured vector itself, so it is a fixed point. A nonlinearity
    /// that shows with four times the noise moves it by 20 µT, since the base model absorbs most of that, and its slope
    /// comes near 1: the rounds go on until nothing moves. `None` where they do not end.
    pub(crate) fn settled(
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
                next += Vector3::from(effect.disturbance(self, t_s, measured.into()));
            }
            let moved = (next - measured).amax();
            measured = next;
            if moved < SETTLED_UT {
                return Some(measured);
            }
        }
        None
    }
}
