//! A calibration as a plain struct, and its use.

use crate::error::IronoutError;
use crate::pointer;
use crate::sensor::IronoutSensor;
use crate::status::saturated_u32;
use ironout::calibration::Calibration;
use ironout::fit::FitReport;
use ironout::record::Record;
use ironout::sensor::AxisMap;

/// A calibration: corrected = matrix * (measured - offset). Constants from `ironout export` may be filled in by hand.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IronoutCalibration {
    /// Offset (hard iron), µT in the board's axes.
    pub offset_ut: [f32; 3],
    /// Matrix (soft iron), rows first, no unit.
    pub matrix: [[f32; 3]; 3],
    /// Magnitude of corrected vectors, µT.
    pub field_ut: f32,
    /// Noise of the sensor, standard deviation per axis, µT.
    pub noise_ut: f32,
    /// Residual rms of the corrected magnitude, µT.
    pub rms_ut: f32,
    /// Predicted error (1 sigma) of the corrected vector in the worst direction, µT; NaN if unknown. Of a record it is
    /// rounded up by at most 6 %.
    pub predicted_error_ut: f32,
    /// Samples behind the fit.
    pub samples: u32,
    /// Sequence number of the record; 0 for a calibration of a session.
    pub sequence: u32,
    /// Effects in the record, which this struct does not contain.
    pub effects: u32,
    /// Code of the sensor's mounting that the record was made with; 0 if it states none.
    pub mounting: u32,
}

impl IronoutCalibration {
    pub(crate) fn of_report(report: &FitReport) -> Self {
        let Calibration { offset_ut, matrix, field_ut } = report.calibration.cast();
        Self {
            offset_ut,
            matrix,
            field_ut,
            noise_ut: report.noise_ut as f32,
            rms_ut: report.rms_ut as f32,
            predicted_error_ut: report.predicted_error_ut as f32,
            samples: saturated_u32(report.samples),
            sequence: 0,
            effects: 0,
            mounting: 0,
        }
    }

    pub(crate) fn of_record(record: &Record) -> Self {
        let Calibration { offset_ut, matrix, field_ut } = record.calibration.cast();
        let share = record.predicted_error.share();
        Self {
            offset_ut,
            matrix,
            field_ut,
            noise_ut: record.noise_ut as f32,
            rms_ut: record.rms_ut as f32,
            predicted_error_ut: share.map_or(f32::NAN, |share| (share * record.calibration.field_ut) as f32),
            samples: saturated_u32(record.samples),
            sequence: record.sequence,
            effects: record.effects.len() as u32,
            mounting: record.axes.map_or(0, |axes| AxisMap::code(axes).into()),
        }
    }

    fn apply(&self, measured_ut: [f32; 3]) -> [f32; 3] {
        let Self { offset_ut, matrix, field_ut, .. } = *self;
        Calibration { offset_ut, matrix, field_ut }.apply(measured_ut)
    }
}

/// Writes the corrected field of a sample in counts to `corrected_ut`, µT in the board's axes. Only `ut_per_count` of the
/// sensor is read. A count at the end of the range gives a number too: what the chip calls out of range is no measurement.
/// cbindgen:ptrs-as-arrays=[[counts; 3], [corrected_ut; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_apply_counts(
    calibration: *const IronoutCalibration,
    sensor: *const IronoutSensor,
    counts: *const i16,
    corrected_ut: *mut f32,
) -> IronoutError {
    let applied = pointer::vector(counts).and_then(|[x, y, z]| {
        let [scale_x, scale_y, scale_z] = pointer::input(sensor)?.ut_per_count;
        let measured_ut = [f32::from(x) * scale_x, f32::from(y) * scale_y, f32::from(z) * scale_z];
        pointer::write_vector(corrected_ut, pointer::input(calibration)?.apply(measured_ut))
    });
    IronoutError::of(applied)
}

/// Writes the corrected field of a measured vector to `corrected_ut`, both µT in the board's axes. They may be the same
/// array. NaN in, NaN out.
/// cbindgen:ptrs-as-arrays=[[measured_ut; 3], [corrected_ut; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_apply_ut(
    calibration: *const IronoutCalibration,
    measured_ut: *const f32,
    corrected_ut: *mut f32,
) -> IronoutError {
    let applied = pointer::vector(measured_ut).and_then(|measured_ut| {
        pointer::write_vector(corrected_ut, pointer::input(calibration)?.apply(measured_ut))
    });
    IronoutError::of(applied)
}
