//! What `fit` says to people.

use crate::cli::{Expected, FitArgs};
use crate::diagnosis_words::unlogged;
use crate::input::Log;
use crate::output::number;
use crate::wrap::{hang, wrap};
use ironout::fit::Order;
use ironout_analysis::Fitted;
use ironout_analysis::base::axes::Alignment;
use ironout_analysis::base::counted::Why;
use ironout_analysis::base::solution::Solution;
use ironout_analysis::calibration::FittedEffect;

/// Lines are at most this wide.
const WIDTH: usize = 110;

/// The whole solution.
pub fn text(arguments: &FitArgs, log: &Log, fitted: &Fitted, expected: &Expected) -> String {
    let mut lines = Lines(String::new());
    samples(log, fitted, &mut lines);
    lines.line("");
    if let Some(found) = &fitted.recordings {
        unlogged::recordings(found, WIDTH).iter().for_each(|line| lines.line(line));
        lines.line("");
    }
    if let Some(solution) = &fitted.solution {
        table(solution, expected, &mut lines);
        lines.line("");
        errors(fitted, solution, expected, &mut lines);
        lines.line("");
    }
    verdict(arguments, fitted, &mut lines);
    lines.0
}

/// Lines, each with its end.
struct Lines(String);

impl Lines {
    fn line(&mut self, text: &str) {
        self.0.push_str(text);
        self.0.push('\n');
    }
}

fn samples(log: &Log, fitted: &Fitted, out: &mut Lines) {
    let seconds = log.time_s.as_ref().and_then(|t| Some(t.last()? - t.first()?));
    let over = seconds.map_or(" (no time column)".to_string(), |s| format!(" over {s:.1} s"));
    out.line(&format!("{}: {} rows{over}", log.path.display(), fitted.rows));
    let mut parts = vec![format!("{} sample{} used", fitted.used, if fitted.used == 1 { "" } else { "s" })];
    let mut part = |count: usize, what: &str| {
        if count > 0 {
            parts.push(format!("{count} {what}"));
        }
    };
    part(fitted.repeated, "repeated rows");
    part(fitted.at_rest, "at rest");
    for aside in &fitted.aside {
        let what = match aside.why {
            Why::Clipping { axis } => format!("clipped on {}", ["x", "y", "z"][axis]),
            Why::Burst => "set aside as bursts".to_string(),
            Why::Stuck => "stuck".to_string(),
            Why::Copy => "copies of earlier readings".to_string(),
        };
        part(aside.samples, &what);
    }
    out.line(&parts.join(", "));
}

fn table(solution: &Solution, expected: &Expected, out: &mut Lines) {
    let calibration = &solution.calibration;
    let errors = &solution.std_errors;
    out.line("                     x          y          z");
    let triple = |v: [f64; 3], decimals: usize| v.map(|v| format!("{v:>11.decimals$}")).concat();
    out.line(&format!("offset       {} µT", triple(calibration.offset_ut, 3)));
    out.line(&format!("         ±   {}", triple(errors.offset_ut, 3)));
    for (row, (values, sigma)) in calibration.matrix.iter().zip(&errors.matrix).enumerate() {
        let label = if row == 0 { "matrix" } else { "" };
        out.line(&format!("{label:<13}{}     ±{}", triple(*values, 5), triple(*sigma, 5)));
    }
    let source = match expected {
        Expected { earth: Some(earth), .. } => format!(
            "world magnetic model; dip {:.1}°, declination {:+.1}°",
            earth.dip_deg, earth.declination_deg
        ),
        Expected { field_ut: Some(_), .. } => "as given by --field".to_string(),
        _ => "the log's own mean: give --field or --at to scale to the true one".to_string(),
    };
    out.line(&format!("field        {:11.3} µT  ({source})", calibration.field_ut));
    if solution.model != Order::Ellipsoid {
        out.line(match solution.model {
            Order::Sphere => "model        one gain for all axes: the attitudes do not carry nine parameters",
            _ => {
                "model        a gain an axis, axes at right angles: the attitudes do not carry nine parameters"
            }
        });
    }
    if let Some(prior) = &solution.prior {
        out.line(&format!("prior        {prior}"));
    }
    alignment(&solution.alignment, out);
    effects(&solution.effects, out);
    out.line(if solution.effects.is_empty() {
        "corrected = matrix · (measured − offset)"
    } else {
        "corrected = matrix · (measured − offset − effects)"
    });
}

fn alignment(alignment: &Alignment, out: &mut Lines) {
    match alignment {
        Alignment::None => {}
        Alignment::ByAll => out.line(
            "alignment    the matrix is a full 3×3 in the axes in which the accelerometer shows gravity while level",
        ),
        Alignment::Done { angle_deg, before_deg, after_deg, standing } => {
            out.line(&format!(
                "alignment    the matrix is a full 3×3 in the accelerometer's axes: turned by {angle_deg:.2}°; spread of the dip \
                 {before_deg:.2}° → {after_deg:.2}°"
            ));
            for (row, words) in
                standing.words().iter().flat_map(|words| wrap(words, "", WIDTH - 13)).enumerate()
            {
                out.line(&format!("{:<13}{words}", if row == 0 { "axes" } else { "" }));
            }
        }
        Alignment::Mirrored(_) => out.line("alignment    none: the log's magnetometer axes are mirrored"),
        Alignment::Open(_) => {
            out.line("alignment    none: the log does not tell whether its magnetometer is turned or mirrored")
        }
        Alignment::NoDip { after_deg } => out.line(&format!(
            "alignment    none: the dip against the accelerometer spreads by {after_deg:.0}° at best, so it shows no gravity \
             or stands in other axes"
        )),
    }
}

fn effects(effects: &[FittedEffect], out: &mut Lines) {
    for effect in effects {
        out.line("");
        out.line(&format!("effect       {} ({})", effect.name, effect.id));
        out.line(&format!("             {}", effect.explanation));
        let rows = effect.coefficients.chunks(3).zip(effect.std_errors.chunks(3));
        for (row, (values, errors)) in rows.enumerate() {
            let joined =
                |values: &[f64]| values.iter().map(|v| format!(" {:>10}", short(*v))).collect::<String>();
            let label = if row == 0 { "coefficients" } else { "" };
            out.line(&format!("{label:<13}{}  ±{}  {}", joined(values), joined(errors), effect.unit));
        }
        let mut fixed: Vec<String> = effect
            .reference
            .iter()
            .map(|(column, value)| format!("none at {column} = {}", short(*value)))
            .collect();
        fixed.extend(effect.parameters.iter().map(|(name, value)| format!("{name} = {value:.4}")));
        if !fixed.is_empty() {
            out.line(&format!("             {}", fixed.join(", ")));
        }
    }
    if !effects.is_empty() {
        out.line("");
    }
}

/// Four significant digits.
fn short(value: f64) -> String {
    if value.is_nan() {
        return "-".into();
    }
    let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-4..6).contains(&digits) {
        format!("{value:.*}", (3 - digits).max(0) as usize)
    } else {
        format!("{value:.3e}")
    }
}

fn errors(fitted: &Fitted, solution: &Solution, expected: &Expected, out: &mut Lines) {
    let field = solution.calibration.field_ut;
    let both = |value: Option<f64>| match value {
        Some(value) => format!("{value:9.3} µT  {:6.2} %", value / field * 100.0),
        None => "        -".to_string(),
    };
    if let Some((mean, rms)) = fitted.before {
        out.line(&format!(
            "error before        {rms:9.3} µT  {:6.2} %   of the measured magnitude about its mean",
            rms / mean * 100.0
        ));
    }
    if let Some(base) = &solution.without_effects {
        out.line(&format!(
            "without effects     {}   of the corrected magnitude; on unseen time {} µT",
            both(Some(base.rms_ut)),
            number(base.holdout_rms_ut, 3)
        ));
    }
    out.line(&format!("error after         {}   of the corrected magnitude", both(Some(solution.rms_ut))));
    // The fit for a vehicle has no such figures of its own.
    if fitted.holdout_rms_ut.is_some() {
        out.line(&format!(
            "  on unseen time    {}   each tenth of the log under the fit of the others",
            both(fitted.holdout_rms_ut)
        ));
    }
    if fitted.residual_floor_ut.is_some() {
        out.line(&format!(
            "  floor by noise    {}   what the sensor's noise alone would leave{}",
            both(fitted.residual_floor_ut),
            match (fitted.residual_floor_least_ut, fitted.residual_floor_ut) {
                (Some(least), Some(floor)) if least > 0.0 && floor > UNEXPLAINED * least =>
                    format!(", at most; {least:.3} µT at least"),
                _ => String::new(),
            }
        ));
    }
    if fitted.noise_floor_ut.is_some() {
        out.line(&format!(
            "sensor noise        {:>9} µT            per axis",
            number(fitted.noise_floor_ut, 3)
        ));
    }
    // Where most of it is the rotation, that is not what the verdict is of.
    let rotation = match solution.vector_error_ut() > solution.predicted_error_ut * MOSTLY {
        true => format!(
            "; {} µT without the rotation to the accelerometer",
            number(Some(solution.predicted_error_ut), 3)
        ),
        false => String::new(),
    };
    out.line(&format!(
        "predicted error     {}   1σ of a corrected vector, worst direction{rotation}",
        both(Some(solution.vector_error_ut()))
    ));
    if let Some(own) = fitted.accelerometer {
        let triple = |v: [f64; 3]| v.map(|v| format!("{v:9.3}")).concat();
        out.line(&format!(
            "accelerometer       {:9.3} m/s²          spread of its magnitude; {:.3} m/s² with this calibration, which the fit uses:",
            own.before_mps2, own.after_mps2
        ));
        out.line(&format!("  its offset        {} m/s²", triple(own.offset_mps2)));
        for (row, values) in own.matrix.into_iter().enumerate() {
            out.line(&format!("  {:<18}{}", if row == 0 { "its matrix" } else { "" }, triple(values)));
        }
        out.line("  use it for the heading too: gravity = matrix · (measured − offset)");
    }
    if let Some(beside) = fitted.beside_gyro {
        out.line(&format!(
            "beside the gyro     {}   departure of the field's direction over two seconds, rms per axis",
            both(Some(beside.field * solution.calibration.field_ut))
        ));
    }
    match fitted.heading_error_deg {
        Some(degrees) => out.line(&format!(
            "heading error       {degrees:9.2} °             1σ of a {} at a dip of {}°, {}",
            match &fitted.holds_for {
                Some(holds_for) => format!("heading, tilted by up to {:.0}°,", holds_for.tilt_deg),
                None => "level reading".into(),
            },
            number(fitted.dip_deg, 0),
            if expected.earth.is_some() {
                "of the world magnetic model"
            } else {
                "against the accelerometer"
            }
        )),
        None if matches!(solution.alignment, Alignment::Mirrored(_) | Alignment::Open(_)) => {
            out.line("heading error               -               not before the axes are in order")
        }
        None if matches!(solution.alignment, Alignment::NoDip { .. }) => {
            out.line("heading error               -               needs the dip, which this accelerometer does not show: --at")
        }
        None => {
            out.line("heading error               -               needs the dip: an accelerometer, or --at")
        }
    }
    if let Some(coverage) = fitted.coverage {
        out.line(&format!(
            "coverage            {:9.0} %             of all directions{}; largest gap {}°",
            coverage * 100.0,
            // A fit that is wrong sees the directions wrong.
            if fitted.accepted { "" } else { ", as this refused fit sees them" },
            number(fitted.gap_deg, 0)
        ));
    }
}

/// The rotation is told apart where it makes the predicted error larger by this factor.
const MOSTLY: f64 = 1.5;

/// A dip that spreads by more than this, degrees, ...
const LOOSE_DEG: f64 = 1.0;
/// ... and by so many times what is predicted of a heading, is worth a word.
const LOOSE: f64 = 3.0;
/// An error this many times the floor by noise is worth an explanation.
const UNEXPLAINED: f64 = 1.2;

fn verdict(arguments: &FitArgs, fitted: &Fitted, out: &mut Lines) {
    out.line(&match (&fitted.holds_for, fitted.accepted) {
        (Some(holds_for), true) => format!("ACCEPTED for tilts up to {:.0}°", holds_for.tilt_deg),
        (None, true) => "ACCEPTED".into(),
        (_, false) => "REFUSED".into(),
    });
    for reason in &fitted.reasons {
        hang(reason, "  ", "    ", WIDTH).iter().for_each(|words| out.line(words));
    }
    if fitted.accepted && arguments.output.is_none() {
        out.line("  keep it with -o cal.json");
    }
    let beyond = match (&fitted.solution, fitted.residual_floor_ut) {
        (Some(solution), Some(floor)) if floor > 0.0 => solution.rms_ut / floor,
        _ => 1.0,
    };
    let dip = fitted.solution.as_ref().map(|solution| &solution.alignment);
    if let (Some(Alignment::Done { after_deg, .. }), Some(predicted)) = (dip, fitted.heading_error_deg)
        && *after_deg > LOOSE_DEG
        && *after_deg > LOOSE * predicted
    {
        let words = format!(
            "the dip spreads by {after_deg:.1}°, {:.1} times the heading error that noise makes: a shaken accelerometer does that, and \
             so does a sensor that lags, which ironout diagnose {} tells",
            after_deg / predicted,
            arguments.log.typed()
        );
        hang(&words, "  ", "  ", WIDTH).iter().for_each(|words| out.line(words));
    }
    let least = (fitted.residual_floor_least_ut).filter(|least| *least > 0.0).or(fitted.residual_floor_ut);
    let most = match (&fitted.solution, least) {
        (Some(solution), Some(least)) if least > 0.0 => solution.rms_ut / least,
        _ => beyond,
    };
    if beyond > UNEXPLAINED {
        out.line(&format!(
            "  the error is {beyond:.1} times what noise leaves: something is missing in the model; \
             ironout diagnose {} looks for it",
            arguments.log.typed()
        ));
    } else if most > UNEXPLAINED {
        let words = format!(
            "the error is {most:.1} times what is new from sample to sample: the sensor's noise has a memory, or something is \
             missing in the model; the residual alone does not tell, and ironout diagnose {} holds it against the columns",
            arguments.log.typed()
        );
        hang(&words, "  ", "  ", WIDTH).iter().for_each(|words| out.line(words));
    }
}
