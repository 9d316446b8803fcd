//! Builds the page's WebAssembly module from the sources of this workspace, and packs it with the page's files.
//!
//! The module is a build of its own (another target, another profile) in a folder of its own, so that the two builds do not wait
//! for each other's lock. `IRONOUT_WASM=FILE` takes a module that is built already. A page without its module could not fit, so there is none:
//! where the target wasm32-unknown-unknown is not installed, the build asks rustup for it, and fails with the command to run where that does not help.

use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// What the module is made of, from the workspace's root.
const SOURCES: [&str; 8] = [
    "src",
    "analysis/src",
    "host-tool/src",
    "hal-drivers/sensor/src",
    "simulation/src",
    "web/wasm",
    "Cargo.lock",
    "Cargo.toml",
];
/// What the page is made of, from this folder.
const FILES: [&str; 2] = ["page", "vendor"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let root = here.parent().ok_or("the crate is not in its workspace")?.to_path_buf();
    let out = PathBuf::from(env::var("OUT_DIR")?);
    println!("cargo:rerun-if-env-changed=IRONOUT_WASM");
    SOURCES.iter().for_each(|path| println!("cargo:rerun-if-changed={}", root.join(path).display()));
    FILES.iter().for_each(|path| println!("cargo:rerun-if-changed={}", here.join(path).display()));

    let module = match env::var_os("IRONOUT_WASM") {
        Some(path) => fs::read(path)?,
        None => module(&root, &out)?,
    };
    if !module.starts_with(b"\0asm") {
        return Err("IRONOUT_WASM names a file that is not a WebAssembly module".into());
    }
    fs::write(out.join("module.wasm.gz"), packed(&module)?)?;

    // Each file of the page by its name, packed where it is long.
    let mut list = String::from("pub(crate) const FILES: &[(&str, &[u8])] = &[\n");
    for folder in FILES {
        let mut paths: Vec<PathBuf> = fs::read_dir(here.join(folder))?
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<_, _>>()?;
        paths.sort();
        for path in paths {
            let name = path.file_name().and_then(|name| name.to_str()).ok_or("a file's name is no text")?;
            let to = out.join(format!("{name}.gz"));
            fs::write(&to, packed(&fs::read(&path)?)?)?;
            list += &format!("    ({name:?}, include_bytes!({:?})),\n", to.display().to_string());
        }
    }
    list += "];\n";
    fs::write(out.join("files.rs"), list)?;
    Ok(())
}

fn packed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Whether this toolchain has the library of a target.
fn has_target(target: &str) -> std::io::Result<bool> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let libdir = Command::new(rustc).args(["--print", "target-libdir", "--target", target]).output()?;
    Ok(Path::new(String::from_utf8_lossy(&libdir.stdout).trim()).exists())
}

/// Builds the module.
fn module(root: &Path, out: &Path) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    const TARGET: &str = "wasm32-unknown-unknown";
    if !has_target(TARGET)? {
        // No rustup, or one that cannot reach its server: the look below says what is left to do.
        let _ = Command::new("rustup").current_dir(root).args(["target", "add", TARGET]).status();
        if !has_target(TARGET)? {
            let error = format!(
                "the page needs the target {TARGET}, which this toolchain does not have. Fix: rustup target add {TARGET} (or build \
                 the program without --features page)"
            );
            return Err(error.into());
        }
    }
    // target/PROFILE/build/ironout-web-HASH/out: one folder for all profiles.
    let target = out.ancestors().nth(4).ok_or("no folder to build in")?.join("web-module");
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(root).args([
        "build",
        "--quiet",
        "--locked",
        "--package",
        "ironout-wasm",
        "--profile",
        "web",
    ]);
    command.args(["--target", TARGET, "--target-dir"]).arg(&target);
    // What cargo says to the build around this one is not said to this one; what people say of networks and registries is.
    const NOT_MEANT: [&str; 11] = [
        "CARGO_PKG_",
        "CARGO_CFG_",
        "CARGO_FEATURE_",
        "CARGO_MANIFEST_",
        "CARGO_ENCODED_",
        "CARGO_BUILD_",
        "CARGO_PROFILE_",
        "CARGO_TARGET_",
        "CARGO_MAKEFLAGS",
        "RUSTFLAGS",
        "RUSTC_",
    ];
    for (key, _) in env::vars_os() {
        if NOT_MEANT.iter().any(|start| key.to_string_lossy().starts_with(start)) {
            command.env_remove(&key);
        }
    }
    if !command.status()?.success() {
        return Err("the page's module could not be built".into());
    }
    Ok(fs::read(target.join(TARGET).join("web").join("ironout_wasm.wasm"))?)
}
