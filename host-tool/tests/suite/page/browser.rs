//! A scenario of the browser, and what it has seen.

use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

const REQUIRE: &str = "IRONOUT_REQUIRE_CHROMIUM";

/// One browser at a time.
static TURN: Mutex<()> = Mutex::new(());

pub fn node_side() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tests/web")
}

/// What is missing to drive a browser.
fn missing() -> Option<String> {
    let runs = |program: &str| {
        let run = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        run.is_ok_and(|status| status.success())
    };
    let browser = std::env::var("CHROMIUM").ok().filter(|program| runs(program)).is_some()
        || ["chromium", "chromium-browser", "google-chrome"].into_iter().any(runs);
    if !browser {
        Some("there is no Chromium (apt-get install chromium, or CHROMIUM=its path)".into())
    } else if !runs("node") {
        Some("there is no Node".into())
    } else if !node_side().join("node_modules/playwright-core").exists() {
        Some("its driver is not installed (npm ci in host-tests/web)".into())
    } else {
        None
    }
}

/// The turn of a test, or `None` and a word where there is no browser.
pub fn turn(test: &str) -> Option<MutexGuard<'static, ()>> {
    if let Some(why) = missing() {
        assert!(std::env::var(REQUIRE).as_deref() != Ok("1"), "{REQUIRE}=1, but {why}");
        // Written directly: the test harness swallows eprintln!.
        let _ = writeln!(std::io::stderr(), "{test}: skipped: {why}");
        return None;
    }
    Some(TURN.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Runs a scenario; what the browser complained of fails the test.
pub fn scenario(name: &str, mut given: Value) -> Value {
    let shots = std::env::var("IRONOUT_SCREENSHOTS").ok();
    given["shots"] = shots.map_or(Value::Null, |dir| Value::from(format!("{dir}/{name}")));
    let run = Command::new("node")
        .current_dir(node_side())
        .args(["run.js", name, &given.to_string()])
        .output()
        .expect("node runs");
    let said = String::from_utf8_lossy(&run.stdout);
    let seen: Value = serde_json::from_str(said.trim())
        .unwrap_or_else(|error| panic!("{name}: {error}: {said}\n{}", String::from_utf8_lossy(&run.stderr)));
    assert_eq!(seen["wrong"], json!([]), "{name}: the browser complains");
    for key in ["objections", "empty", "wide"] {
        if let Some(objections) = seen.get(key) {
            assert_eq!(*objections, json!([]), "{name}: {key}");
        }
    }
    seen
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

pub fn words(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
