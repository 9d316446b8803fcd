//! Where the base model fails: against each column, time, attitude and in the spectrum.

use crate::diagnosis_words::curve::{Curve, Residuals, limits, sparkline, spectrum};
use crate::diagnosis_words::diagnosed_log::{DiagnosedLog, WIDTH, at_rest, title};
use crate::diagnosis_words::numbers::{field, microtesla, percent, probability, significant, unit_of, wrap};
use crate::field_unit::chosen;
use crate::input::Log;
use ironout_analysis::outcome::outcome::{Diagnosis, Verdict, Where};

/// More columns than this are summed up.
const MOST: usize = 12;
/// Width of a column's name.
const NAME: usize = 13;

/// The values of a quantity at each sample; `None` where it has no curve.
fn values(log: &Log, rows: &[usize], against: &str) -> Option<Vec<f64>> {
    let column = match against {
        "time" | "t_s" => log.time_s.as_deref()?,
        name => &log.covariate(name)?.values,
    };
    Some(rows.iter().map(|&row| column.get(row).copied().unwrap_or(f64::NAN)).collect())
}

fn residuals<'a>(diagnosis: &'a Diagnosis, last: bool) -> Residuals<'a> {
    let series = if last { &diagnosis.traces.final_ut } else { &diagnosis.traces.base_ut };
    Residuals { series, directions: &diagnosis.traces.directions }
}

/// The residual against a column, of the base model and of the final one, in the same terms.
pub fn against_column(diagnosed_log: &DiagnosedLog, column: &str) -> Option<(Curve, Curve)> {
    let x = values(diagnosed_log.log, &diagnosed_log.diagnosis.traces.rows, column)?;
    let before = residuals(diagnosed_log.diagnosis, false).against(&x)?;
    let after = residuals(diagnosed_log.diagnosis, true).like(&x, &before)?;
    Some((before, after))
}

/// What the values of a curve are.
pub fn what(curve: &Curve) -> &'static str {
    if curve.offset { "local offset" } else { "mean" }
}

/// Curves are drawn on at least this range, µT, so that noise looks flat.
pub fn least_span(diagnosis: &Diagnosis) -> f64 {
    diagnosis.residual_floor_ut.map_or(1e-6, |floor| (2.0 * floor).max(1e-6))
}

/// What a residual is shown against, as people read it; JSON keeps its own words.
pub fn label(against: &str) -> &str {
    if against == "attitude" { "orientation" } else { against }
}

/// The two ends of a curve's axis with their unit.
pub fn axis_label(against: &str, curve: &Curve) -> (String, String) {
    let unit = match against {
        "time" => " s",
        "spectrum" => " Hz",
        "rate of turn" => " rad/s",
        name => unit_of(name),
    };
    // Both ends to the same place: three digits of the larger, and enough to tell them apart.
    let place = |value: f64, digits: f64| digits - value.max(1e-9).log10().floor();
    let larger = place(curve.low.abs().max(curve.high.abs()), 2.0);
    let decimals = larger.max(place(curve.high - curve.low, 1.0)).clamp(0.0, 6.0) as usize;
    let digits = |value: f64| {
        let text = format!("{value:.decimals$}");
        if text.trim_matches(['-', '0', '.']).is_empty() { "0".to_string() } else { text }
    };
    (digits(curve.low), format!("{}{unit}", digits(curve.high)))
}

/// How the values of a curve are scaled when it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scale {
    /// As all the others of the table.
    Common,
    /// From zero to its own largest.
    Own,
    /// From minus its own largest to plus that.
    Symmetric,
}

struct Row<'a> {
    shown: &'a Where,
    curve: Option<Curve>,
    scale: Scale,
    note: String,
}

/// A function of the direction of the field.
type OfDirection = fn([f64; 3]) -> f64;

/// Third-order harmonics of the direction, which no offset and no matrix takes away: name, value, and what to draw
/// against (along a single axis the direction itself).
const HARMONICS: [(&str, OfDirection, OfDirection); 7] = [
    ("x", |[x, _, _]| x * (5.0 * x * x - 3.0), |[x, _, _]| x),
    ("y", |[_, y, _]| y * (5.0 * y * y - 3.0), |[_, y, _]| y),
    ("z", |[_, _, z]| z * (5.0 * z * z - 3.0), |[_, _, z]| z),
    ("xy²−xz²", |[x, y, z]| x * (y * y - z * z), |[x, y, z]| x * (y * y - z * z)),
    ("yz²−yx²", |[x, y, z]| y * (z * z - x * x), |[x, y, z]| y * (z * z - x * x)),
    ("zx²−zy²", |[x, y, z]| z * (x * x - y * y), |[x, y, z]| z * (x * x - y * y)),
    ("xyz", |[x, y, z]| x * y * z, |[x, y, z]| x * y * z),
];

/// The residual against the function of the direction that it follows most.
fn attitude(base: &Residuals, directions: &[[f64; 3]]) -> (Option<Curve>, String) {
    let values = |of: OfDirection| directions.iter().map(|u| of(*u)).collect::<Vec<f64>>();
    let best = HARMONICS
        .iter()
        .map(|(name, value, abscissa)| (base.share(&values(*value)), name, abscissa))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, name, abscissa)) = best else { return (None, String::new()) };
    let curve = base.means(&values(*abscissa));
    let note = curve.as_ref().map_or(String::new(), |curve| {
        format!("±{}, {name}", significant(largest(curve) * chosen().per_ut(), 2))
    });
    (curve, note)
}

fn rows<'a>(diagnosed_log: &DiagnosedLog<'a>) -> Vec<Row<'a>> {
    let diagnosis = diagnosed_log.diagnosis;
    let traces = &diagnosis.traces;
    let base = residuals(diagnosis, false);
    let row = |shown: &'a Where| {
        let (curve, scale, note) = match shown.against.as_str() {
            "attitude" => {
                let (curve, note) = attitude(&base, &traces.directions);
                (curve, Scale::Symmetric, note)
            }
            "spectrum" => {
                let time = values(diagnosed_log.log, &traces.rows, "time");
                match time.zip(traces.base_ut.first()).and_then(|(time, r)| spectrum(&time, r)) {
                    Some((curve, hz, amplitude)) => {
                        (Some(curve), Scale::Own, format!("{}, {hz:.1} Hz", field(amplitude)))
                    }
                    None => (None, Scale::Own, String::new()),
                }
            }
            "rate of turn" => {
                let curve = turning(diagnosed_log.log, &traces.rows).and_then(|x| base.spread(&x));
                let top = curve.as_ref().map_or(0.0, |curve| limits(std::iter::once(curve), 1e-9).1);
                (curve, Scale::Own, format!("rms, █ is {}", field(top)))
            }
            name => {
                let curve = values(diagnosed_log.log, &traces.rows, name).and_then(|x| base.against(&x));
                let note = curve.as_ref().map_or(String::new(), |curve| what(curve).to_string());
                (curve, Scale::Common, note)
            }
        };
        Row { shown, curve, scale, note }
    };
    let possible = |shown: &&Where| shown.against != "rate of turn" || diagnosed_log.log.gyro_radps.is_some();
    diagnosis.shows.iter().filter(possible).map(row).collect()
}

/// The largest size of a curve's values, µT.
fn largest(curve: &Curve) -> f64 {
    curve.values.iter().flatten().fold(1e-9, |top, value| top.max(value.abs()))
}

/// How fast the board turns at each sample, rad/s.
fn turning(log: &Log, rows: &[usize]) -> Option<Vec<f64>> {
    let gyro = log.gyro_radps.as_ref()?;
    let rate =
        |row: usize| gyro.iter().map(|axis| axis.get(row).map_or(f64::NAN, |w| w * w)).sum::<f64>().sqrt();
    Some(rows.iter().map(|&row| rate(row)).collect())
}

/// A dependence with a larger p-value is not significant.
const MAX_P_VALUE: f64 = 0.02;

/// The table.
pub fn failures(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    if diagnosis.shows.is_empty() {
        return;
    }
    let all = rows(diagnosed_log);
    let common = |row: &&Row| row.scale == Scale::Common;
    let (bottom, top) =
        limits(all.iter().filter(common).filter_map(|row| row.curve.as_ref()), least_span(diagnosis));
    let nowhere = diagnosis.shows.iter().all(|shown| shown.p_value >= MAX_P_VALUE);
    title(
        out,
        if nowhere && diagnosis.verdict == Verdict::Undetermined {
            "Residual by column (the log does not determine the base model)"
        } else if nowhere && diagnosis.verdict == Verdict::Unexplained {
            "Residual by column (no logged column is significant)"
        } else if nowhere {
            "Residual by column (none is significant)"
        } else if diagnosis.verdict == Verdict::Complete {
            "Residual by column (significant, but too small to matter)"
        } else {
            "Residual by column"
        },
    );
    let drawn = all.iter().any(|row| row.curve.is_some());
    let scale = if drawn {
        format!("   residual: ▁ is {}, █ is {}", microtesla(bottom), field(top))
    } else {
        String::new()
    };
    out.push(format!("  {:<NAME$}{:>8} {:>8}{scale}", "column", "explains", "p-value"));
    // The ends of the axes in a column of their own, so that the curves stand below each other.
    let ends: Vec<(String, String)> = all
        .iter()
        .map(|row| {
            row.curve.as_ref().map_or_else(Default::default, |curve| axis_label(&row.shown.against, curve))
        })
        .collect();
    let left = ends.iter().map(|(low, _)| low.chars().count()).max().unwrap_or(0);
    let right = ends.iter().map(|(_, high)| high.chars().count()).max().unwrap_or(0);
    for (row, (low, high)) in all.iter().zip(&ends).take(MOST) {
        let label = shorten(label(&row.shown.against), NAME - 1);
        let mut text = format!(
            "  {label:<NAME$}{:>8} {:>8}",
            percent(row.shown.explained),
            probability(row.shown.p_value)
        );
        if let Some(curve) = &row.curve {
            let (bottom, top) = match row.scale {
                Scale::Common => (bottom, top),
                Scale::Own => (0.0, limits(std::iter::once(curve), 1e-9).1),
                Scale::Symmetric => (-largest(curve), largest(curve)),
            };
            let line = sparkline(&curve.values, bottom, top);
            text.push_str(&format!("   {low:>left$} {line} {high:<right$}  {}", row.note));
        }
        out.push(text.trim_end().to_string());
    }
    if all.len() > MOST {
        out.push(format!("  and {} more columns that explain less", all.len() - MOST));
    }
    if drawn {
        let mut note = String::from(
            "explains: share of the residual variance (R²). p-value: corrected for all columns and effects tested.",
        );
        if all.iter().any(|row| row.curve.as_ref().is_some_and(|curve| curve.offset)) {
            note.push_str(if at_rest(diagnosis) {
                " local offset: reading of the sensor at rest, along the direction of its largest variation."
            } else {
                " local offset: best additional offset for this part of the log."
            });
        }
        if all.iter().any(|row| row.scale == Scale::Symmetric && row.curve.is_some()) {
            note.push_str(
                " orientation: residual against the field direction in sensor axes. The last column is its amplitude.",
            );
        }
        out.extend(wrap(&note, "  ", WIDTH));
    }
}

fn shorten(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        text.to_string()
    } else {
        text.chars().take(most - 1).chain(['…']).collect()
    }
}
