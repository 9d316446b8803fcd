//! One linearised pass in blocks of time.

use super::normal::Normal;
use crate::math::Real;
use crate::model::{Model, NotFinite, Observation, Residual, Term};

/// The normal matrices of one pass: `P` columns at most, `B` blocks of time, `N` terms at most.
///
/// On a board `Study<f32, 22, 4, 6>` takes some 8 KB. The host uses the same type in `f64`.
#[derive(Clone, Debug)]
pub struct Study<T, const P: usize, const B: usize, const N: usize> {
    residual: Residual,
    model: Model<T>,
    blocks: [Normal<T, P>; B],
}

impl<T: Real, const P: usize, const B: usize, const N: usize> Study<T, P, B, N> {
    /// A pass at `model` whose terms have `coefficients` coefficients in all.
    pub fn new(residual: Residual, model: Model<T>, coefficients: usize) -> Self {
        let columns = residual.base_columns() + coefficients;
        Study { residual, model, blocks: core::array::from_fn(|_| Normal::new(columns)) }
    }

    /// The residual it looks at.
    pub fn residual(&self) -> Residual {
        self.residual
    }

    /// The model it linearises at.
    pub fn model(&self) -> &Model<T> {
        &self.model
    }

    /// Adds one sample to a block of time; a block beyond the last is the last.
    pub fn push(
        &mut self,
        block: usize,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
    ) -> Result<(), NotFinite> {
        let Study { residual, model, blocks } = self;
        let last = B.saturating_sub(1);
        let Some(block) = blocks.get_mut(block.min(last)) else { return Ok(()) };
        model.rows::<N, P>(*residual, reading, terms, |row, value| block.push(row, value))
    }

    /// The blocks.
    pub fn blocks(&self) -> &[Normal<T, P>] {
        &self.blocks
    }

    /// Adds the rows of a pass over other samples of the same blocks.
    pub fn merge(&mut self, other: &Self) {
        for (block, rows) in self.blocks.iter_mut().zip(&other.blocks) {
            block.merge(rows);
        }
    }
}
