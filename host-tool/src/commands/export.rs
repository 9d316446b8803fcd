//! `ironout export`: a calibration as Rust, C or JSON.

use crate::cal_file::CalFile;
use crate::cli::{ExportArgs, ExportForm};
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::{atomic, output};
use ironout::calibration::Calibration;
use std::fmt::Write as _;

/// Writes the calibration in the form asked for.
pub fn run(arguments: &ExportArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    let text = text(&cal, arguments.form).map_err(|failure| failure.in_file(&arguments.cal))?;
    match &arguments.output {
        Some(path) => {
            atomic::not_over(&arguments.cal, path)?;
            atomic::write(path, |out| out.write_all(text.as_bytes()))?;
            if !json {
                output::line(&format!("wrote {}", path.display()));
            }
        }
        None if !json => output::line(text.trim_end()),
        None => {}
    }
    if json {
        let form = match arguments.form {
            ExportForm::Rust => "rust",
            ExportForm::C => "c",
            ExportForm::Json => "json",
        };
        output::line(
            &serde_json::json!({
                "as": form, "output": arguments.output.as_ref().map(|path| path.display().to_string()), "text": text,
            })
            .to_string(),
        );
    }
    Ok(EXIT_OK)
}

/// The exported text.
pub fn text(cal: &CalFile, form: ExportForm) -> Outcome<String> {
    match form {
        ExportForm::Json => serde_json::to_string_pretty(cal)
            .map(|text| text + "\n")
            .map_err(|error| Failure::usage(error.to_string())),
        ExportForm::Rust => Ok(rust(&plain(cal)?, &summary(cal))),
        ExportForm::C => Ok(c(&plain(cal)?, &summary(cal))),
    }
}

fn summary(cal: &CalFile) -> String {
    let rms = cal.fit.rms_ut.map_or(String::new(), |rms| format!(", residual rms {rms:.3} µT"));
    format!("{} samples, method {}{rms}", cal.fit.samples_used, cal.fit.method)
}

fn rust(calibration: &Calibration<f64>, summary: &str) -> String {
    let mut text = format!(
        "// Written by `ironout export --as rust`: {summary}.\n\
         // corrected = matrix · (measured − offset), microtesla: `CALIBRATION.apply(measured_ut)`.\n\n\
         use ironout::calibration::Calibration;\n\n"
    );
    let constants = [
        ("CALIBRATION", "f32", "In single precision, for the board."),
        ("CALIBRATION_F64", "f64", "To the last bit, for the host."),
    ];
    for (name, scalar, what) in constants {
        // The shortest decimals that read back to the same bits.
        let value = |v: f64| if scalar == "f32" { format!("{:?}", v as f32) } else { format!("{v:?}") };
        let triple = |v: [f64; 3]| format!("[{}, {}, {}]", value(v[0]), value(v[1]), value(v[2]));
        let [a, b, c] = calibration.matrix.map(triple);
        let _ = write!(
            text,
            "/// {what}\n#[allow(dead_code)]\npub const {name}: Calibration<{scalar}> = Calibration {{\n    offset_ut: \
             {},\n    matrix: [\n        {a},\n        {b},\n        {c},\n    ],\n    field_ut: {},\n}};\n",
            triple(calibration.offset_ut),
            value(calibration.field_ut)
        );
    }
    text
}

fn c(calibration: &Calibration<f64>, summary: &str) -> String {
    let value = |v: f64| format!("{:?}f", v as f32);
    let triple = |v: [f64; 3]| format!("{{{}, {}, {}}}", value(v[0]), value(v[1]), value(v[2]));
    let [a, b, c] = calibration.matrix.map(triple);
    format!(
        "/* Written by `ironout export --as c`: {summary}.\n   corrected = matrix * (measured - offset), microtesla. */\n\
         #ifndef IRONOUT_CALIBRATION_H\n#define IRONOUT_CALIBRATION_H\n\n\
         /* The magnitude that corrected vectors have, microtesla. */\n#define IRONOUT_FIELD_UT {field}\n\n\
         /* Hard iron and zero offset, microtesla. */\nstatic const float ironout_offset_ut[3] = {offset};\n\n\
         /* Undoes soft iron, gains and non-orthogonality. */\nstatic const float ironout_matrix[3][3] = {{\n    \
         {a},\n    {b},\n    {c}\n}};\n\n\
         /* Corrects one measured vector; both in microtesla, and they may be the same array. */\n\
         static inline void ironout_apply(const float measured_ut[3], float corrected_ut[3])\n{{\n    \
         const float x = measured_ut[0] - ironout_offset_ut[0];\n    \
         const float y = measured_ut[1] - ironout_offset_ut[1];\n    \
         const float z = measured_ut[2] - ironout_offset_ut[2];\n    int i;\n\n    \
         for (i = 0; i < 3; i++) {{\n        \
         corrected_ut[i] = ironout_matrix[i][0] * x + ironout_matrix[i][1] * y + ironout_matrix[i][2] * z;\n    \
         }}\n}}\n\n#endif /* IRONOUT_CALIBRATION_H */\n",
        field = value(calibration.field_ut),
        offset = triple(calibration.offset_ut),
    )
    .replace('µ', "u")
    .replace('·', "*")
    .replace('−', "-")
}

fn plain(cal: &CalFile) -> Outcome<Calibration<f64>> {
    match cal.fit.effects.first() {
        None => cal.calibration(),
        Some(effect) => Err(Failure::usage(format!("the effect {} is exported as json only", effect.id))),
    }
}
