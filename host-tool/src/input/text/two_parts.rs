//! A time in two columns: whole seconds, and their milli-, micro- or nanoseconds.

use crate::input::names::{Kind, meaning};
use crate::input::text::grid::Grid;
use crate::input::text::table::MONITOR;
use crate::input::unit::{Quantity, Unit};

/// Without names, the fraction must have begun again this many times: fewer happen by chance.
const MIN_TURNS: usize = 3;
/// Rows that may lie before the one above, as a share: a recorder that started again.
const MAX_BACKWARD: f64 = 0.02;
/// What a second is in the fraction, and its unit.
const FRACTIONS: [(f64, &str); 3] = [(1e3, "ms"), (1e6, "us"), (1e9, "ns")];

/// Joins the two columns into the one of the seconds. Columns that `--map` names are left as they are, but for the seconds as time.
pub fn join(grid: &mut Grid, map: &[(String, String)]) {
    let found =
        (0..grid.columns.len().saturating_sub(1)).find_map(|first| Some((first, fraction(grid, first)?)));
    let Some((first, (scale, unit))) = found else { return };
    let header =
        |index: usize| grid.columns.get(index).map(|column| column.header.clone()).unwrap_or_default();
    let (seconds, part) = (header(first), header(first + 1));
    let named = |header: &str, from: &String| {
        from == header || from.strip_prefix(header).is_some_and(|rest| rest.starts_with('['))
    };
    let is_time = |name: &str| name.starts_with("t_");
    let taken =
        map.iter().any(|(name, from)| named(&part, from) || (named(&seconds, from) && !is_time(name)));
    if taken {
        return;
    }
    let fraction = grid.columns.remove(first + 1);
    if let Some(column) = grid.columns.get_mut(first) {
        of_minute(&mut column.values);
        column.values.iter_mut().zip(&fraction.values).for_each(|(value, part)| *value += part / scale);
        column.unit = Unit::of("s", Quantity::Time);
    }
    grid.joined_time = Some((seconds, part, unit));
}

/// Seconds of a minute run on over its end.
fn of_minute(seconds: &mut [f64]) {
    if !seconds.iter().filter(|value| value.is_finite()).all(|value| (0.0..60.0).contains(value)) {
        return;
    }
    let (mut add, mut last) = (0.0, f64::NEG_INFINITY);
    for value in seconds.iter_mut().filter(|value| value.is_finite()) {
        if *value + 30.0 < last {
            add += 60.0;
        }
        last = *value;
        *value += add;
    }
}

/// What a second is in the column behind this one, if the two are a time.
fn fraction(grid: &Grid, first: usize) -> Option<(f64, &'static str)> {
    let (seconds, part) = (grid.columns.get(first)?, grid.columns.get(first + 1)?);
    if seconds.header == MONITOR || part.header == MONITOR || grid.rows() < 3 {
        return None;
    }
    let (named, units) = if grid.named {
        // Names that speak of seconds and of a part of them.
        let unit_of = |header: &str| {
            let found = meaning(header);
            let words = header.to_lowercase();
            let by_word = words
                .rsplit(['.', '_', ' ', '/', ':'])
                .next()
                .and_then(|word| Unit::of(word, Quantity::Time));
            (found.kind == Kind::Time || by_word.is_some()).then(|| found.unit.or(by_word)).flatten()
        };
        if unit_of(&seconds.header)?.name != "s" {
            return None;
        }
        let unit = unit_of(&part.header)?;
        (true, FRACTIONS.into_iter().filter(|(_, name)| *name == unit.name).collect::<Vec<_>>())
    } else if first == 0 {
        (false, FRACTIONS.to_vec())
    } else {
        return None;
    };
    let whole = |values: &[f64]| values.iter().all(|v| !v.is_finite() || (*v >= 0.0 && v.fract() == 0.0));
    if !whole(&seconds.values) || !whole(&part.values) {
        return None;
    }
    let mut running = seconds.values.clone();
    of_minute(&mut running);
    let pairs: Vec<(f64, f64)> = running
        .iter()
        .zip(&part.values)
        .map(|(s, p)| (*s, *p))
        .filter(|(s, p)| s.is_finite() && p.is_finite())
        .collect();
    let most = pairs.iter().map(|(_, part)| *part).fold(0.0, f64::max);
    let turns = pairs.windows(2).filter(|w| w[1].1 < w[0].1).count();
    let moves = pairs.windows(2).any(|w| w[1] != w[0]);
    // How unlike the steps over a full second are to the others: of the right unit, least.
    let unlike = |scale: f64| {
        let steps = |turned: bool| {
            let chosen = pairs.windows(2).filter(|w| (w[1].0 != w[0].0) == turned);
            let mut steps: Vec<f64> = chosen.map(|w| w[1].0 - w[0].0 + (w[1].1 - w[0].1) / scale).collect();
            steps.sort_by(f64::total_cmp);
            steps.get(steps.len() / 2).copied()
        };
        match (steps(true), steps(false)) {
            (Some(over), Some(within)) if over > 0.0 && within > 0.0 => (over / within).ln().abs(),
            (Some(_), None) => 0.0,
            _ => f64::INFINITY,
        }
    };
    let forward = |scale: f64| {
        let backward = pairs.windows(2).filter(|w| w[1].0 + w[1].1 / scale < w[0].0 + w[0].1 / scale).count();
        backward as f64 <= MAX_BACKWARD * pairs.len() as f64
    };
    let fits = units.into_iter().filter(|(scale, _)| most < *scale && forward(*scale));
    let best = fits.min_by(|a, b| unlike(a.0).total_cmp(&unlike(b.0)))?;
    (moves && (named || (turns >= MIN_TURNS && unlike(best.0) < 1.0))).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::text::grid::GridColumn;

    fn grid(names: Option<[&str; 2]>, scale: f64, step: f64) -> Grid {
        let mut grid = Grid { named: names.is_some(), lines: (1..=200).collect(), ..Grid::default() };
        let names = names.unwrap_or(["column 1", "column 2"]);
        let mut columns = names.map(GridColumn::new);
        for row in 0..200 {
            let t = 43.3 + step * f64::from(row);
            let part = ((t - t.floor()) * scale).round().min(scale - 1.0);
            columns[0].values.push(t.floor());
            columns[1].values.push(part);
        }
        grid.columns.extend(columns);
        grid.columns.push(GridColumn { values: vec![1.0; 200], ..GridColumn::new("column 3") });
        grid
    }

    #[test]
    fn seconds_and_their_parts_are_one_time() {
        for (scale, unit) in FRACTIONS {
            for step in [0.4, 0.03, 1.7] {
                let mut found = grid(None, scale, step);
                join(&mut found, &[]);
                assert_eq!(found.joined_time.as_ref().map(|j| j.2), Some(unit), "{scale} {step}");
                let last = found.columns[0].values[199];
                assert!((last - (43.3 + 199.0 * step)).abs() < 2e-3, "{last}");
                assert_eq!(found.columns.len(), 2);
            }
        }
        for names in [
            ["sec", "nanosec"],
            ["stamp.secs", "stamp.nsecs"],
            ["Seconds", "Nanoseconds"],
            ["tv_sec", "tv_nsec"],
        ] {
            let mut found = grid(Some(names), 1e9, 0.1);
            join(&mut found, &[]);
            assert_eq!(found.joined_time.as_ref().map(|j| j.2), Some("ns"), "{names:?}");
        }
        // Two sensors' numbers are not time, nor is a column that the user has named.
        let mut minute = grid(None, 1e3, 0.4);
        minute.columns[0].values.iter_mut().for_each(|value| *value %= 60.0);
        join(&mut minute, &[]);
        assert!((minute.columns[0].values[199] - (43.3 + 199.0 * 0.4)).abs() < 2e-3);
        let mut other = grid(None, 1e3, 0.4);
        other.columns[1].values.reverse();
        join(&mut other, &[]);
        assert!(other.joined_time.is_none());
        let mut stated = grid(Some(["sec", "nanosec"]), 1e9, 0.1);
        join(&mut stated, &[("t_s".into(), "nanosec[ns]".into())]);
        assert!(stated.joined_time.is_none());
    }
}
