//! The simulated world: a board that turns in the Earth's field, its sensors, and what disturbs them.
//!
//! Everything is a function of time fixed by one seed, so that the same world can be sampled into a log
//! ([`World::run`]) or read by a simulated chip at any instant ([`World::sensor_ut`]). The measured vector obeys the
//! program's own model `ĥ = A h + b + Σ Φ(sample) θ + w`, with `Φ` taken at the noise-free measured vector.

mod attitude;
mod covariate;
mod decoy;
mod draw;
mod effects;
mod faults;
mod log;
mod noise;
mod options;
pub mod paper;
mod paths;
mod sampling;
mod scale;
mod scenery;

pub mod truths;
mod world;

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use attitude::Motion;
pub use decoy::Decoy;
pub use effects::{Drawn, EffectKind, EffectSpec, HiddenEffect, Scene, Simulated, SpecError};
pub use faults::FaultSpec;
pub use log::{Log, Truth};
pub use noise::Noise;
pub use options::{Temperature, WorldOptions};
pub use world::{GRAVITY_MPS2, World};
