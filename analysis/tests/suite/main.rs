//! The analysis by its public functions.

mod borne_out;
mod modes;
mod search;
