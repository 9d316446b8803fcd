//! Attributes for the Industrial I/O subsystem of Linux.
//!
//! `Documentation/ABI/testing/sysfs-bus-iio`: `(raw + in_magn_offset) · in_magn_scale` is the field in gauss, an axis each; the
//! mount matrix is a rotation that user space applies, `device = mount_matrix · sensor`.

use crate::export::error::CannotExport;
use crate::export::held::{Held, Room, Shape, Turns};
use crate::export::words::{About, decimal, top};
use crate::frame::Program;

/// What a driver and its user hold.
pub const ROOM: Room = Room {
    name: "IIO",
    shape: Shape::Diagonal,
    turns: Turns::Any,
    power: false,
    temperature: false,
    program: Program::Other,
};

/// µT in a gauss.
const GAUSS: f64 = 100.0;

/// The attributes, a line each: `name=value`. `ut_per_count` is the driver's scale, by the sensor's axes; `number` is that of
/// the device.
///
/// # Errors
/// A scale that is not known.
pub fn text(
    held: &Held,
    number: Option<usize>,
    ut_per_count: Option<[f64; 3]>,
    about: About,
) -> Result<String, CannotExport> {
    let counts = ut_per_count.ok_or(CannotExport::NoCounts(ROOM.name))?;
    let rows: Vec<Vec<String>> =
        (0..3).map(|i| (0..3).map(|j| decimal(held.turn[(i, j)])).collect()).collect();
    let listed = rows.iter().map(|row| row.join(", ")).collect::<Vec<_>>().join("; ");
    let quoted: Vec<String> = rows.iter().flatten().map(|value| format!("\"{value}\"")).collect();
    let notes = [
        "field = in_mount_matrix * ((raw + offset) * scale), gauss; the axes of the device are x forward, y right, z down. \
         Some drivers accept writes to offset and scale. Otherwise the program that reads raw applies them. calibbias is in \
         the chip's own units and is not used."
            .to_string(),
        format!("In a device tree: mount-matrix = {};", quoted.join(", ")),
    ];
    let device = number.unwrap_or(0);
    let mut text = top(held, about, "#", &notes.each_ref().map(String::as_str));
    text += &format!("# /sys/bus/iio/devices/iio:device{device}\n");
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        text += &format!("in_magn_{name}_offset={}\n", decimal(-held.offset_ut[axis] / counts[axis]));
    }
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        text +=
            &format!("in_magn_{name}_scale={}\n", decimal(held.matrix[(axis, axis)] * counts[axis] / GAUSS));
    }
    text += &format!("in_mount_matrix={listed}\n");
    Ok(text)
}
