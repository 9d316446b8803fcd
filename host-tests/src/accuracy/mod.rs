//! How good the calibrations are: errors over the Cramér–Rao bound, honesty of the standard errors, and what the verdict
//! lets through or turns away, side by side with the crate `magcal` on the same counts.

pub mod attitude;
pub mod beyond;
pub mod bound;
pub mod correlated;
pub mod dip_table;
pub mod effect_report;
pub mod effect_table;
pub mod flights;
pub mod gates;
pub mod injected;
pub mod irrelevant;
pub mod irrelevant_table;
pub mod log;
pub mod optical;
pub mod paper_table;
pub mod pooled;
pub mod predicted;
pub mod simulated;
pub mod snapshot;
pub mod solvers;
pub mod table;
pub mod true_error;
pub mod truths;
pub mod truths_table;
pub mod vehicles;
