//! How the numbers of a log became the vectors that a calibration is of: scale and mounting, for the exports.

use nalgebra::{Matrix3, Vector3};
use std::fmt::Write as _;

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `measured_ut = rotation · (ut_per_count ∘ raw)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Microtesla a count for the sensor's x, y, z; `None` for a log in microtesla.
    pub ut_per_count: Option<[f64; 3]>,
    /// From the sensor's axes to those of the calibration, orthogonal, rows first.
    pub rotation: [[f64; 3]; 3],
}

impl Default for Reading {
    fn default() -> Self {
        Reading { ut_per_count: None, rotation: IDENTITY }
    }
}

impl Reading {
    /// Whether a log in microtesla in the calibration's own axes was read.
    pub fn is_plain(&self) -> bool {
        self.ut_per_count.is_none() && self.rotation == IDENTITY
    }

    /// The rotation as a matrix.
    pub(crate) fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.rotation[i][j])
    }

    /// A vector of the calibration's axes in those of the sensor, µT.
    pub(crate) fn to_sensor(self, vector_ut: [f64; 3]) -> Vector3<f64> {
        self.matrix().transpose() * Vector3::from(vector_ut)
    }

    /// `rotation · diag(scale)`: from the numbers of the log to microtesla in the calibration's axes.
    fn rows(&self) -> [[f64; 3]; 3] {
        let scale = self.ut_per_count.unwrap_or([1.0; 3]);
        self.rotation.map(|row| [0, 1, 2].map(|axis| row[axis] * scale[axis]))
    }

    /// What it is, in words.
    fn words(&self) -> String {
        let scale = match self.ut_per_count {
            Some(scale) => format!("in counts of {} uT", scale.map(|value| value.to_string()).join(", ")),
            None => "in microtesla".to_string(),
        };
        let axes = if self.rotation == IDENTITY { "" } else { ", in the sensor's own axes" };
        format!("{scale}{axes}")
    }

    /// A C function from the numbers of the log to what `ironout_apply` takes; `scalar` is its type. Empty where they are
    /// the same.
    pub(crate) fn c(&self, scalar: &str) -> String {
        if self.is_plain() {
            return String::new();
        }
        let row = |row: [f64; 3]| format!("{{{}}}", row.map(|v| format!("({scalar}){v:?}")).join(", "));
        let [a, b, c] = self.rows().map(row);
        format!(
            "/* The log of this calibration was read with a scale or a mounting: its numbers are\n   {words}. From such\n   \
             numbers to what ironout_apply() takes, microtesla in the calibration's axes; not the same array. */\n\
             static const {scalar} ironout_reading[3][3] = {{\n    {a},\n    {b},\n    {c}\n}};\n\n\
             static inline void ironout_measured_ut(const {scalar} raw[3], {scalar} measured_ut[3])\n{{\n    int i;\n\n    \
             for (i = 0; i < 3; i++) {{\n        measured_ut[i] = ironout_reading[i][0] * raw[0] + ironout_reading[i][1] * \
             raw[1] + ironout_reading[i][2] * raw[2];\n    }}\n}}\n\n",
            words = self.words(),
        )
    }

    /// The same in Rust, in both precisions. Empty where they are the same.
    pub(crate) fn rust(&self) -> String {
        let mut text = String::new();
        if self.is_plain() {
            return text;
        }
        for (scalar, suffix, shown) in [("f32", "", "single"), ("f64", "_F64", "double")] {
            let value = |v: f64| if scalar == "f32" { format!("{:?}", v as f32) } else { format!("{v:?}") };
            let [a, b, c] = self.rows().map(|row| format!("[{}]", row.map(value).join(", ")));
            let _ = write!(
                text,
                "\n/// The log of this calibration was read with a scale or a mounting: its numbers are {words}. From them to\n\
                 /// microtesla in the calibration's axes, rows first, {shown} precision.\n#[allow(dead_code)]\n\
                 pub const READING{suffix}: [[{scalar}; 3]; 3] = [\n    {a},\n    {b},\n    {c},\n];\n\n\
                 /// What `apply` takes, of the numbers of such a log.\n#[allow(dead_code)]\n\
                 pub fn measured_ut{lower}(raw: [{scalar}; 3]) -> [{scalar}; 3] {{\n    \
                 READING{suffix}.map(|row| row[0] * raw[0] + row[1] * raw[1] + row[2] * raw[2])\n}}\n",
                words = self.words(),
                lower = suffix.to_lowercase(),
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_reading_needs_no_code_and_another_one_is_carried() {
        assert!(Reading::default().c("float").is_empty() && Reading::default().rust().is_empty());
        let turned = Reading {
            ut_per_count: Some([0.5, 0.25, 2.0]),
            rotation: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        };
        let c = turned.c("float");
        assert!(c.contains("{(float)0.0, (float)0.25, (float)0.0}"), "{c}");
        assert!(turned.rust().contains("[-0.5, 0.0, 0.0],"), "{}", turned.rust());
    }
}
