//! Puts the page together.

use crate::files::{MODULE, licences, packed, text};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};
use std::io::Write;

/// What the page is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// A report of a log that is in it.
    Report,
    /// Served by the program beside a board.
    Live,
    /// By itself: logs are dropped on it, boards speak to it.
    Alone,
}

impl Mode {
    /// The word in the page.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Report => "report",
            Mode::Live => "live",
            Mode::Alone => "alone",
        }
    }
}

/// Scripts, each after those that it imports.
const SCRIPTS: [&str; 21] = [
    "three.min.js",
    "uplot.min.js",
    "dom.js",
    "numbers.js",
    "engine.js",
    "svg.js",
    "plots.js",
    "sphere.js",
    "figures.js",
    "staircase.js",
    "compare.js",
    "wires.js",
    "board.js",
    "recording.js",
    "cloud.js",
    "readings.js",
    "strip.js",
    "turning.js",
    "asking.js",
    "live.js",
    "main.js",
];
/// The script of the worker.
const WORKER: &str = "worker.js";

/// A page.
#[derive(Debug, Clone)]
pub struct Page {
    mode: Mode,
    title: String,
    data: Vec<(String, Vec<u8>)>,
}

impl Page {
    /// An empty one.
    pub fn new(mode: Mode, title: &str) -> Self {
        Page { mode, title: title.to_string(), data: Vec::new() }
    }

    /// With a JSON value that its scripts find under `name` (letters and minus signs).
    #[must_use]
    pub fn with(self, name: &str, value: &serde_json::Value) -> Self {
        self.with_bytes(name, value.to_string().as_bytes())
    }

    /// With bytes that its scripts find under `name`.
    #[must_use]
    pub fn with_bytes(mut self, name: &str, bytes: &[u8]) -> Self {
        self.data.push((name.to_string(), gzip(bytes)));
        self
    }

    /// The file.
    pub fn html(&self) -> String {
        let style = text("uplot.min.css") + &text("page.css");
        let start = text("start.js");
        let mut policy = format!(
            "default-src 'none'; script-src '{}' blob: 'wasm-unsafe-eval'; style-src '{}'; img-src blob: data:; worker-src blob:; \
             base-uri 'none'; form-action 'none'",
            hash(&start),
            hash(&style)
        );
        if self.mode == Mode::Live {
            policy += "; connect-src 'self'";
        }
        let mut out = String::from("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
        out += &format!("<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n");
        out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
        out += "<meta name=\"referrer\" content=\"no-referrer\">\n<link rel=\"icon\" href=\"data:,\">\n";
        out +=
            &format!("<title>{} · ironout</title>\n<style>{style}</style>\n</head>\n", escaped(&self.title));
        out += &format!("<body data-mode=\"{}\">\n{}\n", self.mode.name(), text("body.html"));
        let data = |out: &mut String, kind: &str, name: &str, bytes: &[u8]| {
            *out += &format!("<script type=\"text/plain\" data-{kind}=\"{name}\">");
            STANDARD.encode_string(bytes, out);
            *out += "</script>\n";
        };
        for name in SCRIPTS {
            data(&mut out, "script", name, packed(name));
        }
        data(&mut out, "worker", WORKER, packed(WORKER));
        data(&mut out, "bytes", "module", MODULE);
        data(&mut out, "bytes", "licences", &gzip(licences().as_bytes()));
        for (name, bytes) in &self.data {
            let name: String = name.chars().filter(|c| c.is_ascii_alphabetic() || *c == '-').collect();
            data(&mut out, "bytes", &name, bytes);
        }
        out += &format!("<script>{start}</script>\n</body>\n</html>\n");
        out
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::new(6));
    // Writing to memory does not fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// As the policy names a script or a style that stands in the page.
fn hash(text: &str) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(text.as_bytes())))
}

fn escaped(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '&' => "&amp;".to_string(),
            '<' => "&lt;".to_string(),
            '>' => "&gt;".to_string(),
            '"' => "&quot;".to_string(),
            '\'' => "&#39;".to_string(),
            c if c.is_control() => "\u{fffd}".to_string(),
            c => c.to_string(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_script_is_there_and_nothing_in_the_page_ends_one() {
        for name in SCRIPTS.iter().chain(&[WORKER, "start.js", "page.css", "body.html"]) {
            assert!(!text(name).is_empty(), "{name}");
        }
        assert!(!text("start.js").contains("</"));
        let title = "<script>alert(1)</script>\"'&\u{1b}";
        let html = Page::new(Mode::Report, title).with("report", &serde_json::json!([title])).html();
        assert!(!html.contains("<script>alert"));
        assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;\u{fffd}"));
        assert!(!html.contains("http://") && !html.replace("https://threejs.org", "").contains("https://"));
    }

    #[test]
    fn only_the_served_page_may_ask_its_own_server() {
        assert!(Page::new(Mode::Live, "").html().contains("connect-src 'self'"));
        for mode in [Mode::Report, Mode::Alone] {
            assert!(!Page::new(mode, "").html().contains("connect-src"));
        }
        assert!(licences().contains("MIT") && licences().contains("three.js"));
    }
}
