//! The page in headless Chromium, driven by clicks and keys: a report, the page by itself, and a board beside it.
//!
//! Node's side is `host-tests/web` (`npm ci` there). A test waits for states of the page and never for a time, and says when it was
//! skipped; with `IRONOUT_REQUIRE_CHROMIUM=1` what is missing is a failure. `IRONOUT_SCREENSHOTS=DIR` keeps the pictures.

mod board;
mod browser;
mod emulated;
mod formats;
mod replayed;
mod report;
