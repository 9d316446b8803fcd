//! `ironout fit`: calibrate from a log.

use super::later;
use crate::cli::{FitArgs, MethodArg};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::pipeline::{self, Options};
use crate::{atomic, output};
use ironout::fit::Method;

/// Fits, reports, and keeps an accepted calibration.
pub fn run(arguments: &FitArgs, json: bool) -> Outcome<u8> {
    if !arguments.add.is_empty() {
        return Err(later::option("--add"));
    }
    if arguments.prior.is_some() {
        return Err(later::option("--prior"));
    }
    let expected = arguments.field.expected()?;
    let log = arguments.log.read()?;
    let method = method(arguments.field.method);
    let fitted = pipeline::run(&log, &Options { method, expected });
    if json {
        let object = serde_json::to_string(&fitted.object(method.name()))
            .map_err(|error| Failure::usage(error.to_string()))?;
        output::line(&object);
    } else {
        super::fit_words::print(&log, &fitted, &expected);
    }
    if let Some(path) = &arguments.output {
        if fitted.accepted {
            let text = serde_json::to_string_pretty(&fitted.cal_file(method.name()))
                .map_err(|error| Failure::usage(error.to_string()))?;
            atomic::write(path, |out| writeln!(out, "{text}"))?;
            eprintln!("wrote {}", path.display());
        } else if path.exists() {
            eprintln!("refused: {} is left as it was", path.display());
        } else {
            eprintln!("refused: {} is not written", path.display());
        }
    }
    Ok(if fitted.accepted { EXIT_OK } else { EXIT_REFUSED })
}

/// The core's method for the option.
pub fn method(argument: MethodArg) -> Method {
    match argument {
        MethodArg::Adjusted => Method::Adjusted,
        MethodArg::Trace => Method::Trace,
        MethodArg::Constant => Method::Constant,
    }
}
