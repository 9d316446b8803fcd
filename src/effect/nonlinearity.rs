//! Nonlinearity of each axis.

use super::{Effect, Quantities, Shape, diagonal};
use crate::math::Real;
use core::fmt;

/// `nonlinearity`: `Φ = [diag(ĥ²) | diag(ĥ³)]`: a core or an amplifier that saturates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Nonlinearity;

impl<T: Real> Effect<T> for Nonlinearity {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("nonlinearity")
    }

    fn name(&self) -> &str {
        "nonlinearity"
    }

    fn explanation(&self) -> &str {
        "The core or the amplifier of an axis begins to saturate. \
         Each axis' error follows the square and the cube of its own reading."
    }

    fn coefficients(&self) -> usize {
        6
    }

    fn unit(&self) -> &str {
        "1/µT (squares), 1/µT² (cubes)"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let square = at.measured_ut.map(|axis| axis * axis);
        let [x, y, z] = at.measured_ut;
        let [xx, yy, zz] = square;
        diagonal(square, 0, shape);
        diagonal([xx * x, yy * y, zz * z], 3, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }
}
