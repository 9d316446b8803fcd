//! An offset that follows a course in time of the analysis' own, which effects of the log are held against.

use crate::base::piece::{Clock, Piece};
use ironout::effect::{Effect, MAX_INPUTS, Quantities, Shape};
use std::sync::Arc;

/// An offset in proportion to its input: three numbers.
struct Along;

/// A column-free piece whose offset follows `course`, one value a sample.
pub(crate) fn offset_along<'a>(id: &str, course: impl IntoIterator<Item = f64>) -> Piece<'a> {
    let input = |value: f64| {
        let mut inputs = [0.0; MAX_INPUTS];
        inputs[0] = value;
        inputs
    };
    Piece {
        id: id.into(),
        made: None,
        effect: Arc::new(Along),
        coefficients: Default::default(),
        inputs: Arc::new(course.into_iter().map(input).collect()),
        clock: Clock::Stamps,
    }
}

impl Effect<f64> for Along {
    fn id(&self, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
        out.write_str("along")
    }
    fn name(&self) -> &'static str {
        "course of the offset"
    }
    fn explanation(&self) -> &'static str {
        "The offset follows a course in time. What a log shows must stand beside that."
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn unit(&self) -> &'static str {
        "µT"
    }
    fn reads_centre(&self) -> bool {
        false
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        for (axis, vector) in shape.iter_mut().take(3).enumerate() {
            *vector = [0.0; 3];
            vector[axis] = at.inputs[0];
        }
    }
}
