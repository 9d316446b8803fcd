//! A fit, a diagnosis and what is drawn of them, of the same samples.

use crate::base::ground::Ground;
use crate::calibration::EffectEntry;
use crate::correct::{CannotCorrect, Corrector};
use crate::effects::{Calibrated, calibrated};
use crate::fit::diagnosed::{leave_out, of_ground_searched};
use crate::fit::fitted::Fitted;
use crate::fit::{ids, run};
use crate::outcome::outcome::Diagnosis;
use crate::outcome::request::{Options, Refusal};
use crate::picture::picture::{Drawn, Picture};
use crate::samples::faults::DataFault;
use crate::table::Table;
use crate::threads::with_room;

/// A log, looked at.
#[derive(Debug, Clone)]
pub struct Look {
    /// What [`fit`](crate::fit()) gives.
    pub fitted: Fitted,
    /// What [`diagnose`](crate::diagnose) gives, where it was searched.
    pub diagnosis: Option<Diagnosis>,
    /// Faults of the data.
    pub faults: Vec<DataFault>,
    /// What noise alone leaves of the corrected magnitude, µT: by the search where there was one, for a fit by itself takes what
    /// is missing for noise where it looks like noise.
    pub floor_ut: Option<f64>,
    /// What is drawn.
    pub picture: Picture,
}

/// Fits a log with the effects of `options.add`, searches for others where `options.search` says so, and draws it. `told_ut` is the
/// floor that an earlier search of the same log gave ([`Look::floor_ut`]), if there was one.
///
/// # Errors
/// Those of [`fit`](crate::fit()).
pub fn look(table: &Table, options: &Options, told_ut: Option<f64>) -> Result<Look, Refusal> {
    ids::check(table, &options.add, options.registry)?;
    with_room(|| {
        let mut ground = Ground::of(table, options.method, options.scale_ut(), options.dip_deg);
        let fitted = run::of_ground(&ground, options)?;
        leave_out(&mut ground, options);
        let diagnosis = match options.search {
            true => Some(of_ground_searched(&ground, &Options { force_effect: true, ..options.clone() })?),
            false => None,
        };
        let searched_ut = diagnosis.as_ref().and_then(|found| found.residual_floor_ut).or(told_ut);
        let floor_ut = match (fitted.residual_floor_ut, searched_ut) {
            (Some(own), Some(searched)) => Some(own.min(searched)),
            (own, searched) => own.or(searched),
        };
        let picture = picture(&ground, &fitted, options, floor_ut);
        Ok(Look { fitted, diagnosis, faults: ground.counted.faults.clone(), floor_ut, picture })
    })
}

fn picture(ground: &Ground, fitted: &Fitted, options: &Options, floor_ut: Option<f64>) -> Picture {
    let counted = &ground.counted;
    let drawn = Drawn {
        table: counted.table,
        rows: counted.used.iter().map(|&sample| counted.data.row(sample)).collect(),
        samples: Some(&counted.samples),
        floor_ut,
    };
    let Some(solution) = &fitted.solution else { return drawn.bare() };
    let entries: Vec<EffectEntry> = solution.effects.iter().map(EffectEntry::from).collect();
    let whole = calibrated(solution.calibration, &entries, options.registry).ok();
    let corrector = whole.and_then(|whole| Corrector::new(whole, counted.table).ok());
    let base = match &ground.base {
        Ok(base) if !entries.is_empty() => base.solution.calibration,
        _ => solution.calibration,
    };
    corrector.map_or_else(|| drawn.bare(), |corrector| drawn.under(&base, &corrector))
}

/// Draws a log under a calibration that there is already, and gives the rms of its residual, µT.
///
/// # Errors
/// The column that the calibration needs and the log does not have.
pub fn look_with(table: &Table, calibration: Calibrated) -> Result<(Picture, f64), CannotCorrect> {
    let base = calibration.base;
    let corrector = Corrector::new(calibration, table)?;
    Ok(with_room(|| {
        let ground = Ground::of(table, Default::default(), None, None);
        let rows: Vec<usize> =
            ground.counted.used.iter().map(|&sample| ground.counted.data.row(sample)).collect();
        let squares: (f64, usize) = rows
            .iter()
            .filter_map(|&row| Some((corrector.correct(row).ok()?, table.place(row).share)))
            .fold((0.0, 0), |(sum, n), (corrected, share)| {
                let residual = ironout::calibration::norm(corrected) - base.field_ut * share;
                (sum + residual * residual, n + 1)
            });
        let drawn = Drawn {
            table,
            rows,
            samples: Some(&ground.counted.samples),
            floor_ut: ground.base.as_ref().ok().map(|base| base.residual_floor_ut),
        };
        (drawn.under(&base, &corrector), (squares.0 / squares.1.max(1) as f64).sqrt())
    }))
}
