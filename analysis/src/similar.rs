//! Names that were probably meant by one that is unknown.

/// Known names in the order of their likeness to `name`; empty if none is alike.
pub fn similar<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = name.to_lowercase();
    let mut ranked: Vec<(usize, &str)> = known
        .into_iter()
        .map(|own| {
            let lower = own.to_lowercase();
            let inside =
                wanted.len() > 1 && lower.len() > 1 && (lower.contains(&wanted) || wanted.contains(&lower));
            (if inside { 1 } else { distance(&wanted, &lower) }, own)
        })
        .filter(|(distance, own)| {
            *distance <= (2 * own.chars().count().max(wanted.chars().count()) / 5).max(1)
        })
        .collect();
    // Of equally similar names the first comes first.
    ranked.sort_by_key(|(distance, _)| *distance);
    ranked.into_iter().map(|(_, own)| own).collect()
}

/// `Did you mean a or b?`; `None` if no known name is alike.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let names = similar(name, known);
    let first = names.get(..names.len().min(3)).filter(|names| !names.is_empty())?;
    Some(format!("Did you mean {}?", first.join(" or ")))
}

/// `Did you mean …?`, or all that are known.
pub fn or_all(name: &str, known: &[&str], what: &str) -> String {
    did_you_mean(name, known.iter().copied()).unwrap_or_else(|| {
        let all: String = known.join(", ").chars().take(300).collect();
        format!("the {what} are {all}")
    })
}

/// What to do about an id that is not an effect.
pub fn unknown_effect(id: &str, known: &[String]) -> String {
    let meant = did_you_mean(id, known.iter().map(String::as_str));
    let meant = meant.map_or(String::new(), |meant| format!(" {meant}"));
    format!("unknown effect.{meant} To list all, run: ironout effects LOG")
}

/// How many letters must be changed, added or removed.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        for (j, other) in b.iter().enumerate() {
            let above = row.get(j + 1).copied().unwrap_or(usize::MAX);
            let value = (diagonal + usize::from(letter != *other)).min(above + 1).min(left + 1);
            diagonal = above;
            if let Some(cell) = row.get_mut(j) {
                *cell = left;
            }
            left = value;
        }
        if let Some(last) = row.last_mut() {
            *last = left;
        }
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_name_and_a_slip_are_recognised() {
        let known = ["offset:current_a", "offset:temp_c", "drift"];
        assert_eq!(did_you_mean("current", known), Some("Did you mean offset:current_a?".into()));
        assert_eq!(did_you_mean("dritf", known), Some("Did you mean drift?".into()));
        assert_eq!(did_you_mean("nothing like it", known), None);
    }
}
