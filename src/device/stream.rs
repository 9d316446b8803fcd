//! The stream's lines: one a sample, of the kind asked for.

use core::fmt;

use super::log::Log;
use super::streamed::Sample;
use crate::calibration::norm;
use crate::extended::Live;
use crate::math;
use crate::number::Num;
use crate::protocol::StreamMode;

/// The room that a line of most streams needs.
const LINE_BYTES: usize = 80;

/// The room that the next line of `mode` needs.
pub(super) fn line_bytes(mode: StreamMode, log: &Log) -> usize {
    if mode == StreamMode::Log { log.line_bytes() } else { LINE_BYTES }
}

/// Writes the line of `mode` for one sample.
pub(super) fn write_line(
    out: &mut impl fmt::Write,
    mode: StreamMode,
    sample: &Sample,
    calibration: Option<&Live<f32>>,
    log: &mut Log,
) -> fmt::Result {
    match mode {
        StreamMode::Off => Ok(()),
        StreamMode::Log => log.write_line(out, sample),
        StreamMode::Raw => {
            let [x, y, z] = sample.counts;
            writeln!(out, "R,{},{x},{y},{z}", sample.t_ms)
        }
        StreamMode::Calibrated => {
            // Not known either where an effect waits for its column: nothing else is passed off as corrected.
            let corrected = sample
                .measured_ut
                .zip(calibration)
                .and_then(|(measured, cal)| Some((cal.apply(measured, sample.turn_radps).ok()?, cal)));
            let Some((ut, cal)) = corrected else {
                return writeln!(out, "C,{},-,-,-,-,-", sample.t_ms);
            };
            let ([x, y, z], length, residual) = (ut, norm(ut), cal.residual_ut(ut));
            let ([x, y, z], length, residual) = ([x, y, z].map(Num), Num(length), Num(residual));
            let tilted = if sample.is_tilted { ",tilted" } else { "" };
            writeln!(out, "C,{},{x:.3},{y:.3},{z:.3},{length:.3},{residual:.3}{tilted}", sample.t_ms)
        }
        // MotionCal has no word for an unknown value: a sample out of range is left out.
        StreamMode::MotionCal => match sample.measured_ut {
            // `as` saturates, and 0.1 µT is the unit MotionCal wants.
            Some(ut) => {
                let [x, y, z] = ut.map(|axis| math::round(f64::from(axis) * 10.0) as i16);
                writeln!(out, "Raw:0,0,0,0,0,0,{x},{y},{z}")
            }
            None => Ok(()),
        },
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Log, Sample, write_line};
    use crate::calibration::Calibration;
    use crate::extended::{ExtendedCalibration, Live};
    use crate::protocol::StreamMode;
    use std::string::String;

    fn line(mode: StreamMode, measured_ut: Option<[f32; 3]>) -> String {
        let calibration = Calibration { offset_ut: [93.0, 0.0, -1.0], ..Calibration::identity(48.0) };
        let counts = [-4096, 7, -300];
        let sample = Sample { t_ms: 1260, seq: 63, counts, measured_ut, turn_radps: None, is_tilted: false };
        let mut out = String::new();
        let live = Live::new(&ExtendedCalibration::plain(calibration)).unwrap();
        write_line(&mut out, mode, &sample, Some(&live), &mut Log::new()).unwrap();
        out
    }

    #[test]
    fn the_lines_of_the_contract() {
        let measured = Some([96.0, -4.0, 11.0]);
        assert_eq!(line(StreamMode::Off, measured), "");
        assert_eq!(line(StreamMode::Raw, measured), "R,1260,-4096,7,-300\n");
        assert_eq!(line(StreamMode::Calibrated, measured), "C,1260,3.000,-4.000,12.000,13.000,-35.000\n");
        assert_eq!(line(StreamMode::MotionCal, measured), "Raw:0,0,0,0,0,0,960,-40,110\n");
        assert_eq!(line(StreamMode::Log, measured), "H,t_ms,seq,x,y,z\nL,1260,63,-4096,7,-300\n");
    }

    #[test]
    fn a_sample_out_of_range_has_no_corrected_value() {
        assert_eq!(line(StreamMode::Raw, None), "R,1260,-4096,7,-300\n");
        assert_eq!(line(StreamMode::Calibrated, None), "C,1260,-,-,-,-,-\n");
        assert_eq!(line(StreamMode::MotionCal, None), "");
    }
}
