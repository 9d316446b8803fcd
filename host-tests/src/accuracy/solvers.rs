//! One face for ironout's methods and for `magcal`.

use ironout::fit::{FitOptions, Method, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use nalgebra::{Matrix3, Vector3};

/// Who solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// One of ironout's methods.
    Ironout(Method),
    /// The crate `magcal` 0.1, its ellipsoid fit.
    Magcal,
}

/// All of them, in the order of the tables.
pub const SOLVERS: [Solver; 4] = [
    Solver::Ironout(Method::Constant),
    Solver::Ironout(Method::Trace),
    Solver::Ironout(Method::Adjusted),
    Solver::Magcal,
];

impl Solver {
    /// The word of the tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ironout(method) => method.name(),
            Self::Magcal => "magcal",
        }
    }
}

/// A calibration in the units of the counts' scale, `h = C (x − b)` with `C` upper triangular.
#[derive(Clone, Copy, Debug)]
pub struct Solved {
    /// Offset.
    pub b: Vector3<f64>,
    /// Matrix, upper triangular with a positive diagonal.
    pub c: Matrix3<f64>,
    /// Standard errors of the offset and of the matrix, where the solver gives any.
    pub std_errors: Option<(Vector3<f64>, Matrix3<f64>)>,
}

/// Solves counts of `scale` units each for a field of magnitude `field`; `None` where the solver refuses.
pub fn solve(solver: Solver, counts: &[[i16; 3]], scale: f64, field: f64) -> Option<Solved> {
    match solver {
        Solver::Ironout(method) => {
            let mut moments = Moments::new();
            counts.iter().for_each(|c| moments.push(*c));
            let options =
                FitOptions { method, field_ut: Some(field), lower_orders: false, ..FitOptions::default() };
            let report = fit(&Scatter::from_moments(&moments, [scale; 3]).ok()?, &options).ok()?;
            let (cal, errors) = (report.calibration, report.std_errors);
            Some(Solved {
                b: cal.offset_ut.into(),
                c: Matrix3::from_fn(|r, k| cal.matrix[r][k]),
                std_errors: Some((errors.offset_ut.into(), Matrix3::from_fn(|r, k| errors.matrix[r][k]))),
            })
        }
        Solver::Magcal => {
            // Its single-precision sums want to know the size of the counts; it is told the best one.
            let mut solver = magcal::Solver::with_scale((field / scale) as f32);
            counts.iter().for_each(|c| solver.push_sample(*c));
            of_magcal(&solver.solve_ellipsoid().ok()?, scale, field)
        }
    }
}

/// `magcal`'s answer with the rotation that no magnitude tells taken off, as for everybody else.
fn of_magcal(found: &magcal::MagCal, scale: f64, field: f64) -> Option<Solved> {
    let w = Matrix3::from_fn(|r, k| f64::from(found.soft_iron[r][k]))
        * (field / (f64::from(found.field_strength) * scale));
    let c = (w.transpose() * w).cholesky()?.l().transpose();
    Some(Solved { b: Vector3::from_fn(|a, _| f64::from(found.hard_iron[a]) * scale), c, std_errors: None })
        .filter(|s| s.b.iter().chain(s.c.iter()).all(|v| v.is_finite()))
}
