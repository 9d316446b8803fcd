//! The drivers against the transactions of the datasheets.

mod lsm303dlhc_init;
mod lsm303dlhc_read;
mod lsm303dlhc_temperature;
mod transactions;
