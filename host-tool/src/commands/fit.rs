//! `ironout fit`: calibrate from a log.

use crate::cal_file::{CalFile, FitObject};
use crate::cli::{FitArgs, Form, Free};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::plausible::Known;
use crate::progress::Working;
use crate::reading::Reading;
use crate::registry::REGISTRY;
use crate::{atomic, fit_words, headings, output, prior, read_block, refusal, source};
use ironout_analysis::reason::codes;
use ironout_analysis::{Options, Report, Table, fit};

/// The object of `--json`: the fit, and how the log was read.
#[derive(serde::Serialize)]
struct Said {
    #[serde(flatten)]
    fit: FitObject,
    reason_codes: Vec<&'static str>,
    report: Report,
    #[serde(flatten)]
    context: serde_json::Map<String, serde_json::Value>,
}

/// Fits, reports, and keeps an accepted calibration.
pub fn run(arguments: &FitArgs, form: Form) -> Outcome<u8> {
    let json = form == Form::Json;
    let expected = arguments.field.expected()?;
    let earlier = arguments.prior.as_ref().or(arguments.prior_from.as_ref());
    let method = arguments.field.method_with(&arguments.add, earlier)?;
    if let Some(path) = &arguments.output {
        output::leave_to(Some(path), json)?;
        arguments.log.logs().try_for_each(|log| atomic::not_over(log, path))?;
    }
    let known = Known::given(expected.field_ut);
    let (mut log, used) = source::read_held(&arguments.log, arguments.prior.as_deref(), &known, form)?;
    headings::guide(&mut log, &arguments.headings)?;
    let expected = expected.or_reference(&arguments.log, &log);
    let mut options = Options {
        method,
        field_ut: expected.field_ut,
        dip_deg: expected.earth.map(|earth| earth.dip_deg),
        add: arguments.add.clone(),
        force_effect: arguments.force_effect,
        search: false,
        purpose: arguments.purpose.unwrap_or_default(),
        registry: REGISTRY,
        ..Options::default()
    };
    let prior = match (&arguments.prior, &arguments.prior_from) {
        (Some(path), _) => Some(prior::read(path, &log, &used)?),
        (None, Some(from)) => Some(prior::from(from, &log, &used, &options, json)?),
        (None, None) => None,
    };
    options.prior = match arguments.free {
        Some(Free::Offset) => prior.map(|prior| prior.without_offset()),
        None => prior,
    };
    let working = Working::new("fitting");
    let fitted = fit(&Table::from(&log), &options).map_err(|refusal| refusal::failure(refusal, &log.path))?;
    drop(working);
    let to_text = |error: serde_json::Error| Failure::usage(error.to_string());
    // Written before anything is printed: a file that cannot be written is an error, and the only answer.
    let mut written = None;
    if let Some(path) = &arguments.output {
        written = Some(if fitted.accepted {
            let text = {
                let mut cal = CalFile::of(&fitted, method.name());
                cal.reading = Some(Reading::of(&log, &used, &cal.read_columns())?);
                serde_json::to_string_pretty(&cal).map_err(to_text)?
            };
            atomic::write(path, |out| writeln!(out, "{text}"))?;
            if output::is_standard(path) { String::new() } else { format!("wrote {}", path.display()) }
        } else if path.exists() {
            format!("refused: {} is unchanged", path.display())
        } else {
            format!("refused: {} is not written", path.display())
        });
    }
    match form {
        Form::Json => {
            let object = Said {
                fit: FitObject::of(&fitted, method.name()),
                reason_codes: codes(&fitted.reasons),
                report: fit_words::report(arguments, &log, &fitted, &expected),
                context: read_block::context(&log),
            };
            output::line(&serde_json::to_string(&object).map_err(to_text)?);
        }
        Form::Line => output::text(&(fit_words::one_line(&fitted) + "\n")),
        Form::Brief => output::text(&fit_words::brief(arguments, &log, &fitted, &expected)),
        Form::Full => output::text(&fit_words::text(arguments, &log, &fitted, &expected)),
    }
    if let Some(text) = written.filter(|text| !text.is_empty() && form != Form::Line) {
        eprintln!("{text}");
    }
    Ok(if fitted.accepted { EXIT_OK } else { EXIT_REFUSED })
}
