//! `web/vendor/crates.LICENSES.txt` says under which licences the Rust crates are that the page's module and the program are made
//! of. It is made here from what cargo says; `IRONOUT_RENEW=1 cargo test -p ironout-web --test crates` writes it anew.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

const KEPT: &str = "vendor/crates.LICENSES.txt";
/// What is built, for what, and how it is called.
const BUILT: [(&str, &str, &str); 2] = [
    ("ironout-wasm", "wasm32-unknown-unknown", "page"),
    ("ironout-cli", "x86_64-unknown-linux-gnu", "program"),
];
/// The licence that is taken where there is a choice.
const CHOSEN: &str = "MIT";
const MIT: &str = "Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation files \
(the \"Software\"), to deal in the Software without restriction, including without limitation the rights to use, copy, modify, merge, publish, \
distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is furnished to do so, subject to the \
following conditions:\n\nThe above copyright notice and this permission notice shall be included in all copies or substantial portions of the \
Software.\n\nTHE SOFTWARE IS PROVIDED \"AS IS\", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF \
MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, \
DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE \
OR OTHER DEALINGS IN THE SOFTWARE.";

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn cargo(arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let run = Command::new(cargo).current_dir(here()).args(arguments).output().expect("cargo runs");
    assert!(run.status.success(), "cargo {arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).expect("text")
}

/// Names and versions of the crates of others that are compiled into a package; macros are not in what they make.
fn crates(package: &str, target: &str) -> BTreeSet<(String, String)> {
    let edges = "normal,no-proc-macro";
    // The program that the page is in.
    let features = if package == "ironout-cli" { "page" } else { "" };
    let arguments = format!(
        "tree --locked -p {package} --features={features} --target {target} -e {edges} --prefix none -f {{p}}"
    );
    let tree = cargo(&arguments.split(' ').collect::<Vec<_>>());
    tree.lines()
        .filter(|line| !line.starts_with("ironout"))
        .filter_map(|line| {
            let mut words = line.split(' ');
            Some((words.next()?.to_string(), words.next()?.trim_start_matches('v').to_string()))
        })
        .collect()
}

/// Every package that cargo knows for the targets, by name and version.
fn packages() -> BTreeMap<(String, String), Value> {
    let mut all = BTreeMap::new();
    for (_, target, _) in BUILT {
        let said = cargo(&[
            "metadata",
            "--all-features",
            "--locked",
            "--format-version",
            "1",
            "--filter-platform",
            target,
        ]);
        let said: Value = serde_json::from_str(&said).expect("JSON");
        for package in said["packages"].as_array().expect("packages") {
            let word = |key: &str| package[key].as_str().unwrap_or_default().to_string();
            all.insert((word("name"), word("version")), package.clone());
        }
    }
    all
}

/// The texts of a package's licence: of the chosen one where there is a choice, else of all.
fn texts(package: &Value) -> Vec<String> {
    let folder = Path::new(package["manifest_path"].as_str().expect("a path")).parent().expect("a folder");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    let named = |path: &Path, parts: &[&str]| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
        path.is_file() && parts.iter().any(|part| name.contains(part))
    };
    let licence = package["license"].as_str().unwrap_or_default();
    let of_choice = licence.contains(CHOSEN) && !licence.contains("AND");
    let all: Vec<&PathBuf> = files
        .iter()
        .filter(|path| named(path, &["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"]))
        .collect();
    let own: Vec<&PathBuf> = all.iter().copied().filter(|path| named(path, &[CHOSEN, "NOTICE"])).collect();
    let taken = if of_choice && own.iter().any(|path| named(path, &[CHOSEN])) { own } else { all };
    let mut texts: Vec<String> =
        taken.iter().map(|path| std::fs::read_to_string(path).expect("text").replace('\r', "")).collect();
    if texts.is_empty() {
        // The package has none: its own words are the licence's name and who made it.
        assert!(licence.contains(CHOSEN), "{} has no text of its licence {licence}", package["name"]);
        let authors: Vec<&str> =
            package["authors"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let who = if authors.is_empty() {
            package["repository"].as_str().unwrap_or("its authors").into()
        } else {
            authors.join(", ")
        };
        texts.push(format!("MIT License\n\nCopyright (c) {who}\n\n{MIT}"));
    }
    texts
}

fn made() -> String {
    let packages = packages();
    let built = BUILT.map(|(package, target, _)| crates(package, target));
    let all: BTreeSet<_> = built.iter().flatten().cloned().collect();
    let (mut list, mut by_text) = (String::new(), BTreeMap::<String, (String, BTreeSet<String>)>::new());
    let mut listed = BTreeSet::new();
    for own in &all {
        let package = packages.get(own).unwrap_or_else(|| panic!("{own:?} is in no package"));
        let places: Vec<&str> = BUILT
            .iter()
            .zip(&built)
            .filter(|(_, crates)| crates.contains(own))
            .map(|((.., name), _)| *name)
            .collect();
        let licence = package["license"].as_str().expect("a licence");
        // No versions: a text outlives them.
        let line = format!("{} ({licence}): {}\n", own.0, places.join(", "));
        if listed.insert(line.clone()) {
            list += &line;
        }
        for text in texts(package) {
            let key: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
            by_text
                .entry(key)
                .or_insert_with(|| (text.trim().to_string(), BTreeSet::new()))
                .1
                .insert(own.0.clone());
        }
    }
    let mut groups: Vec<_> = by_text.into_values().collect();
    groups.sort_by(|a, b| a.1.cmp(&b.1));
    let mut out = format!(
        "Crates of others in the page's analysis (page) and in the program built for Linux (program). Where there is a choice of licences, {CHOSEN} \
         is the one.\n\n{list}"
    );
    for (text, names) in groups {
        let names: Vec<String> = names.into_iter().collect();
        out += &format!("\n--- {}\n\n{text}\n", names.join(", "));
    }
    out
}

#[test]
fn the_crates_licences_are_those_that_are_compiled_in() {
    let (path, made) = (here().join(KEPT), made());
    if std::env::var("IRONOUT_RENEW").as_deref() == Ok("1") {
        std::fs::write(&path, &made).expect("it is written");
    }
    let kept = std::fs::read_to_string(&path).expect("the kept list");
    let missing: Vec<&str> = made.lines().filter(|line| !kept.contains(line)).collect();
    let dead: Vec<&str> = kept.lines().filter(|line| !made.contains(line)).collect();
    assert!(
        kept == made,
        "IRONOUT_RENEW=1 cargo test -p ironout-web --test crates writes it anew; missing: {missing:#?}; no longer there: {dead:#?}"
    );
    // What the page shows and what `ironout web` writes.
    let shown = ironout_web::licences();
    for part in [
        "nalgebra (Apache-2.0): page, program",
        "tiny_http (MIT OR Apache-2.0): program",
        "Apache License",
        "three.js",
        "uPlot",
    ] {
        assert!(shown.contains(part), "no {part}");
    }
}
