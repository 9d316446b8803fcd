//! Frame of a log: from the numbers of its source to microtesla in body axes (x forward, y right, z down).
//!
//! A reader that scales, turns or takes out an autopilot's calibration says so here, once. The value travels with the log and in
//! CAL.json, so that every export can undo exactly what the reader did.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Rows of a 3 × 3 matrix.
pub type Rows = [[f64; 3]; 3];

/// The identity.
pub const IDENTITY: Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Largest deviation of `R·Rᵀ` from the identity at which `R` still counts as orthogonal: nine numbers typed with few digits.
const MAX_NOT_ORTHOGONAL: f64 = 5e-3;
/// Most calibrations of one log that a file keeps: more changes than any flight has.
pub const MAX_REMOVED: usize = 256;

/// Program whose own numbers a log holds. An export for the same program writes its numbers in the axes in which that program
/// applies them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Program {
    /// PX4.
    Px4,
    /// ArduPilot.
    Ardupilot,
    /// Betaflight.
    Betaflight,
    /// INAV.
    Inav,
    /// ROS.
    Ros,
    /// Any other.
    #[default]
    #[serde(other)]
    Other,
}

/// Calibration that the source had applied, and the reader took out: `numbers = matrix · (sensor − offset)`, in the source's own
/// numbers and axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Removed {
    /// Seconds of the log from which on it applied; absent for its beginning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// Subtracted first.
    pub offset: [f64; 3],
    /// Applied then, rows first.
    pub matrix: Rows,
    /// Whether a compensation of motors or current was taken out too: it changes from row to row and is in no matrix.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub power: bool,
}

impl Removed {
    /// What undoes it; `None` where the matrix has no inverse.
    pub fn inverse(&self) -> Option<Matrix3<f64>> {
        let back = matrix3(&self.matrix).try_inverse()?;
        back.iter().chain(&self.offset).all(|value| value.is_finite()).then_some(back)
    }
}

/// From the numbers of a source to microtesla in body axes:
/// `body = from_source · ut_per_number ∘ (matrix⁻¹ · numbers + offset)`, matrix and offset those of [`Removed`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Program that wrote the numbers.
    #[serde(default)]
    pub program: Program,
    /// Microtesla per number of the source, by its axes: a count, a gauss, a tesla.
    pub ut_per_number: [f64; 3],
    /// From the axes of the source to the body's, orthogonal, rows first.
    pub from_source: Rows,
    /// From the sensor's axes to those of the source, where the source had turned its sensor by a mounting of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_sensor: Option<Rows>,
    /// Mounting that the source applies to its sensor on its way to body axes, where the log tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mounting: Option<Rows>,
    /// Calibrations that the source had applied, in order of time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<Removed>,
    /// Repairs of the source's numbers before all else, as `--repair` takes them (`unsigned`).
    #[serde(skip)]
    pub repairs: Vec<String>,
}

impl Default for Frame {
    fn default() -> Self {
        Frame {
            program: Program::Other,
            ut_per_number: [1.0; 3],
            from_source: IDENTITY,
            from_sensor: None,
            mounting: None,
            removed: Vec::new(),
            repairs: Vec::new(),
        }
    }
}

impl Frame {
    /// Frame of a program that has `from_source` axes and `ut_per_number`.
    pub fn of(program: Program, ut_per_number: f64, from_source: Rows) -> Self {
        Frame { program, ut_per_number: [ut_per_number; 3], from_source, ..Frame::default() }
    }

    /// The same frame turned further in the body's axes, as by `--rotate`.
    #[must_use]
    pub fn turned(mut self, rotation: &Rows) -> Self {
        self.from_source = product(rotation, &self.from_source);
        self
    }

    /// Whether numbers are microtesla in body axes already.
    pub fn is_plain(&self) -> bool {
        self.ut_per_number == [1.0; 3]
            && self.from_source == IDENTITY
            && self.removed.is_empty()
            && self.repairs.is_empty()
    }

    /// Rotation from the source's axes to the body's.
    pub fn rotation(&self) -> Matrix3<f64> {
        matrix3(&self.from_source)
    }

    /// Rotation from the axes in which `program` keeps its calibration to the body's: the sensor's own where the source is that
    /// program and has turned its sensor, else those of the source.
    pub fn rotation_for(&self, program: Program) -> Matrix3<f64> {
        match &self.from_sensor {
            Some(from_sensor) if self.program == program => self.rotation() * matrix3(from_sensor),
            _ => self.rotation(),
        }
    }

    /// Mounting that `program` applies already, where the log is its own and tells.
    pub fn mounting_of(&self, program: Program) -> Option<Matrix3<f64>> {
        self.mounting.as_ref().filter(|_| self.program == program).map(matrix3)
    }

    /// Matrix and offset of `body_ut = matrix · numbers + offset`, with the last calibration that the source applied.
    pub fn affine(&self) -> (Rows, [f64; 3]) {
        let scale = Matrix3::from_diagonal(&Vector3::from(self.ut_per_number));
        let to_body = self.rotation() * scale;
        let (back, offset) = match self.removed.last() {
            Some(removed) => {
                (removed.inverse().unwrap_or_else(Matrix3::identity), Vector3::from(removed.offset))
            }
            None => (Matrix3::identity(), Vector3::zeros()),
        };
        (rows(&(to_body * back)), (to_body * offset).into())
    }

    /// Microtesla in body axes of one row of numbers at a time of the log, s.
    pub fn body_ut(&self, time_s: f64, numbers: [f64; 3]) -> [f64; 3] {
        let removed = self.removed.iter().rev().find(|one| one.from_s.is_none_or(|from| from < time_s));
        let frame = Frame {
            removed: removed.or(self.removed.first()).copied().into_iter().collect(),
            ..self.clone()
        };
        let (matrix, offset) = frame.affine();
        (matrix3(&matrix) * Vector3::from(numbers) + Vector3::from(offset)).into()
    }

    /// Whether the numbers can be meant; why not.
    ///
    /// # Errors
    /// A scale that is not positive, axes that are not orthogonal, a calibration without an inverse.
    pub fn check(&self) -> Result<(), &'static str> {
        if !self.ut_per_number.iter().all(|scale| scale.is_finite() && *scale > 0.0) {
            return Err("frame.ut_per_number is not positive");
        }
        let turns = [Some(&self.from_source), self.from_sensor.as_ref(), self.mounting.as_ref()];
        let orthogonal = |rows: &&Rows| {
            let m = matrix3(rows);
            (m * m.transpose() - Matrix3::identity()).abs().max() < MAX_NOT_ORTHOGONAL
        };
        if !turns.iter().flatten().all(orthogonal) {
            return Err("a rotation of frame is not orthogonal");
        }
        if self.removed.len() > MAX_REMOVED {
            return Err("frame.removed has more entries than any log");
        }
        let sound = |one: &Removed| one.inverse().is_some() && one.from_s.is_none_or(f64::is_finite);
        if !self.removed.iter().all(sound) {
            return Err("a calibration of frame.removed has no inverse");
        }
        Ok(())
    }
}

/// The matrix of these rows.
pub fn matrix3(rows: &Rows) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// The rows of a matrix.
pub fn rows(matrix: &Matrix3<f64>) -> Rows {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

fn product(a: &Rows, b: &Rows) -> Rows {
    // By rows, so that a signed permutation keeps its ones.
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLIP: Rows = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];

    #[test]
    fn numbers_become_microtesla_in_body_axes_by_what_was_removed_then() {
        let mut frame = Frame::of(Program::Ardupilot, 0.1, FLIP);
        frame.removed = vec![
            Removed { from_s: None, offset: [0.0; 3], matrix: IDENTITY, power: false },
            Removed {
                from_s: Some(5.0),
                offset: [10.0, 20.0, -30.0],
                matrix: [[2.0, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, 0.5, 1.0]],
                power: false,
            },
        ];
        let (sensor, late) = ([100.0, -200.0, 300.0], frame.removed[1]);
        let numbers = matrix3(&late.matrix) * (Vector3::from(sensor) - Vector3::from(late.offset));
        let body = frame.body_ut(6.0, numbers.into());
        for (own, wanted) in body.iter().zip([10.0, 20.0, -30.0]) {
            assert!((own - wanted).abs() < 1e-12, "{body:?}");
        }
        assert_eq!(frame.body_ut(1.0, sensor), [10.0, 20.0, -30.0]);
        let (matrix, offset) = frame.affine();
        let last = matrix3(&matrix) * numbers + Vector3::from(offset);
        assert!((last - Vector3::new(10.0, 20.0, -30.0)).norm() < 1e-12);
    }

    #[test]
    fn what_is_no_frame_is_told_and_a_file_reads_back() {
        let frame =
            Frame::of(Program::Ros, 1e6, FLIP).turned(&[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(frame.check(), Ok(()));
        assert_eq!(frame.from_source, [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
        let text = serde_json::to_string(&frame).expect("JSON");
        assert_eq!(serde_json::from_str::<Frame>(&text).expect("a frame"), frame);
        assert!(Frame { ut_per_number: [1.0, 0.0, 1.0], ..frame.clone() }.check().is_err());
        assert!(Frame { from_source: [[1.0, 0.0, 0.0]; 3], ..frame.clone() }.check().is_err());
        let flat = Removed { from_s: None, offset: [0.0; 3], matrix: [[0.0; 3]; 3], power: false };
        assert!(Frame { removed: vec![flat], ..frame }.check().is_err());
        let newer = r#"{"program":"xyz","ut_per_number":[1,1,1],"from_source":[[1,0,0],[0,1,0],[0,0,1]]}"#;
        assert_eq!(serde_json::from_str::<Frame>(newer).expect("a frame"), Frame::default());
    }
}
