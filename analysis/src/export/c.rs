//! A calibration as a C header (C99) with one function that applies it.

use crate::effects::Calibrated;
use crate::export::bound;
use crate::export::error::CannotExport;
use crate::export::measured;
use crate::export::range::{Range, ranges};
use crate::frame::Frame;
use ironout::calibration::{Calibration, inverse_3x3};
use ironout::effect::{Bends, ColumnName, Effect, Id, Made, Past, TIME};
use ironout::extended::{FittedEffect, MAX_RATIO_TO_FIELD, MAX_WIDTHS_OUTSIDE};
use std::fmt::Write as _;

type Fitted = FittedEffect<f64, Made<ColumnName>>;

/// The most looks at a disturbance that depends on the field it disturbs, as in the library.
const LOOKS: usize = 28;

/// How the file ends.
const END: &str = "#endif /* IRONOUT_CALIBRATION_H */\n";

/// The file, with how the log was read.
///
/// # Errors
/// Two columns that have the same name in C, or a matrix without an inverse.
pub fn text(calibration: &Calibrated, frame: &Frame, summary: &str) -> Result<String, CannotExport> {
    let (text, scalar) = if calibration.effects.is_empty() {
        (plain(&calibration.base, summary), "float")
    } else {
        (extended(calibration, summary)?, "ironout_real")
    };
    let text = match text.strip_suffix(END) {
        Some(body) => format!("{body}{}{END}", measured::c(frame, scalar)),
        None => text,
    };
    Ok(text.replace('µ', "u").replace('·', "*").replace('−', "-").replace('°', "deg ").replace('²', "^2"))
}

fn plain(calibration: &Calibration<f64>, summary: &str) -> String {
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
}

/// A constant to the last bit, in whatever precision the header is compiled for.
fn number(v: f64) -> String {
    format!("(ironout_real){v:?}")
}

fn triple(v: &[f64]) -> String {
    let words: Vec<String> = v.iter().map(|v| number(*v)).collect();
    format!("{{{}}}", words.join(", "))
}

fn rows(matrix: &[[f64; 3]; 3]) -> String {
    let [a, b, c] = matrix.map(|row| triple(&row));
    format!("{{\n    {a},\n    {b},\n    {c}\n}}")
}

/// The parameter of the C function that carries a column.
fn parameter(name: &str, past: Past<f64>) -> String {
    let mut word: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        word.insert_str(0, "column_");
    }
    // C's own words and the function's other names must not be taken.
    if !word.contains('_') {
        word.push_str("_value");
    }
    if ["measured_ut", "corrected_ut", "turn_radps", "ironout_real"].contains(&word.as_str()) {
        word.push_str("_column");
    }
    match past.word() {
        "" => word,
        which => format!("{word}_{which}"),
    }
}

/// What a parameter is called once it is held at the ends of its range.
const HELD: &str = "_held";

/// Whether an effect goes by this column held at the ends of its range.
fn held(calibration: &Calibrated, column: &str) -> bool {
    let holds = |fitted: &&Fitted| !fitted.effect.repeats();
    calibration.effects.iter().filter(holds).any(|fitted| {
        let columns = fitted.effect.columns().into_iter().zip(fitted.ranges);
        columns.filter(|(_, range)| range.is_some()).any(|(own, _)| own.is_some_and(|own| own.name == column))
    })
}

struct Parameter {
    name: String,
    column: String,
    past: Past<f64>,
}

fn parameters(calibration: &Calibrated) -> Result<Vec<Parameter>, CannotExport> {
    let mut list: Vec<Parameter> = Vec::new();
    for fitted in calibration.effects.iter() {
        for column in fitted.effect.columns().into_iter().flatten() {
            let name = parameter(column.name, column.past);
            match list.iter().find(|known| known.name == name) {
                None => {
                    list.push(Parameter { name, column: column.name.to_string(), past: column.past });
                }
                Some(known) if known.column == column.name && known.past == column.past => {}
                Some(known) => {
                    return Err(CannotExport::SameName(known.column.clone(), column.name.to_string()));
                }
            }
        }
    }
    Ok(list)
}

fn extended(calibration: &Calibrated, summary: &str) -> Result<String, CannotExport> {
    let base = &calibration.base;
    let (list, ranges) = (parameters(calibration)?, ranges(calibration));
    let turning = calibration.effects.iter().any(|fitted| fitted.effect.needs_gyro());
    let delays = calibration.effects.iter().filter_map(|fitted| fitted.effect.delay_s(&fitted.coefficients));
    let delay_s = delays.reduce(|sum, delay| sum + delay);
    let coupled = |fitted: &&Fitted| fitted.effect.delay_s(&fitted.coefficients).is_none();
    let couples = calibration.effects.iter().filter(coupled).any(|fitted| fitted.effect.needs_gyro());
    let looks_again = |fitted: &Fitted| fitted.bends == Bends::Field || fitted.effect.reads_centre();
    let evaluations = if calibration.effects.iter().any(looks_again) { LOOKS } else { 1 };
    let math = calibration.effects.iter().any(|fitted| fitted.effect.family().c_needs_math());
    let mut text = format!(
        "/* Written by `ironout export --as c`: {summary}.\n   corrected = matrix * (measured - offset - effects), \
         microtesla. \
         */\n#ifndef IRONOUT_CALIBRATION_H\n#define IRONOUT_CALIBRATION_H\n\n"
    );
    if let Some(warning) = bound::warning(calibration) {
        let _ = write!(text, "/* {}. */\n\n", warning.join("\n   "));
    }
    if math {
        text.push_str("#include <math.h>\n\n");
    }
    let _ = write!(
        text,
        "/* Define IRONOUT_REAL as double for double precision. */\n#ifndef IRONOUT_REAL\n#define IRONOUT_REAL \
         float\n#endif\n\
         typedef IRONOUT_REAL ironout_real;\n\n\
         /* The magnitude that corrected vectors have, microtesla. */\n#define IRONOUT_FIELD_UT {}\n\n\
         /* Hard iron and zero offset, microtesla. */\nstatic const ironout_real ironout_offset_ut[3] = {};\n\n\
         /* Undoes soft iron, gains, non-orthogonality and rotation. */\nstatic const ironout_real ironout_matrix[3][3] = {};\n\n",
        number(base.field_ut),
        triple(&base.offset_ut),
        rows(&base.matrix)
    );
    if couples {
        let inverse = inverse_3x3(&base.matrix).ok_or(CannotExport::Singular)?;
        let _ = write!(
            text,
            "/* Its inverse. */\nstatic const ironout_real ironout_inverse[3][3] = {};\n\n",
            rows(&inverse)
        );
    }
    text.push_str("/* Corrects one measured vector; both in microtesla, and they may be the same array. If the effects make \
         the vector longer than\n   twice the field and twice its length without them, it is NaN.");
    text.push_str(match list.is_empty() && !turning {
        true => " It needs nothing else.\n",
        false => "\n   Besides it needs:\n",
    });
    for Parameter { name, column, past } in &list {
        let what = match column.as_str() {
            TIME => "the time, s, on the recording's clock".to_string(),
            _ => match past {
                Past::Now => format!("the column {column}"),
                Past::Delayed(s) if *s < 0.0 => {
                    format!(
                        "{column} as logged {:.4} s after the sample: delay the correction by that time",
                        -s
                    )
                }
                Past::Delayed(delay_s) => format!("the column {column} as it was {delay_s:.4} s ago"),
                Past::LowPass(s) => format!(
                    "the column {column} through a low-pass with the time constant {s:.4} s:\n      \
                     y += (x - y) * (1 - exp(-dt_s / {s:.4})) for each value x, beginning with y = x"
                ),
            },
        };
        let _ = writeln!(text, "   {name}: {what}");
    }
    if turning {
        text.push_str("   turn_radps: the rate of turn, rad/s, body axes\n");
    }
    text.push_str("*/\nstatic inline void ironout_apply(const ironout_real measured_ut[3]");
    for Parameter { name, column, .. } in &list {
        // Seconds since long ago do not fit a single.
        let scalar = if column == TIME { "double" } else { "ironout_real" };
        let _ = write!(text, ", {scalar} {name}");
    }
    if turning {
        text.push_str(", const ironout_real turn_radps[3]");
    }
    text.push_str(", ironout_real corrected_ut[3])\n{\n    ironout_real centred[3], left[3], sum[3], with = 0, without = 0;\n");
    if evaluations > 1 {
        text.push_str("    ironout_real moved, size;\n");
    }
    for Parameter { name, column, past } in &list {
        let range = ranges.iter().find(|range| range.column == *column && range.past == *past);
        if let Some(Range { ends: [least, most], .. }) = range.filter(|_| held(calibration, column)) {
            let scalar = if column == TIME { "double" } else { "ironout_real" };
            let (end, margin) =
                (|end: f64| format!("({scalar}){end:?}"), (most - least) * MAX_WIDTHS_OUTSIDE);
            let (least, most) = (end(least - margin), end(most + margin));
            let _ = writeln!(
                text,
                "    const {scalar} {name}{HELD} = {name} < {least} ? {least} : {name} > {most} ? {most} : {name};"
            );
        }
    }
    text.push_str(
        "    int i, look;\n\n    for (i = 0; i < 3; i++) \
         {\n        centred[i] = measured_ut[i] - ironout_offset_ut[i];\n        \
         left[i] = centred[i];\n    }\n",
    );
    let _ = writeln!(text, "    for (look = 0; look < {evaluations}; look++) {{");
    if couples {
        text.push_str(TURNING);
    }
    text.push_str("        for (i = 0; i < 3; i++) {\n            sum[i] = 0;\n        }\n");
    for fitted in calibration.effects.iter().filter(coupled) {
        // Writing to a string cannot fail.
        let _ = body(fitted, &mut text);
    }
    // The disturbance stands where a look moves it no further, as in the library.
    text.push_str(match evaluations {
        1 => "        for (i = 0; i < 3; i++) {\n            left[i] = centred[i] - sum[i];\n        }\n    }\n",
        _ => STANDS,
    });
    text.push_str(&CORRECTED.replace("LIMIT", &number(MAX_RATIO_TO_FIELD * MAX_RATIO_TO_FIELD)));
    if let Some(delay_s) = delay_s {
        let _ = write!(
            text,
            "    {{ /* lag: the sensor rotated since this reading */\n        const ironout_real late_s = {};\n{TURNED}    }}\n",
            number(delay_s)
        );
    }
    text.push_str("}\n\n");
    text.push_str(&outside(&list, &ranges));
    text.push_str("#endif /* IRONOUT_CALIBRATION_H */\n");
    Ok(text)
}

/// The function that says which columns lie outside; nothing where no range is known.
fn outside(list: &[Parameter], ranges: &[Range]) -> String {
    let of = |parameter: &Parameter| {
        let mut all = ranges.iter();
        all.find(|range| range.column == parameter.column && range.past == parameter.past)
    };
    if list.iter().all(|parameter| of(parameter).is_none()) {
        return String::new();
    }
    let (mut ranges, mut body, mut arguments) = (String::new(), String::new(), Vec::new());
    for (bit, parameter) in list.iter().enumerate() {
        let Parameter { name, column, .. } = parameter;
        let scalar = if column == TIME { "double" } else { "ironout_real" };
        arguments.push(format!("{scalar} {name}"));
        match of(parameter) {
            Some(Range { ends: [least, most], .. }) => {
                ranges += &format!("   bit {bit}, {name}: {least:?} to {most:?}\n");
                body += &format!(
                    "    if (!({name} >= ({scalar}){least:?} && {name} <= ({scalar}){most:?})) \
                     {{\n        outside |= {}u;\n    }}\n",
                    1_u32 << bit
                );
            }
            None => {
                ranges += &format!("   bit {bit}, {name}: unknown, never set\n");
                body += &format!("    (void){name};\n");
            }
        }
    }
    format!(
        "/* Which columns lie outside the range that their effects were fitted over, one bit per column; 0 if none does. \
         Outside, the\n   \
         effects are extrapolated by at most the width of the range, and the error grows with the distance.\n{ranges}*/\nstatic inline unsigned \
         ironout_outside({})\n{{\n    unsigned outside = 0u;\n\n{body}    return outside;\n}}\n\n",
        arguments.join(", ")
    )
}

/// The end of a look at effects that depend on the field they disturb.
const STANDS: &str = "        moved = 0;
        size = 0;
        for (i = 0; i < 3; i++) {
            ironout_real next = centred[i] - sum[i];
            moved += (next - left[i]) * (next - left[i]);
            size += next * next;
            left[i] = next;
        }
        if (!(moved > (ironout_real)1e-10 * size)) {
            break;
        }
    }
";

/// `corrected = C left`, or no number where the effects make of it what they were never fitted to, as in the library.
const CORRECTED: &str = "    for (i = 0; i < 3; i++) {
        ironout_real plain = ironout_matrix[i][0] * centred[0] + ironout_matrix[i][1] * centred[1] + ironout_matrix[i][2] * centred[2];

        corrected_ut[i] = ironout_matrix[i][0] * left[0] + ironout_matrix[i][1] * left[1] + ironout_matrix[i][2] * left[2];
        without += plain * plain;
        with += corrected_ut[i] * corrected_ut[i];
    }
    if (with > LIMIT * without && with > LIMIT * IRONOUT_FIELD_UT * IRONOUT_FIELD_UT) {
        for (i = 0; i < 3; i++) {
            corrected_ut[i] = (with - with) / (with - with);
        }
    }
";

/// `turning = A (ω × C v)`.
const TURNING: &str = "        ironout_real field[3], turned[3], turning[3];

        for (i = 0; i < 3; i++) {
            field[i] = ironout_matrix[i][0] * left[0] + ironout_matrix[i][1] * left[1] + ironout_matrix[i][2] * left[2];
        }
        for (i = 0; i < 3; i++) {
            turned[i] = turn_radps[(i + 1) % 3] * field[(i + 2) % 3] - turn_radps[(i + 2) % 3] * field[(i + 1) % 3];
        }
        for (i = 0; i < 3; i++) {
            turning[i] = ironout_inverse[i][0] * turned[0] + ironout_inverse[i][1] * turned[1] + ironout_inverse[i][2] * turned[2];
        }
";

/// `corrected` turned back by what the board turned in `late_s`, by a quaternion, as in the library.
const TURNED: &str = "        ironout_real axis[3], once[3], twice[3], square = 0, whole = 1, part = 1, share;

        for (i = 0; i < 3; i++) {
            axis[i] = -late_s * turn_radps[i];
            square += axis[i] * axis[i] / 4;
        }
        for (i = 8; i > 0; i--) {
            whole = 1 - whole * square / (ironout_real)(2 * i * (2 * i - 1));
            part = 1 - part * square / (ironout_real)((2 * i + 1) * 2 * i);
        }
        for (i = 0, share = whole * whole; i < 3; i++) {
            axis[i] *= part / 2;
            share += axis[i] * axis[i];
        }
        for (i = 0; i < 3; i++) {
            once[i] = axis[(i + 1) % 3] * corrected_ut[(i + 2) % 3] - axis[(i + 2) % 3] * corrected_ut[(i + 1) % 3];
        }
        for (i = 0; i < 3; i++) {
            twice[i] = axis[(i + 1) % 3] * once[(i + 2) % 3] - axis[(i + 2) % 3] * once[(i + 1) % 3];
        }
        for (i = 0; i < 3; i++) {
            corrected_ut[i] += 2 / share * (whole * once[i] + twice[i]);
        }
";

/// What an effect reads in place of the measured vector if it bends the field.
const UNDISTURBED: &str = "            const ironout_real undisturbed[3] = {left[0] + ironout_offset_ut[0], left[1] + ironout_offset_ut[1],
                left[2] + ironout_offset_ut[2]};
            const ironout_real *const measured_ut = undisturbed;
";

/// The statements that add one effect to `sum`.
fn body(fitted: &Fitted, text: &mut String) -> std::fmt::Result {
    let made = &fitted.effect;
    let k = made.coefficients();
    writeln!(text, "        {{ /* {} */", Id(made))?;
    writeln!(
        text,
        "            static const ironout_real theta[{k}] = {};",
        triple(&fitted.coefficients[..k])
    )?;
    let mut names = made.inputs().map(|column| column.map_or(String::new(), |c| parameter(c.name, c.past)));
    for (name, _) in
        names.iter_mut().zip(fitted.ranges).filter(|(_, range)| range.is_some() && !made.repeats())
    {
        name.push_str(HELD);
    }
    if fitted.bends == Bends::Field {
        text.push_str(UNDISTURBED);
    }
    let [first, second] = &names;
    made.family().c(&made.parts().borrowed(), [first, second], text)?;
    text.push_str("        }\n");
    Ok(())
}
