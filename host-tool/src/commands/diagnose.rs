//! `ironout diagnose`: find the missing effect.

use crate::cli::{DiagnoseArgs, Form};
use crate::diagnosis_words::{self, DiagnosedLog};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Outcome};
use crate::output;
use crate::plausible::Known;
use crate::progress::Working;
use crate::registry::REGISTRY;
use crate::{prior, read_block, refusal, source};
use ironout_analysis::outcome::json;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Diagnosis, Options, Table, diagnose};

/// Diagnoses a log; exit status 1 where the data do not support a calibration.
pub fn run(arguments: &DiagnoseArgs, form: Form) -> Outcome<u8> {
    let expected = arguments.field.expected()?;
    let method = arguments.field.method_with(&arguments.add, arguments.prior.as_ref())?;
    let known = Known::given(expected.field_ut);
    let (log, used) = source::read_held(&arguments.log, arguments.prior.as_deref(), &known, form)?;
    let expected = expected.or_reference(&arguments.log, &log);
    let prior = arguments.prior.as_deref().map(|path| prior::read(path, &log, &used)).transpose()?;
    let options = Options {
        method,
        field_ut: expected.field_ut,
        dip_deg: expected.earth.map(|earth| earth.dip_deg),
        add: arguments.add.clone(),
        force_effect: true,
        search: true,
        prior,
        registry: REGISTRY,
        ..Options::default()
    };
    let working = Working::new("studying");
    let diagnosis =
        diagnose(&Table::from(&log), &options).map_err(|refusal| refusal::failure(refusal, &log.path))?;
    drop(working);
    let diagnosed_log = DiagnosedLog { log: &log, arguments, diagnosis: &diagnosis };
    match form {
        Form::Json => {
            let mut object = json::object(&diagnosis);
            if let Some(fields) = object.as_object_mut() {
                fields.extend(read_block::context(&log));
                fields.insert("report".into(), serde_json::json!(diagnosis_words::report(&diagnosed_log)));
            }
            output::line(&object.to_string());
        }
        Form::Line => output::text(&(diagnosis_words::sentence(&diagnosis) + "\n")),
        Form::Brief => output::text(&diagnosis_words::brief(&diagnosed_log)),
        Form::Full => output::text(&diagnosis_words::text(&diagnosed_log)),
    }
    Ok(status(&diagnosis))
}

fn status(diagnosis: &Diagnosis) -> u8 {
    if diagnosis.verdict == Verdict::Undetermined { EXIT_REFUSED } else { EXIT_OK }
}
