//! From a log to a judged calibration: the base model that `diagnose` begins with too ([`crate::ground`]), coverage, and the
//! core's verdict. With effects (`--add`) or on top of an earlier calibration (`--prior`) the study fits the same samples.

mod extended;
mod result;

pub use extended::known as known_effects;
pub use result::{Fitted, spread_of_magnitude};

use crate::cli::Expected;
use crate::diagnose::Table;
use crate::failure::Outcome;
use crate::ground::{Ground, with_room};
use crate::input::Log;
use crate::prior::Prior;
use ironout::fit::Method;

/// What to fit and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The method.
    pub method: Method,
    /// What is known of the field.
    pub expected: Expected,
    /// Ids of the effects in the model.
    pub add: Vec<String>,
    /// An earlier calibration to build on.
    pub prior: Option<Prior>,
}

impl Options {
    /// The field to scale to: as expected, or else that of the earlier calibration.
    fn field_ut(&self) -> Option<f64> {
        self.expected.field_ut.or_else(|| self.prior.as_ref().map(Prior::field_ut))
    }
}

/// Fits a log. The fit may be refused; the counts of what was used and set aside are there all the same.
///
/// # Errors
/// Only where `options` ask for an effect that is not known or that this log does not allow.
pub fn run(log: &Log, options: &Options) -> Outcome<Fitted> {
    extended::check_ids(log, &options.add)?;
    let table = Table::from(log);
    with_room(|| {
        let ground = Ground::of(&table, options.method, options.field_ut());
        let fitted = Fitted::new(&ground.counted, options);
        if options.add.is_empty() && options.prior.is_none() {
            return Ok(fitted.of_base(&ground));
        }
        extended::run(log, &ground, options, fitted)
    })
}
