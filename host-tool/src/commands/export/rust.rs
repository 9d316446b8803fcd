//! A calibration as Rust constants for the crate.

use ironout::calibration::Calibration;
use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Gain, Lag, Nonlinearity, Offset, Periodic,
    Step,
};
use ironout::extended::{ExtendedCalibration, FittedEffect, MAX_EFFECTS};
use std::fmt::Write as _;

const CONSTANTS: [(&str, &str, &str); 2] = [
    ("CALIBRATION", "f32", "In single precision, for the board."),
    ("CALIBRATION_F64", "f64", "To the last bit, for the host."),
];

/// The shortest decimals that read back to the same bits.
fn value(scalar: &str, v: f64) -> String {
    if v.is_nan() {
        return format!("{scalar}::NAN");
    }
    if scalar == "f32" { format!("{:?}", v as f32) } else { format!("{v:?}") }
}

fn list(scalar: &str, values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(|v| value(scalar, *v)).collect();
    format!("[{}]", words.join(", "))
}

/// The file.
pub fn text(calibration: &ExtendedCalibration, summary: &str) -> String {
    if calibration.effects.is_empty() {
        plain(&calibration.base, summary)
    } else {
        extended(calibration, summary)
    }
}

fn base(calibration: &Calibration<f64>, scalar: &str, indent: &str) -> String {
    let [a, b, c] = calibration.matrix.map(|row| list(scalar, &row));
    format!(
        "Calibration {{\n{indent}    offset_ut: {},\n{indent}    matrix: [\n{indent}        {a},\n{indent}        {b},\n\
         {indent}        {c},\n{indent}    ],\n{indent}    field_ut: {},\n{indent}}}",
        list(scalar, &calibration.offset_ut),
        value(scalar, calibration.field_ut)
    )
}

fn plain(calibration: &Calibration<f64>, summary: &str) -> String {
    let mut text = format!(
        "// Written by `ironout export --as rust`: {summary}.\n\
         // corrected = matrix · (measured − offset), microtesla: `CALIBRATION.apply(measured_ut)`.\n\n\
         use ironout::calibration::Calibration;\n\n"
    );
    for (name, scalar, what) in CONSTANTS {
        let base = base(calibration, scalar, "");
        let _ = writeln!(
            text,
            "/// {what}\n#[allow(dead_code)]\npub const {name}: Calibration<{scalar}> = {base};"
        );
    }
    text
}

fn extended(calibration: &ExtendedCalibration, summary: &str) -> String {
    let columns: Vec<ColumnName> = columns(calibration);
    let constant = |name: &ColumnName| {
        let place = columns.iter().position(|known| known == name).unwrap_or_default();
        format!("COLUMN_{place}")
    };
    let used: Vec<&str> = calibration
        .effects
        .iter()
        .map(|fitted| match fitted.effect {
            BuiltIn::Offset(_) => "Offset, Power",
            BuiltIn::Gain(_) => "Gain",
            BuiltIn::Field(_) => "AmbientField",
            BuiltIn::Drift(_) => "Drift",
            BuiltIn::Step(_) => "Step",
            BuiltIn::Lag(_) => "Lag",
            BuiltIn::Eddy(_) => "Eddy",
            BuiltIn::Nonlinearity(_) => "Nonlinearity",
            BuiltIn::CrossAxis(_) => "CrossAxis",
            BuiltIn::Periodic(_) => "Periodic",
        })
        .collect();
    let mut imports = vec!["BuiltIn"];
    if !columns.is_empty() {
        imports.push("ColumnName");
    }
    imports.extend(used.iter().flat_map(|names| names.split(", ")));
    imports.sort_unstable();
    imports.dedup();
    let mut text = format!(
        "// Written by `ironout export --as rust`: {summary}.\n\
         // corrected = matrix · (measured − offset − effects), microtesla:\n\
         // `let mut live = Live::new(&CALIBRATION)?; live.set(\"column\", value); live.apply(measured_ut, turn_radps)?`.\n\n\
         use ironout::calibration::Calibration;\nuse ironout::effect::{{{}}};\n\
         use ironout::extended::{{Effects, ExtendedCalibration, FittedEffect}};\n\n",
        imports.join(", ")
    );
    for (place, name) in columns.iter().enumerate() {
        let _ = writeln!(
            text,
            "const COLUMN_{place}: ColumnName = match ColumnName::new(\"{name}\") {{\n    Ok(name) => name,\n    \
             Err(_) => panic!(\"a name\"),\n}};"
        );
    }
    for (name, scalar, what) in CONSTANTS {
        let base = base(&calibration.base, scalar, "    ");
        let mut places = String::new();
        for fitted in calibration.effects.iter() {
            let FittedEffect { effect, coefficients, std_errors } = fitted;
            let _ = write!(
                places,
                "        Some(FittedEffect {{\n            effect: {},\n            coefficients: {},\n            \
                 std_errors: {},\n        }}),\n",
                shape(effect, scalar, &constant),
                list(scalar, coefficients),
                list(scalar, std_errors)
            );
        }
        places.push_str(&"        None,\n".repeat(MAX_EFFECTS - calibration.effects.len()));
        let _ = write!(
            text,
            "\n/// {what}\n#[allow(dead_code)]\npub const {name}: ExtendedCalibration<{scalar}> = ExtendedCalibration {{\n    \
             base: {base},\n    effects: Effects::of([\n{places}    ]),\n}};\n"
        );
    }
    text
}

fn columns(calibration: &ExtendedCalibration) -> Vec<ColumnName> {
    let mut columns: Vec<ColumnName> = Vec::new();
    for fitted in calibration.effects.iter() {
        let column = match fitted.effect {
            BuiltIn::Offset(Offset { column, .. }) => column,
            BuiltIn::Gain(Gain { column, .. }) => column,
            BuiltIn::Field(AmbientField { column, .. }) => column,
            _ => continue,
        };
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    columns
}

fn shape(effect: &BuiltIn<f64>, scalar: &str, constant: &impl Fn(&ColumnName) -> String) -> String {
    let number = |v: f64| value(scalar, v);
    match effect {
        BuiltIn::Offset(Offset { column, reference, power, delay_s }) => format!(
            "BuiltIn::Offset(Offset {{ column: {}, reference: {}, power: Power::{power:?}, delay_s: {} }})",
            constant(column),
            number(*reference),
            delay_s.map_or("None".to_string(), |delay| format!("Some({})", number(delay)))
        ),
        BuiltIn::Gain(Gain { column, reference }) => format!(
            "BuiltIn::Gain(Gain {{ column: {}, reference: {} }})",
            constant(column),
            number(*reference)
        ),
        BuiltIn::Field(AmbientField { column, reference }) => format!(
            "BuiltIn::Field(AmbientField {{ column: {}, reference: {} }})",
            constant(column),
            number(*reference)
        ),
        BuiltIn::Drift(Drift { reference_s }) => {
            format!("BuiltIn::Drift(Drift {{ reference_s: {} }})", number(*reference_s))
        }
        BuiltIn::Step(Step { at_s }) => format!("BuiltIn::Step(Step {{ at_s: {} }})", number(*at_s)),
        BuiltIn::Lag(Lag) => "BuiltIn::Lag(Lag)".into(),
        BuiltIn::Eddy(Eddy) => "BuiltIn::Eddy(Eddy)".into(),
        BuiltIn::Nonlinearity(Nonlinearity) => "BuiltIn::Nonlinearity(Nonlinearity)".into(),
        BuiltIn::CrossAxis(CrossAxis) => "BuiltIn::CrossAxis(CrossAxis)".into(),
        BuiltIn::Periodic(Periodic { frequency_hz, reference_s }) => format!(
            "BuiltIn::Periodic(Periodic {{ frequency_hz: {frequency_hz:?}, reference_s: {reference_s:?} }})"
        ),
    }
}
