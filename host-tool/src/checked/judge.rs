//! Compares the log's error with that of the calibration's own log.

use crate::cal_file::CalFile;
use crate::checked::heading::{Headings, headings};
use crate::checked::shift::{Shift, shift};
use crate::checked::word::Word;
use crate::corrected::Corrected;
use crate::failure::Outcome;
use crate::input::Log;
use crate::output::json_number;
use crate::read_block;
use ironout::coverage::CoverageMap;
use ironout_analysis::fit::confined::beyond;
use ironout_analysis::outcome::request::Purpose;
use ironout_analysis::samples::data::Data;
use ironout_analysis::{Extrapolation, Options, Table};

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

/// What a log says of a calibration.
pub struct Checked<'a> {
    pub(crate) cal: &'a CalFile,
    pub(crate) log: &'a Log,
    pub(crate) word: Word,
    pub(crate) field_ut: f64,
    pub(crate) samples: usize,
    pub(crate) rms_ut: f64,
    pub(crate) limit_ut: f64,
    pub(crate) mean_ut: f64,
    pub(crate) coverage: f64,
    pub(crate) shift: Option<Shift>,
    pub(crate) headings: Headings,
    pub(crate) extrapolation: Extrapolation,
    pub(crate) tilted: Option<String>,
    pub(crate) declination_given: bool,
}

/// Compares the log's error with that of the calibration's own log. `notes` gets what is to be said of the columns of its effects.
///
/// # Errors
/// A column that the calibration needs and the log does not have.
pub fn judge<'a>(
    cal: &'a CalFile,
    log: &'a Log,
    declination: Option<f64>,
    notes: &mut Vec<String>,
) -> Outcome<Checked<'a>> {
    let extended = cal.extended()?;
    let calibration = extended.base;
    let table = Table::from(log);
    let corrector = Corrected::with_notes(extended, cal.fitted_to.as_deref(), log, &table, notes)?;
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
    let headings = headings(&table, &corrector, cal.fit.heading_error_deg, declination)?;
    let word = match (&headings, word) {
        (Headings::Judged(one), Word::Good | Word::Field) if one.is_wrong() => Word::Heading,
        (_, word) => word,
    };
    let mut map = CoverageMap::new();
    // About the log's own centre: a moved offset sees all directions from one side.
    let centre_ut = shift.as_ref().filter(|shift| shift.known).map_or([0.0; 3], |shift| shift.centre_ut);
    let from_centre = |field: &[f64; 3]| [0, 1, 2].map(|axis| (field[axis] - centre_ut[axis]) as f32);
    corrected.iter().for_each(|field| map.add(from_centre(field)));
    let coverage = f64::from(map.coverage().fraction);
    Ok(Checked {
        cal,
        log,
        word,
        field_ut: calibration.field_ut,
        samples: samples.len(),
        rms_ut,
        limit_ut,
        mean_ut,
        coverage,
        shift,
        headings,
        extrapolation,
        tilted,
        declination_given: declination.is_some(),
    })
}

impl Checked<'_> {
    /// Whether the calibration can be kept.
    pub fn is_good(&self) -> bool {
        matches!(self.word, Word::Good | Word::Field)
    }

    /// The change of offset and field, if this log determines it.
    pub(crate) fn known(&self) -> Option<&Shift> {
        self.shift.as_ref().filter(|shift| shift.known)
    }

    /// The object of `--json`.
    pub fn json(&self) -> serde_json::Value {
        let known = self.known();
        let mut object = serde_json::json!({
            "verdict": self.word.name(), "good": self.is_good(), "samples": self.samples, "field_ut": self.field_ut,
            "effects": self.cal.fit.effects.iter().map(|effect| &effect.id).collect::<Vec<_>>(),
            "rms_ut": json_number(Some(self.rms_ut)), "limit_ut": self.limit_ut, "calibration_rms_ut": self.cal.fit.rms_ut,
            "mean_residual_ut": json_number(Some(self.mean_ut)), "coverage": self.coverage,
            "offset_shift_ut": known.map(|shift| shift.offset_ut),
            "offset_shift_std_ut": known.map(|shift| shift.offset_std_ut),
            "field_shift_ut": known.map(|shift| shift.field_ut),
            "heading": self.headings.json(),
            "outside": self.extrapolation.outside, "range_unknown": self.extrapolation.unknown,
            "reasons": std::iter::once(self.word.explanation().to_string())
                .chain(self.headings.words(self.declination_given))
                .chain(self.extrapolation.notices(self.field_ut)).chain(self.tilted.clone()).collect::<Vec<_>>(),
            "reason_codes": self.codes(),
        });
        if let Some(fields) = object.as_object_mut() {
            fields.extend(read_block::context(self.log));
        }
        object
    }

    /// Stable words for the reasons, the verdict's first.
    fn codes(&self) -> Vec<&'static str> {
        let heading = !self.headings.words(self.declination_given).is_empty();
        let outside = !self.extrapolation.notices(self.field_ut).is_empty();
        let others =
            [(heading, "heading"), (outside, "outside-range"), (self.tilted.is_some(), "tilted-further")];
        let others = others.into_iter().filter(|(there, code)| *there && *code != self.word.name());
        std::iter::once(self.word.name()).chain(others.map(|(_, code)| code)).collect()
    }
}
