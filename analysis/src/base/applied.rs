//! The error as a correction leaves it.
//!
//! A fit looks at its shapes at the closest point, where there is no noise; whoever corrects has only the noisy sample. Where an effect
//! follows the field itself (a nonlinearity, a gain) that makes the noise larger or smaller by the effect's slope, and what is said
//! of an error is what a correction leaves.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, Term};
use crate::samples::series::rms;
use crate::threads::halves;
use ironout::calibration::norm;
use ironout::study::{NotFinite, Residual};
use std::ops::Range;

/// The residual of a fitted model under its own correction.
pub struct Applied {
    /// The residuals, in the order of the fit's.
    pub residuals: Vec<f64>,
    /// Their rms over that of the fit's own.
    pub share: f64,
}

impl Applied {
    /// Of a fit.
    ///
    /// # Errors
    /// A shape that is not finite at a sample.
    pub fn of(design: &Design, fitted: &Fitted) -> Result<Applied, BadShape> {
        let list: Vec<&Term> = fitted.terms.iter().collect();
        let own = design.residuals(&fitted.model, &list)?;
        if design.residual != Residual::Magnitude || list.is_empty() {
            return Ok(Applied { residuals: own, share: 1.0 });
        }
        let within = |samples: &Range<usize>| -> Result<Vec<f64>, BadShape> {
            let mut residuals = Vec::with_capacity(samples.len());
            let mut at_sample = Vec::with_capacity(list.len());
            for sample in samples.clone() {
                at_sample.clear();
                at_sample.extend(list.iter().map(|term| term.at_sample(sample)));
                match fitted.model.correct(&design.samples.readings[sample], &at_sample) {
                    Ok(corrected) => {
                        let field_ut = fitted.model.field_ut * design.samples.place(sample).share;
                        residuals.push(norm(corrected) - field_ut);
                    }
                    Err(NotFinite::Effect(index)) => {
                        return Err(BadShape::NotFinite(
                            list.get(index).map_or_else(String::new, |one| one.id.clone()),
                        ));
                    }
                    // Such a sample has no row in a fit either.
                    Err(NotFinite::Sample) => {}
                }
            }
            Ok(residuals)
        };
        let n = design.samples.len();
        let (first, second) = halves((&(0..n / 2), &(n / 2..n)), within);
        let mut residuals = first?;
        residuals.extend(second?);
        let (ours, theirs) = (rms(&residuals), rms(&own));
        let share = if ours.is_finite() && theirs > 0.0 { ours / theirs } else { 1.0 };
        Ok(Applied { residuals, share })
    }
}
