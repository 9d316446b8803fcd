//! The panic handler that a static library has to have on bare metal.
//!
//! No function of the library can reach it: `c/check` fails if a linked program contains it.

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
