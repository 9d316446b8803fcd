//! The page of ironout as one self-contained HTML file: style, scripts, libraries, the analysis as WebAssembly, and the data of a
//! report. It asks no other host for anything, and its content security policy does not let it.
//!
//! ```
//! let page = ironout_web::Page::new(ironout_web::Mode::Report, "log.csv");
//! let html = page.with("report", &serde_json::json!({"hostile": "</script>"})).html();
//! assert!(html.starts_with("<!doctype html>"));
//! assert!(!html.contains("hostile"));
//! ```

mod files;
mod page;

pub use files::{licences, module_bytes};
pub use page::{Mode, Page};
