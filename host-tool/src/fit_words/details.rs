//! Every figure of a fit: samples, matrix with standard errors, alignment, effects, errors.

use crate::cli::Expected;
use crate::diagnosis_words::unlogged;
use crate::field_unit::{derived, fixed, symbol};
use crate::fit_words::brief::{length, posture, set_aside};
use crate::input::Log;
use crate::output::number;
use crate::wrap::{WIDTH, wrap};
use ironout::fit::Order;
use ironout_analysis::Fitted;
use ironout_analysis::base::axes::Alignment;
use ironout_analysis::base::solution::Solution;
use ironout_analysis::calibration::FittedEffect;
use ironout_analysis::fit::fitted::MIN_ERROR_RATIO_TO_DIAGNOSE;
use nalgebra::Matrix3;

/// The details, line by line.
pub fn details(log: &Log, fitted: &Fitted, expected: &Expected) -> Vec<String> {
    let mut lines = Lines(Vec::new());
    samples(log, fitted, &mut lines);
    if let Some(found) = &fitted.recordings {
        unlogged::recordings(found, WIDTH).iter().for_each(|line| lines.line(line));
    }
    if let Some(solution) = &fitted.solution {
        lines.line("");
        table(solution, expected, &mut lines);
        lines.line("");
        errors(fitted, solution, expected, &mut lines);
        if log.earth.is_some() {
            tolles_lawson(solution, &mut lines);
        }
    }
    lines.0
}

/// The model as the terms of Tolles and Lawson, where the field of each row is known and eddy currents are in the model:
/// `m = p + (1 + I) h + E dh/dt` with h up to a rotation, which the magnitude does not show.
fn tolles_lawson(solution: &Solution, out: &mut Lines) {
    let of_eddies = |effect: &&FittedEffect| effect.id == "lag" && effect.coefficients.len() == 9;
    let Some(eddy) = solution.effects.iter().find(of_eddies) else { return };
    let calibration = &solution.calibration;
    let matrix = Matrix3::from_fn(|i, j| calibration.matrix[i][j]);
    let Some(answer) = matrix.try_inverse() else { return };
    // The symmetric root of A·Aᵀ: what of A is no rotation of the field.
    let parts = (answer * answer.transpose()).symmetric_eigen();
    let root = Matrix3::from_diagonal(&parts.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let induced = parts.eigenvectors * root * parts.eigenvectors.transpose();
    let coupled = -Matrix3::from_row_slice(&eddy.coefficients) * induced;
    out.line("");
    out.line("Tolles–Lawson terms: m = p + (1 + I) h + E dh/dt, h in axes in which I is symmetric");
    let [x, y, z] = calibration.offset_ut.map(|value| fixed(Some(value), 3));
    out.line(&format!("permanent p   {x}  {y}  {z} {}", symbol()));
    let mut rows = |label: &str, matrix: &Matrix3<f64>, unit: &str| {
        for (row, values) in matrix.row_iter().enumerate() {
            let label = if row == 0 { label } else { "" };
            let unit = if row == 0 { unit } else { "" };
            out.line(
                format!("{label:<12}{:>11.5}{:>11.5}{:>11.5} {unit}", values[0], values[1], values[2])
                    .trim_end(),
            );
        }
    };
    rows("induced I", &(induced - Matrix3::identity()), "");
    rows("eddy E", &coupled, "s");
    out.line("A sensor delay adds a multiple of the identity to E. It does not change the magnitude, so E does not include it.");
}

struct Lines(Vec<String>);

impl Lines {
    fn line(&mut self, text: &str) {
        self.0.push(text.to_string());
    }
}

fn samples(log: &Log, fitted: &Fitted, out: &mut Lines) {
    out.line(&format!("{}: {}", log.path.display(), length(log, fitted.rows)));
    let mut parts = vec![format!("{} sample{} used", fitted.used, if fitted.used == 1 { "" } else { "s" })];
    let mut part = |count: usize, what: &str| {
        if count > 0 {
            parts.push(format!("{count} {what}"));
        }
    };
    part(fitted.repeated, if fitted.repeated == 1 { "repeated row" } else { "repeated rows" });
    part(fitted.at_rest, "at rest");
    parts.extend(set_aside(fitted));
    out.line(&parts.join(", "));
}

fn table(solution: &Solution, expected: &Expected, out: &mut Lines) {
    let calibration = &solution.calibration;
    let errors = &solution.std_errors;
    out.line("                     x          y          z");
    let triple = |v: [f64; 3], decimals: usize| v.map(|v| format!("{v:>11.decimals$}")).concat();
    let fields = |v: [f64; 3]| v.map(|v| format!("{:>11}", fixed(Some(v), 3))).concat();
    out.line(&format!("offset       {} {}", fields(calibration.offset_ut), symbol()));
    out.line(&format!("         ±   {}", fields(errors.offset_ut)));
    for (row, (values, sigma)) in calibration.matrix.iter().zip(&errors.matrix).enumerate() {
        let label = if row == 0 { "matrix" } else { "" };
        out.line(&format!("{label:<13}{}     ±{}", triple(*values, 5), triple(*sigma, 5)));
    }
    let source = match expected {
        Expected { earth: Some(earth), .. } => format!(
            "World Magnetic Model; dip {:.1}°, declination {:+.1}°",
            earth.dip_deg, earth.declination_deg
        ),
        Expected { field_ut: Some(_), .. } => "as given by --field".to_string(),
        _ => "mean of the log; use --field or --at for the true value".to_string(),
    };
    out.line(&format!("field        {:>11} {}  ({source})", fixed(Some(calibration.field_ut), 3), symbol()));
    if solution.model != Order::Ellipsoid {
        out.line(match solution.model {
            Order::Sphere => "model        one gain for all axes (too few orientations for the full matrix)",
            _ => "model        offset and one gain per axis (too few orientations for the full matrix)",
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
            "alignment    full 3×3 matrix, in the axes in which the accelerometer measures gravity while level",
        ),
        Alignment::Done { angle_deg, before_deg, after_deg, order_status } => {
            out.line(&format!(
                "alignment    full 3×3 matrix, in the accelerometer's axes (rotation {angle_deg:.2}°; dip spread {before_deg:.2}° → \
                 {after_deg:.2}° rms)"
            ));
            for (row, words) in
                order_status.words().iter().flat_map(|words| wrap(words, "", WIDTH - 13)).enumerate()
            {
                out.line(&format!("{:<13}{words}", if row == 0 { "axes" } else { "" }));
            }
        }
        Alignment::Mirrored(_) => out.line("alignment    none: the magnetometer axes of the log are mirrored"),
        Alignment::Open(_) => {
            out.line("alignment    none: this log cannot show whether the magnetometer is rotated or mirrored")
        }
        Alignment::NoDip { after_deg } => out.line(&format!(
            "alignment    none: the dip against the accelerometer varies by {after_deg:.0}° rms at best, so the accelerometer \
             does not measure gravity or uses other axes"
        )),
    }
}

fn effects(effects: &[FittedEffect], out: &mut Lines) {
    for effect in effects {
        out.line("");
        out.line(&format!("effect       {} ({})", effect.name, effect.id));
        wrap(&effect.explanation, "             ", WIDTH).iter().for_each(|line| out.line(line));
        let (factor, unit) = derived(&effect.unit);
        let rows = effect.coefficients.chunks(3).zip(effect.std_errors.chunks(3));
        for (row, (values, errors)) in rows.enumerate() {
            let joined = |values: &[f64]| {
                values.iter().map(|v| format!(" {:>10}", short(*v * factor))).collect::<String>()
            };
            let label = if row == 0 { "coefficients" } else { "" };
            out.line(&format!("{label:<13}{}  ±{}  {}", joined(values), joined(errors), unit));
        }
        let mut fixed: Vec<String> = effect
            .reference
            .iter()
            .map(|(column, value)| format!("zero at {column} = {}", short(*value)))
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
    let unit = symbol();
    let both = |value: Option<f64>| match value {
        Some(value) => format!("{:>9} {unit}  {:6.2} %", fixed(Some(value), 3), value / field * 100.0),
        None => "        -".to_string(),
    };
    if let Some((mean, rms)) = fitted.before {
        out.line(&format!(
            "error before        {:>9} {unit}  {:6.2} %   measured magnitude, rms about its mean",
            fixed(Some(rms), 3),
            rms / mean * 100.0
        ));
    }
    if let Some(base) = &solution.without_effects {
        out.line(&format!(
            "without effects     {}   corrected magnitude; held out {} {unit}",
            both(Some(base.rms_ut)),
            fixed(base.holdout_rms_ut, 3)
        ));
    }
    out.line(&format!("error after         {}   corrected magnitude, rms", both(Some(solution.rms_ut))));
    // The fit for a vehicle has no such figures of its own.
    if fitted.holdout_rms_ut.is_some() {
        out.line(&format!("  held out          {}   10-fold cross-validation", both(fitted.holdout_rms_ut)));
    }
    if fitted.residual_floor_ut.is_some() {
        out.line(&format!(
            "  noise floor       {}   expected if only sensor noise remains{}",
            both(fitted.residual_floor_ut),
            match (fitted.residual_floor_least_ut, fitted.residual_floor_ut) {
                (Some(least), Some(floor)) if least > 0.0 && floor > MIN_ERROR_RATIO_TO_DIAGNOSE * least =>
                    format!(" (upper limit; lower limit {} {unit})", fixed(Some(least), 3)),
                _ => String::new(),
            }
        ));
    }
    if fitted.noise_floor_ut.is_some() {
        out.line(&format!(
            "sensor noise        {:>9} {unit}            per axis",
            fixed(fitted.noise_floor_ut, 3)
        ));
    }
    // The verdict is about the error without the rotation.
    let rotation = match solution.vector_error_ut() > solution.predicted_error_ut * MIN_ROTATION_RATIO {
        true => format!(
            "; {} {unit} without the rotation to the accelerometer",
            fixed(Some(solution.predicted_error_ut), 3)
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
            "accelerometer       {:9.3} m/s²          spread of its magnitude; {:.3} m/s² with this accelerometer calibration, which the fit uses:",
            own.before_mps2, own.after_mps2
        ));
        out.line(&format!("  its offset        {} m/s²", triple(own.offset_mps2)));
        for (row, values) in own.matrix.into_iter().enumerate() {
            out.line(&format!("  {:<18}{}", if row == 0 { "its matrix" } else { "" }, triple(values)));
        }
        out.line("  Use it for the heading too: gravity = matrix · (measured − offset)");
    }
    if let Some(beside) = fitted.beside_gyro {
        out.line(&format!(
            "against the gyro    {}   change of field direction over 2 s minus the gyro's, rms per axis",
            both(Some(beside.field * solution.calibration.field_ut))
        ));
    }
    match fitted.heading_error_deg {
        Some(degrees) => out.line(&format!(
            "heading error       {degrees:9.2} °             1σ, {}, {}",
            posture(fitted),
            if expected.earth.is_some() { "dip from the World Magnetic Model" } else { "dip from the accelerometer" }
        )),
        None if matches!(solution.alignment, Alignment::Mirrored(_) | Alignment::Open(_)) => {
            out.line("heading error               -               unknown until the axis order is corrected")
        }
        None if matches!(solution.alignment, Alignment::NoDip { .. }) => {
            out.line("heading error               -               unknown: this accelerometer does not give the dip; use --at")
        }
        None => {
            out.line("heading error               -               unknown: needs an accelerometer or --at")
        }
    }
    if let Some(coverage) = fitted.coverage {
        out.line(&format!(
            "coverage            {:9.0} %             of directions; largest gap {}°",
            coverage * 100.0,
            number(fitted.gap_deg, 0)
        ));
    }
}

/// The predicted error without the rotation is printed if the rotation makes it larger by this factor.
const MIN_ROTATION_RATIO: f64 = 1.5;
