//! The rates of the table of hidden effects, pooled over rows of a kind: twenty logs of a row say little by themselves.

use crate::accuracy::effect_table::{Case, Row};
use crate::rate::Rate;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_simulation::{EffectSpec, FaultSpec};

/// Kinds of rows, in the order of the table.
const KINDS: [&str; 7] = [
    "effects hidden",
    "nothing hidden",
    "confounded by its column",
    "too little attitude",
    "its column left out",
    "a fault alone",
    "an effect and a fault",
];

fn kind(case: &Case) -> &'static str {
    let any = |test: &dyn Fn(&str) -> bool| case.hidden.split(',').any(test);
    let effects = any(&|item| EffectSpec::parse(item).is_ok());
    let faults = any(&|item| FaultSpec::parse(item).is_ok());
    match (case.verdict, effects, faults) {
        (Verdict::Confounded, ..) => KINDS[2],
        (Verdict::Undetermined, ..) => KINDS[3],
        (Verdict::Unexplained, ..) => KINDS[4],
        (_, true, true) => KINDS[6],
        (_, true, false) => KINDS[0],
        (_, false, true) => KINDS[5],
        (_, false, false) => KINDS[1],
    }
}

/// One line a kind.
pub fn text(rows: &[(Case, Row)]) -> String {
    let mut text = String::from(
        "pooled, 95 % intervals    rows  logs  first                           exact                           right verdict\n",
    );
    for name in KINDS {
        let of_kind: Vec<&(Case, Row)> = rows.iter().filter(|(case, _)| kind(case) == name).collect();
        let of: u64 = of_kind.iter().map(|(_, row)| u64::from(row.logs)).sum();
        if of == 0 {
            continue;
        }
        // What the rows above leave open is left open here.
        let rate = |count: fn(&Row) -> u32, asked: fn(Verdict) -> bool| {
            let asked = of_kind.iter().all(|(case, _)| asked(case.verdict));
            let count = of_kind.iter().map(|(_, row)| u64::from(count(row))).sum();
            Rate { count, of: if asked { of } else { 0 } }
        };
        let first = rate(|row| row.named_first, |verdict| verdict == Verdict::Missing);
        let exact = rate(
            |row| row.exact,
            |verdict| matches!(verdict, Verdict::Missing | Verdict::Complete | Verdict::Unexplained),
        );
        let right = rate(|row| row.verdict, |_| true);
        text += &format!("{name:<25} {:>4} {of:>5}  {first:<31} {exact:<31} {right}\n", of_kind.len());
    }
    text
}
