//! What is not in order is found, and what is in order is not accused.

use ironout_layers::{Finding, Report, check_workspace};
use std::fs;
use tempfile::TempDir;

const MANIFEST: &str = "[package]\nname = \"one\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[workspace]\n";
const ORDER: &str = "## Order of crates\n| `one` |\n## Order of rooms: `one`\n| `low` | |\n| `high` | |\n";

/// Checks a crate `one` with these files; `low` and `high` are its rooms.
fn check(files: &[(&str, &str)]) -> Report {
    check_ordered(ORDER, files)
}

fn check_ordered(order: &str, files: &[(&str, &str)]) -> Report {
    let folder = TempDir::new().unwrap();
    let fixed = [
        ("Cargo.toml", MANIFEST),
        ("host-tests/layers/ROOMS.md", order),
        ("src/low.rs", ""),
        ("src/high.rs", ""),
    ];
    for (path, text) in fixed.iter().chain(files) {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    if !folder.path().join("src/lib.rs").exists() {
        fs::write(folder.path().join("src/lib.rs"), "pub mod low;\npub mod high;\n").unwrap();
    }
    check_workspace(&folder.path().canonicalize().unwrap()).unwrap()
}

fn circle(report: &Report) -> Vec<&str> {
    let found = report.findings.iter().find_map(|finding| match finding {
        Finding::Circle { files, .. } => Some(files.iter().map(String::as_str).collect()),
        _ => None,
    });
    found.unwrap_or_default()
}

/// Lines of upward arrows.
fn upward(report: &Report) -> Vec<usize> {
    let line = |finding: &Finding| match finding {
        Finding::Upward { import, .. } => Some(import.line),
        _ => None,
    };
    report.findings.iter().filter_map(line).collect()
}

#[test]
fn what_is_in_order_is_not_accused() {
    let report = check(&[
        ("src/high.rs", "use crate::low::{self, A as B};\nfn f() -> B { low::f(); crate::low::A }\n"),
        (
            "src/low.rs",
            "pub struct A;\npub fn f() {}\n#[cfg(test)]\nmod tests { use super::*; use crate::low::A; }\n",
        ),
    ]);
    assert!(report.findings.is_empty(), "{report}");
    assert_eq!((report.crates, report.files, report.imports, report.rooms), (1, 3, 1, 2));
}

#[test]
fn upward_arrows_are_found_however_they_are_written() {
    for text in [
        "use crate::high::A;",
        "use crate::{high::{A, B}};",
        "use super::high::*;",
        "pub use crate::high as other;",
        "fn f() { crate::high::f() }",
        "fn f() -> super::high::A { todo!() }",
        "fn f() { println!(\"{}\", crate::high::A) }",
        "macro_rules! m { () => { $crate::high::f() } }",
        "#[serde(with = \"crate::high::a\")]\nstruct S;",
        "mod inner { use super::super::high::A; }",
        "fn f() { use crate::high; high::f() }",
        "impl crate::high::T for S {}",
    ] {
        let report = check(&[("src/low.rs", text)]);
        assert!(!upward(&report).is_empty(), "{text}: {report}");
    }
    let report = check(&[("src/low.rs", "\n\nuse crate::high::A;\n")]);
    assert_eq!(upward(&report), [3]);
    // The root stands above its rooms.
    assert_eq!(upward(&check(&[("src/low.rs", "use crate::Thing;")])), [1]);
}

#[test]
fn a_circle_is_found_with_its_files_and_lines() {
    let report = check(&[
        ("src/high.rs", "use crate::low::A;\npub struct B;"),
        ("src/low.rs", "pub struct A;\nfn f(b: crate::high::B) {}"),
    ]);
    assert_eq!(circle(&report), ["src/low.rs", "src/high.rs"]);
    let text = report.to_string();
    assert!(text.contains("src/high.rs:1: crate::low::A -> src/low.rs"), "{text}");
    assert!(text.contains("src/low.rs:2: crate::high::B -> src/high.rs"), "{text}");
}

#[test]
fn a_child_that_imports_from_its_facade_is_a_circle_and_a_bare_mod_is_no_import() {
    let order = ORDER.replace("`high`", "`high`, `high::child`");
    let child = ("src/high/child.rs", "use super::Other;\npub struct A;");
    let facade =
        check_ordered(&order, &[("src/high.rs", "mod child;\npub use child::A;\npub struct Other;"), child]);
    assert_eq!(circle(&facade), ["src/high.rs", "src/high/child.rs"], "{facade}");
    let bare = check(&[("src/high.rs", "mod child;\npub struct Other;"), child]);
    assert!(bare.findings.is_empty(), "{bare}");
    // What a sibling's glob brings along is the sibling's child, wherever its name stands.
    let glob = check(&[
        ("src/low.rs", "pub mod deep;\nuse crate::high::X;"),
        ("src/low/deep.rs", "pub fn f() {}"),
        ("src/high.rs", "use crate::low::*;\npub struct X;\nfn g() { deep::f() }"),
    ]);
    assert_eq!(circle(&glob), ["src/low.rs", "src/high.rs"], "{glob}");
    assert_eq!(glob.imports, 3, "{glob}");
}

#[test]
fn a_test_module_in_a_file_of_its_own_may_import_its_parent_and_no_other_upwards() {
    let order = ORDER.replace("`high`", "`high`, `high::tests`");
    let high = ("src/high.rs", "#[cfg(test)]\nmod tests;\npub struct B;");
    let own = check_ordered(&order, &[high, ("src/high/tests.rs", "use super::*;\nuse crate::low;")]);
    assert!(own.findings.is_empty(), "{own}");
    let low = ("src/low.rs", "#[cfg(test)]\nmod tests;");
    let other = check(&[low, ("src/low/tests.rs", "use super::*;\nuse crate::high::B;")]);
    assert_eq!(upward(&other), [2], "{other}");
}

#[test]
fn programs_and_tests_are_crates_of_their_own() {
    let report = check(&[
        ("src/bin/prog/main.rs", "mod a;\nmod b;\nuse a::A;\nuse one::high::X;"),
        ("src/bin/prog/a.rs", "use crate::b::B;\npub struct A;"),
        ("src/bin/prog/b.rs", "use crate::a::A;\npub struct B;"),
        ("tests/t.rs", "mod common;\nuse common::x;"),
        ("tests/common/mod.rs", "pub fn x() {}"),
    ]);
    assert_eq!(circle(&report), ["src/bin/prog/a.rs", "src/bin/prog/b.rs"], "{report}");
    assert_eq!((report.targets, report.findings.len()), (3, 1));
}

#[test]
fn long_files_missing_rooms_and_missing_files_are_found() {
    let lines = |n: usize| "// line\n".repeat(n);
    assert!(check(&[("src/high.rs", &lines(800))]).findings.is_empty());
    let long = check(&[("src/high.rs", &lines(801))]);
    assert_eq!(long.findings, [Finding::TooLong { file: "src/high.rs".into(), lines: 801 }]);
    let more = check(&[("src/lib.rs", "mod low;\nmod high;\nmod more;"), ("src/more.rs", "")]);
    assert_eq!(more.findings, [Finding::NoRoom { target: "one".into(), file: "src/more.rs".into() }]);
    let empty = check_ordered(&ORDER.replace("`high`", "`high`, `gone`"), &[]);
    assert_eq!(empty.findings, [Finding::EmptyRoom { target: "one".into(), room: "gone".into() }]);
    assert_eq!(
        check_ordered("## Order of crates\n| `one` |", &[]).findings,
        [Finding::NoOrder { target: "one".into() }]
    );
    let missing = check(&[("src/lib.rs", "mod low;\nmod high;\nmod gone;")]);
    assert!(matches!(missing.findings[0], Finding::Unreadable { .. }), "{missing}");
}

#[test]
fn a_crate_depends_only_on_those_before_it() {
    let member = |name: &str, rest: &str| {
        format!("[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n{rest}")
    };
    let upper = member("upper", "");
    let manifest =
        format!("{}members = [\"upper\"]\n[dependencies]\nupper = {{ path = \"upper\" }}\n", MANIFEST);
    let files = [("Cargo.toml", manifest.as_str()), ("upper/Cargo.toml", &upper), ("upper/src/lib.rs", "")];
    let up = check_ordered(&ORDER.replace("`one` |", "`one`, `upper` |"), &files);
    assert_eq!(up.findings, [Finding::CrateUpward { from: "one".into(), to: "upper".into() }]);
    let down = check_ordered(&ORDER.replace("`one` |", "`upper`, `one` |"), &files);
    assert!(down.findings.is_empty(), "{down}");
    let undeclared = check_ordered(ORDER, &files);
    assert!(undeclared.findings.contains(&Finding::CrateUndeclared { name: "upper".into() }), "{undeclared}");
}

#[test]
fn a_wrong_arrow_is_tolerated_only_while_it_is_there() {
    let order = format!(
        "{ORDER}## Not yet in order\n| file | imports | why |\n|---|---|---|\n| `src/low.rs` | `src/high.rs` | soon |\n"
    );
    let there = check_ordered(&order, &[("src/low.rs", "use crate::high::A;")]);
    assert!(there.findings.is_empty(), "{there}");
    assert_eq!(there.not_yet, ["src/low.rs:1: crate::high::A -> src/high.rs (soon)"]);
    let gone = check_ordered(&order, &[]);
    let (from, to) = ("src/low.rs".to_string(), "src/high.rs".to_string());
    assert_eq!(gone.findings, [Finding::NotThereAnyMore { from, to }]);
}
