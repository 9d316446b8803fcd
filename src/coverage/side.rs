//! The sides of a board, in words.

/// The name of the side a direction points through, in the board's axes: x front, y right, z bottom.
pub fn side_name(direction: [f32; 3]) -> &'static str {
    const NAMES: [&str; 27] = [
        "back-left-top",
        "back-left",
        "back-left-bottom",
        "back-top",
        "back",
        "back-bottom",
        "back-right-top",
        "back-right",
        "back-right-bottom",
        "left-top",
        "left",
        "left-bottom",
        "top",
        "any",
        "bottom",
        "right-top",
        "right",
        "right-bottom",
        "front-left-top",
        "front-left",
        "front-left-bottom",
        "front-top",
        "front",
        "front-bottom",
        "front-right-top",
        "front-right",
        "front-right-bottom",
    ];
    let third = |v: f32| {
        if v > 0.4 {
            2
        } else if v < -0.4 {
            0
        } else {
            1
        }
    };
    let place = third(direction[0]) * 9 + third(direction[1]) * 3 + third(direction[2]);
    NAMES.get(place).copied().unwrap_or("any")
}

#[cfg(test)]
mod tests {
    use super::side_name;

    #[test]
    fn each_axis_and_corner_has_its_side() {
        let cases = [
            ([1.0, 0.0, 0.0], "front"),
            ([-1.0, 0.0, 0.0], "back"),
            ([0.0, 1.0, 0.0], "right"),
            ([0.0, -1.0, 0.0], "left"),
            ([0.0, 0.0, 1.0], "bottom"),
            ([0.0, 0.0, -1.0], "top"),
            ([0.0, 0.0, 0.0], "any"),
        ];
        for (direction, name) in cases {
            assert_eq!(side_name(direction), name);
        }
        // A corner's name is put together of its axes' names, so that no entry of the table can be in another's place.
        for x in [-1.0f32, 0.0, 1.0] {
            for y in [-1.0f32, 0.0, 1.0] {
                for z in [-1.0f32, 0.0, 1.0] {
                    let word = |v: f32, positive, negative| {
                        if v > 0.0 {
                            positive
                        } else if v < 0.0 {
                            negative
                        } else {
                            ""
                        }
                    };
                    let words =
                        [word(x, "front", "back"), word(y, "right", "left"), word(z, "bottom", "top")];
                    let name = side_name([0.577 * x, 0.577 * y, 0.577 * z]);
                    let said = name.split('-').filter(|w| *w != "any");
                    assert!(said.eq(words.into_iter().filter(|w| !w.is_empty())), "{x} {y} {z}: {name}");
                }
            }
        }
    }
}
