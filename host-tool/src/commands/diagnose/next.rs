//! The commands to run next, exactly as they can be typed.

use crate::cli::{DiagnoseArgs, MethodArg};

/// A word of a POSIX shell: quoted only where it must be.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,+@%^".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// The user's options about reading the log.
fn reading(arguments: &DiagnoseArgs) -> Vec<String> {
    let mut words = Vec::new();
    let mut option = |name: &str, value: &str| {
        // A value that begins with a minus needs the equals sign.
        words.push(format!("{name}{}{}", if value.starts_with('-') { "=" } else { " " }, quoted(value)));
    };
    if let Some(scale) = &arguments.log.ut_per_count {
        option("--ut-per-count", scale);
    }
    for map in &arguments.log.map {
        option("--map", map);
    }
    for rotate in &arguments.log.rotate {
        option("--rotate", rotate);
    }
    words
}

/// ... and about the field and the fit.
fn fitting(arguments: &DiagnoseArgs) -> Vec<String> {
    let mut words = Vec::new();
    if let Some(field) = arguments.field.field {
        words.push(format!("--field {field}"));
    }
    if let Some(at) = &arguments.field.at {
        let equals = if at.starts_with('-') { "=" } else { " " };
        words.push(format!("--at{equals}{}", quoted(at)));
    }
    match arguments.field.method {
        MethodArg::Adjusted => {}
        MethodArg::Trace => words.push("--method trace".into()),
        MethodArg::Constant => words.push("--method constant".into()),
    }
    if let Some(prior) = &arguments.prior {
        words.push(format!("--prior {}", quoted(&prior.display().to_string())));
    }
    words
}

fn path(text: &str) -> String {
    // A file that begins with a minus would be taken for an option.
    if text.starts_with('-') { quoted(&format!("./{text}")) } else { quoted(text) }
}

fn line(command: &str, log: &str, options: impl IntoIterator<Item = String>) -> String {
    let mut text = format!("ironout {command} {}", path(log));
    for option in options {
        text.push(' ');
        text.push_str(&option);
    }
    text
}

/// `ironout fit LOG … --add ID … -o cal.json`.
pub fn fit(arguments: &DiagnoseArgs, effects: &[String]) -> String {
    let log = arguments.log.log.display().to_string();
    let adds = effects.iter().map(|id| format!("--add {}", quoted(id)));
    let output = std::iter::once("-o cal.json".to_string());
    line("fit", &log, reading(arguments).into_iter().chain(fitting(arguments)).chain(adds).chain(output))
}

/// `ironout check SECOND.csv … --cal cal.json`.
pub fn check(arguments: &DiagnoseArgs) -> String {
    line("check", "second.csv", reading(arguments).into_iter().chain(["--cal cal.json".to_string()]))
}

/// `ironout diagnose LOG …` with a further option.
pub fn diagnose(arguments: &DiagnoseArgs, log: &str, further: &str) -> String {
    let adds = arguments.add.iter().map(|id| format!("--add {}", quoted(id)));
    let further = (!further.is_empty()).then(|| further.to_string());
    line("diagnose", log, reading(arguments).into_iter().chain(fitting(arguments)).chain(adds).chain(further))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Cli, Command};
    use clap::Parser;

    fn arguments(words: &[&str]) -> DiagnoseArgs {
        let all = ["ironout", "diagnose"].into_iter().chain(words.iter().copied());
        match Cli::try_parse_from(all).expect("good usage").command {
            Command::Diagnose(arguments) => arguments,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_users_options_are_kept_and_quoted() {
        let a = arguments(&[
            "my log's.csv",
            "--map",
            "mx_ut=Mag X,my_ut=MagY,mz_ut=MagZ",
            "--rotate",
            "-y,x,z",
            "--at",
            "-33.9,18.4,2026-03-01",
            "--method",
            "trace",
        ]);
        assert_eq!(
            fit(&a, &["offset:temp_c".into(), "offset:current_a^2".into()]),
            "ironout fit 'my log'\\''s.csv' --map 'mx_ut=Mag X,my_ut=MagY,mz_ut=MagZ' --rotate=-y,x,z \
             --at=-33.9,18.4,2026-03-01 --method trace --add offset:temp_c --add offset:current_a^2 -o cal.json"
        );
        assert_eq!(
            check(&a),
            "ironout check second.csv --map 'mx_ut=Mag X,my_ut=MagY,mz_ut=MagZ' --rotate=-y,x,z --cal cal.json"
        );
    }

    #[test]
    fn what_is_printed_is_understood_again() {
        let a =
            arguments(&["a.csv", "--ut-per-count", "0.1,0.1,0.2", "--field", "48.5", "--prior", "old.json"]);
        let words = fit(&a, &["drift".into()]);
        let again = Cli::try_parse_from(words.split(' ')).expect("good usage");
        assert!(matches!(again.command, Command::Fit(fit) if fit.add == ["drift"]
            && fit.field.field == Some(48.5) && fit.prior.is_some() && fit.log.ut_per_count.is_some()));
    }
}
