//! The firmware: wires a board to the driver, the session, the store and the console.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("the firmware is built for the board's target: use an alias, such as `cargo fw-mps2`");
#[cfg(not(any(feature = "board-mps2")))]
compile_error!("the firmware needs exactly one board feature, such as `board-mps2`");

mod board;
mod fault;

use board::Board;
use core::fmt::Write;
use embedded_hal::i2c::I2c;
use heapless::String;

#[cortex_m_rt::entry]
fn main() -> ! {
    let faults = fault::Faults::read();
    let Some(mut b) = Board::take() else { panic!("the board was taken twice") };
    defmt::info!("ironout on {}, faults {}: {}", board::NAME, faults.count, faults.last.as_str());
    let mut s: String<200> = String::new();
    let mut id = [0u8; 3];
    let r = b.bus.write_read(0x1e, &[0x0a], &mut id);
    let _ = write!(s, "+ id {:?} {:?}\n", r, id);
    b.console.write(s.as_bytes());
    s.clear();
    let r = b.bus.write(0x1e, &[0x00, 0x80 | 0x1c]);
    let _ = write!(s, "+ cra {:?}\n", r);
    b.console.write(s.as_bytes());
    s.clear();
    let r = b.bus.write(0x1e, &[0x01, 0x20]);
    let _ = write!(s, "+ crb {:?}\n", r);
    b.console.write(s.as_bytes());
    s.clear();
    let r = b.bus.write(0x1e, &[0x02, 0x00]);
    let _ = write!(s, "+ mr {:?} absent {:?}\n", r, b.bus.write(0x33, &[1]));
    b.console.write(s.as_bytes());
    s.clear();
    let r = b.bus.write(0x50, &[0x00, 0x40, 1, 2, 3, 4]);
    let mut back = [0u8; 4];
    let q = b.bus.write_read(0x50, &[0x00, 0x40], &mut back);
    let _ = write!(s, "+ ee {:?} {:?} {:?} faults={} {}\n", r, q, back, faults.count, faults.last);
    b.console.write(s.as_bytes());
    s.clear();
    loop {
        while let Some(c) = b.console.read() {
            b.console.write(&[c]);
        }
        if b.clock.sample_due().is_some() {
            let mut raw = [0u8; 6];
            let r = b.bus.write_read(0x1e, &[0x03], &mut raw);
            s.clear();
            let _ = write!(s, "R,{},{:?},{:?}\n", b.clock.now_ms(), r, raw);
            b.console.try_write(s.as_bytes());
        }
        board::sleep();
    }
}
