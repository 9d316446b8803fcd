//! The JSON answers are as `docs/schema/` says: every key, every type. A new or a missing key fails until its schema is changed.

use crate::common::{calibrate, folder, ironout, simulate, text};
use serde_json::Value;
use std::path::Path;

fn schema(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/schema").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("a schema is JSON")
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    }
}

/// What of a value is not as its schema says: of JSON Schema, the keywords that `docs/schema/` uses.
fn faults(value: &Value, schema: &Value, at: &str, out: &mut Vec<String>) {
    const KNOWN: [&str; 12] = [
        "$schema",
        "$id",
        "title",
        "description",
        "type",
        "required",
        "properties",
        "additionalProperties",
        "items",
        "enum",
        "minItems",
        "maxItems",
    ];
    let Some(rules) = schema.as_object() else { panic!("{at}: the schema is {schema}") };
    if let Some(unknown) = rules.keys().find(|key| !KNOWN.contains(&key.as_str())) {
        panic!("{at}: this test does not know the keyword {unknown}");
    }
    let is = kind(value);
    let fits = |wanted: &str| wanted == is || (wanted == "number" && is == "integer");
    let types: Vec<&str> = match &rules.get("type") {
        Some(Value::Array(list)) => list.iter().filter_map(Value::as_str).collect(),
        Some(Value::String(one)) => vec![one],
        _ => Vec::new(),
    };
    if !types.is_empty() && !types.into_iter().any(fits) {
        out.push(format!("{at} is {is}, not {}", rules["type"]));
        return;
    }
    if let Some(allowed) = rules.get("enum").and_then(Value::as_array)
        && !allowed.contains(value)
    {
        out.push(format!("{at} is {value}, not one of {allowed:?}"));
    }
    if let Some(object) = value.as_object() {
        for key in rules.get("required").and_then(Value::as_array).into_iter().flatten() {
            if !object.contains_key(key.as_str().expect("a key")) {
                out.push(format!("{at} has no {key}"));
            }
        }
        let properties = rules.get("properties").and_then(Value::as_object);
        for (key, value) in object {
            let at = format!("{at}.{key}");
            match (properties.and_then(|known| known.get(key)), rules.get("additionalProperties")) {
                (Some(schema), _) => faults(value, schema, &at, out),
                (None, Some(Value::Bool(false))) => out.push(format!("{at} is not in the schema")),
                (None, Some(schema @ Value::Object(_))) => faults(value, schema, &at, out),
                _ => {}
            }
        }
    }
    if let Some(list) = value.as_array() {
        let count = |key: &str| rules.get(key).and_then(Value::as_u64);
        if count("minItems").is_some_and(|least| (list.len() as u64) < least)
            || count("maxItems").is_some_and(|most| list.len() as u64 > most)
        {
            out.push(format!("{at} has {} entries", list.len()));
        }
        if let Some(schema) = rules.get("items") {
            list.iter()
                .enumerate()
                .for_each(|(place, one)| faults(one, schema, &format!("{at}[{place}]"), out));
        }
    }
}

#[track_caller]
fn keeps(value: &Value, name: &str, what: &str) {
    let mut out = Vec::new();
    faults(value, &schema(name), "$", &mut out);
    assert!(out.is_empty(), "{what} does not keep docs/schema/{name}:\n{}", out.join("\n"));
}

#[test]
fn answers_keep_their_schemas() {
    let here = folder("schemas");
    let seconds = ["--seconds", "100", "--seed", "17"];
    for (name, effects) in [
        ("clean", &[][..]),
        ("current", &["--effect", "offset:current_a=2"]),
        ("late", &["--effect", "offset:current_a@delay=3", "--effect", "lag=18ms"]),
        ("periodic", &["--effect", "periodic=3", "--effect", "gain:temp_c=3"]),
        ("ramp", &["--effect", "offset:temp_c=3", "--ramp"]),
        ("burst", &["--effect", "burst", "--without", "current_a"]),
        ("level", &["--motion", "planar"]),
        ("rest", &["--motion", "rest", "--effect", "offset:temp_c=3"]),
    ] {
        let log = simulate(&here, &format!("{name}.csv"), &[&seconds[..], effects].concat());
        keeps(&ironout(["fit", text(&log), "--json"]).json(), "fit.schema.json", name);
        keeps(&ironout(["diagnose", text(&log), "--json"]).json(), "diagnose.schema.json", name);
    }
    let log = here.join("current.csv");
    let add = ["--add", "offset:current_a"];
    let cal = calibrate(&here, &log, &add);
    let read = |path: &Path| -> Value {
        serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON")
    };
    keeps(&read(&cal), "calibration.schema.json", "cal.json");
    keeps(
        &ironout(["fit", text(&log), "--json", "--add", "offset:current_a"]).json(),
        "fit.schema.json",
        "with an effect",
    );
    for other in ["current.csv", "clean.csv", "level.csv", "burst.csv"] {
        let run = ironout(["check", text(&here.join(other)), "--cal", text(&cal), "--json"]);
        if run.status != 2 {
            keeps(&run.json(), "check.schema.json", other);
        }
    }
    // With a prior, and with a place.
    let prior = ["--prior", text(&cal), "--json"];
    keeps(&ironout(["fit", text(&log)].iter().chain(&prior)).json(), "fit.schema.json", "on a prior");
    keeps(
        &ironout(["diagnose", text(&log)].iter().chain(&prior)).json(),
        "diagnose.schema.json",
        "on a prior",
    );
}

#[test]
fn a_changed_key_is_noticed() {
    let here = folder("schemas_changed");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "1"]);
    let good = ironout(["fit", text(&log), "--json"]).json();
    let schema = schema("fit.schema.json");
    let wrong = |value: &Value| {
        let mut out = Vec::new();
        faults(value, &schema, "$", &mut out);
        out.len()
    };
    assert_eq!(wrong(&good), 0);
    let mut renamed = good.clone();
    let object = renamed.as_object_mut().expect("an object");
    let value = object.remove("rms_ut").expect("a key");
    object.insert("rms".into(), value);
    assert_eq!(wrong(&renamed), 2, "one key is missing, one is new");
    let mut retyped = good;
    retyped["accepted"] = "yes".into();
    assert_eq!(wrong(&retyped), 1);
}
