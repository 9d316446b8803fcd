//! What to simulate.

use crate::attitude::Motion;
use crate::decoy::Decoy;
use crate::effects::EffectSpec;
use crate::faults::FaultSpec;
use crate::noise::Noise;

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
    /// The noise's colour.
    pub noise: Noise,
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
    /// Columns that cause nothing, with their names.
    pub decoys: Vec<(String, Decoy)>,
    /// Columns with this share of their cells empty.
    pub empty_cells: Vec<(String, f64)>,
    /// The times are those of arrival: late by up to this many rows.
    pub arrival_jitter_rows: f64,
}

impl Default for WorldOptions {
    fn default() -> Self {
        WorldOptions {
            seed: 1,
            seconds: 80.0,
            rate_hz: 50.0,
            noise_ut: 0.25,
            noise_correlation: 0.0,
            noise: Noise::Memory,
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
            decoys: Vec::new(),
            empty_cells: Vec::new(),
            arrival_jitter_rows: 0.0,
        }
    }
}
