//! Effects of a log that does not show all attitudes: offsets in proportion to a column.

use crate::base::term::Term;
use crate::calibration::FittedEffect;
use crate::confined::log::{Log, MOST_EFFECTS};
use crate::confined::solve::Solved;
use crate::confined::state::effect_at;
use crate::outcome::request::Options;
use crate::outcome::rows::describe;
use crate::samples::samples::{Column, Samples};
use ironout::effect::{MAX_INPUTS, Made, Parts};
use std::sync::Arc;

/// χ² with three degrees of freedom that chance exceeds in one of a thousand logs.
const CHI_SQUARE: f64 = 16.27;

/// The columns of the effects that are asked for; `None` where one of them is not an offset in proportion to a column, or they are too many.
pub(crate) fn offsets<'a>(samples: &'a Samples, options: &Options) -> Option<Vec<&'a Column>> {
    let of = |id: &String| {
        let named = options.registry.parse(id)?;
        let parts = Parts { form: named.form, column: named.column, reference: 0.0, parameter: 0.0 };
        let column = samples.columns.iter().find(|column| column.name == named.column)?;
        (named.family.is_proportional(&parts) && column.problem.is_none()).then_some(column)
    };
    (options.add.len() <= MOST_EFFECTS).then(|| options.add.iter().map(of).collect())?
}

/// The effects with their coefficients, and which of them the log does not show.
pub(crate) fn entries(
    samples: &Samples,
    options: &Options,
    solved: &Solved,
    log: &Log,
) -> Option<(Vec<FittedEffect>, Vec<String>)> {
    let (mut effects, mut not_significant) = (Vec::new(), Vec::new());
    for (at, (id, column)) in options.add.iter().zip(offsets(samples, options)?).enumerate() {
        let (vector, place) = (solved.state.effects.get(at)?.0, effect_at(at));
        let covariance = solved.covariance.fixed_view::<3, 3>(place, place).into_owned();
        let square = vector.dot(&(covariance.try_inverse()? * vector));
        if square < CHI_SQUARE {
            let error_ut = (covariance.trace() * log.effects.get(at)?).sqrt();
            not_significant.push(format!(
                "no evidence for {id}: its vector is zero within the error ({error_ut:.2} µT at the \
                 rms of {})",
                column.name
            ));
        }
        let named = options.registry.parse(id)?;
        let parts =
            Parts { form: named.form, column: named.column, reference: column.reference, parameter: 0.0 };
        let inputs = column.values.iter().map(|value| {
            std::array::from_fn::<f64, MAX_INPUTS, _>(|slot| if slot == 0 { *value } else { 0.0 })
        });
        let mut term = Term::new(Made::new(named.family, parts)?, Arc::new(inputs.collect()));
        term.coefficients[..3].copy_from_slice(vector.as_slice());
        effects.push(describe(&term, (0..3).map(|axis| covariance[(axis, axis)].max(0.0).sqrt()).collect()));
    }
    Some((effects, not_significant))
}
