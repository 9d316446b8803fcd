//! A pure delay in full: not to first order in the rate of turn, but against the other sensors as they were.

use crate::base::alignment::align;
use crate::base::engine::Design;
use crate::base::prior::Prior;
use crate::base::start::NO_ROTATION;
use crate::base::term::{BadShape, Term};
use crate::bounds::MAX_LAG_S;
use crate::samples::samples::Samples;
use crate::samples::series::median;
use crate::table::Table;
use ironout::study::{Model, Residual};

/// Delays that are tried where the dip spreads and no small one explains it, s.
const SCANNED_S: [f64; 8] = [0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.2, 1.6];

/// A fit of the dip with a delay.
pub struct Late<'a> {
    /// Rotation and dip.
    pub model: Model<f64>,
    /// The delay, as the coefficient of the lag.
    pub terms: Vec<Term<'a>>,
    /// Sum of squared residuals, rad².
    pub squares: f64,
    /// How late the other sensors were taken; `None` where the delay is still of first order.
    pub beside: Option<f64>,
}

/// Rows of the log, s from one to the next.
fn step_s(table: &Table) -> Option<f64> {
    let time = table.time_s?;
    let mut steps: Vec<f64> =
        time.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    let step = median(&mut steps);
    (step.is_finite() && step > 0.0).then_some(step)
}

/// The delay at which the dip is most constant, for a sensor so late that a fit of first order does not see it: `None`
/// where no delay takes away the better part of the spread `after_deg`.
pub fn scan(
    table: &Table,
    samples: &Samples,
    model: &Model<f64>,
    after_deg: f64,
) -> Result<Option<(f64, Model<f64>)>, BadShape> {
    let mut best: Option<(f64, f64, Model<f64>)> = None;
    for delay_s in SCANNED_S {
        let Some(moved) = samples.beside_late(table, delay_s) else { return Ok(None) };
        let start = Model::new(model.offset_ut, model.matrix, model.field_ut, NO_ROTATION, 0.0);
        let Some(start) = start else { return Ok(None) };
        if let Some(found) = align(&moved, &start)?
            && found.after_deg < 0.5 * after_deg
            && best.as_ref().is_none_or(|(least, ..)| found.after_deg < *least)
        {
            best = Some((found.after_deg, delay_s, found.model));
        }
    }
    Ok(best.map(|(_, delay_s, model)| (delay_s, model)))
}

impl<'a> Late<'a> {
    /// Moves the other sensors back by the delay, in whole rows so that none is averaged with its neighbour, until the rest
    /// is less than a row and of first order. `samples` have no effects left in them. `from` is a delay that a scan has
    /// found. The fit of first order stays where moving does not make the dip more constant.
    pub fn settled(
        self,
        table: &Table,
        samples: &Samples,
        known: &Prior,
        from: Option<(f64, Model<f64>)>,
    ) -> Result<Late<'a>, BadShape> {
        let (Some(term), Some(step_s)) = (self.terms.first().cloned(), step_s(table)) else {
            return Ok(self);
        };
        let mut best = self;
        let (mut delay_s, mut model) = from.unwrap_or((term.coefficients[0], best.model));
        for _ in 0..12 {
            let beside = (delay_s / step_s).round() * step_s;
            if !(delay_s.abs() < MAX_LAG_S) || best.beside == Some(beside) || beside == 0.0 {
                break;
            }
            let Some(moved) = samples.beside_late(table, beside) else { break };
            let design = Design::new(&moved, Residual::Dip);
            let mut rest = Term { coefficients: Default::default(), ..term.clone() };
            rest.coefficients[0] = delay_s - beside;
            let Some(fit) = design.fit(model, vec![rest.clone()], known)? else { break };
            delay_s = beside + fit.terms[0].coefficients[0];
            model = fit.model;
            if fit.squares < best.squares {
                rest.coefficients[0] = delay_s;
                best = Late { model, terms: vec![rest], squares: fit.squares, beside: Some(beside) };
            }
        }
        Ok(best)
    }
}
