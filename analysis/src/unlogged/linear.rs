//! The magnitude of corrected vectors, linearised: what a small offset and a small symmetric matrix do to it.

use nalgebra::{SMatrix, SVector};

/// Columns of the base: an offset (3), then a symmetric matrix xx, yy, zz, xy, xz, yz (6). A rotation does not show.
pub const BASE: usize = 9;

/// One sample.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// `‖h‖ − F`, µT.
    pub residual_ut: f64,
    /// `h/‖h‖`: the direction in which the magnitude sees a disturbance.
    pub direction: [f64; 3],
    /// Derivatives of the residual by the base.
    pub base: [f64; BASE],
}

impl Row {
    /// Of a corrected vector.
    pub fn of(corrected_ut: [f64; 3], field_ut: f64) -> Option<Row> {
        let [x, y, z] = corrected_ut;
        let norm = (x * x + y * y + z * z).sqrt();
        if !(norm > 0.0 && norm.is_finite()) {
            return None;
        }
        let direction = [x / norm, y / norm, z / norm];
        let base = base_columns(direction, corrected_ut);
        Some(Row { residual_ut: norm - field_ut, direction, base })
    }
}

/// Derivatives of the magnitude of `h + S h − b − …` by b and S, where that vector has this direction.
pub fn base_columns([u, v, w]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; BASE] {
    [-u, -v, -w, u * x, v * y, w * z, u * y + v * x, u * z + w * x, v * z + w * y]
}

/// `1 + S` of the six entries of a step.
pub fn one_and(step: [f64; 6]) -> SMatrix<f64, 3, 3> {
    let [xx, yy, zz, xy, xz, yz] = step;
    SMatrix::<f64, 3, 3>::new(1.0 + xx, xy, xz, xy, 1.0 + yy, yz, xz, yz, 1.0 + zz)
}

/// Normal equations of K columns.
#[derive(Debug, Clone)]
pub struct Normal<const K: usize> {
    /// `Σ w c cᵀ`.
    pub matrix: SMatrix<f64, K, K>,
    /// `Σ w c r`.
    pub right: SVector<f64, K>,
    /// `Σ w r²`.
    pub squares: f64,
}

impl<const K: usize> Default for Normal<K> {
    fn default() -> Self {
        Normal { matrix: SMatrix::zeros(), right: SVector::zeros(), squares: 0.0 }
    }
}

impl<const K: usize> Normal<K> {
    /// Adds a sample.
    pub fn add(&mut self, columns: &[f64; K], residual: f64) {
        for j in 0..K {
            for k in j..K {
                self.matrix[(j, k)] += columns[j] * columns[k];
            }
            self.right[j] += columns[j] * residual;
        }
        self.squares += residual * residual;
    }

    /// What leaves the least squares, `c·step ≈ −r`, and the squares that it leaves; `None` where the columns are alike.
    pub fn solve(&self) -> Option<(SVector<f64, K>, f64)> {
        let step = -self.inverse()? * self.right;
        Some((step, (self.squares + self.right.dot(&step)).max(0.0)))
    }

    /// The inverse of the matrix.
    pub fn inverse(&self) -> Option<SMatrix<f64, K, K>> {
        let mut full = self.matrix;
        full.fill_lower_triangle_with_upper_triangle();
        // In units of each column's own size, so that a small determinant says that columns are alike.
        let sizes: SVector<f64, K> = full.diagonal().map(|value| value.max(f64::MIN_POSITIVE).sqrt());
        let scaled: SMatrix<f64, K, K> = SMatrix::from_fn(|j, k| full[(j, k)] / (sizes[j] * sizes[k]));
        let inverse = scaled.cholesky()?.inverse();
        inverse
            .iter()
            .all(|value| value.is_finite())
            .then(|| SMatrix::from_fn(|j, k| inverse[(j, k)] / (sizes[j] * sizes[k])))
    }
}

/// By how much samples in sequence say less than as many independent ones: `(1 + ρ)/(1 − ρ)` of the residual from one to the next.
pub fn memory(residuals: impl Iterator<Item = f64> + Clone) -> f64 {
    let mut squares = 0.0;
    let mut products = 0.0;
    let mut last: Option<f64> = None;
    for value in residuals {
        squares += value * value;
        products += last.map_or(0.0, |before| before * value);
        last = Some(value);
    }
    let rho = if squares > 0.0 { (products / squares).clamp(0.0, 0.99) } else { 0.0 };
    (1.0 + rho) / (1.0 - rho)
}
