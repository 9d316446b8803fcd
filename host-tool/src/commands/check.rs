//! `ironout check`: is a calibration still good for a new log?

use crate::cal_file::CalFile;
use crate::cli::CheckArgs;
use crate::corrected::Corrected;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Outcome};
use crate::output::{json_number, line};
use crate::{read_block, source};
use ironout::calibration::{Calibration, norm};
use ironout::coverage::CoverageMap;
use ironout_analysis::Table;
use ironout_analysis::samples::data::Data;
use nalgebra::{SMatrix, SVector};

/// Fewer samples say nothing.
const LEAST_SAMPLES: usize = 20;
/// The error may grow to this many times that of the calibration's own log …
const GROWTH: f64 = 1.5;
/// … or by this share of the field, whichever is more.
const MARGIN: f64 = 0.01;
/// An offset has moved where the shift is this many standard errors, …
const MOVED_SIGMA: f64 = 4.0;
/// … and at least this share of the field.
const MOVED: f64 = 0.02;
/// The linear estimate of a shift means something up to this share of the field.
const LINEAR: f64 = 0.3;
/// A shift of the offset is stated where its standard error is below this share of the field.
const KNOWN: f64 = 0.02;

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    Good,
    Field,
    Moved,
    Worse,
    Unknown,
}

impl Word {
    fn name(self) -> &'static str {
        match self {
            Word::Good => "good",
            Word::Field => "field",
            Word::Moved => "moved",
            Word::Worse => "worse",
            Word::Unknown => "unknown",
        }
    }

    fn explanation(self) -> &'static str {
        match self {
            Word::Good => "the calibration still holds, as far as the directions seen tell",
            Word::Field => {
                "the calibration holds; the field's magnitude is another than at the calibration (another place, or iron \
                 around): directions are right, magnitudes are off by that factor"
            }
            Word::Moved => {
                "the offset has moved (a magnet, a new part, a shock): calibrate again with ironout fit"
            }
            Word::Worse => {
                "the errors grew, and neither a moved offset nor another field explains it: calibrate again, and see \
                 what is missing with ironout diagnose"
            }
            Word::Unknown => "the log cannot tell: turn the board through more directions",
        }
    }
}

/// A change of the offset, and of the field's magnitude, that explains a residual.
struct Shift {
    offset_ut: [f64; 3],
    offset_std_ut: [f64; 3],
    field_ut: f64,
    /// Rms of what it leaves.
    rms_ut: f64,
    known: bool,
}

impl Shift {
    /// Whether the offset moved, beyond doubt and by enough to matter.
    fn moved(&self, field_ut: f64) -> bool {
        self.known
            && norm(self.offset_ut) >= MOVED * field_ut
            && self
                .offset_ut
                .iter()
                .zip(self.offset_std_ut)
                .any(|(shift, std)| shift.abs() > MOVED_SIGMA * std)
    }
}

/// Compares the log's error with that of the calibration's own log.
pub fn run(arguments: &CheckArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    let extended = cal.extended().map_err(|failure| failure.in_file(&arguments.cal))?;
    let calibration = extended.base;
    let log = source::read_for(&arguments.log, &cal, &arguments.cal, json)?;
    let table = Table::from(&log);
    let corrector = Corrected::new(extended, &log, &table)?;
    let extrapolation = corrector.extrapolation(&cal.fit.effects);
    let data = Data::new(&table);
    let all: Vec<u32> = (0..data.rows.len() as u32).collect();
    let samples = data.moving(&all, 1.0);
    let corrected = samples
        .iter()
        .map(|&sample| corrector.field(data.row(sample)))
        .collect::<Outcome<Vec<[f64; 3]>>>()?;
    let residual: Vec<f64> = corrected.iter().map(|field| calibration.residual_ut(*field)).collect();
    let rms =
        |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let rms_ut = rms(&residual);
    let own_ut = cal.fit.rms_ut.unwrap_or(0.0);
    let limit_ut = (GROWTH * own_ut).max(own_ut + MARGIN * calibration.field_ut);
    let mean_ut = residual.iter().sum::<f64>() / residual.len().max(1) as f64;
    let about_mean_ut = (rms_ut * rms_ut - mean_ut * mean_ut).max(0.0).sqrt();
    let shift =
        (samples.len() >= LEAST_SAMPLES).then(|| shift(&corrected, &residual, &calibration)).flatten();
    let word = match &shift {
        _ if samples.len() < LEAST_SAMPLES => Word::Unknown,
        Some(shift) if shift.moved(calibration.field_ut) && shift.rms_ut <= limit_ut => Word::Moved,
        _ if rms_ut <= limit_ut => Word::Good,
        // Which of the two it is, only many directions tell.
        None => Word::Unknown,
        Some(shift) if !shift.known => Word::Unknown,
        Some(_) if about_mean_ut <= limit_ut => Word::Field,
        Some(_) => Word::Worse,
    };
    let good = matches!(word, Word::Good | Word::Field);
    let mut map = CoverageMap::new();
    corrected.iter().for_each(|field| map.add(field.map(|value| value as f32)));
    let coverage = f64::from(map.coverage().fraction);
    let known = shift.as_ref().filter(|shift| shift.known);
    if json {
        line(
            &serde_json::json!({
                "read_as": read_block::json(&log.read_as),
                "verdict": word.name(), "good": good, "samples": samples.len(), "field_ut": calibration.field_ut,
                "effects": cal.fit.effects.iter().map(|effect| &effect.id).collect::<Vec<_>>(),
                "rms_ut": json_number(Some(rms_ut)), "limit_ut": limit_ut, "calibration_rms_ut": cal.fit.rms_ut,
                "mean_residual_ut": json_number(Some(mean_ut)), "coverage": coverage,
                "offset_shift_ut": known.map(|shift| shift.offset_ut),
                "offset_shift_std_ut": known.map(|shift| shift.offset_std_ut),
                "outside": extrapolation.outside, "range_unknown": extrapolation.unknown,
                "reasons": std::iter::once(word.explanation().to_string())
                    .chain(extrapolation.notices(calibration.field_ut)).collect::<Vec<_>>(),
            })
            .to_string(),
        );
    } else {
        let percent = |ut: f64| ut / calibration.field_ut * 100.0;
        line(&format!(
            "{}: {} samples against {}",
            log.path.display(),
            samples.len(),
            arguments.cal.display()
        ));
        line(&format!("error now             {rms_ut:9.3} µT  {:6.2} %", percent(rms_ut)));
        line(&format!("error at calibration  {own_ut:9.3} µT  {:6.2} %", percent(own_ut)));
        line(&format!("good up to            {limit_ut:9.3} µT  {:6.2} %", percent(limit_ut)));
        if let Some(shift) = known {
            let [x, y, z] = shift.offset_ut;
            let [sx, sy, sz] = shift.offset_std_ut;
            line(&format!("offset moved by       {x:+.2} ±{sx:.2}  {y:+.2} ±{sy:.2}  {z:+.2} ±{sz:.2} µT"));
            line(&format!(
                "field changed by      {:+9.3} µT  {:+6.2} %",
                shift.field_ut,
                percent(shift.field_ut)
            ));
        }
        line(&format!("directions seen       {:9.0} %", coverage * 100.0));
        line(&format!("{}: {}", word.name().to_uppercase(), word.explanation()));
        let notices = extrapolation.notices(calibration.field_ut);
        notices.iter().for_each(|notice| line(&format!("  extrapolated: {notice}")));
    }
    Ok(if good { EXIT_OK } else { EXIT_REFUSED })
}

/// Least squares of the residual on a shift of the offset and of the field: `r = (Cᵀu)·δb + δF`: what is
/// added to every measurement shows along the corrected direction.
fn shift(corrected: &[[f64; 3]], residual: &[f64], calibration: &Calibration<f64>) -> Option<Shift> {
    let mut normal = SMatrix::<f64, 4, 4>::zeros();
    let mut right = SVector::<f64, 4>::zeros();
    for (h, &r) in corrected.iter().zip(residual) {
        let length = norm(*h);
        if length <= 0.0 {
            continue;
        }
        let c = &calibration.matrix;
        let slope = [0, 1, 2].map(|axis| (0..3).map(|row| c[row][axis] * h[row]).sum::<f64>() / length);
        let row = SVector::<f64, 4>::new(slope[0], slope[1], slope[2], 1.0);
        normal += row * row.transpose();
        right += row * r;
    }
    let factor = normal.cholesky()?;
    let solution = factor.solve(&right);
    let n = corrected.len() as f64;
    let squares: f64 = residual.iter().map(|r| r * r).sum();
    let rms_ut = ((squares - solution.dot(&right)).max(0.0) / n).sqrt();
    let inverse = factor.inverse();
    // Neighbouring residuals are not independent: count a tenth of the samples.
    let std = |i: usize| rms_ut * (10.0 * inverse[(i, i)]).sqrt();
    let offset_std_ut = [std(0), std(1), std(2)];
    Some(Shift {
        offset_ut: [solution[0], solution[1], solution[2]],
        offset_std_ut,
        field_ut: solution[3],
        rms_ut,
        known: offset_std_ut.iter().all(|s| *s <= KNOWN * calibration.field_ut)
            && norm([solution[0], solution[1], solution[2]]).max(solution[3].abs())
                <= LINEAR * calibration.field_ut,
    })
}
