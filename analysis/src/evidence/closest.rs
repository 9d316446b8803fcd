//! The closest point of a bent ellipsoid.
//!
//! A sensor that bends the field gives out y(u) = x + Φ(x)θ with x = F·C⁻¹u + b. The residual is the distance of the reading from that
//! surface. It needs no undisturbed reading: a strong effect may fold the readings, and then two fields have one reading.

use crate::base::term::Term;
use core::ops::AddAssign;
use ironout::effect::Quantities;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Steps to the closest point, at most.
const MOST_STEPS: usize = 12;
/// Shortenings of a step that leads away.
const SHORTER: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// A step that is shorter than this share of the field is the last.
const SHORT_STEP: f64 = 1e-3;
/// Slope of the readings by the field that is as good as one: starts on another fold need not be tried.
const WEAK_SLOPE: f64 = 0.3;

/// The surface of readings at one sample.
pub struct Surface<'m, 'a> {
    /// b, µT.
    pub offset: Vector3<f64>,
    /// C.
    pub matrix: &'m Matrix3<f64>,
    /// The terms that read the field.
    pub reading: &'m [&'m Term<'a>],
    /// C⁻¹.
    pub inverse: &'m Matrix3<f64>,
    /// The sample.
    pub sample: usize,
    /// Its rate of turn, rad/s.
    pub rate: Option<Vector3<f64>>,
    /// Its field, µT.
    pub field: f64,
}

/// What an effect reads at an undisturbed reading.
pub fn quantities(
    x: &Vector3<f64>,
    rate: Option<Vector3<f64>>,
    offset: &Vector3<f64>,
    matrix: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
) -> Quantities<f64> {
    let centred = x - offset;
    let mut at = Quantities::of_vector((*x).into());
    at.centred_ut = centred.into();
    if let Some(rate) = rate {
        at.turning_ut_per_s = (inverse * rate.cross(&(matrix * centred))).into();
    }
    at
}

/// A point of the surface.
#[derive(Debug, Clone, Copy)]
pub struct Foot {
    /// Direction of the field.
    pub unit: Vector3<f64>,
    /// Undisturbed reading, µT.
    pub x: Vector3<f64>,
    /// Slope of the reading by the undisturbed one.
    pub slope: Matrix3<f64>,
    /// Unit normal, outward where nothing folds.
    pub normal: Vector3<f64>,
    /// Distance of the reading along the normal, µT.
    pub residual: f64,
    distance: f64,
}

impl Surface<'_, '_> {
    fn disturbed(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let at = quantities(x, self.rate, &self.offset, self.matrix, self.inverse);
        self.reading.iter().map(|term| term.disturbance(self.sample, &at)).sum()
    }

    fn slope(&self, x: &Vector3<f64>, here: &Vector3<f64>) -> Matrix3<f64> {
        let step = 1e-3 * self.field;
        let mut slope = Matrix3::identity();
        for axis in 0..3 {
            let mut moved = *x;
            moved[axis] += step;
            let by_axis = (self.disturbed(&moved) - here) / step;
            slope.column_mut(axis).add_assign(&by_axis);
        }
        slope
    }

    /// The closest point to a reading from a direction on.
    pub fn closest_point(&self, measured: &Vector3<f64>, from: Vector3<f64>) -> Option<Foot> {
        let place = |unit: &Vector3<f64>| {
            let x = self.inverse * unit * self.field + self.offset;
            let disturbance = self.disturbed(&x);
            (x, disturbance, measured - x - disturbance)
        };
        let mut unit = from;
        let (mut x, mut disturbance, mut off) = place(&unit);
        let mut slope = self.slope(&x, &disturbance);
        for _ in 0..MOST_STEPS {
            let first = unit.cross(&Vector3::ith(unit.iamin(), 1.0)).normalize();
            let second = unit.cross(&first);
            let bent = slope * self.inverse * self.field;
            let (a, b) = (bent * first, bent * second);
            let normal_matrix = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
            let right = Vector2::new(a.dot(&off), b.dot(&off));
            let by = normal_matrix.try_inverse()? * right;
            let promised = right.dot(&by);
            if !(promised > 1e-14 * self.field * self.field) {
                break;
            }
            let mut moved = false;
            for share in SHORTER {
                let next = (unit + (first * by[0] + second * by[1]) * share).normalize();
                let (next_x, next_disturbance, next_off) = place(&next);
                if next_off.norm_squared() < off.norm_squared() {
                    (unit, x, disturbance, off) = (next, next_x, next_disturbance, next_off);
                    moved = true;
                    break;
                }
            }
            if !moved {
                break;
            }
            // The slope hardly changes over a step as short as this.
            if promised < SHORT_STEP * SHORT_STEP * self.field * self.field {
                break;
            }
            slope = self.slope(&x, &disturbance);
        }
        let first = unit.cross(&Vector3::ith(unit.iamin(), 1.0)).normalize();
        let second = unit.cross(&first);
        let bent = slope * self.inverse;
        let normal = (bent * first).cross(&(bent * second)).try_normalize(1e-12)?;
        let residual = normal.dot(&off);
        residual.is_finite().then_some(Foot {
            unit,
            x,
            slope,
            normal,
            residual,
            distance: off.norm_squared(),
        })
    }

    /// The closest of the points that several directions lead to.
    pub fn closest(
        &self,
        measured: &Vector3<f64>,
        from: Vector3<f64>,
        others: &[Vector3<f64>],
    ) -> Option<Foot> {
        let mut best = self.closest_point(measured, from);
        let is_weak = |closest_point: &Foot| (closest_point.slope - Matrix3::identity()).norm() < WEAK_SLOPE;
        if best.as_ref().is_some_and(is_weak) {
            return best;
        }
        for other in others {
            if let Some(closest_point) = self.closest_point(measured, *other)
                && best.as_ref().is_none_or(|best| closest_point.distance < best.distance)
            {
                best = Some(closest_point);
            }
        }
        best
    }
}
