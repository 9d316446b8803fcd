//! The committed header is what the sources say, and is no more than was promised.

use std::path::Path;

/// Functions that the header may have.
const MOST_FUNCTIONS: usize = 20;

#[test]
fn the_header_is_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml can be read");
    // The order of the header. By file: of a whole crate cbindgen asks cargo, which may ask the network.
    let files = [
        "sensor",
        "session",
        "calibration",
        "record",
        "live",
        "monitor",
        "heading",
        "side",
        "status",
        "error",
    ];
    let builder = files.iter().fold(cbindgen::Builder::new().with_config(config), |builder, file| {
        builder.with_src(root.join("src").join(file).with_extension("rs"))
    });
    let mut made = Vec::new();
    builder.generate().expect("the sources can be parsed").write(&mut made);
    // Compilers for small processors read ASCII.
    let made = String::from_utf8(made).expect("UTF-8").replace('µ', "u").replace('²', "^2");
    assert!(made.is_ascii(), "the header is not ASCII");
    let version = [
        ("MAJOR", env!("CARGO_PKG_VERSION_MAJOR")),
        ("MINOR", env!("CARGO_PKG_VERSION_MINOR")),
        ("PATCH", env!("CARGO_PKG_VERSION_PATCH")),
    ];
    for (part, number) in version {
        assert!(
            made.contains(&format!("#define IRONOUT_VERSION_{part} {number}\n")),
            "{part}: cbindgen.toml"
        );
    }
    let path = root.join("include/ironout.h");
    if std::env::var_os("IRONOUT_ACCEPT_HEADER").is_some() {
        std::fs::write(&path, &made).expect("the header can be written");
    }
    let kept = std::fs::read_to_string(&path).expect("the header is there");
    assert!(kept == made, "c/include/ironout.h is not current. Fix: run c/check --accept");
    let functions = made
        .lines()
        .filter(|line| line.contains(" ironout_") && line.contains('(') && !line.starts_with(' '));
    let functions = functions.filter(|line| !line.starts_with("//") && !line.starts_with("typedef")).count();
    assert!((1..=MOST_FUNCTIONS).contains(&functions), "{functions} functions");
}
