//! A calibration file as the record of a board, and back.

use super::console::Identity;
use crate::cal_file::{CalFile, FitObject, VERSION};
use crate::failure::{Failure, Outcome};
use crate::reading::Reading;
use ironout::effect::Id;
use ironout::extended::{Effects, Live, LiveError, MAX_DELAYED};
use ironout::fit::{Method, Order};
use ironout::record::{self, Covariance, MAX_RECORD_BYTES, PredictedError, Record, TILTS_DEG};
use ironout_analysis::calibration::{AtTilt, EffectEntry, HoldsFor, Information, StdErrors};
use ironout_analysis::effects::{entry, of_library};
use ironout_analysis::frame::{Frame, IDENTITY, matrix3, rows};
use nalgebra::Vector3;

/// Scales that differ by less than this share are the same: a board holds its own in single precision.
const SAME_SCALE: f64 = 1e-6;

/// What a board is given.
#[derive(Debug, Clone)]
pub struct Carried {
    /// The record.
    pub record: Record,
    /// What of the file a record does not hold, in words.
    pub notices: Vec<String>,
}

/// The record that a board holds of a calibration.
///
/// # Errors
/// What this board cannot hold or would apply wrongly, with what to do.
pub fn carried(cal: &CalFile, board: &Identity) -> Outcome<Carried> {
    right_for(cal, board)?;
    let mut notices = Vec::new();
    let turned = in_source_axes(cal, &mut notices)?;
    let cal = &turned;
    let calibrated = cal.extended()?;
    for fitted in calibrated.effects.iter() {
        if fitted.effect.parts().form.tag == 0 {
            return Err(cannot(&format!(
                "a board cannot store the effect {}. Fix: fit again without it",
                Id(&fitted.effect)
            )));
        }
    }
    let extended = of_library(&calibrated).ok_or_else(|| {
        cannot("one of its effects is not in the library's catalogue: fit again without it, or build it into the firmware")
    })?;
    let live = Live::new(&extended.on_own_clock().0.cast::<f32>());
    let live = live.map_err(|error| match error {
        LiveError::TooManyDelayed => cannot(&format!(
            "a board supports {MAX_DELAYED} delayed columns, and this calibration needs more. Fix: fit again with fewer"
        )),
        LiveError::AheadOfItsColumn => cannot(
            "a column acts before it is logged, and a board cannot wait for it: feed that column to the board earlier, or fit again without the effect",
        ),
        LiveError::Singular => cannot("its matrix cannot be inverted in single precision: fit again"),
    })?;
    let method = Method::parse(&cal.fit.method).unwrap_or_default();
    let record = Record {
        sequence: 0,
        calibration: extended.base,
        effects: extended.effects,
        method,
        model: order(&extended.base.matrix),
        samples: cal.fit.samples_used,
        noise_ut: cal.fit.noise_floor_ut.unwrap_or(0.0),
        rms_ut: cal.fit.rms_ut.unwrap_or(0.0),
        axes: None,
        // A file does not say it; whoever sends a calibration wants it in the place of the old one.
        predicted_error: PredictedError::UNKNOWN,
        covariance: cal
            .information
            .as_ref()
            .and_then(Information::covariance)
            .as_ref()
            .and_then(Covariance::of),
        holds_for: cal.fit.holds_for.as_ref().map(tilts),
    };
    let encoded = record.encode().map_err(|_| {
        cannot(&format!(
            "its effects do not fit into a board's record of {MAX_RECORD_BYTES} bytes. Fix: fit again with one fewer"
        ))
    })?;
    // As it is stored: without a covariance that finds no room.
    let covariance = Record::decode(encoded.as_bytes()).ok().and_then(|stored| stored.covariance);
    let record = Record { covariance, ..record };
    if cal.information.is_some() && covariance.is_none() {
        notices.push(
            "the board has no room for the information matrix in addition to these effects. Keep the file for fit --prior".into(),
        );
    }
    if !extended.effects.is_empty() {
        notices.push(
            "the board stores the effects' standard errors and ranges in single precision (ranges rounded outward)".into(),
        );
    }
    if live.needs_gyro() {
        notices.push("it needs a gyro: without one the board cannot correct the field".into());
    }
    Ok(Carried { record, notices })
}

fn cannot(why: &str) -> Failure {
    Failure::usage(format!("this calibration cannot be sent to a board: {why}"))
}

/// Whether the calibration is of the board's own scale and axes.
fn right_for(cal: &CalFile, board: &Identity) -> Outcome<()> {
    let Some(reading) = &cal.reading else { return Ok(()) };
    if let (Some(own), Some(of_board)) = (reading.ut_per_count, board.ut_per_count)
        && own.iter().zip(of_board).any(|(own, board)| (own - board).abs() > SAME_SCALE * board)
    {
        let words = |scale: [f64; 3]| scale.map(|value| value.to_string()).join(",");
        return Err(cannot(&format!(
            "it is for {} µT per count, but the board has {} µT per count. Fix: fit a log of this board (ironout record)",
            words(own),
            words(of_board)
        )));
    }
    Ok(())
}

/// The calibration in the axes of the numbers that its log held, which a board corrects in: `Rᵀ·M·R·(raw − Rᵀ·b − …)`.
///
/// # Errors
/// An effect whose coefficients are not vectors.
fn in_source_axes(cal: &CalFile, notices: &mut Vec<String>) -> Outcome<CalFile> {
    let frame = cal.reading.as_ref().map_or_else(|| Ok(Frame::default()), Reading::frame)?;
    let (mut turned, r) = (cal.clone(), frame.rotation());
    if frame.from_source == IDENTITY {
        return Ok(turned);
    }
    let back = r.transpose();
    turned.fit.offset_ut = cal.fit.offset_ut.map(|offset| (back * Vector3::from(offset)).into());
    if let Some(holds_for) = &mut turned.fit.holds_for {
        holds_for.down = (back * Vector3::from(holds_for.down)).into();
    }
    turned.fit.matrix = cal.fit.matrix.map(|matrix| rows(&(back * matrix3(&matrix) * r)));
    for entry in &mut turned.fit.effects {
        let kind = entry.id.split([':', '#']).next().unwrap_or_default();
        if !["offset", "drift", "step"].contains(&kind) {
            return Err(cannot(&format!(
                "its log was read in other axes than the sensor's, and the effect {} cannot be rotated back to them. Fix: \
                 fit the log again with --rotate so that its axes are the board's",
                entry.id
            )));
        }
        for three in entry.coefficients.chunks_exact_mut(3) {
            three.copy_from_slice((back * Vector3::from_column_slice(three)).as_slice());
        }
        for three in entry.std_errors.chunks_exact_mut(3) {
            let before: Vec<Option<f64>> = three.to_vec();
            for (axis, sigma) in three.iter_mut().enumerate() {
                let parts = before.iter().enumerate().filter(|(j, _)| back[(axis, *j)] != 0.0);
                let squares: Option<f64> =
                    parts.map(|(j, own)| own.map(|s| (back[(axis, j)] * s).powi(2))).sum();
                *sigma = squares.map(f64::sqrt);
            }
        }
    }
    let signs = [0, 1, 2].map(|axis| r[(axis, axis)]);
    let flips = signs.iter().all(|sign| sign.abs() == 1.0);
    let covariance = cal.information.as_ref().and_then(Information::covariance).filter(|_| flips);
    turned.information = covariance.and_then(|mut covariance| {
        let [x, y, z] = signs;
        let of = [x, y, z, x * x, x * y, x * z, y * y, y * z, z * z];
        for (i, row) in covariance.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(j, value)| *value *= of[i] * of[j]);
        }
        Information::from_covariance(&covariance)
    });
    notices.push(
        "its log was read in other axes than the sensor's. ironout rotates it back to the sensor's axes"
            .into(),
    );
    if cal.information.is_some() && turned.information.is_none() {
        notices.push(
            "the information matrix is not sent, because it cannot be rotated. Keep the file for fit --prior"
                .into(),
        );
    }
    Ok(turned)
}

/// The order of the model, as its matrix shows it: the file does not say.
fn order(matrix: &[[f64; 3]; 3]) -> Order {
    let off_diagonal = (0..3).any(|i| (0..3).any(|j| i != j && matrix[i][j] != 0.0));
    let [x, y, z] = [matrix[0][0], matrix[1][1], matrix[2][2]];
    match off_diagonal {
        true => Order::Ellipsoid,
        false if x == y && y == z => Order::Sphere,
        false => Order::AxisAligned,
    }
}

/// A calibration file from the record of a board, and the covariance of offset and matrix where it is known.
///
/// # Errors
/// A record that no file may hold.
pub fn cal_file(record: &Record, covariance: Option<&[[f64; 9]; 9]>, board: &Identity) -> Outcome<CalFile> {
    let base = record.calibration;
    // 0 stands for what the sender did not know.
    let known = |value: f64| (value > 0.0).then_some(value);
    let cal = CalFile {
        version: VERSION,
        fit: FitObject {
            holds_for: record.holds_for.as_ref().map(holds_for),
            method: record.method.name().to_string(),
            samples_used: record.samples,
            samples_set_aside: 0,
            field_ut: Some(base.field_ut),
            offset_ut: Some(base.offset_ut),
            matrix: Some(base.matrix),
            effects: entries(&record.effects),
            std_errors: covariance.map(std_errors),
            rms_ut: known(record.rms_ut),
            holdout_rms_ut: None,
            noise_floor_ut: known(record.noise_ut),
            residual_floor_ut: None,
            residual_floor_least_ut: None,
            predicted_error_ut: None,
            heading_error_deg: None,
            coverage: None,
            gap_deg: None,
            accepted: true,
            reasons: vec![format!("note: from the board {} ({})", board.board, board.sensor)],
            contradiction: None,
            beside_gyro: None,
            accelerometer: None,
            recordings: None,
        },
        information: covariance.and_then(Information::from_covariance),
        conditions: Default::default(),
        fitted_to: None,
        reading: board.ut_per_count.map(|scale| Reading { ut_per_count: Some(scale), ..Reading::default() }),
    };
    let text = serde_json::to_string(&cal).map_err(|error| Failure::usage(error.to_string()))?;
    CalFile::parse(&text)
}

/// The tilts as a record keeps them. For a tilt that the file does not have, the error of the next larger one.
fn tilts(holds_for: &HoldsFor) -> record::HoldsFor {
    let error = |tilt_deg: f32| {
        let enough = |at: &&AtTilt| at.tilt_deg >= f64::from(tilt_deg);
        let at = holds_for.heading_errors.iter().find(enough).or(holds_for.heading_errors.last());
        at.map_or(0.0, |at| at.heading_error_deg as f32)
    };
    record::HoldsFor {
        tilt_deg: holds_for.tilt_deg as f32,
        down: holds_for.down.map(|axis| axis as f32),
        heading_errors_deg: TILTS_DEG.map(error),
    }
}

/// The tilts as a file keeps them.
fn holds_for(tilts: &record::HoldsFor) -> HoldsFor {
    // The digits of single precision, and not those of its binary value.
    let digits = |value: f32| value.to_string().parse().unwrap_or_else(|_| f64::from(value));
    let errors = TILTS_DEG.into_iter().zip(tilts.heading_errors_deg);
    HoldsFor {
        tilt_deg: digits(tilts.tilt_deg),
        down: tilts.down.map(digits),
        heading_errors: errors
            .map(|(tilt_deg, error_deg)| AtTilt {
                tilt_deg: digits(tilt_deg),
                heading_error_deg: digits(error_deg),
            })
            .collect(),
    }
}

fn entries(effects: &Effects<f64>) -> Vec<EffectEntry> {
    effects.iter().map(entry).collect()
}

/// The roots of the diagonal, in the order of [`ironout_analysis::calibration::PARAMETERS`].
fn std_errors(covariance: &[[f64; 9]; 9]) -> StdErrors {
    let sigma = |i: usize| covariance[i][i].max(0.0).sqrt();
    StdErrors {
        offset_ut: [sigma(0), sigma(1), sigma(2)],
        matrix: [[sigma(3), sigma(4), sigma(5)], [0.0, sigma(6), sigma(7)], [0.0, 0.0, sigma(8)]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tilts_of_a_vehicle_go_to_a_board_and_come_back() {
        let mut cal = CalFile::parse(include_str!("../../tests/fixtures/cal.json")).expect("a calibration");
        let errors = [(0.0, 0.25), (10.0, 0.5), (20.0, 1.25), (45.0, 4.5)];
        let of = |(tilt_deg, heading_error_deg)| AtTilt { tilt_deg, heading_error_deg };
        let own = HoldsFor { tilt_deg: 28.0, down: [0.0, 0.6, 0.8], heading_errors: errors.map(of).to_vec() };
        cal.fit.holds_for = Some(own.clone());
        let flip = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let frame = Frame { from_source: flip, ..Frame::default() };
        cal.reading = Some(Reading { frame: Some(frame), ..Reading::default() });
        let board = Identity {
            firmware: "1".into(),
            board: "bench".into(),
            sensor: "chip".into(),
            ut_per_count: None,
        };
        let Carried { record, .. } = carried(&cal, &board).expect("it can be sent");
        let read = Record::decode(record.encode().expect("it fits").as_bytes()).expect("sound");
        let back = cal_file(&read, None, &board).expect("a file").fit.holds_for.expect("the tilts");
        assert_eq!(back, HoldsFor { down: [0.0, -0.6, -0.8], ..own });
    }

    #[test]
    fn a_board_corrects_its_own_numbers_to_the_same_field() {
        let mut cal = CalFile::parse(include_str!("../../tests/fixtures/cal.json")).expect("a calibration");
        let flip = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let yaw = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        for turn in [flip, yaw] {
            let frame = Frame { from_source: turn, ..Frame::default() };
            cal.reading = Some(Reading { frame: Some(frame), ..Reading::default() });
            let mut notices = Vec::new();
            let turned = in_source_axes(&cal, &mut notices).expect("no effects");
            let (own, board) = (cal.calibration().expect("sound"), turned.calibration().expect("sound"));
            let raw = [20.0, -31.0, 12.5];
            let body = matrix3(&turn) * Vector3::from(raw);
            let corrected = matrix3(&turn) * Vector3::from(board.apply(raw));
            assert!((corrected - Vector3::from(own.apply(body.into()))).norm() < 1e-9, "{turn:?}");
            assert_eq!(
                turned.information.is_some(),
                cal.information.is_some() && turn == flip,
                "{notices:?}"
            );
            assert!(notices[0].contains("ironout rotates it back"));
        }
    }
}
