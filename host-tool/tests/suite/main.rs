//! The tests of the program: one binary, one module a subject. Each runs the built `ironout`, as a user would.

mod answer_first;
mod batch;
mod blackbox;
#[cfg(feature = "demo")]
mod board_link;
mod cases_copies;
mod cases_numbers;
mod cases_tables;
mod cases_time;
mod check_heading;
mod close_steps;
#[cfg(feature = "parquet")]
mod columnar;
#[cfg(not(feature = "parquet"))]
mod columnar_not_built;
mod common;
#[cfg(feature = "demo")]
mod console_script;
mod contract;
mod corpus;
mod dataflash;
#[cfg(feature = "demo")]
mod demo;
mod derive;
mod diagnose_fuzz;
mod diagnose_json;
mod diagnose_recordings;
mod diagnose_text;
mod effects;
mod effects_doc;
mod effects_exported;
mod exports_cost;
mod exports_reading;
mod exports_targets;
mod extrapolation;
mod frames;
mod frames_cases;
mod frames_sources;
mod fuzz;
mod journey;
mod judged;
mod malformed;
mod mcap;
mod one_truth;
mod packed;
#[cfg(feature = "emulated")]
mod page;
mod plain_words;
mod plausible;
mod prior;
mod reader;
mod reading;
mod recordings;
mod schemas;
mod several;
mod telemetry;
mod text_corpus;
mod text_questions;
mod transients;
mod tutorial;
mod two_sensors;
mod ulog;
mod unlogged;
mod vehicles;
mod vehicles_course;
mod vehicles_flights;
mod writers;

/// Stands in the summary for what this build leaves out.
#[cfg(not(feature = "emulated"))]
#[test]
#[ignore = "emulated boards and the browser: cargo test --workspace --features emulated"]
fn emulated_boards_and_browser() {}
