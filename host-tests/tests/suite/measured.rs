//! The document of measurements shows what the snapshots hold, and explains it.

use ironout_host_tests::measured::{between_markers, path};

/// The one table of times: another machine has others, so no snapshot holds it.
const TIMES: &str = "bench";

fn document() -> String {
    std::fs::read_to_string(path()).expect("the document lies in the repository")
}

/// The names of the marked tables with their text.
fn tables(document: &str) -> Vec<(String, String)> {
    document
        .split("<!-- ")
        .filter_map(|part| {
            let (name, rest) = part.split_once(":begin -->\n```text\n")?;
            Some((name.to_owned(), rest.split("\n```\n").next()?.to_owned()))
        })
        .collect()
}

#[test]
fn every_marked_table_is_that_of_a_snapshot() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots");
    let snapshots: Vec<String> = std::fs::read_dir(folder)
        .expect("the snapshots lie in the repository")
        .map(|entry| std::fs::read_to_string(entry.expect("a file").path()).expect("text"))
        .collect();
    let document = document();
    let tables = tables(&document);
    assert_eq!(tables.len(), document.matches(":begin -->\n").count(), "a marked table is not plain text");
    for name in ["m4", TIMES, "accuracy-paper", "accuracy-sweep", "accuracy-verdicts", "accuracy-correlated"]
        .into_iter()
        .chain(["accuracy-effects", "accuracy-irrelevant", "accuracy-truths", "accuracy-predicted"])
    {
        assert!(tables.iter().any(|(own, _)| own == name), "the document has lost its table {name}");
    }
    for (name, table) in tables.iter().filter(|(name, _)| name != TIMES) {
        let held = snapshots.iter().any(|snapshot| snapshot.contains(table));
        assert!(held, "{name} is not in a snapshot: run the command that writes it, with --accept");
    }
}

#[test]
fn every_snapshot_is_shown() {
    let document = document();
    let shown: Vec<&str> = document.lines().collect();
    for name in ["accuracy.txt", "effects.txt", "irrelevant.txt", "m4.txt", "truths.txt", "predicted.txt"] {
        let file = format!("{}/snapshots/{name}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(file).expect("the snapshot lies in the repository");
        // The first line of this one is a heading of its own.
        let lines = text.lines().filter(|line| !line.starts_with("The paper's simulation"));
        for line in lines {
            assert!(shown.contains(&line), "host-tests/measured.md lacks this line of {name}: {line}");
        }
    }
}

#[test]
fn every_figure_of_the_microcontroller_is_explained() {
    let text = include_str!("../../snapshots/m4.txt");
    let document = document();
    // The peer's figures stand beside ours under the same words.
    for key in text.lines().skip(1).filter_map(|line| line.split_whitespace().next()) {
        let own = key.strip_prefix("magcal_").is_some();
        assert!(
            own || document.contains(&format!("`{key}`")),
            "host-tests/measured.md does not explain {key}"
        );
    }
}

/// The numbers and words of the one line of a snapshot that begins with these words.
fn line<'a>(snapshot: &'a str, start: &str) -> &'a str {
    snapshot
        .lines()
        .find_map(|line| line.trim_start().strip_prefix(start))
        .unwrap_or_else(|| panic!("the snapshots have no line {start}"))
}

#[test]
fn the_readmes_figures_are_those_of_the_tables() {
    let readme = include_str!("../../../README.md");
    let accuracy = include_str!("../../snapshots/accuracy.txt");
    let m4 = include_str!("../../snapshots/m4.txt");
    let sweep: Vec<&str> = line(accuracy, "1.0 %    2000     25 %   0.5 F |").split_whitespace().collect();
    let rate = |text: &str, at: usize| text.split_whitespace().skip(at).take(3).collect::<Vec<_>>().join(" ");
    let value = |key: &str| line(m4, key).split_whitespace().next().unwrap_or_default().to_owned();
    // Logs that nothing was tuned on, a row for each pair of seeds: number, and "first, exactly, false, …" of this search.
    let (mut exactly, mut hidden, mut falsely, mut logs) = (0, 0, 0, 0);
    for row in include_str!("../../../docs/method.md").lines().filter(|line| line.starts_with("| seeds ")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let numbers: Vec<u32> = cells[4].split([',', ' ']).filter_map(|word| word.parse().ok()).collect();
        logs += cells[2].parse::<u32>().expect("a number of logs");
        (exactly, hidden, falsely) = (exactly + numbers[2], hidden + numbers[3], falsely + numbers[4]);
    }
    let figures = [
        format!("`magcal` 0.1: {}) | {} |", sweep[3], sweep[2]),
        format!("| {} | 1000 logs |", rate(line(accuracy, "limited   adjusted"), 0)),
        format!("| {exactly} of {hidden}; {falsely} of {logs}; "),
        format!("| {}, {} | 2 sessions, exact |", value("session_push "), value("session_push_worst ")),
        format!("| {} | exact |", value("session_bytes ")),
    ];
    for figure in &figures {
        assert!(readme.contains(figure), "README.md, \"Figures\", is out of date: it should say {figure}");
    }
}

#[test]
fn a_table_goes_between_its_markers() {
    let document = "a\n<!-- t:begin -->\nold\n<!-- t:end -->\nb\n";
    let changed = between_markers(document, "t", "new\n").expect("it has the markers");
    assert_eq!(changed, "a\n<!-- t:begin -->\n```text\nnew\n```\n<!-- t:end -->\nb\n");
    assert_eq!(between_markers(&changed, "t", "new\n").as_deref(), Some(changed.as_str()));
    assert_eq!(between_markers(document, "u", ""), None);
}
