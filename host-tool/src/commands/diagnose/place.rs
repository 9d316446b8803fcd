//! Where the base model fails: against each column, time, attitude and in the spectrum.

use super::curve::{Curve, Residuals, limits, sparkline, spectrum};
use super::numbers::{microtesla, percent, probability, significant, unit_of};
use super::words::{Told, at_rest, title};
use crate::diagnose::outcome::{Diagnosis, Where};
use crate::input::Log;

/// More columns than this are summed up.
const MOST: usize = 12;
/// Width of a column's name.
const NAME: usize = 14;

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
pub fn against_column(told: &Told, column: &str) -> Option<(Curve, Curve)> {
    let x = values(told.log, &told.diagnosis.traces.rows, column)?;
    let before = residuals(told.diagnosis, false).against(&x)?;
    let after = residuals(told.diagnosis, true).like(&x, &before)?;
    Some((before, after))
}

/// What the values of a curve are.
pub fn what(curve: &Curve) -> &'static str {
    if curve.offset { "local offset" } else { "mean residual" }
}

/// Curves are drawn on at least this range, µT, so that noise looks flat.
pub fn least_span(diagnosis: &Diagnosis) -> f64 {
    diagnosis.residual_floor_ut.unwrap_or(0.0).max(1e-6)
}

/// The two ends of a curve's axis with their unit.
pub fn axis_label(against: &str, curve: &Curve) -> (String, String) {
    let unit = match against {
        "time" => " s",
        "spectrum" => " Hz",
        name => unit_of(name),
    };
    let digits =
        |value: f64| if value.abs() >= 1000.0 { format!("{value:.0}") } else { significant(value, 3) };
    (digits(curve.low), format!("{}{unit}", digits(curve.high)))
}

struct Row<'a> {
    shown: &'a Where,
    label: String,
    curve: Option<Curve>,
    note: String,
}

fn rows<'a>(told: &Told<'a>) -> Vec<Row<'a>> {
    let diagnosis = told.diagnosis;
    let series = &diagnosis.traces;
    let base = residuals(diagnosis, false);
    let mut list = Vec::new();
    for shown in &diagnosis.shows {
        let row = |label: &str, curve: Option<Curve>, note: String| Row {
            shown,
            label: label.to_string(),
            curve,
            note,
        };
        match shown.against.as_str() {
            "attitude" => {
                for (axis, name) in ["x", "y", "z"].iter().enumerate() {
                    let x: Vec<f64> = series.directions.iter().map(|u| u[axis]).collect();
                    let curve = base.means(&x);
                    let label = if axis == 0 { "attitude" } else { "" };
                    list.push(row(label, curve, format!("field along {name}")));
                }
            }
            "spectrum" => {
                let time = values(told.log, &series.rows, "time");
                let drawn = time.zip(series.base_ut.first()).and_then(|(time, r)| spectrum(&time, r));
                match drawn {
                    Some((curve, hz, amplitude)) => {
                        let note = format!("peak {} µT at {hz:.2} Hz", microtesla(amplitude));
                        list.push(row("spectrum", Some(curve), note));
                    }
                    None => list.push(row("spectrum", None, String::new())),
                }
            }
            name => {
                let curve = values(told.log, &series.rows, name).and_then(|x| base.against(&x));
                let note = curve.as_ref().map_or(String::new(), |curve| what(curve).to_string());
                list.push(row(name, curve, note));
            }
        }
    }
    list
}

/// The table.
pub fn failures(told: &Told, out: &mut Vec<String>) {
    let diagnosis = told.diagnosis;
    if diagnosis.shows.is_empty() {
        return;
    }
    let all = rows(told);
    let column = |row: &&Row| !["attitude", "spectrum"].contains(&row.shown.against.as_str());
    let (bottom, top) = limits(
        all.iter().filter(|row| row.shown.against != "spectrum").filter_map(|row| row.curve.as_ref()),
        least_span(diagnosis),
    );
    title(out, "Where the base model fails");
    let drawn = all.iter().any(|row| row.curve.is_some());
    let scale = if drawn {
        format!("   its residual: ▁ is {}, █ is {} µT", microtesla(bottom), microtesla(top))
    } else {
        String::new()
    };
    out.push(format!("  {:<NAME$}{:>9} {:>8}{scale}", "against", "explains", "chance"));
    // The ends of the axes in a column of their own, so that the curves stand below each other.
    let ends: Vec<(String, String)> = all
        .iter()
        .map(|row| {
            row.curve.as_ref().map_or_else(Default::default, |curve| axis_label(&row.shown.against, curve))
        })
        .collect();
    let left = ends.iter().map(|(low, _)| low.chars().count()).max().unwrap_or(0);
    let right = ends.iter().map(|(_, high)| high.chars().count()).max().unwrap_or(0);
    let columns = all.iter().filter(column).count();
    let (mut shown, mut hidden) = (0, 0);
    for (row, (low, high)) in all.iter().zip(&ends) {
        if column(&row) && columns > MOST {
            shown += 1;
            if shown > MOST {
                hidden += 1;
                continue;
            }
        }
        let (explains, chance) = if row.label.is_empty() {
            (String::new(), String::new())
        } else {
            (percent(row.shown.explained), probability(row.shown.p_value))
        };
        let label = shorten(&row.label, NAME - 1);
        let mut text = format!("  {label:<NAME$}{explains:>9} {chance:>8}");
        if let Some(curve) = &row.curve {
            let (bottom, top) = if row.shown.against == "spectrum" {
                let (_, top) = limits(std::iter::once(curve), 1e-9);
                (0.0, top)
            } else {
                (bottom, top)
            };
            text.push_str(&format!(
                "   {low:>left$} {} {high:<right$}  {}",
                sparkline(&curve.values, bottom, top),
                row.note
            ));
        }
        out.push(text.trim_end().to_string());
    }
    if hidden > 0 {
        out.push(format!("  and {hidden} more columns that explain less"));
    }
    if at_rest(diagnosis) && drawn {
        out.push(
            "  (the board rests: drawn is the vector along the direction in which it varies most)".into(),
        );
    }
}

fn shorten(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        text.to_string()
    } else {
        text.chars().take(most - 1).chain(['…']).collect()
    }
}
