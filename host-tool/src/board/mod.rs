//! A connected board: its console over a serial port or a TCP connection, its calibration and its stream.

mod carried;
mod console;
mod stream;
mod transfer;
mod wire;

pub use carried::{Carried, cal_file, carried};
pub use console::{Console, Identity, Refusal, Reply};
pub use stream::{Columns, Row, Streamed};
pub use transfer::{Dumped, dump, load};
pub use wire::{Address, Trouble, Wire};
