//! Code that does what the reader of the log did: from the numbers of its source to the vectors that a calibration is of.

use crate::frame::{Frame, IDENTITY};
use std::fmt::Write as _;

/// What the numbers of the log are, and what the code cannot undo, a sentence each.
fn words(frame: &Frame) -> Vec<String> {
    let scale = match frame.ut_per_number {
        [1.0, 1.0, 1.0] => "microtesla".to_string(),
        [x, y, z] if x == y && y == z => format!("units of {x:?} uT"),
        all => format!("units of {} uT", all.map(|value| format!("{value:?}")).join(", ")),
    };
    let axes = if frame.from_source == IDENTITY { "" } else { ", in the axes of the sensor" };
    let mut sentences = vec![format!("The numbers of the log are {scale}{axes}.")];
    if !frame.repairs.is_empty() {
        sentences.push(format!(
            "ironout has repaired them (--repair {}). Repair the numbers in the same way before this conversion. For unsigned: \
             read the registers as signed numbers.",
            frame.repairs.join(",")
        ));
    }
    if let Some(last) = frame.removed.last() {
        sentences.push("Their program had applied a calibration, which ironout has removed.".into());
        if frame.removed.len() > 1 {
            let since =
                last.from_s.map_or(String::new(), |from| format!(", in use from {from:.1} s of the log on"));
            sentences.push(format!(
                "It changed {} times in the log. This is the last one{since}.",
                frame.removed.len() - 1
            ));
        }
        if frame.removed.iter().any(|one| one.power) {
            sentences.push(
                "It does not include the compensation of motors or current. Pass numbers from which that compensation is \
                 already removed.".into(),
            );
        }
    }
    sentences
}

/// A C function from the numbers of the log to what `ironout_apply` takes; `scalar` is its type. Empty where they are the same.
pub(crate) fn c(frame: &Frame, scalar: &str) -> String {
    if frame.is_plain() {
        return String::new();
    }
    let (matrix, offset) = frame.affine();
    let row = |row: [f64; 3]| format!("{{{}}}", row.map(|v| format!("({scalar}){v:?}")).join(", "));
    let [a, b, c] = matrix.map(row);
    let (constant, plus) = match offset {
        [0.0, 0.0, 0.0] => (String::new(), ""),
        _ => (
            format!("static const {scalar} ironout_reading_offset_ut[3] = {};\n", row(offset)),
            " + ironout_reading_offset_ut[i]",
        ),
    };
    format!(
        "/* {words}\n   Converts these numbers to the input of ironout_apply(), microtesla in the calibration's axes. The two \
         arrays must differ. */\n\
         static const {scalar} ironout_reading[3][3] = {{\n    {a},\n    {b},\n    {c}\n}};\n{constant}\n\
         static inline void ironout_measured_ut(const {scalar} raw[3], {scalar} measured_ut[3])\n{{\n    int i;\n\n    \
         for (i = 0; i < 3; i++) {{\n        measured_ut[i] = ironout_reading[i][0] * raw[0] + ironout_reading[i][1] * \
         raw[1] + ironout_reading[i][2] * raw[2]{plus};\n    }}\n}}\n\n",
        words = words(frame).join("\n   "),
    )
}

/// The same in Rust, in both precisions. Empty where they are the same.
pub(crate) fn rust(frame: &Frame) -> String {
    let mut text = String::new();
    if frame.is_plain() {
        return text;
    }
    let (matrix, offset) = frame.affine();
    for (scalar, suffix, shown) in [("f32", "", "single"), ("f64", "_F64", "double")] {
        let value = |v: f64| if scalar == "f32" { format!("{:?}", v as f32) } else { format!("{v:?}") };
        let row = |row: [f64; 3]| format!("[{}]", row.map(value).join(", "));
        let [a, b, c] = matrix.map(row);
        let (constant, add) = match offset {
            [0.0, 0.0, 0.0] => (String::new(), String::new()),
            _ => (
                format!(
                    "/// Added to what `READING{suffix}` gives, microtesla.\n#[allow(dead_code)]\npub const \
                     READING_OFFSET_UT{suffix}: [{scalar}; 3] = {};\n\n",
                    row(offset)
                ),
                format!(
                    "    let [x, y, z] = measured;\n    let [a, b, c] = READING_OFFSET_UT{suffix};\n    [x + a, y + b, z + \
                     c]\n"
                ),
            ),
        };
        let product =
            format!("READING{suffix}.map(|row| row[0] * raw[0] + row[1] * raw[1] + row[2] * raw[2])");
        let body = if add.is_empty() {
            format!("    {product}\n")
        } else {
            format!("    let measured = {product};\n{add}")
        };
        let _ = write!(
            text,
            "\n/// {words}\n/// From them to microtesla in the calibration's axes, rows first, {shown} \
             precision.\n#[allow(dead_code)]\n\
             pub const READING{suffix}: [[{scalar}; 3]; 3] = [\n    {a},\n    {b},\n    {c},\n];\n\n{constant}\
             /// Converts the numbers of such a log to the input of `apply`.\n#[allow(dead_code)]\n\
             pub fn measured_ut{lower}(raw: [{scalar}; 3]) -> [{scalar}; 3] {{\n{body}}}\n",
            words = words(frame).join("\n/// "),
            lower = suffix.to_lowercase(),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Removed;

    #[test]
    fn a_plain_frame_needs_no_code_and_another_one_is_carried() {
        assert!(c(&Frame::default(), "float").is_empty() && rust(&Frame::default()).is_empty());
        let turned = Frame {
            ut_per_number: [0.5, 0.25, 2.0],
            from_source: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            ..Frame::default()
        };
        let code = c(&turned, "float");
        assert!(code.contains("{(float)0.0, (float)0.25, (float)0.0}"), "{code}");
        assert!(!code.contains("offset"), "{code}");
        assert!(rust(&turned).contains("[-0.5, 0.0, 0.0],"), "{}", rust(&turned));
        let removed = Removed { from_s: None, offset: [4.0, 0.0, 0.0], matrix: IDENTITY, power: true };
        let corrected = Frame { removed: vec![removed], ..turned };
        let code = c(&corrected, "float");
        assert!(code.contains("{(float)0.0, (float)-2.0, (float)0.0}") && code.contains("motors"), "{code}");
        assert!(rust(&corrected).contains("READING_OFFSET_UT: [f32; 3] = [0.0, -2.0, 0.0]"));
    }
}
