//! The error on blocks of time that the fit has not seen.

use super::normal::Normal;
use crate::math::Real;

/// What the blocks say about rows they were not fitted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut<T> {
    /// Sum of squared residuals over all held-out blocks.
    pub squares: T,
    /// Rows in them.
    pub rows: u32,
}

impl<T: Real> HeldOut<T> {
    /// Root mean square; `None` without rows.
    pub fn rms(&self) -> Option<T> {
        (self.rows > 0).then(|| (self.squares / T::of(f64::from(self.rows))).root())
    }
}

/// Leaves each block out in turn, fits the others (and the prior), and adds up the error on the block left out:
/// `E_k = e_k + 2δᵀg_k + δᵀN_kδ` with `δ = −(N − N_k)⁻¹(g − g_k)`.
///
/// `None` where the rest without some block does not determine the parameters.
pub fn held_out<T: Real, const P: usize>(
    blocks: &[Normal<T, P>],
    prior: Option<&Normal<T, P>>,
    columns: &[usize],
) -> Option<HeldOut<T>> {
    let total = Normal::total(blocks, prior).select(columns);
    let mut result = HeldOut { squares: T::zero(), rows: 0 };
    for block in blocks.iter().filter(|block| block.rows() > 0) {
        let block = block.select(columns);
        let rest = total.without(&block);
        let delta = rest.step(&rest.factor()?);
        result.squares += block.squares_after(&delta);
        result.rows = result.rows.saturating_add(block.rows());
    }
    Some(result)
}
