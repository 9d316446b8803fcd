//! Compares the log's error with that of the calibration's own log.

use crate::cal_file::CalFile;
use crate::cli::CheckArgs;
use crate::commands::check::heading::{Headings, headings};
use crate::commands::check::shift::shift;
use crate::commands::check::word::Word;
use crate::corrected::Corrected;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Outcome};
use crate::output::{json_number, line};
use crate::{read_block, source};
use ironout::coverage::CoverageMap;
use ironout_analysis::Options;
use ironout_analysis::Table;
use ironout_analysis::fit::confined::beyond;
use ironout_analysis::outcome::request::Purpose;
use ironout_analysis::samples::data::Data;

/// Fewer samples say nothing.
const LEAST_SAMPLES: usize = 20;
/// The error may grow to this many times that of the calibration's own log …
const GROWTH: f64 = 1.5;
/// … or by this share of the field, whichever is more.
const MARGIN: f64 = 0.01;
/// Whether a calibration of the log's own is accepted and leaves no more than this, µT.
fn explains_itself(table: &Table<'_>, limit_ut: f64) -> bool {
    let options = Options { purpose: Purpose::All, ..Options::default() };
    let fitted = ironout_analysis::fit(table, &options);
    fitted.is_ok_and(|fitted| {
        fitted.accepted && fitted.solution.is_some_and(|solution| solution.rms_ut <= limit_ut)
    })
}

/// Compares the log's error with that of the calibration's own log.
pub fn run(arguments: &CheckArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    let extended = cal.extended().map_err(|failure| failure.in_file(&arguments.cal))?;
    let calibration = extended.base;
    let log = source::read_for(&arguments.log, &cal, &arguments.cal, json)?;
    let table = Table::from(&log);
    let corrector = Corrected::new(extended, cal.fitted_to.as_deref(), &log, &table)?;
    let extrapolation = corrector.extrapolation(&cal.fit.effects);
    let tilted = cal.fit.holds_for.as_ref().and_then(|holds_for| beyond(holds_for, &table));
    let data = Data::new(&table);
    let all: Vec<u32> = (0..data.rows.len() as u32).collect();
    let samples = data.moving(&all, 1.0);
    let corrected = samples
        .iter()
        .map(|&sample| corrector.field(data.row(sample)))
        .collect::<Outcome<Vec<[f64; 3]>>>()?;
    let residual: Vec<f64> = (samples.iter().zip(&corrected))
        .map(|(&sample, field)| corrector.residual_ut(data.row(sample), *field))
        .collect();
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
        Some(shift) if !shift.known && !explains_itself(&table, limit_ut) => Word::Unknown,
        Some(shift) if shift.known && about_mean_ut <= limit_ut => Word::Field,
        Some(_) if explains_itself(&table, limit_ut) => Word::Other,
        Some(_) => Word::Worse,
    };
    let headings = headings(&table, &corrector, cal.fit.heading_error_deg, arguments.declination)?;
    let word = match (&headings, word) {
        (Headings::Judged(one), Word::Good | Word::Field) if one.is_wrong() => Word::Heading,
        (_, word) => word,
    };
    let good = matches!(word, Word::Good | Word::Field);
    let mut map = CoverageMap::new();
    // About the log's own centre: a moved offset sees all directions from one side.
    let centre_ut = shift.as_ref().filter(|shift| shift.known).map_or([0.0; 3], |shift| shift.centre_ut);
    let from_centre = |field: &[f64; 3]| [0, 1, 2].map(|axis| (field[axis] - centre_ut[axis]) as f32);
    corrected.iter().for_each(|field| map.add(from_centre(field)));
    let coverage = f64::from(map.coverage().fraction);
    let known = shift.as_ref().filter(|shift| shift.known);
    if json {
        line(
            &serde_json::json!({
                "read_as": read_block::json(&log),
                "verdict": word.name(), "good": good, "samples": samples.len(), "field_ut": calibration.field_ut,
                "effects": cal.fit.effects.iter().map(|effect| &effect.id).collect::<Vec<_>>(),
                "rms_ut": json_number(Some(rms_ut)), "limit_ut": limit_ut, "calibration_rms_ut": cal.fit.rms_ut,
                "mean_residual_ut": json_number(Some(mean_ut)), "coverage": coverage,
                "offset_shift_ut": known.map(|shift| shift.offset_ut),
                "offset_shift_std_ut": known.map(|shift| shift.offset_std_ut),
                "heading": headings.json(),
                "outside": extrapolation.outside, "range_unknown": extrapolation.unknown,
                "reasons": std::iter::once(word.explanation().to_string())
                    .chain(headings.words(arguments.declination.is_some()))
                    .chain(extrapolation.notices(calibration.field_ut)).chain(tilted).collect::<Vec<_>>(),
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
        if let Headings::Judged(one) = &headings {
            line(&one.line());
        }
        line(&format!("directions seen       {:9.0} %", coverage * 100.0));
        line(&format!("{}: {}", word.name().to_uppercase(), word.explanation()));
        for words in headings.words(arguments.declination.is_some()) {
            line(&format!("  {words}"));
        }
        let notices: Vec<String> =
            extrapolation.notices(calibration.field_ut).into_iter().chain(tilted).collect();
        notices.iter().for_each(|notice| line(&format!("  outside the range: {notice}")));
    }
    Ok(if good { EXIT_OK } else { EXIT_REFUSED })
}
