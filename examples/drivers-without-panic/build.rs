//! No runtime, no memory map: the program is linked, never run.

fn main() {
    println!("cargo:rustc-link-arg-bins=--entry=start");
}
