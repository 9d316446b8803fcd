//! Effects of like-named columns that belong together: motor currents of one vehicle, axes of another sensor.

use ironout::effect::Registry;
use serde::Serialize;

/// Effects of one kind whose columns differ by a number, or by the letter of an axis.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Block {
    /// What the names have in common, with `#` where they differ.
    pub like: String,
    /// Ids, in the order in which they were found.
    pub ids: Vec<String>,
    /// Columns, in the same order.
    pub columns: Vec<String>,
}

/// What names like this one have in common: each number as `#`, or one letter of an axis that stands alone in its word.
fn templates(name: &str) -> Vec<String> {
    let mut list = Vec::new();
    let mut numbered = String::new();
    for letter in name.chars() {
        match letter.is_ascii_digit() {
            true if numbered.ends_with('#') => {}
            true => numbered.push('#'),
            false => numbered.push(letter),
        }
    }
    if numbered != name {
        list.push(numbered);
    }
    let letters: Vec<char> = name.chars().collect();
    let is_apart = |at: Option<usize>| {
        at.and_then(|at| letters.get(at)).is_none_or(|letter| !letter.is_ascii_alphabetic())
    };
    for (at, letter) in letters.iter().enumerate() {
        let alone = is_apart(at.checked_sub(1)) && is_apart(Some(at + 1));
        if matches!(letter, 'x' | 'y' | 'z' | 'X' | 'Y' | 'Z') && alone {
            let other = |(place, own): (usize, &char)| if place == at { '#' } else { *own };
            list.push(letters.iter().enumerate().map(other).collect());
        }
    }
    list
}

/// The blocks among these ids: two members or more of one kind and form.
pub fn blocks(ids: &[&str], registry: Registry) -> Vec<Block> {
    let named: Vec<_> = ids.iter().map(|id| registry.parse(id).filter(|named| named.form.column)).collect();
    let mut list: Vec<Block> = Vec::new();
    for (at, own) in named.iter().enumerate() {
        let Some(own) = own.filter(|_| !list.iter().any(|block| block.ids.iter().any(|id| id == ids[at])))
        else {
            continue;
        };
        let members = |like: &String| -> Vec<usize> {
            let belongs = |place: &usize| {
                named[*place].is_some_and(|other| {
                    (other.family.kind(), other.form) == (own.family.kind(), own.form)
                        && templates(other.column).contains(like)
                })
            };
            (at..ids.len()).filter(belongs).collect()
        };
        let best = templates(own.column).into_iter().map(|like| (members(&like), like));
        let Some((members, like)) = best.max_by_key(|(members, _)| members.len()) else { continue };
        if members.len() > 1 {
            let columns = members.iter().filter_map(|&place| Some(named[place]?.column.to_string()));
            list.push(Block {
                like,
                columns: columns.collect(),
                ids: members.iter().map(|&place| ids[place].to_string()).collect(),
            });
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(ids: &[&str]) -> Vec<(String, usize)> {
        let list = blocks(ids, Registry::BUILT_IN);
        list.into_iter().map(|block| (block.like, block.ids.len())).collect()
    }

    #[test]
    fn motors_and_axes_are_blocks_and_others_are_not() {
        let motors = ["offset:esc1_a", "drift", "offset:esc4_a", "offset:esc2_a"];
        assert_eq!(found(&motors), [("esc#_a".to_string(), 3)]);
        assert_eq!(found(&["offset:coil_x_a", "offset:coil_z_a"]), [("coil_#_a".to_string(), 2)]);
        assert_eq!(found(&["offset:motor[0]", "offset:motor[3]"]), [("motor[#]".to_string(), 2)]);
        // Of one kind and form only, and never a column alone.
        assert_eq!(found(&["offset:esc1_a", "gain:esc2_a", "offset:esc3_a^2", "offset:temp_c"]), []);
        assert_eq!(found(&["offset:max_a", "offset:may_a"]), []);
    }
}
