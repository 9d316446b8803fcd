//! Writes the memory map of the measuring images; the root's `memory.x`, which the linker finds first, includes it.

use std::{env, fs, path::PathBuf};

/// Sizes of a real board of the class, as the firmware's own; the stack lies at the bottom, so an overflow faults.
const MAP: &str = "MEMORY
{
  FLASH (rx) : ORIGIN = 0x00000000, LENGTH = 512K
  STACK (rw) : ORIGIN = 0x20000000, LENGTH = 48K
  RAM   (rw) : ORIGIN = 0x2000C000, LENGTH = 80K
}
_stack_start = ORIGIN(STACK) + LENGTH(STACK);
_stack_end = ORIGIN(STACK);
";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::write(out.join("board.x"), MAP).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
}
