//! What to record next: for effects that a log cannot tell apart, and for columns that it lacks.

/// The kinds of effects as far as advice differs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind<'a> {
    Temperature(&'a str),
    Current(&'a str),
    /// Any other column.
    Column(&'a str),
    Drift,
    Step,
    Periodic,
    Lag,
    Nonlinearity,
    CrossAxis,
    Other,
}

fn column_of(id: &str) -> Option<&str> {
    id.split_once(':').map(|(_, rest)| rest.split(['^', '@']).next().unwrap_or(rest))
}

fn kind(id: &str) -> Kind<'_> {
    match column_of(id) {
        Some(column) if column.ends_with("_c") => Kind::Temperature(column),
        Some(column) if column.ends_with("_a") || column.contains("throttle") || column.contains("motor") => {
            Kind::Current(column)
        }
        Some(column) => Kind::Column(column),
        None => match id {
            "drift" => Kind::Drift,
            "step" => Kind::Step,
            "periodic" => Kind::Periodic,
            "lag" => Kind::Lag,
            "nonlinearity" => Kind::Nonlinearity,
            "cross-axis" => Kind::CrossAxis,
            _ => Kind::Other,
        },
    }
}

/// The recording that would tell two effects apart.
pub fn separating(first: &str, second: &str) -> String {
    let (first, second) = if first <= second { (first, second) } else { (second, first) };
    ordered(first, second).or_else(|| ordered(second, first)).unwrap_or_else(|| {
        "record again for longer, through more attitudes and at different speeds, with pauses".into()
    })
}

fn ordered(first: &str, second: &str) -> Option<String> {
    use Kind::*;
    if let (Some(a), Some(b)) = (column_of(first), column_of(second))
        && a == b
    {
        return Some(same_column(first, second, a));
    }
    let text = match (kind(first), kind(second)) {
        (Temperature(column), Drift) => format!(
            "{column} only ever went one way, as the clock does. Log while it warms up and while it cools down again; \
             or warm the board up first and then turn it at constant temperature: an error that goes on is drift."
        ),
        (Temperature(column), Step) => format!(
            "let {column} change slowly and go back to where it began: what stays afterwards is a step, what goes away \
             is temperature."
        ),
        (Temperature(heat), Current(current)) => format!(
            "{heat} follows {current}. Warm the board with {current} at zero (a hair dryer), or switch {current} on and \
             off faster than the board warms, and log that."
        ),
        // The other way round it is the case above.
        (Current(_), Temperature(_)) => return None,
        (Temperature(a) | Current(a) | Column(a), Temperature(b) | Current(b) | Column(b)) => {
            format!("log again, changing {a} while {b} stays, and then {b} while {a} stays.")
        }
        (Current(column), Drift | Step) => format!(
            "switch {column} on and off several times in one log, at uneven intervals, while the board turns: only what \
             comes and goes with it is {column}."
        ),
        (Column(column), Drift) => {
            format!("log again, taking {column} up and down several times: a drift does not turn back.")
        }
        (Column(column), Step) => {
            format!("log again, changing {column} several times: a step does not happen again.")
        }
        (Drift, Step) => {
            "record for at least twice as long: a drift goes on, a step stays where it is.".into()
        }
        (Periodic, Temperature(column) | Current(column) | Column(column)) => format!(
            "log {column} and the field at another sampling rate: a frequency folded by sampling moves, {column} does \
             not."
        ),
        (Periodic, _) => {
            "record again at another sampling rate: a frequency folded by sampling moves to another place.".into()
        }
        (Nonlinearity, CrossAxis) => {
            "record every direction evenly, then again with a small magnet fixed near the sensor (a large offset): \
             squares and products of axes grow differently with it."
                .into()
        }
        (Nonlinearity | CrossAxis, Temperature(column) | Current(column) | Column(column)) => {
            format!(
                "hold {column} constant through one log of all directions: what is left is the sensor itself."
            )
        }
        (Nonlinearity | CrossAxis, Drift | Step) => {
            "go through all directions twice in one log: the sensor's own errors repeat, what depends on time does \
             not."
                .into()
        }
        (Lag, Nonlinearity | CrossAxis) => {
            "go through the same directions once slowly and once fast: only lag and eddy currents know the speed."
                .into()
        }
        (Lag, _) => {
            "turn the same way once slowly and once fast, and both ways round: lag and eddy currents change with the \
             speed, nothing else does."
                .into()
        }
        _ => return None,
    };
    Some(text)
}

fn same_column(first: &str, second: &str, column: &str) -> String {
    let late = |id: &str| id.contains('@');
    let square = |id: &str| id.contains('^');
    if late(first) != late(second) {
        return format!(
            "change {column} abruptly, several times: a late effect then trails visibly behind it."
        );
    }
    if square(first) != square(second) {
        return format!(
            "take {column} through its whole range, and both signs if it has two: a square does not change sign."
        );
    }
    format!(
        "turn the board through all directions at the lowest {column}, and again at the highest: an offset is the same in \
         every direction, a gain or a change of the field is not."
    )
}

/// How to log the column that a reason asks for.
pub fn how_to_log(why: &str) -> Option<&'static str> {
    const COLUMNS: [(&str, &str); 7] = [
        ("temp_c", "the sensor's own temperature register, or a thermometer glued beside it, in °C"),
        (
            "current_a",
            "the current of the motors or the battery in A, from the power module or the controller",
        ),
        (
            "ax_mps2",
            "the accelerometer on the same board, m/s², body axes; at rest and level it reads az_mps2 = −9.8",
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
    fn every_pair_has_advice_that_names_its_columns_and_does_not_depend_on_the_order() {
        for a in IDS {
            for b in IDS {
                if a == b {
                    continue;
                }
                let text = separating(a, b);
                assert_eq!(text, separating(b, a), "{a} {b}");
                assert!(text.len() > 30 && text.ends_with('.'), "{a} {b}: {text}");
                for (id, other) in [(a, b), (b, a)] {
                    let both_timed = ["lag"].contains(&other) || ["lag"].contains(&id);
                    if let Some(column) = column_of(id)
                        && !both_timed
                    {
                        assert!(text.contains(column), "{a} {b}: {text}");
                    }
                }
            }
        }
    }

    #[test]
    fn temperature_and_drift_are_separated_by_cooling() {
        let text = separating("drift", "offset:temp_c");
        assert!(text.contains("cools down") && text.contains("constant temperature"), "{text}");
    }

    #[test]
    fn columns_are_explained() {
        assert!(how_to_log("no temperature column: log temp_c").is_some_and(|how| how.contains("°C")));
        assert_eq!(how_to_log("servo is constant"), None);
    }
}
