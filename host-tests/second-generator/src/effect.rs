//! Shapes of hidden effects, and their scaling to a wanted strength.

use crate::column::Column;
use crate::linalg::{
    Mat3, Span, Vec3, add_scaled, dot, inverse, mul_vec, norm, rms, rms_of_vectors, scale, standardised, sub,
    to_body,
};
use crate::motion::Motion;
use crate::random::{Source, choose, direction, normal3, sign, uniform};
use crate::truth::Hidden;
use std::f64::consts::TAU;

/// Largest disturbance that one effect makes, as a share of the field.
const MOST_OF_FIELD: f64 = 0.6;
/// Longest lag, s.
const LONGEST_LAG_S: f64 = 0.3;

/// Families of the catalogue of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Offset,
    Gain,
    Field,
    Drift,
    Step,
    Lag,
    Nonlinearity,
    CrossAxis,
    Periodic,
}

impl Family {
    pub const ALL: [Family; 9] = [
        Family::Offset,
        Family::Gain,
        Family::Field,
        Family::Drift,
        Family::Step,
        Family::Lag,
        Family::Nonlinearity,
        Family::CrossAxis,
        Family::Periodic,
    ];

    /// True when a column of the log drives it.
    pub fn needs_column(self) -> bool {
        matches!(self, Family::Offset | Family::Gain | Family::Field)
    }
}

/// Effect before it is scaled: its disturbance at an amplitude of 1.
pub struct Shape {
    pub id: String,
    pub words: String,
    pub in_catalogue: bool,
    pub parameters: Vec<(&'static str, f64)>,
    pub columns: Vec<String>,
    pub unit: Vec<Vec3>,
}

/// Sensor and motion that effects act on.
pub struct Scene<'a> {
    pub times: &'a [f64],
    pub rate_hz: f64,
    pub field_ned: Vec3,
    pub matrix: Mat3,
    pub offset: Vec3,
    /// Noise that strengths are multiples of, µT.
    pub noise_ut: f64,
    pub motion: &'a Motion,
    /// Field in the body frame that the sensor sees: the true one, or a late one behind a lag.
    pub seen: Vec<Vec3>,
    base: Span,
}

impl<'a> Scene<'a> {
    pub fn new(
        times: &'a [f64],
        rate_hz: f64,
        field_ned: Vec3,
        (matrix, offset): (Mat3, Vec3),
        noise_ut: f64,
        motion: &'a Motion,
    ) -> Self {
        let seen: Vec<Vec3> = times.iter().map(|&t| to_body(motion.orientation(t), field_ned)).collect();
        let base = base_columns(&seen);
        Scene { times, rate_hz, field_ned, matrix, offset, noise_ut, motion, seen, base }
    }

    fn late_field(&self, lag_s: f64) -> Vec<Vec3> {
        let late = |&t: &f64| to_body(self.motion.orientation(t - lag_s), self.field_ned);
        self.times.iter().map(late).collect()
    }

    /// Reading without noise and disturbances, µT.
    fn reading(&self, i: usize) -> Vec3 {
        add_scaled(mul_vec(&self.matrix, self.seen[i]), 1.0, self.offset)
    }

    /// Every sample's vector of a constant direction times a course of time.
    pub fn along(&self, direction: Vec3, course: &[f64]) -> Vec<Vec3> {
        course.iter().map(|&z| scale(z, direction)).collect()
    }

    /// Reading times a gain per axis times a course of time, per field.
    pub fn gain(&self, gain: Vec3, course: &[f64]) -> Vec<Vec3> {
        let field = norm(self.field_ned);
        let at = |(i, &z): (usize, &f64)| {
            let x = self.reading(i);
            std::array::from_fn(|axis| gain[axis] * x[axis] * z / field)
        };
        course.iter().enumerate().map(at).collect()
    }

    /// Shape of a family; `column` is the cause's for families that need one.
    pub fn shape(&self, family: Family, rng: &mut Source, column: Option<&Column>) -> Shape {
        let name = column.map_or("", |c| c.name.as_str());
        let course = column.map_or(Vec::new(), |c| standardised(&c.signal.sample(self.times)));
        let last = self.times[self.times.len() - 1];
        let field = norm(self.field_ned);
        let n = self.times.len();
        let per_reading = |f: &dyn Fn(Vec3) -> Vec3| -> Vec<Vec3> {
            (0..n).map(|i| scale(field, f(scale(1.0 / field, self.reading(i))))).collect()
        };
        let mut parameters = Vec::new();
        let (id, words, unit) = match family {
            Family::Offset => {
                let unit = self.along(direction(rng), &course);
                (format!("offset:{name}"), format!("offset proportional to {name}"), unit)
            }
            Family::Gain => {
                let unit = self.gain(direction(rng), &course);
                (format!("gain:{name}"), format!("gain of each axis proportional to {name}"), unit)
            }
            Family::Field => {
                let at = |(i, &z): (usize, &f64)| scale(z / field, mul_vec(&self.matrix, self.seen[i]));
                let unit = course.iter().enumerate().map(at).collect();
                (format!("field:{name}"), format!("ambient field proportional to {name}"), unit)
            }
            Family::Drift => {
                let unit = self.along(direction(rng), &standardised(self.times));
                ("drift".into(), "offset proportional to time".into(), unit)
            }
            Family::Step => {
                let at_s = last * uniform(rng, 0.2, 0.8);
                parameters.push(("at_s", at_s));
                let course: Vec<f64> = self.times.iter().map(|&t| f64::from(t >= at_s)).collect();
                ("step".into(), format!("offset step at {at_s:.3} s"), self.along(direction(rng), &course))
            }
            Family::Nonlinearity => {
                let (square, cube) = (normal3(rng), normal3(rng));
                let powers = choose(rng, &[[1.0, 0.0], [0.0, 1.0], [0.0, 1.0], [0.7, 0.7]]);
                let unit = per_reading(&|x| {
                    let curve =
                        |i: usize| powers[0] * square[i] * x[i] * x[i] + powers[1] * cube[i] * x[i].powi(3);
                    std::array::from_fn(curve)
                });
                let words = format!("square ({}) and cube ({}) of each axis's reading", powers[0], powers[1]);
                ("nonlinearity".into(), words, unit)
            }
            Family::CrossAxis => {
                // The sensitivity of each axis depends on the field across it.
                let (next, other) = (normal3(rng), normal3(rng));
                let unit = per_reading(&|x| {
                    std::array::from_fn(|i| x[i] * (next[i] * x[(i + 1) % 3] + other[i] * x[(i + 2) % 3]))
                });
                ("cross-axis".into(), "each axis times the readings across it".into(), unit)
            }
            Family::Periodic => {
                let hertz = uniform(rng, 1.1, 0.46 * self.rate_hz);
                parameters.push(("frequency_hz", hertz));
                let (a, b) = (direction(rng), scale(uniform(rng, 0.0, 1.0), direction(rng)));
                let wave = |&t: &f64| {
                    let phase = TAU * hertz * t;
                    add_scaled(scale(phase.sin(), a), phase.cos(), b)
                };
                ("periodic".into(), format!("tone of {hertz:.4} Hz"), self.times.iter().map(wave).collect())
            }
            Family::Lag => ("lag".into(), String::new(), Vec::new()),
        };
        let columns = column.map(|c| c.name.clone()).into_iter().collect();
        Shape { id, words, in_catalogue: true, parameters, columns, unit }
    }

    /// Change of the magnitude by a disturbance: the part outside of the base model and the whole, µT rms.
    fn magnitude_change(&self, disturbance: &[Vec3]) -> (f64, f64) {
        let c = inverse(&self.matrix);
        let change = |(h, d): (&Vec3, &Vec3)| norm(add_scaled(*h, 1.0, mul_vec(&c, *d))) - norm(*h);
        let changes: Vec<f64> = self.seen.iter().zip(disturbance).map(change).collect();
        (rms(&self.base.project_out(&changes)), rms(&changes))
    }

    /// Scales a shape so that what it does to the magnitude is `strength` times the noise, if the field allows.
    pub fn scaled(&self, shape: Shape, strength: f64) -> Hidden {
        let most = MOST_OF_FIELD * norm(self.field_ned) / rms_of_vectors(&shape.unit).max(1e-12);
        let mut amplitude = 1e-3 * most;
        for _ in 0..12 {
            let disturbance: Vec<Vec3> = shape.unit.iter().map(|&u| scale(amplitude, u)).collect();
            let now = self.magnitude_change(&disturbance).0.max(1e-12);
            amplitude = (amplitude * strength * self.noise_ut / now).min(most);
        }
        let disturbance_ut: Vec<Vec3> = shape.unit.iter().map(|&u| scale(amplitude, u)).collect();
        let (strength_ut, magnitude_rms_ut) = self.magnitude_change(&disturbance_ut);
        Hidden {
            id: shape.id,
            words: shape.words,
            in_catalogue: shape.in_catalogue,
            parameters: shape.parameters,
            columns: shape.columns,
            logged: true,
            strength: strength_ut / self.noise_ut,
            strength_ut,
            magnitude_rms_ut,
            vector_rms_ut: rms_of_vectors(&disturbance_ut),
            disturbance_ut,
        }
    }

    /// Makes the sensor see a late field, so that the dip changes by `strength` times the noise over the field.
    pub fn lag(&mut self, strength: f64) -> Hidden {
        let dip = |h: Vec3, t: f64| {
            let down = to_body(self.motion.orientation(t), [0.0, 0.0, 1.0]);
            (dot(h, down) / norm(h)).clamp(-1.0, 1.0).asin()
        };
        let change = |seen: &[Vec3]| {
            let each = |((late, now), &t): ((&Vec3, &Vec3), &f64)| dip(*late, t) - dip(*now, t);
            rms(&seen.iter().zip(&self.seen).zip(self.times).map(each).collect::<Vec<f64>>())
        };
        let field = norm(self.field_ned);
        let mut lag_s = 0.01;
        for _ in 0..6 {
            let now = change(&self.late_field(lag_s)) * field;
            lag_s = (lag_s * strength * self.noise_ut / now.max(1e-12)).min(LONGEST_LAG_S);
        }
        let late = self.late_field(lag_s);
        let strength_ut = change(&late) * field;
        let shift = |(late, now): (&Vec3, &Vec3)| mul_vec(&self.matrix, sub(*late, *now));
        let disturbance_ut: Vec<Vec3> = late.iter().zip(&self.seen).map(shift).collect();
        self.base = base_columns(&late);
        self.seen = late;
        Hidden {
            id: "lag".into(),
            words: format!("sensor late by {lag_s:.4} s"),
            in_catalogue: true,
            parameters: vec![("delay_s", lag_s)],
            columns: Vec::new(),
            logged: true,
            strength: strength_ut / self.noise_ut,
            strength_ut,
            magnitude_rms_ut: 0.0,
            vector_rms_ut: rms_of_vectors(&disturbance_ut),
            disturbance_ut,
        }
    }
}

/// Changes of the magnitude that an offset and a matrix can make: linear and quadratic in the direction.
fn base_columns(field: &[Vec3]) -> Span {
    let directions: Vec<Vec3> = field.iter().map(|&h| scale(1.0 / norm(h), h)).collect();
    let mut columns: Vec<Vec<f64>> = (0..3).map(|i| directions.iter().map(|u| u[i]).collect()).collect();
    for i in 0..3 {
        for j in i..3 {
            columns.push(directions.iter().map(|u| u[i] * u[j]).collect());
        }
    }
    Span::new(&columns)
}

/// Matrix and offset of a sensor in a field of a magnitude in µT; the offset is at most `most_offset` fields.
pub fn sensor(rng: &mut Source, field_ut: f64, most_offset: f64) -> (Mat3, Vec3) {
    // Soft iron is symmetric, along axes of its own; gains, skewed axes and mounting are not.
    let axes = crate::random::orientation(rng);
    let stretch: Vec3 = std::array::from_fn(|_| 1.0 + sign(rng) * uniform(rng, 0.0, 0.15));
    let basis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| to_body(axes, e));
    let soft: Mat3 = std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..3).map(|k| stretch[k] * basis[k][i] * basis[k][j]).sum())
    });
    let skew: Mat3 = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            f64::from(i == j) + uniform(rng, -0.03, 0.03) * if i == j { 1.5 } else { 1.0 }
        })
    });
    let offset = scale(field_ut * uniform(rng, 0.0, most_offset), direction(rng));
    (crate::linalg::mul_mat(&skew, &soft), offset)
}
