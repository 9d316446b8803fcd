//! Whether a log contradicts the earlier calibration that it is studied on top of, and what is freed of that then.
//!
//! Nested models are compared by `T`, the rise of `−2 ln L` to second order: the earlier calibration as it is, with its offset free, with
//! its field free (another place), with both, and not used at all. The variance is that of the loosest fit's residual, times how many
//! samples contain the information of one independent sample. `T / k`, of k freed parameters, is F-distributed where the calibration still holds.

use crate::base::earlier::EarlierCalibration;
use crate::base::engine::{Design, Fitted};
use crate::base::ground::Ground;
use crate::base::prior::{Earlier, Prior, parameters};
use crate::base::quality::Sizes;
use crate::base::start::sphere;
use crate::base::term::{Matrix, Term};
use crate::bounds::{ALIGNABLE, MAX_P_CONTRADICTED};
use crate::outcome::asked::asked_for;
use crate::outcome::request::{Options, Refusal};
use crate::search::candidates::Catalogue;
use crate::search::state::Fitter;
use ironout::study::{Model, Residual, f_tail};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Parameters of offset and triangle.
const PARAMETERS: f64 = 9.0;
/// Fewer independent samples say nothing about them.
const FEWEST: f64 = 2.0 * PARAMETERS;

/// Parameters of an earlier calibration that are fitted again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Freed {
    /// The offset; the matrix is kept.
    Offset,
    /// The magnitude of the field, and with it one factor of the matrix.
    Field,
    /// Both.
    OffsetAndField,
    /// All of it: the log is fitted by itself.
    All,
}

impl Freed {
    const ALL: [Freed; 4] = [Freed::Offset, Freed::Field, Freed::OffsetAndField, Freed::All];

    /// Degrees of freedom.
    fn freedom(self) -> f64 {
        match self {
            Freed::Offset => 3.0,
            Freed::Field => 1.0,
            Freed::OffsetAndField => 4.0,
            Freed::All => PARAMETERS,
        }
    }

    /// What is left of an earlier calibration.
    fn of(self, prior: &EarlierCalibration) -> Option<EarlierCalibration> {
        let c = &prior.triangle;
        let field = [0.0, 0.0, 0.0, c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]];
        match self {
            Freed::Offset => Some(prior.without_offset()),
            Freed::Field => Some(prior.without(&[field])),
            Freed::OffsetAndField => Some(prior.without_offset().without(&[field])),
            Freed::All => None,
        }
    }
}

/// What a log says against an earlier calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contradiction {
    /// The parameters that are fitted again.
    pub freed: Freed,
    /// By how many standard deviations the log contradicts: √T.
    pub sigmas: f64,
    /// How far the offset has moved, µT.
    pub moved_ut: [f64; 3],
    /// The field here as a share of that of the earlier calibration.
    pub field_ratio: f64,
}

impl Contradiction {
    /// In words.
    pub fn words(&self) -> String {
        let [x, y, z] = self.moved_ut;
        let offset = format!("the offset has changed by ({x:+.1}, {y:+.1}, {z:+.1}) µT");
        let field = format!("the field strength is {:.1} % of the earlier one", 100.0 * self.field_ratio);
        let (what, done) = match self.freed {
            Freed::Offset => (offset, "has fitted the offset again and kept the matrix"),
            Freed::Field => {
                (field, "has fitted the field strength again and kept the offset and the shape of the matrix")
            }
            Freed::OffsetAndField => {
                (format!("{offset} and {field}"), "has fitted both again and kept the shape of the matrix")
            }
            Freed::All => (
                "the matrix has changed too".into(),
                "has ignored the earlier calibration and fitted this log alone",
            ),
        };
        format!(
            "This log contradicts the earlier calibration ({:.0} standard errors): {what}. ironout {done}",
            self.sigmas
        )
    }
}

/// The request without what this log contradicts, and what that is; `None` where the earlier calibration holds.
pub(crate) fn freed(ground: &Ground, options: &Options) -> Result<Option<(Options, Contradiction)>, Refusal> {
    let Some(prior) = &options.prior else { return Ok(None) };
    let counted = &ground.counted;
    if counted.rests || counted.axes != [true; 3] {
        return Ok(None);
    }
    let samples = counted.samples.known_at(&prior.conditions);
    let catalogue = Catalogue::new(&samples, counted.table, options.registry);
    let Some(begin) = prior.model(options.field_ut) else { return Ok(None) };
    let log =
        Log { design: Design::new(&samples, Residual::Magnitude), catalogue: &catalogue, options, begin };
    let earlier = prior.earlier(options.field_ut);
    // Where the log says little of the matrix a freer one is fitted to the noise across the plane or the cap of its directions.
    let tells_all = ground.base.as_ref().is_ok_and(|base| base.predicted_share() <= ALIGNABLE);
    let freed = if tells_all { &Freed::ALL[..] } else { &Freed::ALL[..2] };
    let information = |freed: Freed| freed.of(prior).map(|kept| kept.earlier(options.field_ut));
    let mut looser = Vec::new();
    for &freed in freed {
        let kept = information(freed);
        let Some(fitted) = log.with(kept.as_ref(), 1.0)? else { continue };
        let terms: Vec<&Term> = fitted.terms.iter().collect();
        let residuals = log.design.residuals(&fitted.model, &terms)?;
        let memory = Sizes::of(&residuals).memory();
        let independent = fitted.rows / memory - PARAMETERS;
        // What does not fit says nothing of what is kept.
        if independent < FEWEST {
            continue;
        }
        let fitted = log.with(kept.as_ref(), memory)?.unwrap_or(fitted);
        looser.push((freed, Looser::of(&fitted, memory, independent, earlier.parameters, kept)));
    }
    // A model holds where none that frees more is better by more than chance.
    let stands = |own: Option<&Earlier>, parameters: f64| {
        looser.iter().filter(|(freed, _)| freed.freedom() > parameters).all(|(freed, looser)| {
            let more = freed.freedom() - parameters;
            let rise = own.and_then(|own| looser.rises_under(own));
            rise.is_none_or(|rise| f_tail(rise / more, more, looser.independent) >= MAX_P_CONTRADICTED)
        })
    };
    if stands(Some(&earlier), 0.0) {
        return Ok(None);
    }
    let found = looser.iter().find(|(freed, _)| stands(information(*freed).as_ref(), freed.freedom()));
    let Some((freed, looser)) = found else { return Ok(None) };
    let (then, moved) = (earlier.parameters, looser.departs);
    let size = |diagonal: [f64; 3]| diagonal.iter().product::<f64>().abs().cbrt();
    let contradiction = Contradiction {
        freed: *freed,
        sigmas: looser.rises_under(&earlier).unwrap_or_default().sqrt(),
        moved_ut: [0, 1, 2].map(|axis| moved[axis]),
        field_ratio: size([3, 6, 8].map(|i| then[i])) / size([3, 6, 8].map(|i| then[i] + moved[i])),
    };
    let mut prior = freed.of(prior);
    if let Some(prior) = prior.as_mut().filter(|_| *freed != Freed::Field) {
        // Nothing is known of it any more: where the next fit begins.
        (0..3).for_each(|axis| prior.offset_ut[axis] += moved[axis]);
    }
    Ok(Some((Options { prior, ..options.clone() }, contradiction)))
}

/// What a fit says of one that keeps more, to second order: a fit at the closest points is no least sum of squares, so that their sums
/// cannot be compared.
struct Looser {
    /// How far it is from the earlier calibration.
    departs: SVector<f64, 9>,
    /// Information of the data, all columns.
    information: DMatrix<f64>,
    /// Half the slope of `−2 ln L` of the data.
    slope: DVector<f64>,
    /// What is kept of the earlier calibration.
    kept: Option<Earlier>,
    /// Independent samples beyond the parameters.
    independent: f64,
}

fn nine(earlier: &Earlier) -> SMatrix<f64, 9, 9> {
    SMatrix::from_fn(|i, j| earlier.information[i][j])
}

impl Looser {
    fn of(fitted: &Fitted, memory: f64, independent: f64, then: [f64; 9], kept: Option<Earlier>) -> Self {
        let data = Matrix::total(&fitted.blocks, None);
        let (columns, variance) = (data.columns(), fitted.sigma().powi(2) * memory);
        let entry = |i: usize, j: usize| data.entry(i.min(j), i.max(j)) / variance;
        let now = parameters(&fitted.model);
        Looser {
            departs: SVector::from_fn(|i, _| now[i] - then[i]),
            information: DMatrix::from_fn(columns, columns, entry),
            slope: DVector::from_fn(columns, |i, _| data.right(i) / variance),
            kept,
            independent,
        }
    }

    /// `T`: by how much `−2 ln L` rises where this is known instead of what is kept; `None` where nothing is determined.
    fn rises_under(&self, known: &Earlier) -> Option<f64> {
        let known = nine(known);
        let pull = known * self.departs;
        let (mut information, mut slope) = (self.information.clone(), self.slope.clone());
        for i in 0..9 {
            slope[i] += pull[i];
            (0..9).for_each(|j| information[(i, j)] += known[(i, j)]);
        }
        let step = -information.cholesky()?.solve(&slope);
        let kept = self.kept.as_ref().map_or(0.0, |kept| self.departs.dot(&(nine(kept) * self.departs)));
        Some((self.departs.dot(&pull) + step.dot(&slope) - kept).max(0.0))
    }
}

/// A log under one of several earlier calibrations.
struct Log<'a> {
    design: Design<'a>,
    catalogue: &'a Catalogue<'a>,
    options: &'a Options,
    begin: Model<f64>,
}

impl<'a> Log<'a> {
    /// Fit with the requested effects; `None` if it does not converge. `memory` samples contain the information of one.
    fn with(&self, earlier: Option<&Earlier>, memory: f64) -> Result<Option<Fitted<'a>>, Refusal> {
        let known = Prior { earlier: earlier.map(|earlier| earlier.times(memory)), ..Prior::default() };
        // From where it was, and from where the readings lie: an offset that has moved by as much as the field is far away.
        let mut begins = vec![self.begin];
        if let Some((centre, _)) = sphere(self.design.samples) {
            let Model { matrix, field_ut, rotation, sin_dip, .. } = self.begin;
            begins.extend(Model::new(centre, matrix, field_ut, rotation, sin_dip));
        }
        let mut best: Option<Fitted> = None;
        for begin in begins {
            let found = self.design.fit(begin, Vec::new(), &known)?;
            if let Some(found) =
                found.filter(|found| best.as_ref().is_none_or(|best| found.squares < best.squares))
            {
                best = Some(found);
            }
        }
        let Some(base) = best else { return Ok(None) };
        if self.options.add.is_empty() {
            return Ok(Some(base));
        }
        let fitter = Fitter::new(self.design, self.catalogue, &known);
        Ok(asked_for(&fitter, &base, self.options)?.ok().map(|added| added.start))
    }
}
