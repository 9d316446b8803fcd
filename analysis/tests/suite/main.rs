//! The analysis by its public functions.

mod accelerometer;
mod another_field;
mod borne_out;
mod broken_numbers;
mod collinear;
mod long_vehicle;
mod modes;
mod one_column;
mod search;
