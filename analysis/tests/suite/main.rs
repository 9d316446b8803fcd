//! The analysis by its public functions.

mod another_field;
mod borne_out;
mod broken_numbers;
mod modes;
mod search;
