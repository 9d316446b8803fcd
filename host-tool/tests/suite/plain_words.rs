//! Every printed sentence keeps the rules of plain English that a machine can check: string literals of the rooms that print, the
//! help of each command, and the snapshots of the explanations.

use crate::common::ironout;
use std::path::{Path, PathBuf};

/// Shorter texts are labels, not sentences.
const MIN_WORDS: usize = 4;

/// Forbidden word sequences, with what to write instead.
const FORBIDDEN: [(&str, &str); 43] = [
    ("anew", "again"),
    ("beside", "next to, in addition to"),
    ("meanwhile", "name the time"),
    ("all the same", "anyway"),
    ("at once", "at the same time, immediately"),
    ("on end", "consecutive"),
    ("unseen", "held out"),
    ("nobody", "name the actor"),
    ("is said", "name the actor: ironout prints"),
    ("are said", "name the actor: ironout prints"),
    ("be said", "name the actor: ironout prints"),
    ("is told", "name the actor: ironout detects"),
    ("are told", "name the actor: ironout detects"),
    ("told by", "detected from"),
    ("told apart", "distinguished"),
    ("tells", "shows, prints"),
    ("chance does", "p = …"),
    ("carries", "has, contains, is sufficient for"),
    ("not carry", "is not sufficient for"),
    ("asks for", "is significant"),
    ("ask for", "is significant"),
    ("stand in", "replace"),
    ("stands in", "replaces"),
    ("stand for", "correspond to, represent"),
    ("stands for", "corresponds to, represents"),
    ("taken for", "ironout assumes, uses"),
    ("taken as", "ironout assumes, uses"),
    ("taken out", "removed"),
    ("left out", "skipped"),
    ("noise leaves", "noise floor"),
    ("noise makes", "noise floor"),
    ("mend", "correct, repair"),
    ("is none", "is not one"),
    ("is no", "is not a"),
    ("are no", "are not"),
    ("where it", "if it"),
    ("where they", "if they"),
    ("where the log", "if the log"),
    ("where there", "if there"),
    ("where not", "if not"),
    ("where a", "if a"),
    ("where an", "if an"),
    ("as it is left", "unchanged"),
];

/// Words after which `a` or `an` means per.
const MEASURES: [&str; 12] = [
    "microtesla",
    "µt",
    "ut",
    "gauss",
    "counts",
    "samples",
    "rows",
    "gain",
    "factor",
    "value",
    "degrees",
    "g",
];
/// What a measure is per.
const PER: [&str; 8] = ["count", "sample", "second", "axis", "row", "unit", "degree", "ampere"];

fn words(text: &str) -> Vec<String> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '\''))
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect()
}

/// A text without the names in its placeholders.
fn without_placeholders(text: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for c in text.chars() {
        inside = (inside || c == '{') && c != '}';
        out.push(if inside || c == '}' { ' ' } else { c });
    }
    out
}

/// What is wrong with a text.
fn faults(text: &str) -> Vec<String> {
    let words = words(&without_placeholders(text));
    if words.len() < MIN_WORDS {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (wrong, instead) in FORBIDDEN {
        let wrong: Vec<&str> = wrong.split(' ').collect();
        for (at, window) in words.windows(wrong.len()).enumerate() {
            // `there is no` and `is no longer` are English.
            let exists = at > 0 && words[at - 1] == "there";
            let longer = words.get(at + wrong.len()).is_some_and(|next| next == "longer");
            if window == wrong.as_slice() && !exists && !longer {
                found.push(format!("`{}`: {instead}", wrong.join(" ")));
            }
        }
    }
    for window in words.windows(3) {
        let per = |word: &String, list: &[&str]| list.contains(&word.as_str());
        if per(&window[0], &MEASURES) && (window[1] == "a" || window[1] == "an") && per(&window[2], &PER) {
            found.push(format!("`{}`: per", window.join(" ")));
        }
    }
    found
}

fn sources(folder: &Path, list: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if path.is_dir() {
            sources(&path, list);
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
            list.push(path);
        }
    }
}

/// String literals of Rust code, each with its line; neither comments nor test modules.
fn literals(code: &str) -> Vec<(usize, String)> {
    let end = code.find("#[cfg(test)]\nmod tests {").unwrap_or(code.len());
    let bytes = &code.as_bytes()[..end];
    let (mut at, mut line, mut list) = (0, 1, Vec::new());
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'\n' => line += 1,
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                while bytes.get(at).is_some_and(|byte| *byte != b'\n') {
                    at += 1;
                }
                continue;
            }
            b'\'' if bytes.get(at + 2) == Some(&b'\'') => at += 2,
            b'\'' if bytes.get(at + 1) == Some(&b'\\') && bytes.get(at + 3) == Some(&b'\'') => at += 3,
            b'"' => {
                let (from, first) = (at + 1, line);
                at = from;
                while bytes.get(at).is_some_and(|byte| *byte != b'"') {
                    line += usize::from(bytes[at] == b'\n');
                    at += if bytes[at] == b'\\' && bytes.get(at + 1) != Some(&b'\n') { 2 } else { 1 };
                }
                let text = String::from_utf8_lossy(&bytes[from..at.min(bytes.len())]);
                // A continued line is one text; escapes separate words.
                let text = text.replace("\\\n", " ").replace("\\n", " ").replace("\\r", " ");
                list.push((first, text));
            }
            _ => {}
        }
        at += 1;
    }
    list
}

fn report(place: &str, text: &str, out: &mut Vec<String>) {
    out.extend(faults(text).into_iter().map(|fault| format!("{place}: {fault}: {}", text.trim())));
}

#[test]
fn the_rules_find_what_they_forbid() {
    for bad in [
        "the attitudes do not carry a calibration",
        "the scale in microtesla a count is missing",
        "this is no log but a picture",
        "the log is read anew with that",
        "leave it out where the log lacks it",
    ] {
        assert!(!faults(bad).is_empty(), "{bad}");
    }
    for good in [
        "there is no calibration in use",
        "it is no longer tested here",
        "the log marks where they were lost",
    ] {
        let wrong: Vec<String> = faults(good).into_iter().filter(|fault| !fault.contains("where")).collect();
        assert!(wrong.is_empty(), "{good}: {wrong:?}");
    }
    let code = "let a = \"one two three\"; // \"no\"\nlet b = '\"';\nlet c = \"four \\\n five\";";
    assert_eq!(literals(code), [(1, "one two three".to_string()), (3, "four   five".to_string())]);
}

#[test]
fn every_printed_sentence_is_plain_english() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut wrong = Vec::new();
    let mut count = 0;
    for room in ["analysis/src", "host-tool/src", "src"] {
        let mut files = Vec::new();
        sources(&root.join(room), &mut files);
        for file in files {
            let code = std::fs::read_to_string(&file).expect("code");
            let name = file.strip_prefix(&root).expect("a file of the project").display().to_string();
            for (line, text) in literals(&code) {
                count += usize::from(words(&text).len() >= MIN_WORDS);
                report(&format!("{name}:{line}"), &text, &mut wrong);
            }
        }
    }
    assert!(count > 1000, "only {count} sentences were found");
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn the_help_of_every_command_is_plain_english() {
    let help = ironout(["--help"]).stdout;
    let commands = help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let commands: Vec<&str> = commands
        .take_while(|line| !line.is_empty())
        .filter_map(|line| {
            line.strip_prefix("  ")?.split_whitespace().next().filter(|_| !line.starts_with("   "))
        })
        .collect();
    assert!(commands.len() >= 15 && commands.contains(&"effects"), "{commands:?}");
    let mut wrong = Vec::new();
    for command in commands.into_iter().filter(|command| *command != "help") {
        let run = ironout([command, "--help"]);
        assert_eq!(run.status, 0, "{command}: {}", run.stderr);
        run.stdout.split("\n\n").for_each(|part| report(command, part, &mut wrong));
    }
    help.split("\n\n").for_each(|part| report("ironout", part, &mut wrong));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_explanations_are_plain_english() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots");
    let mut wrong = Vec::new();
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the snapshots") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|extension| extension == "txt") {
            count += 1;
            let text = std::fs::read_to_string(&path).expect("text");
            text.split("\n\n").for_each(|part| report(&path.display().to_string(), part, &mut wrong));
        }
    }
    assert!(count >= 4, "{count} snapshots");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
