//! Lines for Betaflight's command line.
//!
//! `compassUpdate` of `src/main/sensors/compass.c` turns the driver's counts by `align_mag` and takes `mag_calibration` away:
//! an offset in whole counts, and nothing else. Its axes are x forward, y left, z up; the words of `align_mag` are
//! `alignSensorViaRotation` of `sensors/boardalignment.c`.

use crate::export::error::CannotExport;
use crate::export::held::{Held, Room, Shape, Turns};
use crate::export::rotations::euler_deg;
use crate::export::words::{About, top};
use crate::frame::Program;
use nalgebra::{Matrix3, Vector3};

/// What Betaflight holds.
pub const ROOM: Room = Room {
    name: "Betaflight",
    shape: Shape::Scalar,
    turns: Turns::Numbered,
    power: false,
    temperature: false,
    program: Program::Betaflight,
};

/// `align_mag` by its word: which axes of the sensor become Betaflight's x, y, z.
const ALIGNMENTS: [(&str, [[f64; 3]; 3]); 8] = [
    ("CW0", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    ("CW90", [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    ("CW180", [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]),
    ("CW270", [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    ("CW0FLIP", [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]),
    ("CW90FLIP", [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
    ("CW180FLIP", [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
    ("CW270FLIP", [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
];

/// The lines. `ut_per_count` is the driver's scale, by the sensor's axes.
///
/// # Errors
/// A scale that is not known, an offset that 16 bits do not hold, a number beyond the one magnetometer.
pub fn text(
    held: &Held,
    number: Option<usize>,
    ut_per_count: Option<[f64; 3]>,
    about: About,
) -> Result<String, CannotExport> {
    if let Some(number) = number.filter(|number| *number != 0) {
        return Err(CannotExport::NoNumber { target: ROOM.name, number, least: 0, most: 0 });
    }
    let scale = ut_per_count.ok_or(CannotExport::NoCounts(ROOM.name))?;
    let counts = Vector3::from_fn(|axis, _| held.offset_ut[axis] / scale[axis]);
    let mut notes = vec![
        "mag = align_mag(counts) - mag_calibration, in whole counts of the driver. Paste it into the command line; it ends \
         with \
         save."
            .to_string(),
        format!(
            "1 count = {} uT (rounding error of the offset: up to {:.3} uT).",
            scale.map(|value| value.to_string()).join(", "),
            scale.map(|value| value / 2.0).iter().fold(0.0_f64, |most, value| most.max(*value))
        ),
    ];
    // From x forward, y right, z down to Betaflight's x forward, y left, z up.
    let up = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    // A blackbox log is behind align_mag, which stays as it is.
    let aligned = matches!(held.source, Program::Betaflight | Program::Inav);
    let known = held.mounting.filter(|mounting| !aligned && !mounting.is_none() && held.lost_deg.is_some());
    let wanted = known.map(|mounting| up * mounting.matrix);
    let named = |matrix: &Matrix3<f64>| {
        let of = |rows: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| rows[i][j]);
        ALIGNMENTS.iter().map(|(word, rows)| (*word, of(rows))).find(|(_, own)| (own - matrix).norm() < 1e-6)
    };
    let alignment = wanted.as_ref().and_then(named).filter(|(word, _)| *word != "CW0");
    let (mut rows, mut custom) = (String::new(), None);
    match (wanted, alignment) {
        (_, Some((word, _))) => {
            notes.push("ironout takes the axes of the log as the driver's own axes.".into());
            rows += &format!("set align_mag = {word}\n");
        }
        (Some(matrix), None) if named(&matrix).is_none() => {
            notes.push(
                "ironout takes the axes of the log as the driver's own axes. The mounting is not one of the eight that \
                 align_mag names. The angles \
                 are in tenths of a degree, and need Betaflight 2026.6 or later: earlier versions turn by the inverse rotation."
                    .into(),
            );
            custom = Some(matrix);
            rows += "set align_mag = CUSTOM\n";
            for (name, angle_deg) in ["roll", "pitch", "yaw"].iter().zip(euler_deg(&matrix)) {
                rows += &format!("set mag_align_{name} = {:.0}\n", angle_deg * 10.0);
            }
        }
        _ if aligned => {
            notes.push(
                "align_mag stays unchanged: the offset is in the axes of the log, after align_mag.".into(),
            );
            if held.source == Program::Inav {
                notes.push(
                    "This is an INAV log. INAV subtracts magzero_x, magzero_y, magzero_z before align_mag, in the driver's \
                     axes, so these numbers are correct only with align_mag CW0."
                        .into(),
                );
            }
        }
        _ => notes.push("align_mag stays unchanged: the offset is in the axes of the log.".into()),
    }
    let turn = alignment.map(|(_, matrix)| matrix).or(custom).unwrap_or_else(Matrix3::identity);
    let whole = (turn * counts).map(f64::round);
    if let Some(value) = whole.iter().find(|value| value.abs() > f64::from(i16::MAX)) {
        let parameter = "mag_calibration".to_string();
        return Err(CannotExport::TooLarge { parameter, value: format!("{value:.0}") });
    }
    let [x, y, z] = [0, 1, 2].map(|axis| whole[axis] as i32);
    rows += &format!("set mag_calibration = {x},{y},{z}\nsave\n");
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    Ok(top(held, about, "#", &notes) + &rows)
}
