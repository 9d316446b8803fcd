//! The stack of the module: a study passes matrices of 33 KB by value, and a page has no threads to choose a stack for.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-cdylib-link-arg=-zstack-size=33554432");
}
