//! A calibration as Rust constants for the crate.

use crate::effects::Calibrated;
use crate::export::bound;
use crate::export::measured;
use crate::export::range::{Range, ranges};
use crate::frame::Frame;
use ironout::calibration::Calibration;
use ironout::effect::{Bends, ColumnName, Effect, Made, Past, RustCode, TIME};
use ironout::extended::{FittedEffect, MAX_EFFECTS, Ranges};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

const CONSTANTS: [(&str, &str, &str); 2] = [
    ("CALIBRATION", "f32", "In single precision, for the microcontroller."),
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

/// The file, with how the log was read.
pub fn text(calibration: &Calibrated, frame: &Frame, summary: &str) -> String {
    let text = if calibration.effects.is_empty() {
        plain(&calibration.base, summary)
    } else {
        extended(calibration, summary) + &outside(&ranges(calibration))
    };
    text + &measured::rust(frame)
}

/// The ranges and the function that says whether a value lies outside; nothing where no range is known.
fn outside(ranges: &[Range]) -> String {
    if ranges.is_empty() {
        return String::new();
    }
    let row = |Range { column, past, ends: [least, most] }: &Range| {
        format!("    (\"{column}\", {:?}, [{least:?}, {most:?}]),\n", past.seconds())
    };
    let rows: String = ranges.iter().map(row).collect();
    format!(
        "\n/// Column, how late it acts or its time constant (s), and the range that its effects were fitted over.\n#[allow(dead_code)]\n\
         pub const RANGES: [(&str, f64, [f64; 2]); {}] = [\n{rows}];\n\n\
         /// Whether a value of a column lies outside the range that its effects were fitted over: there the effects are\n\
         /// extrapolated by at most the width of the range, and the error grows with the distance.\n#[allow(dead_code)]\n\
         pub fn is_outside(column: &str, value: f64) -> bool {{\n    \
         RANGES.iter().any(|(name, _, [least, most])| *name == column && !(*least..=*most).contains(&value))\n}}\n",
        ranges.len()
    )
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

fn extended(calibration: &Calibrated, summary: &str) -> String {
    let columns: Vec<ColumnName> = columns(calibration);
    let constant = |name: &ColumnName| {
        let place = columns.iter().position(|known| known == name).unwrap_or_default();
        format!("COLUMN_{place}")
    };
    // Effects of the library are of one type; with another one among them all stand behind references.
    let of_library = calibration.effects.iter().all(|fitted| fitted.effect.parts().form.tag != 0);
    let mut imports: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for made in calibration.effects.iter().map(|fitted| &fitted.effect) {
        let names = made.family().rust_names(&made.parts().borrowed());
        imports.entry(made.family().rust_module()).or_default().extend(names);
    }
    let library = imports.entry("ironout::effect").or_default();
    if !columns.is_empty() {
        library.insert("ColumnName");
    }
    if calibration.effects.iter().any(|fitted| fitted.bends == Bends::Field) {
        library.insert("Bends");
    }
    if !of_library {
        library.insert("Effect");
    }
    let warning: String =
        bound::warning(calibration).iter().flatten().map(|line| format!("// {line}\n")).collect();
    let mut text = format!(
        "// Written by `ironout export --as rust`: {summary}.\n\
         // corrected = matrix · (measured − offset − effects), microtesla:\n\
         {}{warning}\n\
         use ironout::calibration::Calibration;\n",
        usage(calibration)
    );
    let mut uses: Vec<String> = imports.iter().map(|(module, names)| import(module, names)).collect();
    uses.push("use ironout::extended::{Effects, ExtendedCalibration, FittedEffect};\n".into());
    uses.sort();
    text.push_str(&uses.concat());
    text.push('\n');
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
        for FittedEffect { effect, coefficients, std_errors, ranges, bends } in calibration.effects.iter() {
            let column = constant(&effect.parts().column);
            let code = RustCode { single: scalar == "f32", column: &column };
            let mut shape = String::from(if of_library { "" } else { "&" });
            // Writing to a string cannot fail.
            let _ = effect.family().rust(&effect.parts().borrowed(), &code, &mut shape);
            let _ = write!(
                places,
                "        Some(FittedEffect::new(\n            {shape},\n            {},\n            {},\n        ){}{}),\n",
                list(scalar, coefficients),
                list(scalar, std_errors),
                over(scalar, ranges),
                if *bends == Bends::Field { ".bending(Bends::Field)" } else { "" }
            );
        }
        places.push_str(&"        None,\n".repeat(MAX_EFFECTS - calibration.effects.len()));
        let of = if of_library { String::new() } else { format!(", &'static (dyn Effect<{scalar}> + Sync)") };
        let _ = write!(
            text,
            "\n/// {what}\n#[allow(dead_code)]\npub const {name}: ExtendedCalibration<{scalar}{of}> = ExtendedCalibration \
             {{\n    \
             base: {base},\n    effects: Effects::of([\n{places}    ]),\n}};\n"
        );
    }
    text
}

/// How the constant is used: only what its effects ask for, with the arguments that `Live` takes.
fn usage(calibration: &Calibrated) -> String {
    let mut text = String::from("// `let mut live = Live::new(&CALIBRATION)?;`, then for each sample\n");
    let mut columns: Vec<String> = Vec::new();
    let read = calibration.effects.iter().flat_map(|fitted| fitted.effect.inputs().into_iter().flatten());
    for column in read.filter(|column| column.name != TIME) {
        if !columns.iter().any(|known| known == column.name) {
            columns.push(column.name.to_string());
            let _ = writeln!(text, "// `live.set(\"{}\", value);`", column.name);
        }
    }
    let all = || calibration.effects.iter().map(|fitted| &fitted.effect);
    let by_time = |effect: &Made<ColumnName>| {
        let mut columns = effect.columns().into_iter().flatten();
        columns.any(|column| column.name == TIME || column.past != Past::Now)
    };
    if all().any(by_time) {
        text.push_str("// `live.advance(now_s);`\n");
    }
    let turn = if all().any(|effect| effect.needs_gyro()) { "Some(turn_radps)" } else { "None" };
    let _ = writeln!(text, "// `let corrected_ut = live.apply(measured_ut, {turn})?;`");
    text
}

/// The ranges of its columns, where one is known.
fn over(scalar: &str, ranges: &Ranges<f64>) -> String {
    if ranges.iter().all(Option::is_none) {
        return String::new();
    }
    let words =
        ranges.map(|range| range.map_or("None".into(), |ends| format!("Some({})", list(scalar, &ends))));
    format!(".over([{}])", words.join(", "))
}

fn import(module: &str, names: &BTreeSet<&str>) -> String {
    let names: Vec<&str> = names.iter().copied().collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => format!("use {module}::{one};\n"),
        _ => format!("use {module}::{{{}}};\n", names.join(", ")),
    }
}

/// The columns that ids name, each once.
fn columns(calibration: &Calibrated) -> Vec<ColumnName> {
    let mut columns: Vec<ColumnName> = Vec::new();
    for parts in calibration.effects.iter().map(|fitted| fitted.effect.parts()) {
        if parts.form.column && !columns.contains(&parts.column) {
            columns.push(parts.column);
        }
    }
    columns
}
