//! A board at rest: the vector itself is the residual.

use crate::base::engine::Design;
use crate::base::prior::Prior;
use crate::base::quality::{covariance, residue};
use crate::base::start;
use crate::outcome::asked::placed_at;
use crate::outcome::blank::undetermined;
use crate::outcome::outcome::{Diagnosis, NoiseRow, Status, Verdict};
use crate::outcome::request::{Options, Refusal};
use crate::outcome::rows::describe;
use crate::outcome::shows::shows;
use crate::outcome::view::View;
use crate::reason::Reason;
use crate::residual::traces::Traces;
use crate::samples::samples::Samples;
use crate::search::candidates::Catalogue;
use crate::search::state::Fitter;
use crate::table::Table;
use ironout::effect::Follows;
use ironout::extended::MAX_EFFECTS;
use ironout::study::{Model, Residual};

/// A board at rest: the vector itself is the residual.
pub(crate) fn at_rest(table: &Table, samples: &Samples, options: &Options) -> Result<Diagnosis, Refusal> {
    let catalogue = Catalogue::new(samples, table, options.registry);
    let design = Design::new(samples, Residual::Vector);
    let known = Prior::default();
    let mean = samples.mean_vector();
    let model = Model::new(mean, start::NO_ROTATION, 1.0, start::NO_ROTATION, 0.0);
    let nothing = || {
        undetermined(
            table,
            samples,
            options.registry,
            Reason::new("at-rest", "the sensor was at rest for most of the log, and no column changes"),
        )
    };
    if catalogue.usable_columns().next().is_none() {
        return Ok(nothing());
    }
    let Some(base) = model.map(|model| design.fit(model, Vec::new(), &known)).transpose()?.flatten() else {
        return Ok(nothing());
    };
    let fitter = Fitter::new(design, &catalogue, &known);
    if let Some(more) = options.add.get(MAX_EFFECTS) {
        return Err(Refusal::cannot_add(more, format!("a calibration stores at most {MAX_EFFECTS} effects")));
    }
    let asked: Vec<&String> = options.add.iter().collect();
    let start = match asked.is_empty() {
        true => base.clone(),
        false => {
            let (terms, _) = placed_at(&fitter, &base, &asked)?;
            design.fit(base.model, terms, &known)?.unwrap_or_else(|| base.clone())
        }
    };
    let explanation = if options.search {
        fitter.that_hold(fitter.selected(start)?, &options.add)?
    } else {
        let mut only = fitter.only(base, start)?;
        only.chances = fitter.chances(&only.fitted);
        only
    };
    let (used, confounded) = (explanation.fitted.terms.len(), explanation.confounded.clone());
    let fitted = &explanation.fitted;
    let residuals = design.residuals(&fitted.model, &fitted.terms.iter().collect::<Vec<_>>())?;
    let left = residue(&design, &fitted.model, &residuals, fitted.columns());
    let covariance = covariance(fitted, left.time);
    let mut column = 3;
    let effects = fitted
        .terms
        .iter()
        .map(|term| {
            let errors = (column..column + term.k())
                .map(|index| covariance.as_ref().map_or(f64::NAN, |rows| rows[index][index].max(0.0).sqrt()))
                .collect();
            column += term.k();
            describe(term, errors)
        })
        .collect();
    let mut reasons = vec![Reason::new(
        "at-rest",
        "The sensor was at rest for most of the log, so this log alone cannot be calibrated",
    )];
    let verdict = if left.structure > 0.0 {
        reasons.push(Reason::new(
            "unexplained-variance",
            format!(
                "{:.0} % of the variance is not noise, and no candidate explains it",
                100.0 * left.structure
            ),
        ));
        Verdict::Unexplained
    } else if !confounded.is_empty() {
        Verdict::Confounded
    } else if used > 0 {
        Verdict::Missing
    } else {
        Verdict::Complete
    };
    let base_residuals = design.residuals(&explanation.base.model, &[])?;
    let shows = shows(samples, &base_residuals, &explanation, &explanation.base.model);
    let traces = Traces::of(&design, &explanation.base, &explanation.fitted)?;
    let view = View {
        table,
        samples,
        catalogue: &catalogue,
        design,
        known: &known,
        explanation,
        lower_order: None,
        base: None,
        dip_deg: None,
        searches: options.search,
    };
    let in_group = |id: &String| confounded.iter().any(|group| group.ids.contains(id));
    let mut steps = view.steps(&None)?;
    steps.retain(|step| step.added.as_ref().is_none_or(|id| !in_group(id)));
    let mut candidates = view.candidates(&None, false, None, verdict);
    let turning =
        |id: &str| options.registry.parse(id).is_some_and(|named| named.family.follows() == Follows::Turning);
    for row in &mut candidates {
        if row.residual == "magnitude" {
            row.residual = Residual::Vector.name();
        }
        if row.status == Status::Untestable && turning(&row.id) {
            row.why = "the sensor did not turn".into();
        }
    }
    Ok(Diagnosis {
        verdict,
        reasons,
        residual: Residual::Vector.name(),
        steps,
        noise_floor_ut: Some(left.floor),
        residual_floor_ut: Some(left.floor),
        residual_floor_least_ut: Some(left.floor_least),
        noise: Some(NoiseRow::of(&left)),
        candidates,
        effects,
        shows,
        prior: "none".into(),
        contradiction: None,
        recordings: None,
        switching: None,
        levels: None,
        pair: None,
        wander: None,
        traces,
        ..undetermined(table, samples, options.registry, Reason::new("at-rest", ""))
    })
}
