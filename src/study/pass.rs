//! One linearised pass in blocks of time.

use super::normal::Normal;
use crate::math::Real;
use crate::model::{Model, NoRow, Observation, Residual, Term};

/// The normal matrices of one pass: `P` columns at most, `B` blocks of time, `N` terms at most.
///
/// On a board `Study<f32, 22, 4, 6>` takes some 8 KB. The host uses the same type in `f64`.
#[derive(Clone, Debug)]
pub struct Study<T, const P: usize, const B: usize, const N: usize> {
    residual: Residual,
    model: Model<T>,
    /// As many as were asked for, also where they do not fit.
    columns: usize,
    blocks: [Normal<T, P>; B],
}

impl<T: Real, const P: usize, const B: usize, const N: usize> Study<T, P, B, N> {
    /// A pass at `model` whose terms have `coefficients` coefficients in all. Where these and the base model have more columns
    /// than `P`, every [`Study::push`] refuses; where their number is a constant, [`Study::sized`] does so when it is compiled.
    pub fn new(residual: Residual, model: Model<T>, coefficients: usize) -> Self {
        let columns = residual.base_columns().saturating_add(coefficients);
        Study { residual, model, columns, blocks: core::array::from_fn(|_| Normal::new(columns)) }
    }

    /// A pass at `model` whose terms have `K` coefficients in all. It does not compile unless they fit beside the widest base
    /// model, the nine columns of the magnitude.
    ///
    /// ```compile_fail
    /// # use ironout::study::{Model, Residual, Study};
    /// # const ONE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let model = Model::new([0.0; 3], ONE, 50.0, ONE, 0.0).unwrap();
    /// let study = Study::<f64, 11, 1, 1>::sized::<3>(Residual::Magnitude, model); // twelve columns
    /// ```
    pub fn sized<const K: usize>(residual: Residual, model: Model<T>) -> Self {
        const {
            assert!(
                K <= P && P - K >= Residual::Magnitude.base_columns(),
                "base model and coefficients have more columns than the study"
            );
        }
        Self::new(residual, model, K)
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
    ///
    /// # Errors
    /// [`NoRow`] for what is not finite, and for more columns or terms than there is room for; nothing is added then.
    pub fn push(
        &mut self,
        block: usize,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
    ) -> Result<(), NoRow> {
        let Study { residual, model, columns, blocks } = self;
        let (columns, width) = (*columns, P);
        if columns > width {
            return Err(NoRow::TooWide { columns, width });
        }
        let last = B.saturating_sub(1);
        let Some(block) = blocks.get_mut(block.min(last)) else { return Ok(()) };
        // Rows of more columns than the study was made for would lose the last ones.
        model.rows_within::<N, P>(*residual, reading, terms, columns, |row, value| block.push(row, value))
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
