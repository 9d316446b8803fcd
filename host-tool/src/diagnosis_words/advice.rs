//! What to record next: for effects that a log cannot tell apart, and for columns that it lacks.

use ironout::effect::Registry;

/// The recording that would tell two effects apart, in the same words whichever of the two comes first.
pub fn separating(registry: Registry, first: &str, second: &str) -> String {
    let (first, second) = if first <= second { (first, second) } else { (second, first) };
    let known = registry.parse(first).zip(registry.parse(second));
    known.and_then(|(first, second)| Some(first.apart(&second)?.to_string())).unwrap_or_else(|| {
        "record again for longer, in more orientations and at different speeds, with pauses".into()
    })
}

/// How to log the column that a reason asks for.
pub fn how_to_log(why: &str) -> Option<&'static str> {
    const COLUMNS: [(&str, &str); 7] = [
        ("temp_c", "the temperature register of the sensor, or a thermometer next to it, in °C"),
        (
            "current_a",
            "the current of the motors or the battery in A, from the power module or the controller",
        ),
        (
            "ax_mps2",
            "the accelerometer of the same sensor board, m/s², body axes; level and at rest az_mps2 = −9.8",
        ),
        ("gx_radps", "the gyroscope on the same board, rad/s, body axes"),
        ("t_s", "the time of each sample in seconds, from the logger's own clock"),
        ("heading_deg", "a reference heading in degrees, from a dual-antenna receiver or a turntable"),
        ("throttle", "the throttle as it is sent to the motors, 0 to 1"),
    ];
    COLUMNS.iter().find(|(name, _)| why.contains(name)).map(|(_, how)| *how)
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDS: [&str; 14] = [
        "offset:temp_c",
        "gain:temp_c",
        "offset:temp_c^2",
        "offset:current_a",
        "offset:current_a@delay",
        "offset:throttle",
        "field:height_m",
        "offset:servo",
        "drift",
        "step",
        "lag",
        "nonlinearity",
        "cross-axis",
        "periodic",
    ];

    #[test]
    fn every_pair_has_advice_that_does_not_depend_on_the_order() {
        for a in IDS {
            for b in IDS.into_iter().filter(|b| *b != a) {
                let text = separating(Registry::BUILT_IN, a, b);
                assert_eq!(text, separating(Registry::BUILT_IN, b, a), "{a} {b}");
                assert!(text.len() > 30 && text.ends_with('.'), "{a} {b}: {text}");
            }
        }
    }

    #[test]
    fn temperature_and_drift_are_separated_by_cooling() {
        let text = separating(Registry::BUILT_IN, "drift", "offset:temp_c");
        assert!(text.contains("cools down") && text.contains("constant temperature"), "{text}");
    }

    #[test]
    fn columns_are_explained() {
        assert!(how_to_log("no temperature column: log temp_c").is_some_and(|how| how.contains("°C")));
        assert_eq!(how_to_log("servo is constant"), None);
    }
}
