//! Writes one simulated log and its truth.

use second_generator::{Kind, draw};
use std::process::ExitCode;

const USAGE: &str =
    "usage: second-generator KIND NUMBER [-o LOG.csv] [--truth TRUTH.json]\n       second-generator list";

fn main() -> ExitCode {
    match run(&std::env::args().skip(1).collect::<Vec<String>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<(), String> {
    if let [only] = arguments
        && only == "list"
    {
        Kind::ALL.iter().for_each(|kind| println!("{}", kind.name()));
        return Ok(());
    }
    let [name, number, options @ ..] = arguments else {
        return Err(USAGE.into());
    };
    let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name);
    let kind = kind.ok_or_else(|| {
        format!("unknown kind {name}\nFix: choose one that `second-generator list` prints.")
    })?;
    let number = number.parse().map_err(|_| format!("{number} is not a whole number\n{USAGE}"))?;
    let (mut log, mut truth) = (None, None);
    for option in options.chunks(2) {
        match option {
            [flag, path] if flag == "-o" => log = Some(path),
            [flag, path] if flag == "--truth" => truth = Some(path),
            _ => return Err(USAGE.into()),
        }
    }
    let drawn = draw(kind, number);
    let write = |path: &String, text: String| std::fs::write(path, text).map_err(|e| format!("{path}: {e}"));
    match log {
        Some(path) => write(path, drawn.csv())?,
        None => print!("{}", drawn.csv()),
    }
    truth.map_or(Ok(()), |path| write(path, drawn.truth.json()))
}
