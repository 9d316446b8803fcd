//! Errors of what the dip gives: the rotation to the accelerometer, and a delay.
//!
//! The dip is fitted with offset, triangle and effects as the magnitude gave them. Their errors pass on: with `N = JᵀJ` of
//! the dip's own columns `J` and `K = ∂dip/∂β` the estimate moves by `G δβ`, `G = −N⁻¹JᵀK`. The two residuals share
//! hardly any noise (one sees it along the field, the other across), so
//! `Cov = σ²τ N⁻¹ + G Cov(β) Gᵀ + Z Cov(z) Zᵀ`, where `z` are the zero errors that accelerometer and gyro may have, and `Z = N⁻¹Jᵀ∂dip/∂z`.

use crate::base::engine::Design;
use crate::base::term::{BadShape, COLUMNS, Term};
use crate::samples::samples::Samples;
use crate::samples::scores::Scores;
use crate::samples::series::Autocorrelation;
use ironout::study::{Model, Residual};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

/// Rows of a covariance, as [`covariance`](crate::base::quality::covariance) gives them.
pub type Rows = [[f64; COLUMNS]];

/// Errors of the dip's parameters: rotation (3), sine of the dip, and the delay if there is one.
#[derive(Debug, Clone)]
pub struct DipErrors {
    /// Covariance from the dip's own noise and the zero errors of accelerometer and gyro.
    own: DMatrix<f64>,
    /// `G`: how they follow offset (3), triangle (6) and the effects' coefficients.
    follows: DMatrix<f64>,
}

/// Errors of the rotation vector.
#[derive(Debug, Clone, PartialEq)]
pub struct RotationErrors {
    /// Covariance of its own, rad².
    pub own: [[f64; 3]; 3],
    /// How it follows the errors of offset (3) and triangle (6), rad per unit.
    pub follows: [[f64; 9]; 3],
}

impl DipErrors {
    /// At a fitted model. `lag` is the delay that the dip was fitted with, if any. `None` where the dip does not determine
    /// its parameters.
    pub fn of(
        samples: &Samples,
        model: &Model<f64>,
        terms: &[Term],
        lag: Option<&Term>,
    ) -> Result<Option<DipErrors>, BadShape> {
        let design = Design::new(samples, Residual::Dip);
        let effects: usize = terms.iter().map(Term::k).sum();
        let (base, late) = (Residual::Dip.base_columns(), usize::from(lag.is_some()));
        let (own_columns, others) = (base + late, 9 + effects);
        let full = Matrix3::from_fn(|i, j| model.full_matrix()[i][j]);
        let rotation = Matrix3::from_fn(|i, j| model.rotation[i][j]);
        let Some(inverse) = full.try_inverse() else { return Ok(None) };
        let list: Vec<&Term> = terms.iter().chain(lag).collect();
        let mut normal = DMatrix::<f64>::zeros(own_columns, own_columns);
        let mut cross = DMatrix::<f64>::zeros(own_columns, others);
        let mut accel_zero = DMatrix::<f64>::zeros(own_columns, 3);
        let mut gyro_zero = accel_zero.clone();
        let mut residuals = Vec::with_capacity(samples.len());
        let mut scores = Scores::new(own_columns, samples.len());
        let mut own = DVector::<f64>::zeros(own_columns);
        let mut given = DVector::<f64>::zeros(others);
        design.rows(0..samples.len(), model, &list, |sample, row, residual| {
            let reading = &samples.readings[sample];
            let at_sample: Vec<_> = list.iter().map(|term| term.at_sample(sample)).collect();
            let (Some(down), Ok(h)) = (reading.down, model.correct(reading, &at_sample)) else { return };
            let (down, h) = (Vector3::from(down), Vector3::from(h));
            let (length, v) = (h.norm(), inverse * h);
            let u = h / length;
            let sine = u.dot(&down);
            // How the angle moves with the corrected vector, as in the rows themselves.
            let across = (down - u * sine) / (length * (1.0 - sine * sine).max(0.01).sqrt());
            let (pull, turned) = (full.transpose() * across, rotation.transpose() * across);
            for axis in 0..3 {
                given[axis] = -pull[axis];
            }
            for (slot, (i, j)) in TRIANGLE.into_iter().enumerate() {
                given[3 + slot] = turned[i] * v[j];
            }
            for (slot, value) in row[base..base + effects].iter().enumerate() {
                given[9 + slot] = *value;
            }
            for (slot, value) in row[..base].iter().chain(&row[base + effects..][..late]).enumerate() {
                own[slot] = *value;
            }
            let by_down = (u - down * sine) / (1.0 - sine * sine).max(0.01).sqrt();
            let (by_accel, by_gyro) = samples.down_follows(sample, &down);
            accel_zero.ger(1.0, &own, &(by_accel.transpose() * by_down), 1.0);
            gyro_zero.ger(1.0, &own, &(by_gyro.transpose() * by_down), 1.0);
            normal.ger(1.0, &own, &own, 1.0);
            cross.ger(1.0, &own, &given, 1.0);
            residuals.push(residual);
            scores.add(sample, own.as_slice(), residual);
        })?;
        let scale = DVector::from_fn(own_columns, |i, _| 1.0 / normal[(i, i)].max(1e-300).sqrt());
        let scaled = DMatrix::from_fn(own_columns, own_columns, |i, j| normal[(i, j)] * scale[i] * scale[j]);
        let Some(inverse) = scaled.cholesky().map(|factor| factor.inverse()) else { return Ok(None) };
        let inverse =
            DMatrix::from_fn(own_columns, own_columns, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
        let freedom = residuals.len().saturating_sub(own_columns).max(1) as f64;
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let variance = squares / freedom * Autocorrelation::of(&residuals).time;
        let own = never_below(&inverse * variance, &(&inverse * scores.spread() * &inverse));
        let (by_accel, by_gyro) = (&inverse * accel_zero, &inverse * gyro_zero);
        let own = own
            + &by_accel * samples.zero_error_square * by_accel.transpose()
            + &by_gyro * samples.gyro_zero_covariance * by_gyro.transpose();
        let errors = DipErrors { follows: -(&inverse * cross), own };
        let finite = errors.own.iter().chain(errors.follows.iter()).all(|value| value.is_finite());
        Ok(finite.then_some(errors))
    }

    /// How a parameter follows all columns of the magnitude study, times their covariance.
    fn carried(&self, parameter: usize, covariance: &Rows, column: usize) -> f64 {
        (0..self.follows.ncols()).map(|i| self.follows[(parameter, i)] * covariance[i][column]).sum()
    }

    /// Variance of the delay, s².
    pub fn delay_variance(&self, covariance: &Rows) -> f64 {
        let delay = Residual::Dip.base_columns();
        if self.own.nrows() <= delay || covariance.len() < self.follows.ncols() {
            return f64::NAN;
        }
        let from_others: f64 = (0..self.follows.ncols())
            .map(|column| self.carried(delay, covariance, column) * self.follows[(delay, column)])
            .sum();
        self.own[(delay, delay)] + from_others
    }

    /// Covariance of the delay with a column of the magnitude study.
    pub fn delay_with(&self, covariance: &Rows, column: usize) -> f64 {
        let delay = Residual::Dip.base_columns();
        if self.own.nrows() <= delay || covariance.len() < self.follows.ncols() {
            return f64::NAN;
        }
        self.carried(delay, covariance, column)
    }

    /// The rotation's errors; what it follows of the effects counts as its own as far as offset and triangle do not tell
    /// it. Without a covariance nothing is carried over.
    pub fn rotation(&self, covariance: Option<&Rows>) -> RotationErrors {
        let mut errors = RotationErrors {
            own: std::array::from_fn(|i| std::array::from_fn(|j| self.own[(i, j)])),
            follows: std::array::from_fn(|i| std::array::from_fn(|j| self.follows[(i, j)])),
        };
        let effects = self.follows.ncols() - 9;
        let Some(covariance) = covariance.filter(|rows| rows.len() >= self.follows.ncols() && effects > 0)
        else {
            return errors;
        };
        let nine = SMatrix::<f64, 9, 9>::from_fn(|i, j| covariance[i][j]);
        let Some(nine) = nine.try_inverse() else { return errors };
        let beside = DMatrix::from_fn(effects, 9, |i, j| covariance[9 + i][j]);
        let follows = &beside * nine;
        let left = DMatrix::from_fn(effects, effects, |i, j| covariance[9 + i][9 + j])
            - &follows * beside.transpose();
        let through = self.follows.view((0, 9), (3, effects));
        let (more, own) = (through * follows, through * left * through.transpose());
        for i in 0..3 {
            for j in 0..9 {
                errors.follows[i][j] += more[(i, j)];
            }
            for j in 0..3 {
                errors.own[i][j] += own[(i, j)];
            }
        }
        errors
    }
}

/// The first covariance, each of its standard errors raised to that of the second where that is larger.
fn never_below(own: DMatrix<f64>, other: &DMatrix<f64>) -> DMatrix<f64> {
    let raise =
        DVector::from_fn(own.nrows(), |i, _| (other[(i, i)] / own[(i, i)].max(1e-300)).sqrt().max(1.0));
    DMatrix::from_fn(own.nrows(), own.ncols(), |i, j| own[(i, j)] * raise[i] * raise[j])
}

impl RotationErrors {
    /// Covariance of the rotation vector, with that of offset and triangle, rad².
    pub fn covariance(&self, nine: &[[f64; 9]; 9]) -> Matrix3<f64> {
        let own = Matrix3::from_fn(|i, j| self.own[i][j]);
        let follows = SMatrix::<f64, 3, 9>::from_fn(|i, j| self.follows[i][j]);
        own + follows * SMatrix::<f64, 9, 9>::from_fn(|i, j| nine[i][j]) * follows.transpose()
    }
}

/// Entries of the upper triangle, in the order of the columns.
pub const TRIANGLE: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
