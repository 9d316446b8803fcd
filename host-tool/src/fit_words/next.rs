//! The commands to run after a fit, exactly as they can be typed.

use crate::cli::FitArgs;
use crate::cli::Free;
use crate::log_args::SAVED;
use crate::shell::typed_option;
use ironout_analysis::outcome::request::Purpose;
use std::path::Path;

/// `ironout fit LOG …` as it was typed, without `-o`.
pub fn fit(arguments: &FitArgs) -> String {
    let mut words = format!("ironout fit {}", arguments.log.typed());
    words += &arguments.field.typed(!arguments.add.is_empty());
    if let Some(prior) = &arguments.prior {
        words += &typed_option("--prior", &prior.display().to_string());
    }
    if let Some(from) = &arguments.prior_from {
        words += &typed_option("--prior-from", &from.display().to_string());
    }
    if let Some(Free::Offset) = arguments.free {
        words += " --free offset";
    }
    for known in &arguments.headings {
        words += &format!(" --heading {}={}", known.time_s, known.heading_deg);
    }
    match arguments.purpose {
        Some(Purpose::All) => words += " --for all",
        Some(Purpose::Tilt(tilt)) => words += &format!(" --for {tilt}"),
        _ => {}
    }
    words += &arguments.add.iter().map(|id| typed_option("--add", id)).collect::<String>();
    if arguments.force_effect {
        words += " --force-effect";
    }
    words
}

/// `ironout diagnose LOG …`.
pub fn diagnose(arguments: &FitArgs) -> String {
    let mut words = format!("ironout diagnose {}", arguments.log.typed());
    words += &arguments.field.typed(!arguments.add.is_empty());
    if let Some(prior) = &arguments.prior {
        words += &typed_option("--prior", &prior.display().to_string());
    }
    words + &arguments.add.iter().map(|id| typed_option("--add", id)).collect::<String>()
}

/// `ironout check second.csv … --cal CAL.json`.
pub fn check(arguments: &FitArgs, cal: &Path) -> String {
    format!(
        "ironout check {}{}",
        arguments.log.typed_for("second.csv"),
        typed_option("--cal", &cal.display().to_string())
    )
}

/// Whether the log came from standard input, and has to be saved for the next command.
pub fn must_be_saved(arguments: &FitArgs) -> Option<String> {
    let piped = arguments.log.logs().any(|log| log == Path::new("-"));
    piped.then(|| format!("The log came from standard input. Save it as {SAVED} first."))
}
