//! Numbers as people read them: as many digits as mean something.

use crate::field_unit::{chosen, derived, fixed, symbol};
pub use crate::wrap::{hang, wrap};

/// `value` with `digits` significant digits; a power of ten where there would be too many zeros.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..=6).contains(&exponent) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
    format!("{value:.decimals$}")
}

/// A field in the unit in use, of a value in microtesla: two to four significant digits.
pub fn microtesla(value_ut: f64) -> String {
    match value_ut.abs() {
        v if !v.is_finite() => "-".into(),
        v if v < 0.095 => fixed(Some(value_ut), 3),
        v if v < 100.0 => fixed(Some(value_ut), 2),
        v if v < 10_000.0 => fixed(Some(value_ut), 0),
        _ => format!("{:.1e}", value_ut * chosen().per_ut()),
    }
}

/// The same with its unit.
pub fn field(value_ut: f64) -> String {
    format!("{} {}", microtesla(value_ut), symbol())
}

/// Degrees.
pub fn degrees(value: f64) -> String {
    if value.abs() < 10.0 { format!("{value:.2}°") } else { format!("{value:.1}°") }
}

/// A probability: two digits are plenty.
pub fn probability(p: f64) -> String {
    match p {
        p if p.is_nan() => "-".into(),
        p if p < 1e-99 => "<1e-99".into(),
        p if p < 0.001 => format!("{p:.0e}"),
        p if p < 0.01 => format!("{p:.3}"),
        p if p < 0.995 => format!("{p:.2}"),
        _ => "1".into(),
    }
}

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p.is_nan() => "-".into(),
        p if p > 0.0 && p < 0.5 => "<1 %".into(),
        p => format!("{p:.0} %"),
    }
}

/// `+1.234 ±0.056`: the error with two digits, the value to the same place.
pub fn with_error(value: f64, error: f64) -> String {
    if !(error.is_finite() && error > 0.0) {
        return format!("{}{}", if value < 0.0 { "" } else { "+" }, significant(value, 3));
    }
    let decimals = (1.0 - error.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:+.decimals$} ±{error:.decimals$}")
}

/// A unit that people read, and the factor into it: a second as milliseconds, a share as per cent, and otherwise a
/// power of a thousand where the numbers would begin with zeros.
pub fn readable_unit(unit: &str, largest: f64) -> (f64, String) {
    match unit {
        "s" => (1e3, "ms".into()),
        "1/°C" => (100.0, "%/°C".into()),
        "1/A" => (100.0, "%/A".into()),
        "1 per unit" => (100.0, "% per unit".into()),
        unit if unit.starts_with("µT") && derived(unit).0 != 1.0 => {
            let (factor, unit) = derived(unit);
            let (further, unit) = scaled(&unit, largest * factor);
            (factor * further, unit)
        }
        _ => scaled(unit, largest),
    }
}

/// A unit in thousandths, millionths … if the numbers in it would begin with zeros, and the factor into it.
fn scaled(unit: &str, largest: f64) -> (f64, String) {
    match largest {
        _ if largest > 0.0 && largest < 1e-2 => {
            let thousands = ((-largest.log10()).ceil() / 3.0).ceil().clamp(1.0, 4.0) as i32;
            let power = ["", "³", "⁶", "⁹", "¹²"][thousands as usize];
            (1e3_f64.powi(thousands), format!("10⁻{power} {unit}"))
        }
        _ => (1.0, unit.into()),
    }
}

/// The unit that a column's name states.
pub fn unit_of(column: &str) -> &'static str {
    const UNITS: [(&str, &str); 16] = [
        ("_c", " °C"),
        ("_a", " A"),
        ("_ma", " mA"),
        ("_v", " V"),
        ("_w", " W"),
        ("_s", " s"),
        ("_m", " m"),
        ("_mps", " m/s"),
        ("_rpm", " rpm"),
        ("_hz", " Hz"),
        ("_pct", " %"),
        ("_deg", "°"),
        ("_rad", " rad"),
        ("_us", " µs"),
        ("_pa", " Pa"),
        ("_hpa", " hPa"),
    ];
    let column = column.to_ascii_lowercase();
    UNITS.iter().find(|(suffix, _)| column.ends_with(suffix)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_mean_something() {
        assert_eq!(significant(0.052_34, 3), "0.0523");
        assert_eq!(significant(-12.345, 3), "-12.3");
        assert_eq!(significant(1.0e-7, 3), "1.00e-7");
        assert_eq!(significant(f64::NAN, 3), "-");
        assert_eq!(with_error(0.052_34, 0.001_2), "+0.0523 ±0.0012");
        assert_eq!(with_error(-3.0, f64::NAN), "-3.00");
        assert_eq!(with_error(1234.5, 30.0), "+1234 ±30");
        assert_eq!(probability(0.0), "<1e-99");
        assert_eq!(probability(3.2e-12), "3e-12");
        assert_eq!(probability(0.004), "0.004");
        assert_eq!(percent(0.001), "<1 %");
        assert_eq!(percent(0.0), "0 %");
    }

    #[test]
    fn units_that_people_read() {
        assert_eq!(readable_unit("s", 0.018), (1e3, "ms".into()));
        assert_eq!(readable_unit("µT/°C", 0.4), (1.0, "µT/°C".into()));
        let (factor, unit) = readable_unit("1/µT", 3e-5);
        assert_eq!((factor, unit.as_str()), (1e6, "10⁻⁶ 1/µT"));
        assert_eq!(unit_of("temp_c"), " °C");
        assert_eq!(unit_of("throttle"), "");
    }

    #[test]
    fn no_line_is_wider_than_asked() {
        let text = "one two three four five six seven";
        let lines = wrap(text, "  ", 12);
        assert!(lines.iter().all(|line| line.chars().count() <= 12), "{lines:?}");
        assert_eq!(lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" "), text);
    }
}
