//! What every file for another program says at its top: what it holds, what it does not, and what that costs.

use crate::export::held::{Held, Shape, Turns};
use crate::export::refit::Cost;

/// Lines are at most this wide.
const WIDTH: usize = 100;
/// A misalignment below this is not worth a word, degrees.
const LEAST_DEG: f64 = 0.05;

/// What is known next to the calibration for the words at the top.
#[derive(Debug, Clone, Copy)]
pub struct About<'a> {
    /// The fit, in words.
    pub summary: &'a str,
    /// What it costs that the target does not hold all; `None` where no log was given.
    pub cost: Option<&'a Cost>,
}

/// A number with as many digits as a single-precision parameter keeps, without an exponent.
pub(crate) fn decimal(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0.0".into();
    }
    let before = value.abs().log10().floor() as i32 + 1;
    let text = format!("{value:.*}", (9 - before).clamp(1, 24) as usize);
    let trimmed = text.trim_end_matches('0');
    if trimmed.ends_with('.') { format!("{trimmed}0") } else { trimmed.to_string() }
}

/// What the target does not hold, a sentence each.
pub fn not_held(held: &Held) -> Vec<String> {
    let mut list: Vec<String> =
        held.dropped.iter().map(|dropped| format!("the effect {}: {}", dropped.id, dropped.why)).collect();
    let name = held.room.name;
    if held.narrowed {
        list.push(match held.room.shape {
            Shape::Scalar => format!("soft iron and the gains of the axes: {name} has an offset only"),
            _ => format!("the off-diagonal soft iron: {name} has one factor per axis"),
        });
    }
    if let Some(lost_deg) = held.lost_deg.filter(|lost_deg| *lost_deg > LEAST_DEG) {
        list.push(format!(
            "a rotation of {lost_deg:.2} degrees between magnetometer and accelerometer, in addition to the mounting: it \
             changes the heading, not the magnitude{}",
            if held.room.power { " (for external magnetometers, --euler writes the whole rotation)" } else { "" }
        ));
    }
    list
}

/// What that costs, a sentence each.
pub fn costs(held: &Held, cost: Option<&Cost>) -> Vec<String> {
    let lost = not_held(held);
    let Some(cost) = cost else {
        return match lost.is_empty() {
            true => Vec::new(),
            false => {
                vec![
                    "To print the error of these parameters, and to refit them on the log, add --log LOG"
                        .into(),
                ]
            }
        };
    };
    let percent = |ut: f64| ut / held.field_ut * 100.0;
    let mut list = vec![format!(
        "error of the magnitude on {} samples: {:.3} uT ({:.2} %) with the whole calibration, {:.3} uT ({:.2} %) with these \
         parameters",
        cost.samples,
        cost.whole_rms_ut,
        percent(cost.whole_rms_ut),
        cost.held_rms_ut,
        percent(cost.held_rms_ut)
    )];
    if let Some(heading) = cost.heading {
        list.push(format!(
            "heading of these parameters minus that of the whole calibration: {:.2} degrees rms",
            heading.between_deg
        ));
        if let Some([whole, own]) = heading.errors_deg {
            list.push(format!(
                "against heading_deg: {whole:.2} degrees rms with the whole calibration, {own:.2} degrees with these \
                 parameters"
            ));
        }
    }
    if held.refitted {
        list.push("ironout has refitted these parameters on that log".into());
    }
    list
}

/// The lines at the top, each after `mark`: `formula` is the target's own.
pub(crate) fn top(held: &Held, about: About, mark: &str, formula: &[&str]) -> String {
    let mut lines = Vec::new();
    let mut say = |text: &str, indent: &str| lines.extend(wrapped(text, indent));
    say(&format!("Written by `ironout export`: {}.", about.summary), "");
    formula.iter().for_each(|text| say(text, ""));
    let lost = not_held(held);
    if lost.is_empty() {
        say(&format!("{} represents the whole calibration.", held.room.name), "");
    } else {
        say(&format!("{} cannot represent:", held.room.name), "");
    }
    lost.iter().for_each(|text| say(&format!("- {text}"), "  "));
    costs(held, about.cost).iter().for_each(|text| say(text, ""));
    match held.mounting.filter(|_| held.room.turns == Turns::Numbered) {
        Some(mounting) if !mounting.is_none() => say(&format!("Mounting: {}.", mounting.name()), ""),
        _ => {}
    }
    if held.lost_deg.is_none() {
        say("No accelerometer was used, so the sensor's mounting angle is unknown.", "");
    }
    let ascii = |text: &str| text.replace('µ', "u").replace('−', "-").replace('°', " degrees");
    lines.iter().map(|line| format!("{mark} {}\n", ascii(line))).collect()
}

fn wrapped(text: &str, indent: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && line + 1 + word.chars().count() > WIDTH {
            lines.push(indent.to_string());
        }
        if let Some(line) = lines.last_mut() {
            if !line.trim().is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_nine_digits_and_no_exponent() {
        for (value, text) in [
            (0.0, "0.0"),
            (1.0, "1.0"),
            (-0.001_234_567_891_23, "-0.00123456789"),
            (123.456_789_012, "123.456789"),
            (1e-9, "0.000000001"),
            (25.0, "25.0"),
        ] {
            assert_eq!(decimal(value), text);
        }
    }
}
