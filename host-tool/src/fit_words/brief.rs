//! The answer of a fit: verdict, the figures that matter, and what to do next.

use crate::cli::{Expected, FitArgs};
use crate::diagnosis_words::unlogged;
use crate::field_unit::{fixed, symbol};
use crate::fit_words::next;
use crate::input::Log;
use crate::output::number;
use crate::report_text::{Layout, lines};
use crate::wrap::WIDTH;
use ironout_analysis::base::axes::Alignment;
use ironout_analysis::base::counted::{Aside, Why};
use ironout_analysis::base::solution::Solution;
use ironout_analysis::fit::fitted::MIN_ERROR_RATIO_TO_DIAGNOSE;
use ironout_analysis::{Fitted, Report};
use std::path::Path;

/// A dip whose spread is larger than this, degrees, and than [`MIN_DIP_SPREAD_RATIO`] times the predicted heading error, is mentioned.
const MIN_DIP_SPREAD_DEG: f64 = 1.0;
const MIN_DIP_SPREAD_RATIO: f64 = 3.0;

/// Codes of a refusal of a vehicle that was not turned over.
const VEHICLE: [&str; 2] = ["vehicle", "too-few-orientations"];

/// The answer.
pub fn report(arguments: &FitArgs, log: &Log, fitted: &Fitted, expected: &Expected) -> Report {
    let mut report =
        Report { verdict: vec![verdict(fitted)], reasons: fitted.reasons.clone(), ..Report::default() };
    figures(log, fitted, expected, &mut report);
    report.remarks = remarks(fitted);
    next_steps(arguments, log, fitted, &mut report);
    report
}

/// The answer, line by line.
pub fn answer(arguments: &FitArgs, log: &Log, fitted: &Fitted, expected: &Expected) -> Vec<String> {
    lines(&report(arguments, log, fitted, expected), Layout { width: WIDTH, label: 16 })
}

/// The answer in one line (`-q`).
pub fn one_line(fitted: &Fitted) -> String {
    let Some(solution) = &fitted.solution else {
        let why = fitted.reasons.first().map_or("no calibration fits", |reason| reason.words.as_str());
        return format!("{}: {why}", verdict(fitted));
    };
    let before = fitted.before.map_or(String::new(), |(_, rms)| format!("{} → ", fixed(Some(rms), 2)));
    let why = match fitted.reasons.first() {
        Some(reason) if !fitted.accepted => format!(": {}", reason.words),
        _ => String::new(),
    };
    format!("{}: error {before}{} {}{why}", verdict(fitted), fixed(Some(solution.rms_ut), 2), symbol())
}

fn verdict(fitted: &Fitted) -> String {
    match (&fitted.holds_for, fitted.accepted) {
        (Some(holds_for), true) => format!("ACCEPTED for tilts up to {:.0}°", holds_for.tilt_deg),
        (None, true) => "ACCEPTED".into(),
        (_, false) => "REFUSED".into(),
    }
}

/// Rows over time, as in `6000 rows over 120.0 s`.
pub fn length(log: &Log, rows: usize) -> String {
    let seconds = log.time_s.as_ref().and_then(|t| Some(t.last()? - t.first()?));
    let over = seconds.map_or(" (no time column)".to_string(), |s| format!(" over {s:.1} s"));
    format!("{rows} row{}{over}", if rows == 1 { "" } else { "s" })
}

fn figures(log: &Log, fitted: &Fitted, expected: &Expected, report: &mut Report) {
    let mut row = |label: &str, text: String| report.figure(label, text);
    let samples: Vec<String> =
        std::iter::once(format!("{} samples used", fitted.used)).chain(set_aside(fitted)).collect();
    row("log", format!("{}: {}, {}", log.path.display(), length(log, fitted.rows), samples.join(", ")));
    if let Some(found) = &fitted.recordings {
        row("recordings", unlogged::recordings_in_short(found));
        row("", "the calibration has the offset of the last recording".into());
    }
    let unit = symbol();
    if let Some(solution) = &fitted.solution {
        let field = solution.calibration.field_ut;
        let percent = |value: f64| format!("{:.2} %", value / field * 100.0);
        let before = fitted.before.map_or(String::new(), |(_, rms)| format!("{} → ", fixed(Some(rms), 2)));
        row(
            "error",
            format!(
                "{before}{} {unit} rms ({} of the field)",
                fixed(Some(solution.rms_ut), 2),
                percent(solution.rms_ut)
            ),
        );
        if let Some(held_out) = fitted.holdout_rms_ut {
            row("held-out error", format!("{} {unit} (10-fold)", fixed(Some(held_out), 2)));
        }
        if let Some(floor) = fitted.residual_floor_ut {
            row("noise floor", format!("{} {unit}", fixed(Some(floor), 2)));
        }
        // The worst direction lies outside the tilts that a vehicle's calibration is for.
        if fitted.holds_for.is_none() {
            row(
                "predicted error",
                format!(
                    "{} {unit} ({}; 1σ of a corrected vector, worst direction)",
                    fixed(Some(solution.vector_error_ut()), 2),
                    percent(solution.vector_error_ut())
                ),
            );
        }
        if let Some(degrees) = fitted.heading_error_deg {
            row("heading error", format!("{degrees:.2}° (1σ, {})", posture(fitted)));
        }
        let source = match expected {
            Expected { earth: Some(_), .. } => "World Magnetic Model",
            Expected { field_ut: Some(_), .. } => "as given by --field",
            _ => "mean of the log; use --field or --at for the true value",
        };
        row("field strength", format!("{} {unit} ({source})", fixed(Some(field), 2)));
        if fitted.accepted {
            let [x, y, z] = solution.calibration.offset_ut.map(|axis| fixed(Some(axis), 2));
            row("offset", format!("x {x}, y {y}, z {z} {unit}"));
            for (place, [x, y, z]) in solution.calibration.matrix.iter().enumerate() {
                row(if place == 0 { "matrix" } else { "" }, format!("{x:9.5} {y:9.5} {z:9.5}"));
            }
        }
        for effect in &solution.effects {
            row("effect", format!("{} ({})", effect.name, effect.id));
        }
    }
    if let Some(coverage) = fitted.coverage {
        let gap = number(fitted.gap_deg, 0);
        row("coverage", format!("{:.0} % of directions (largest gap {gap}°)", coverage * 100.0));
    }
}

/// What was set aside, and why.
pub fn set_aside(fitted: &Fitted) -> Vec<String> {
    let what = |aside: &Aside| match aside.why {
        Why::Clipping { axis } => format!("{} clipped on {}", aside.samples, ["x", "y", "z"][axis]),
        Why::Burst => format!("{} set aside as bursts", aside.samples),
        Why::Stuck => format!("{} stuck", aside.samples),
        Why::Copy => format!("{} copies of earlier readings", aside.samples),
    };
    fitted.aside.iter().filter(|aside| aside.samples > 0).map(what).collect()
}

/// The orientations that a heading error is for.
pub fn posture(fitted: &Fitted) -> String {
    let tilt = fitted.holds_for.as_ref();
    let tilt = tilt.map_or("level".into(), |holds_for| format!("tilted by up to {:.0}°", holds_for.tilt_deg));
    format!("{tilt}, dip {}°", number(fitted.dip_deg, 0))
}

/// How many times the noise floor the error is: of the largest floor that the noise can have, and of the least.
fn error_ratios(fitted: &Fitted) -> (f64, f64) {
    let ratio = |solution: &Solution, floor: Option<f64>| match floor.filter(|floor| *floor > 0.0) {
        Some(floor) => solution.rms_ut / floor,
        None => 1.0,
    };
    let Some(solution) = &fitted.solution else { return (1.0, 1.0) };
    let least = fitted.residual_floor_least_ut.filter(|least| *least > 0.0).or(fitted.residual_floor_ut);
    (ratio(solution, fitted.residual_floor_ut), ratio(solution, least))
}

fn remarks(fitted: &Fitted) -> Vec<String> {
    let mut list = Vec::new();
    let (ratio, most) = error_ratios(fitted);
    if ratio > MIN_ERROR_RATIO_TO_DIAGNOSE {
        list.push(format!(
            "The remaining error is {ratio:.1} × the noise floor, so the model lacks a cause of error."
        ));
    } else if most > MIN_ERROR_RATIO_TO_DIAGNOSE {
        list.push(format!(
            "The remaining error is {most:.1} × the noise estimated from the differences of consecutive samples. Either the sensor noise is correlated, or the \
             model lacks a cause of error."
        ));
    }
    let alignment = fitted.solution.as_ref().map(|solution| &solution.alignment);
    if let (Some(Alignment::Done { after_deg, .. }), Some(predicted)) = (alignment, fitted.heading_error_deg)
        && *after_deg > MIN_DIP_SPREAD_DEG
        && *after_deg > MIN_DIP_SPREAD_RATIO * predicted
    {
        list.push(format!(
            "The dip varies by {after_deg:.1}° rms, {:.1} × the heading error that noise explains. Possible causes: a shaken \
             accelerometer, or a delayed magnetometer.",
            after_deg / predicted
        ));
    }
    list
}

fn next_steps(arguments: &FitArgs, log: &Log, fitted: &Fitted, report: &mut Report) {
    let mut step = |what: &str, command: String| {
        report.say(format!("{what}:"));
        report.command(command);
    };
    let loose = fitted.solution.as_ref().is_some_and(|solution| {
        matches!((&solution.alignment, fitted.heading_error_deg), (Alignment::Done { after_deg, .. }, Some(predicted))
            if *after_deg > MIN_DIP_SPREAD_DEG && *after_deg > MIN_DIP_SPREAD_RATIO * predicted)
    });
    let unexplained = error_ratios(fitted).1 > MIN_ERROR_RATIO_TO_DIAGNOSE || loose;
    let is_vehicle = fitted.reasons.first().is_some_and(|reason| VEHICLE.contains(&reason.code));
    if !fitted.accepted && is_vehicle && arguments.prior.is_none() && arguments.prior_from.is_none() {
        let fit = next::fit(arguments);
        step(
            "Keep the matrix of a calibration made on the bench",
            fit.clone() + " --prior bench.json --free offset",
        );
        if !log.frame.removed.is_empty() {
            step("Or start from the autopilot's own calibration", fit + " --prior-from parameters");
        }
    }
    if !fitted.accepted {
        step("Find the cause", next::diagnose(arguments));
    } else if unexplained {
        step("Find the cause of the remaining error", next::diagnose(arguments));
    }
    if fitted.accepted {
        match &arguments.output {
            Some(path) if path != Path::new("-") => {
                step("Check the calibration on a second log", next::check(arguments, path));
            }
            Some(_) => {}
            None => step("Keep the calibration", next::fit(arguments) + " -o cal.json"),
        }
    }
    if let Some(text) = next::must_be_saved(arguments) {
        report.say(text);
    }
}
