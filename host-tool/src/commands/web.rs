//! `ironout web`: the page by itself.

use crate::cli::WebArgs;
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::{atomic, output};
use ironout_web::{Mode, Page, licences};

/// Writes the page into a folder.
pub fn run(arguments: &WebArgs, json: bool) -> Outcome<u8> {
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|error| Failure::io("make the folder", folder, &error))?;
    let html = Page::new(Mode::Alone, "ironout").html();
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
