//! A calibration on the rows of a log, its failures with their place.

use crate::failure::{Failure, Outcome};
use crate::input::Log;
use ironout_analysis::calibration::EffectEntry;
use ironout_analysis::effects::Calibrated;
use ironout_analysis::{Corrector, Extrapolation, Table, on_another_clock};

/// Corrects the rows of one log.
pub struct Corrected<'a> {
    log: &'a Log,
    corrector: Corrector<'a>,
}

impl<'a> Corrected<'a> {
    /// Finds what the calibration's effects need in the log, and says on standard error what to know about them. What goes by the time
    /// is left out in another log than the calibration is `of`, where that is known.
    ///
    /// # Errors
    /// The column that is missing, empty or not finite, and the effect that needs it.
    pub fn new(
        calibration: Calibrated,
        of: Option<&str>,
        log: &'a Log,
        table: &'a Table<'a>,
    ) -> Outcome<Self> {
        let mut notes = Vec::new();
        let corrected = Self::with_notes(calibration, of, log, table, &mut notes);
        notes.iter().for_each(|note| eprintln!("note: {}: {note}", log.path.display()));
        corrected
    }

    /// [`Self::new`] without a word: what is to be said goes to `notes`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_notes(
        calibration: Calibrated,
        of: Option<&str>,
        log: &'a Log,
        table: &'a Table<'a>,
        notes: &mut Vec<String>,
    ) -> Outcome<Self> {
        let (calibration, left_out) = match of.is_some_and(|of| of != table.fingerprint()) {
            true => on_another_clock(&calibration),
            false => (calibration, Vec::new()),
        };
        if !left_out.is_empty() {
            notes.push(format!(
                "ironout does not apply {}: effects of time depend on the clock of the fitted log, and this is another log",
                left_out.join(" and ")
            ));
        }
        let corrector = Corrector::new(calibration, table)
            .map_err(|error| Failure::usage(error.why).in_file(&log.path).at_column(error.column))?;
        notes.extend(corrector.notice());
        Ok(Corrected { log, corrector })
    }

    /// What the log asks of the effects beyond the ranges that they were fitted over.
    pub fn extrapolation(&self, entries: &[EffectEntry]) -> Extrapolation {
        self.corrector.extrapolation(entries)
    }

    /// The calibration.
    pub fn calibration(&self) -> &Calibrated {
        self.corrector.calibration()
    }

    /// `‖corrected‖ − F` of one row, µT: on a journey with the field of that place.
    pub fn residual_ut(&self, row: usize, corrected_ut: [f64; 3]) -> f64 {
        self.corrector.residual_ut(row, corrected_ut)
    }

    /// The corrected field of one row, µT; a failure that names the row.
    pub fn field(&self, row: usize) -> Outcome<[f64; 3]> {
        self.corrector.correct(row).map_err(|error| {
            Failure::usage(format!("row {} cannot be corrected: {error}", row + 1)).in_file(&self.log.path)
        })
    }

    /// The corrected field of every row.
    ///
    /// # Errors
    /// The row, and the columns that are outside the range that their effect was fitted for.
    pub fn fields(&self, entries: &[EffectEntry]) -> Outcome<Vec<[f64; 3]>> {
        (0..self.log.rows)
            .map(|row| {
                self.field(row).map_err(|mut failure| {
                    let notices = self.extrapolation(entries).notices(self.calibration().base.field_ut);
                    if !notices.is_empty() {
                        failure.message += &format!(
                            ". {}. Fix: calibrate with a log that contains these values",
                            notices.join(". ")
                        );
                    }
                    failure
                })
            })
            .collect()
    }
}
