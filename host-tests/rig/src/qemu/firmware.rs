//! The firmware's ELF: built, found, and read.

use super::error::Error;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The project's source, as it was when this was built.
pub const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The target of the microcontroller on the board of this feature.
fn target(feature: &str) -> &'static str {
    match feature {
        "board-pico" => "thumbv6m-none-eabi",
        _ => "thumbv7em-none-eabihf",
    }
}

/// The environment variable that names an ELF to use instead of building one.
const GIVEN: &str = "IRONOUT_FIRMWARE";

/// A built firmware.
#[derive(Clone, Debug)]
pub struct Firmware {
    path: PathBuf,
}

/// What a firmware takes of the microcontroller, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footprint {
    /// Code.
    pub text: u64,
    /// Constants, with the interrupt table.
    pub rodata: u64,
    /// Initialised statics: they take flash and RAM.
    pub data: u64,
    /// Zeroed statics.
    pub bss: u64,
    /// The region kept for the stack.
    pub stack: u64,
}

impl Footprint {
    /// Flash: code, constants and the statics' initial values.
    pub fn flash(&self) -> u64 {
        self.text + self.rodata + self.data
    }

    /// RAM: statics and the region kept for the stack.
    pub fn ram(&self) -> u64 {
        self.data + self.bss + self.stack
    }
}

impl Firmware {
    /// Builds the firmware for the emulated board, as `cargo fw-mps2` does, or takes the one that `IRONOUT_FIRMWARE` names.
    pub fn build() -> Result<Self, Error> {
        match std::env::var_os(GIVEN) {
            Some(path) => Self::at(Path::new(&path)),
            None => Self::build_for("board-mps2"),
        }
    }

    /// Builds the firmware for the board of this feature, with all that firmware can have: `cargo fw-NAME`.
    pub fn build_for(board: &str) -> Result<Self, Error> {
        Self::build_with(board, &[&format!("fw-{}", board.trim_start_matches("board-"))])
    }

    /// Builds the firmware for this board without the study and other methods than the adjusted one.
    pub fn build_lean(board: &str) -> Result<Self, Error> {
        let target = target(board);
        Self::build_with(
            board,
            &[
                "build",
                "--release",
                "-p",
                "ironout",
                "--bin",
                "firmware",
                "--features",
                board,
                "--target",
                target,
            ],
        )
    }

    fn build_with(board: &str, command: &[&str]) -> Result<Self, Error> {
        let workspace = Path::new(WORKSPACE);
        if !workspace.join("Cargo.toml").is_file() {
            return Err(Error::NoSource(workspace.to_owned()));
        }
        ensure_target(workspace, target(board))?;
        // The path of the ELF comes from cargo itself: CARGO_TARGET_DIR or a configuration may have moved it.
        let out = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
            .current_dir(workspace)
            .args(command)
            .arg("--message-format=json-render-diagnostics")
            .stdin(Stdio::null())
            .output()
            .map_err(Error::io("run cargo"))?;
        if !out.status.success() {
            return Err(Error::Build(String::from_utf8_lossy(&out.stderr).into_owned()));
        }
        String::from_utf8_lossy(&out.stdout)
            .lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok())
            .filter(|message| message["target"]["name"] == "firmware")
            .find_map(|message| message["executable"].as_str().map(PathBuf::from))
            .map(|path| Self { path })
            .ok_or_else(|| Error::Build("cargo named no executable".to_owned()))
    }

    /// The ELF at `path`, built before.
    pub fn at(path: &Path) -> Result<Self, Error> {
        let path =
            path.canonicalize().map_err(Error::io(format!("find the firmware at {}", path.display())))?;
        Ok(Self { path })
    }

    /// Where the ELF is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's bytes.
    pub fn bytes(&self) -> Result<Vec<u8>, Error> {
        std::fs::read(&self.path).map_err(Error::io(format!("read {}", self.path.display())))
    }

    /// The address of a symbol.
    pub fn symbol(&self, name: &str) -> Result<u64, Error> {
        let bytes = self.bytes()?;
        self.parse(&bytes)?
            .symbols()
            .find(|symbol| symbol.name() == Ok(name))
            .map(|symbol| symbol.address())
            .ok_or_else(|| self.wrong(format!("it has no symbol {name}")))
    }

    /// The address of the only symbol whose demangled path, without its hash, ends with `path`.
    pub fn function(&self, path: &str) -> Result<u64, Error> {
        let bytes = self.bytes()?;
        let file = self.parse(&bytes)?;
        // Legacy mangling: each part behind its length, then a hash.
        let mangled: String = path.split("::").map(|part| format!("{}{part}", part.len())).collect();
        let found = |name: &str| name.rsplit_once("17h").is_some_and(|(path, _)| path.ends_with(&mangled));
        let named = file.symbols().find(|symbol| symbol.name().is_ok_and(found));
        named.map(|symbol| symbol.address()).ok_or_else(|| self.wrong(format!("it has no function {path}")))
    }

    /// What it takes of the microcontroller.
    pub fn footprint(&self) -> Result<Footprint, Error> {
        let bytes = self.bytes()?;
        let file = self.parse(&bytes)?;
        let sum = |wanted: &[SectionKind]| -> u64 {
            file.sections()
                .filter(|section| section.address() != 0 || section.name() == Ok(".vector_table"))
                .filter(|section| wanted.contains(&section.kind()))
                .map(|section| section.size())
                .sum()
        };
        Ok(Footprint {
            text: sum(&[SectionKind::Text]),
            rodata: sum(&[SectionKind::ReadOnlyData, SectionKind::ReadOnlyString]),
            data: sum(&[SectionKind::Data]),
            bss: sum(&[SectionKind::UninitializedData]),
            stack: self.symbol("_stack_start")?.saturating_sub(self.symbol("_stack_end")?),
        })
    }

    fn parse<'a>(&self, bytes: &'a [u8]) -> Result<object::File<'a>, Error> {
        object::File::parse(bytes).map_err(|error| self.wrong(format!("it is no ELF file: {error}")))
    }

    fn wrong(&self, reason: String) -> Error {
        Error::Elf { path: self.path.clone(), reason }
    }
}

/// Adds the target to the toolchain unless it is there. The toolchain file names it, but a toolchain that was there before
/// the file may lack it.
fn ensure_target(workspace: &Path, target: &'static str) -> Result<(), Error> {
    let present = Command::new("rustc")
        .current_dir(workspace)
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .is_ok_and(|out| Path::new(String::from_utf8_lossy(&out.stdout).trim()).is_dir());
    if present {
        return Ok(());
    }
    let added = Command::new("rustup").current_dir(workspace).args(["target", "add", target]).output();
    let reason = match added {
        Ok(out) if out.status.success() => return Ok(()),
        Ok(out) => String::from_utf8_lossy(&out.stderr).trim().to_owned(),
        Err(error) => format!("rustup: {error}"),
    };
    Err(Error::NoTarget { target, reason })
}
