//! The tutorial's commands, run in their order, give what the tutorial shows. `IRONOUT_BLESS=1` writes the outputs anew.

use crate::common::{alike, folder};
use std::path::Path;
use std::process::Command;

const START: &str = "```console";
const END: &str = "```";

/// Runs one line in a shell with `ironout` on the path.
fn run(line: &str, folder: &Path) -> String {
    let binary = Path::new(env!("CARGO_BIN_EXE_ironout")).parent().expect("a folder");
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", line])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", binary.display()))
        .output()
        .expect("a shell");
    assert!(
        output.status.success(),
        "{line}: {} {}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("text").trim_end().to_string()
}

#[test]
fn the_tutorial_says_what_the_program_says() {
    if cfg!(not(unix)) {
        return;
    }
    let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/tutorial.md");
    let text = std::fs::read_to_string(&document).expect("the tutorial");
    let folder = folder("tutorial");
    let mut out = String::new();
    let mut commands = 0;
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        out.push_str(line);
        out.push('\n');
        if line != START {
            continue;
        }
        while let Some(line) = lines.next_if(|line| *line != END) {
            let command = line.strip_prefix("$ ").unwrap_or_else(|| panic!("not a command: {line}"));
            let mut told = String::new();
            while let Some(line) = lines.next_if(|line| *line != END && !line.starts_with("$ ")) {
                told.push_str(line);
                told.push('\n');
            }
            let now = run(command, &folder);
            commands += 1;
            out.push_str(line);
            out.push('\n');
            if !now.is_empty() {
                out.push_str(&now);
                out.push('\n');
            }
            if std::env::var_os("IRONOUT_BLESS").is_none() {
                alike::assert_alike(command, &now, told.trim_end());
            }
        }
    }
    assert!(commands >= 8, "only {commands} commands found");
    if std::env::var_os("IRONOUT_BLESS").is_some() {
        std::fs::write(&document, out).expect("the tutorial");
    }
}

#[test]
fn the_comparison_sees_a_difference() {
    let same = |a: &str, b: &str| std::panic::catch_unwind(|| alike::assert_alike("", a, b)).is_ok();
    assert!(same("error 0.81 µT ▁▂█", "error 0.80 µT ▃▃█"));
    assert!(same("chance <1e-99", "chance 4e-30"));
    assert!(!same("error 0.81 µT", "error 0.51 µT"));
    assert!(!same("MISSING: drift.", "MISSING: step."));
    assert!(!same("one line", "one line\ntwo"));
}
