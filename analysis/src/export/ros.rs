//! Parameters for ROS 2: the node `magnetometer_bias_remover` of the package `magnetometer_pipeline`.
//!
//! `MagnetometerBiasRemover::removeBias` of that package: `scaling_matrix · (field − bias)`, tesla, the matrix row by row.

use crate::export::held::{Held, Room, Shape, Turns};
use crate::export::words::{About, top};
use crate::frame::Program;

/// What the node holds.
pub const ROOM: Room = Room {
    name: "ROS",
    shape: Shape::Full,
    turns: Turns::Numbered,
    power: false,
    temperature: false,
    program: Program::Ros,
};

/// µT in a tesla.
const TESLA: f64 = 1e6;

/// The file.
pub fn text(held: &Held, about: About) -> String {
    let mut notes = vec![
        "unbiased = initial_mag_scaling_matrix * (field - initial_mag_bias), tesla, in the frame of the raw field: \
         magnetometer_bias_remover of the package magnetometer_pipeline. For imu_filter_madgwick, which has an offset alone, \
         mag_bias_x, mag_bias_y and mag_bias_z are the same three numbers."
            .to_string(),
        "Load it with: ros2 run magnetometer_pipeline magnetometer_bias_remover_node --ros-args --params-file \
         THIS.yaml".into(),
    ];
    if held.is_own_log() {
        notes.push("Bias and matrix are in the axes of the topic, as in the log.".into());
    } else if held.mounting.is_some_and(|mounting| !mounting.is_none()) {
        notes.push(
            "The mounting belongs to the frames (tf): the rotation from the sensor's frame to x forward, y right, z down. \
             ROS has y to the left and z up."
                .into(),
        );
    }
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    let matrix: Vec<String> =
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|place| number(held.matrix[place])).collect();
    let bias: String = (["x", "y", "z"].iter().enumerate())
        .map(|(axis, name)| {
            format!("    initial_mag_bias_{name}: {}\n", number(held.offset_ut[axis] / TESLA))
        })
        .collect();
    format!(
        "{}/**:\n  ros__parameters:\n{bias}    initial_mag_scaling_matrix: [{}]\n",
        top(held, about, "#", &notes),
        matrix.join(", ")
    )
}

/// A floating-point number of YAML: with a point, and an exponent with a sign.
fn number(value: f64) -> String {
    let text = format!("{value:.12e}");
    match text.split_once('e') {
        Some((digits, power)) if !power.starts_with('-') => format!("{digits}e+{power}"),
        _ => text,
    }
}
