//! `ironout web`: the page by itself.

use crate::cli::WebArgs;
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::{atomic, output};
use ironout_simulation::{EffectSpec, World, WorldOptions};
use ironout_web::{Mode, Page, licences};

const EXAMPLE_SEED: u64 = 17;
const EXAMPLE_SECONDS: f64 = 60.0;
const EXAMPLE_TRUTH: &str = "a simulated log: 3 µT of offset per ampere of current_a are hidden in it";

/// The log behind the page's example button: a simulated board whose offset is proportional to a current.
fn example() -> Outcome<Vec<u8>> {
    let effects =
        EffectSpec::parse("offset:current_a=3").map_err(|error| Failure::usage(error.to_string()))?;
    let world = World::new(WorldOptions {
        seed: EXAMPLE_SEED,
        seconds: EXAMPLE_SECONDS,
        effects: vec![effects],
        ..WorldOptions::default()
    });
    let mut csv = Vec::new();
    world.run().write_csv(&mut csv, EXAMPLE_TRUTH).map_err(|error| Failure::usage(error.to_string()))?;
    Ok(csv)
}

/// Writes the page into a folder.
pub fn run(arguments: &WebArgs, json: bool) -> Outcome<u8> {
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|error| Failure::io("make the folder", folder, &error))?;
    let html = Page::new(Mode::Alone, "ironout").with_bytes("example", &example()?).html();
    let (index, texts) = (folder.join("index.html"), folder.join("LICENSES.txt"));
    atomic::write(&index, |out| out.write_all(html.as_bytes()))?;
    atomic::write(&texts, |out| out.write_all(licences().as_bytes()))?;
    if json {
        output::line(
            &serde_json::json!({"output": index.display().to_string(), "bytes": html.len()}).to_string(),
        );
    } else {
        output::line(&format!(
            "wrote {} ({:.1} MB) and LICENSES.txt",
            index.display(),
            html.len() as f64 / 1e6
        ));
    }
    Ok(EXIT_OK)
}
