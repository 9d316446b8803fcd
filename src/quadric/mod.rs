//! The quadric of a magnetometer's samples: its normal matrix, what noise does to it, and the ellipsoid it is.

mod ellipsoid;
mod gram;
mod noise;
mod order;

pub(crate) use ellipsoid::Ellipsoid;
pub(crate) use gram::{
    Lower, condition_number, corrected, factorise, gram, mean_square, minimiser, product, pure,
};
pub(crate) use noise::NoiseTerms;
pub use order::Order;
