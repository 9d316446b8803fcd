//! Hidden effects: what is asked for, and what was drawn. One file for each kind, and one list of them.

mod cross_axis;
mod drift;
mod field;
mod gain;
mod hidden;
mod lag;
mod list;
mod mounting;
mod nonlinearity;
mod offset;
mod periodic;
mod product;
mod simulated;
mod soft_iron;
mod spec;
mod step;

pub use hidden::HiddenEffect;
pub use simulated::{Drawn, EffectKind, Scene, Simulated};
pub use spec::{EffectSpec, SpecError};
