//! The sides of the board, as bits.

/// The sides of a board, as bits: front-left is IRONOUT_SIDE_FRONT | IRONOUT_SIDE_LEFT. The axes are x forward, y right,
/// z down.
// The names are those of C.
#[allow(non_camel_case_types)]
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IronoutSide {
    /// +x.
    IRONOUT_SIDE_FRONT = 1,
    /// -x.
    IRONOUT_SIDE_BACK = 2,
    /// +y.
    IRONOUT_SIDE_RIGHT = 4,
    /// -y.
    IRONOUT_SIDE_LEFT = 8,
    /// +z.
    IRONOUT_SIDE_BOTTOM = 16,
    /// -z.
    IRONOUT_SIDE_TOP = 32,
}

/// Each side with its word, in the order of the words in a name.
const WORDS: [(IronoutSide, &str); 6] = {
    use IronoutSide::*;
    [
        (IRONOUT_SIDE_FRONT, "front"),
        (IRONOUT_SIDE_BACK, "back"),
        (IRONOUT_SIDE_LEFT, "left"),
        (IRONOUT_SIDE_RIGHT, "right"),
        (IRONOUT_SIDE_TOP, "top"),
        (IRONOUT_SIDE_BOTTOM, "bottom"),
    ]
};

/// The bits of a name like `front-left`; 0 for `any`.
pub(crate) fn bits_of(name: &str) -> u32 {
    let is_named =
        |word: &str| name.as_bytes().split(|byte| *byte == b'-').any(|part| part == word.as_bytes());
    WORDS.iter().filter(|(_, word)| is_named(word)).fold(0, |bits, (side, _)| bits | *side as u32)
}

/// The words of bits, with the hyphens between them: at most five parts. `any` for 0.
pub(crate) fn words_of(bits: u32) -> [&'static str; 5] {
    let mut parts = [""; 5];
    let mut place = parts.iter_mut();
    let named = WORDS.iter().filter(|(side, _)| bits & *side as u32 != 0).map(|(_, word)| *word);
    for (index, word) in named.enumerate() {
        if index > 0
            && let Some(part) = place.next()
        {
            *part = "-";
        }
        if let Some(part) = place.next() {
            *part = word;
        }
    }
    if let ["", rest @ ..] = parts {
        let [a, b, c, d] = rest;
        return ["any", a, b, c, d];
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::{bits_of, words_of};
    use ironout::coverage::side_name;

    #[test]
    fn every_name_of_a_side_has_its_bits_and_its_words_again() {
        for x in [-1.0f32, 0.0, 1.0] {
            for y in [-1.0f32, 0.0, 1.0] {
                for z in [-1.0f32, 0.0, 1.0] {
                    let name = side_name([x, y, z]);
                    assert_eq!(words_of(bits_of(name)).concat(), name);
                }
            }
        }
        assert_eq!(bits_of("front-left"), 1 | 8);
    }
}
