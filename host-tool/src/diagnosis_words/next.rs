//! The commands to run next, exactly as they can be typed.

use crate::cli::{DiagnoseArgs, typed_option};

/// The user's options about the field and the fit. With effects, everything is fitted at once, whatever the base's method.
fn fitting(arguments: &DiagnoseArgs, effects: &[String]) -> String {
    let mut words = arguments.field.typed(!effects.is_empty());
    if let Some(prior) = &arguments.prior {
        words.push_str(&typed_option("--prior", &prior.display().to_string()));
    }
    words
}

fn adding(effects: &[String]) -> String {
    effects.iter().map(|id| typed_option("--add", id)).collect()
}

/// `ironout fit LOG … --add ID … -o cal.json`.
pub fn fit(arguments: &DiagnoseArgs, effects: &[String]) -> String {
    try_fit(arguments, effects) + " -o cal.json"
}

/// `ironout fit LOG … --add ID …`: one that is refused writes nothing.
pub fn try_fit(arguments: &DiagnoseArgs, effects: &[String]) -> String {
    format!("ironout fit {}{}{}", arguments.log.typed(), fitting(arguments, effects), adding(effects))
}

/// `ironout check second.csv … --cal cal.json`.
pub fn check(arguments: &DiagnoseArgs) -> String {
    format!("ironout check {} --cal cal.json", arguments.log.typed_for("second.csv"))
}

/// `ironout diagnose LOG …` with a further option.
pub fn diagnose(arguments: &DiagnoseArgs, log: &str, further: &str) -> String {
    let space = if further.is_empty() { "" } else { " " };
    let options = format!("{}{}", fitting(arguments, &arguments.add), adding(&arguments.add));
    format!("ironout diagnose {}{options}{space}{further}", arguments.log.typed_for(log))
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
             --at=-33.9,18.4,2026-03-01 --add offset:temp_c --add offset:current_a^2 -o cal.json"
        );
        assert!(fit(&a, &[]).ends_with("--method trace -o cal.json"));
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
