//! The kinds of effects that a world may hide.

use super::simulated::Simulated;
use super::{
    cross_axis, drift, field, gain, lag, mounting, nonlinearity, offset, periodic, product, soft_iron, step,
};

/// Each of them, in the order in which they are listed.
pub(super) const LIST: [&dyn Simulated; 14] = [
    &offset::Offset,
    &product::Product,
    &gain::Gain,
    &field::Field,
    &soft_iron::SoftIron,
    &drift::Drift,
    &step::Step,
    &lag::Lag,
    &lag::Eddy,
    &nonlinearity::Nonlinearity,
    &cross_axis::CrossAxis,
    &periodic::Periodic,
    &mounting::Misalignment,
    &mounting::AxisOrder,
];
