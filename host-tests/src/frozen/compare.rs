//! What changed against the snapshot: better or worse by the truth where it is known.

use crate::accuracy::injected::laid_column;
use crate::frozen::row::{HEADER, Row, WORDS};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Numbers may differ by this share before they count as changed: another host's sine differs in the last bit.
const MAX_RELATIVE_DIFFERENCE: f64 = 0.01;
/// Or by this much, µT: half a unit of what is printed for people.
const MAX_DIFFERENCE_UT: f64 = 0.005;
/// A vector error beyond so many times the predicted one counts as a prediction that does not hold.
const MAX_ERRORS_PREDICTED: f64 = 3.0;

/// How well a row answers, from 0 (somebody is falsely named) to 3 (all of it is right); `None` where nobody knows the truth.
pub fn merit(row: &Row) -> Option<u8> {
    let hidden = row.list("hidden");
    let named = row.list("named");
    let claims = ["complete", "missing"].contains(&row.cell("verdict"));
    match hidden.as_slice() {
        ["?"] => None,
        ["column missing"] => {
            let blames = named.iter().any(|id| !["drift", "step"].contains(id));
            Some(if claims || blames { 0 } else { 3 })
        }
        ["injected", effects @ ..] => {
            let of = |id: &str| laid_column(id).map(str::to_owned);
            let own: Vec<Option<String>> = effects.iter().map(|id| of(id)).collect();
            let falsely = named.iter().any(|id| laid_column(id).is_some() && !own.contains(&of(id)));
            let first = named.first().is_some_and(|id| effects.contains(id));
            Some(match (falsely, first || effects.is_empty()) {
                (true, _) => 0,
                (false, true) => 3,
                (false, false) if named.is_empty() => 1,
                (false, false) => 2,
            })
        }
        effects => {
            let confounded = row.list("confounded");
            let is_one_of = |id: &&str| confounded.contains(id) || named.contains(id);
            Some(if named.iter().any(|id| !effects.contains(id)) {
                0
            } else if named.len() == effects.len() && (!effects.is_empty() || claims) {
                3
            } else if !named.is_empty() || (!effects.is_empty() && effects.iter().all(is_one_of)) {
                2
            } else {
                1
            })
        }
    }
}

/// Whether the true error of the corrected vector is beyond what was predicted.
fn is_beyond(row: &Row) -> Option<bool> {
    let (error, predicted) = row.number("true_error_ut").zip(row.number("predicted_error_ut"))?;
    Some(error > MAX_ERRORS_PREDICTED * predicted)
}

fn is_close(old: &str, new: &str) -> bool {
    match (old.parse::<f64>(), new.parse::<f64>()) {
        (Ok(old), Ok(new)) => {
            (old - new).abs() <= (MAX_RELATIVE_DIFFERENCE * old.abs()).max(MAX_DIFFERENCE_UT)
        }
        _ => old == new,
    }
}

/// The columns in which two rows of one log differ.
pub fn changed(old: &Row, new: &Row) -> Vec<&'static str> {
    let differs = |place: &usize| match *place {
        place if place < WORDS => old.0[place] != new.0[place],
        // Coefficients are numbers behind words: they count as changed with the errors that they make.
        place if HEADER[place] == "coefficients" => false,
        place => !is_close(&old.0[place], &new.0[place]),
    };
    (0..HEADER.len()).filter(differs).map(|place| HEADER[place]).collect()
}

/// What became of one set.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
struct Tally {
    logs: usize,
    changed: usize,
    better: usize,
    worse: usize,
    /// Right in full, as far as the truth is known: before and after.
    right: [usize; 2],
    /// Falsely named or falsely claimed: before and after.
    false_names: [usize; 2],
    /// Vector errors beyond three times the predicted one: before and after.
    beyond: [usize; 2],
    /// Logs whose truth is known.
    known: usize,
}

/// A comparison in words, and whether anything changed.
pub struct Comparison {
    /// For people.
    pub text: String,
    /// Rows that differ, came or went.
    pub changed: usize,
}

/// Compares two sets of rows.
pub fn compare(old: &[Row], new: &[Row]) -> Comparison {
    let before: BTreeMap<(&str, &str), &Row> = old.iter().map(|row| (row.key(), row)).collect();
    let mut sets: Vec<(&str, Tally)> = Vec::new();
    let (mut lines, mut all_changed) = (Vec::new(), 0);
    for row in new {
        if sets.last().is_none_or(|(set, _)| *set != row.key().0) {
            sets.push((row.key().0, Tally::default()));
        }
        let Some((_, tally)) = sets.last_mut() else { continue };
        let old = before.get(&row.key()).copied();
        tally.logs += 1;
        let merits = [old.and_then(merit), merit(row)];
        tally.known += usize::from(merits[1].is_some());
        for (place, one) in merits.iter().enumerate() {
            tally.right[place] += usize::from(*one == Some(3));
            tally.false_names[place] += usize::from(*one == Some(0));
        }
        tally.beyond[0] += usize::from(old.and_then(is_beyond) == Some(true));
        tally.beyond[1] += usize::from(is_beyond(row) == Some(true));
        let Some(old) = old else {
            all_changed += 1;
            tally.changed += 1;
            lines.push((1, format!("new     {} {}: {}", row.key().0, row.key().1, said(row))));
            continue;
        };
        let columns = changed(old, row);
        if columns.is_empty() {
            continue;
        }
        all_changed += 1;
        tally.changed += 1;
        let word = match merits {
            [Some(old), Some(new)] if new > old => "better",
            [Some(old), Some(new)] if new < old => "worse",
            _ => "changed",
        };
        tally.better += usize::from(word == "better");
        tally.worse += usize::from(word == "worse");
        let order = ["worse", "better", "changed"].iter().position(|own| *own == word).unwrap_or(2);
        lines.push((order, line(word, old, row, &columns)));
    }
    let now: BTreeMap<(&str, &str), &Row> = new.iter().map(|row| (row.key(), row)).collect();
    for gone in old.iter().filter(|row| !now.contains_key(&row.key())) {
        all_changed += 1;
        lines.push((1, format!("gone    {} {}", gone.key().0, gone.key().1)));
    }
    lines.sort_by_key(|(order, _)| *order);
    let mut text = table(&sets);
    for (_, line) in &lines {
        let _ = writeln!(text, "{line}");
    }
    Comparison { text, changed: all_changed }
}

fn table(sets: &[(&str, Tally)]) -> String {
    let mut text = format!(
        "{:<20} {:>5} {:>8} {:>7} {:>6}   {:>13}   {:>13}   {:>20}\n",
        "set", "logs", "changed", "better", "worse", "right", "falsely named", "error over 3 predicted"
    );
    let mut sum = Tally::default();
    let arrow = |[old, new]: [usize; 2], of: usize| match of {
        0 => "-".to_owned(),
        _ if old == new => format!("{new} of {of}"),
        _ => format!("{old} -> {new} of {of}"),
    };
    let mut put = |set: &str, tally: &Tally| {
        let _ = writeln!(
            text,
            "{set:<20} {:>5} {:>8} {:>7} {:>6}   {:>13}   {:>13}   {:>20}",
            tally.logs,
            tally.changed,
            tally.better,
            tally.worse,
            arrow(tally.right, tally.known),
            arrow(tally.false_names, tally.known),
            arrow(tally.beyond, tally.logs),
        );
    };
    for (set, tally) in sets {
        put(set, tally);
        sum.logs += tally.logs;
        sum.changed += tally.changed;
        sum.better += tally.better;
        sum.worse += tally.worse;
        sum.known += tally.known;
        for place in 0..2 {
            sum.right[place] += tally.right[place];
            sum.false_names[place] += tally.false_names[place];
            sum.beyond[place] += tally.beyond[place];
        }
    }
    put("all", &sum);
    text.push('\n');
    text
}

fn said(row: &Row) -> String {
    let named = if row.cell("named").is_empty() { "nobody" } else { row.cell("named") };
    format!("{} names {named} (hidden: {})", row.cell("verdict"), row.cell("hidden"))
}

/// One changed log: words before and after, then numbers.
fn line(word: &str, old: &Row, new: &Row, columns: &[&str]) -> String {
    let mut text = format!("{word:<7} {} {} (hidden: {})", new.key().0, new.key().1, new.cell("hidden"));
    for column in columns {
        let cell = |row: &Row| match row.cell(column) {
            "" => "-".to_owned(),
            cell => cell.to_owned(),
        };
        let _ = write!(text, "; {column} {} -> {}", cell(old), cell(new));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(hidden: &str, verdict: &str, named: &str) -> Row {
        let mut cells: [String; HEADER.len()] = Default::default();
        let words = ["set", "log", hidden, verdict, named];
        cells.iter_mut().zip(words).for_each(|(cell, word)| word.clone_into(cell));
        Row(cells)
    }

    #[test]
    fn an_answer_is_worth_what_the_truth_says() {
        for (hidden, verdict, named, merit_of) in [
            ("", "complete", "", Some(3)),
            ("", "unexplained", "", Some(1)),
            ("", "missing", "step", Some(0)),
            ("drift", "missing", "drift", Some(3)),
            ("drift", "missing", "drift+step", Some(0)),
            ("drift+step", "unexplained", "drift", Some(2)),
            ("drift", "unexplained", "", Some(1)),
            ("column missing", "unexplained", "drift", Some(3)),
            ("column missing", "complete", "", Some(0)),
            ("column missing", "unexplained", "offset:fan_rpm", Some(0)),
            ("injected+offset:throttle", "unexplained", "offset:throttle", Some(3)),
            ("injected+offset:throttle", "unexplained", "offset:mode", Some(0)),
            ("injected+", "missing", "offset:pressure_hpa", Some(3)),
            ("?", "complete", "", None),
        ] {
            assert_eq!(merit(&row(hidden, verdict, named)), merit_of, "{hidden} {verdict} {named}");
        }
    }

    #[test]
    fn worse_and_better_are_counted_and_chance_digits_are_not() {
        let old = [row("", "complete", ""), row("drift", "missing", "drift")];
        let mut same = old.to_vec();
        same[0].0[7] = "50.0001".into();
        let mut before = old.to_vec();
        before[0].0[7] = "50.0000".into();
        before[1].0[1] = "two".into();
        same[1].0[1] = "two".into();
        assert_eq!(compare(&before, &same).changed, 0);
        let mut worse = same.clone();
        worse[1].0[4] = "step".into();
        let comparison = compare(&before, &worse);
        assert_eq!(comparison.changed, 1);
        assert!(
            comparison.text.contains("worse   set two (hidden: drift); named drift -> step"),
            "{}",
            comparison.text
        );
        worse.pop();
        assert!(compare(&before, &worse).text.contains("gone    set two"));
    }
}
