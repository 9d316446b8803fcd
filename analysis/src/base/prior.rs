//! What is known besides the data: how magnetometers are, and what an earlier calibration says.

use crate::base::term::{Matrix, Term};
use ironout::study::{Model, PhysicalPrior, Residual, base_prior};

/// Information of an earlier calibration about offset and triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Earlier {
    /// Offset (3), then the upper triangle (6).
    pub parameters: [f64; 9],
    /// Inverse of their covariance.
    pub information: [[f64; 9]; 9],
}

impl Earlier {
    /// The same as if it were known from `factor` times as much.
    pub fn times(&self, factor: f64) -> Earlier {
        let information = self.information.map(|row| row.map(|value| value * factor));
        Earlier { information, ..self.clone() }
    }
}

/// Offset (3) and the upper triangle (6) of a model.
pub fn parameters(model: &Model<f64>) -> [f64; 9] {
    let c = &model.matrix;
    let [x, y, z] = model.offset_ut;
    [x, y, z, c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]]
}

/// What is known besides the data.
#[derive(Debug, Clone)]
pub struct Prior {
    /// How magnetometers are.
    pub physical: PhysicalPrior,
    /// Number of rows with the information of one independent row, if a prior is to be compared with structure.
    pub memory: f64,
    /// Standard deviation of the mean gain about 1, where the field is given.
    pub scale: Option<f64>,
    /// An earlier calibration.
    pub earlier: Option<Earlier>,
}

impl Default for Prior {
    fn default() -> Self {
        Prior { physical: PhysicalPrior::default(), memory: 1.0, scale: None, earlier: None }
    }
}

/// A prior on the gains that is tighter than this holds them.
const HELD_GAIN: f64 = 1e-3;

impl Prior {
    /// Whether the matrix is held, or most of it.
    pub fn holds_matrix(&self) -> bool {
        self.physical.gain < HELD_GAIN || self.scale.is_some()
    }

    /// As information in units of the residual's variance.
    pub fn matrix(
        &self,
        residual: Residual,
        model: &Model<f64>,
        sigma: f64,
        terms: &[&Term],
        data: &Matrix,
    ) -> Matrix {
        let base = residual.base_columns();
        let columns = base + terms.iter().map(|term| term.k()).sum::<usize>();
        let mut prior = match residual {
            Residual::Magnitude => base_prior(&self.physical, model, sigma * self.memory.sqrt(), columns),
            Residual::Dip | Residual::Vector => Matrix::new(columns),
        };
        if let (Some(spread), Residual::Magnitude) = (self.scale, residual) {
            let weight = self.memory * (sigma / spread).powi(2);
            let off = (0..3).map(|axis| model.matrix[axis][axis]).sum::<f64>() / 3.0 - 1.0;
            let diagonal = [3, 6, 8];
            for &i in &diagonal {
                prior.pull(i, weight * off / 3.0);
                for &j in diagonal.iter().filter(|j| **j >= i) {
                    prior.inform(i, j, weight / 9.0);
                }
            }
        }
        if let (Some(earlier), Residual::Magnitude) = (&self.earlier, residual) {
            let now = parameters(model);
            for i in 0..9 {
                for j in 0..9 {
                    let weight = earlier.information[i][j] * sigma * sigma;
                    prior.pull(i, weight * (now[j] - earlier.parameters[j]));
                    // Part of the cost: without it every step towards what is known would look like a worse fit.
                    let (a, b) = (now[i] - earlier.parameters[i], now[j] - earlier.parameters[j]);
                    prior.depart(weight * a * b);
                    if j >= i {
                        prior.inform(i, j, weight);
                    }
                }
            }
        }
        if residual == Residual::Vector {
            // Columns of an axis that is a copy of another have no rows.
            for column in (0..columns).filter(|column| data.entry(*column, *column) == 0.0) {
                prior.inform(column, column, 1.0);
            }
        }
        // A pure delay leaves the magnitude alone: the coupling's share along the identity stays where the dip has put
        // it.
        let mut column = base;
        for term in terms {
            let hidden = term.hidden_delay();
            if !hidden.is_empty() && residual == Residual::Magnitude {
                let k = term.k();
                let weight = 1e4 * (0..k).map(|i| data.entry(column + i, column + i)).sum::<f64>() / k as f64;
                for &i in hidden {
                    for &j in hidden {
                        if j >= i {
                            prior.inform(column + i, column + j, weight);
                        }
                    }
                }
            }
            column += term.k();
        }
        prior
    }
}
