//! What the core costs on a Cortex-M4F: builds the measuring images, runs them in the emulator, reads the counts.
//!
//! With `-icount shift=6` an instruction takes 64 ns of the emulated clock, and TIMER0 counts at 25 MHz: 1.6 ticks an
//! instruction. The counts are of instructions, not of cycles, and the same on every run and every host.

pub mod snapshot;

use object::{Object, ObjectSection, ObjectSymbol};
use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::process::Command;

/// The microcontroller's target.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const TICKS_PER_INSTRUCTION: f64 = 1.6;

/// A figure and, where there is one, the limit it must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Its name, as in the JSON object.
    pub key: &'static str,
    /// Instructions or bytes.
    pub value: u64,
    /// Largest value that is accepted.
    pub limit: Option<u64>,
    /// Whether it is ours: others' figures are shown, not held.
    pub ours: bool,
}

/// All figures of one run.
#[derive(Clone, Debug)]
pub struct Measured {
    /// In the order of the table.
    pub figures: Vec<Figure>,
}

/// Why there are no figures.
#[derive(Debug)]
pub enum M4Error {
    /// The emulator is not installed.
    NoEmulator,
    /// A program could not be run.
    Io(io::Error),
    /// The build, the emulation or its output was not what it should be.
    Failed(String),
}

impl std::fmt::Display for M4Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoEmulator => {
                write!(f, "qemu-system-arm is not installed: install the package qemu-system-arm")
            }
            Self::Io(error) => write!(f, "{error}"),
            Self::Failed(what) => write!(f, "{what}"),
        }
    }
}

impl std::error::Error for M4Error {}

impl From<io::Error> for M4Error {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Builds the images of the counts and returns their paths by name.
fn build() -> Result<BTreeMap<String, PathBuf>, M4Error> {
    let mut arguments = vec!["--release", "--features", "image,counts"];
    for image in ["counts", "sample-path", "size-base", "size-core", "size-magcal"] {
        arguments.extend(["--bin", image]);
    }
    build_with(&arguments)
}

/// Builds one image in a profile, with these features of the library, separated by commas.
pub(crate) fn build_image(name: &str, profile: &str, features: &str) -> Result<PathBuf, M4Error> {
    let features = format!("image,{features}");
    build_with(&["--profile", profile, "--bin", name, "--features", &features])?
        .remove(name)
        .ok_or_else(|| M4Error::Failed(format!("cargo built no image {name}")))
}

fn build_with(arguments: &[&str]) -> Result<BTreeMap<String, PathBuf>, M4Error> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .args(["build", "-p", "ironout-m4-bench", "--target", TARGET])
        .args(arguments)
        .arg("--message-format=json-render-diagnostics")
        .stderr(std::process::Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(M4Error::Failed("the measuring images do not build".into()));
    }
    let mut images = BTreeMap::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok(message) = serde_json::from_str::<serde_json::Value>(line) else { continue };
        if let (Some(path), Some(name)) = (message["executable"].as_str(), message["target"]["name"].as_str())
        {
            images.insert(name.to_owned(), PathBuf::from(path));
        }
    }
    Ok(images)
}

/// Runs an image and returns its `key=value` lines.
fn run(image: &std::path::Path) -> Result<BTreeMap<String, String>, M4Error> {
    let output = Command::new("qemu-system-arm")
        .args(["-M", "mps2-an386", "-icount", "shift=6", "-display", "none", "-monitor", "none"])
        .args(["-serial", "none", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(image)
        .output()
        .map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => M4Error::NoEmulator,
            _ => M4Error::Io(error),
        })?;
    let text =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(M4Error::Failed(format!("{} failed in the emulator: {text}", image.display())));
    }
    Ok(text.lines().filter_map(|l| l.split_once('=')).map(|(k, v)| (k.to_owned(), v.to_owned())).collect())
}

/// Sizes of an image's sections by name, bytes.
pub(crate) type Sections = BTreeMap<String, u64>;

pub(crate) fn sections(image: &std::path::Path) -> Result<Sections, M4Error> {
    let bytes = std::fs::read(image)?;
    let file = object::File::parse(&*bytes)
        .map_err(|error| M4Error::Failed(format!("{}: {error}", image.display())))?;
    Ok(file.sections().filter_map(|s| Some((s.name().ok()?.to_owned(), s.size()))).collect())
}

pub(crate) fn size(sections: &Sections, name: &str) -> u64 {
    sections.get(name).copied().unwrap_or(0)
}

/// Functions of an image that a panic goes through. The linker keeps only what can be reached, so that none of them means: none can
/// be.
fn panics(image: &std::path::Path) -> Result<u64, M4Error> {
    let bytes = std::fs::read(image)?;
    let failed = |what: String| M4Error::Failed(format!("{}: {what}", image.display()));
    let file = object::File::parse(&*bytes).map_err(|error| failed(error.to_string()))?;
    let names = || file.symbols().filter_map(|symbol| symbol.name().ok());
    // An image without symbols would pass whatever is in it.
    if !names().any(|name| name.contains("Moments")) {
        return Err(failed("its symbols do not show the path of a sample".into()));
    }
    Ok(names().filter(|name| name.contains("9panicking") || name.contains("rust_begin_unwind")).count()
        as u64)
}

/// Builds and runs everything.
///
/// # Errors
/// See [`M4Error`].
pub fn measure() -> Result<Measured, M4Error> {
    let images = build()?;
    let image =
        |name: &str| images.get(name).ok_or_else(|| M4Error::Failed(format!("cargo built no image {name}")));
    let lines = run(image("counts")?)?;
    let number = |key: &str| {
        let text = lines.get(key).ok_or_else(|| M4Error::Failed(format!("the image printed no {key}")))?;
        text.parse::<f64>().map_err(|_| M4Error::Failed(format!("{key}={text} is not a number")))
    };
    let samples = number("samples")?;
    let instructions = |ticks: f64| (ticks / TICKS_PER_INSTRUCTION).round().max(0.0) as u64;
    // What the two readings of the clock and the loading of a sample cost is taken off.
    let overhead = number("overhead")?;
    let mean = |key: &str| Ok::<u64, M4Error>(instructions((number(key)? - overhead) / samples));
    let worst = |key: &str| Ok::<u64, M4Error>(instructions(number(key)? - overhead / samples));
    let once = |key: &str| Ok::<u64, M4Error>(instructions(number(key)?));
    // Of two whole calibrations, in the hand and over scattered directions, whichever took more.
    let session = |what: &str| -> Result<u64, M4Error> {
        let turned = number("turned")?;
        let of = |name: &str, count: f64| -> Result<f64, M4Error> {
            let ticks = |what: &str| number(&format!("session_{name}_{what}"));
            let each = overhead / samples;
            Ok(match what {
                "push" => ticks("push")? / count - each,
                "push_worst" => ticks("push_worst")? - each,
                // What there is besides the fit: the last block, the coverage, the verdict.
                _ => ticks("stop")? - ticks("fit")?,
            })
        };
        Ok(instructions(of("turned", turned)?.max(of("scattered", samples)?)))
    };
    let bytes = |key: &str| Ok::<u64, M4Error>(number(key)? as u64);
    let sections = |name: &str| sections(image(name)?);
    let (base, core, magcal) = (sections("size-base")?, sections("size-core")?, sections("size-magcal")?);
    let more = |with: &Sections, section: &str| size(with, section).saturating_sub(size(&base, section));

    let ours = |key, value, limit| Figure { key, value, limit, ours: true };
    let theirs = |key, value| Figure { key, value, limit: None, ours: false };
    let figures = vec![
        ours("push", mean("push")?, Some(260)),
        ours("push_worst", worst("push_worst")?, Some(450)),
        ours("constant_solve", once("constant_solve")?, None),
        ours("trace_solve", once("trace_solve")?, Some(150_000)),
        ours("adjusted_solve", once("adjusted_solve")?, Some(700_000)),
        ours("apply_base", mean("apply_base")?, None),
        ours("apply", mean("apply")?, Some(420)),
        ours("study_push", mean("study_push")?, Some(6_000)),
        ours("learn_push", mean("learn_push")?, Some(5_100)),
        ours("learn_push_worst", worst("learn_push_worst")?, None),
        ours("why", once("why")?, None),
        ours("why_step_worst", once("why_step_worst")?, Some(640_000)),
        ours("session_push", session("push")?, Some(900)),
        ours("session_push_worst", session("push_worst")?, Some(5_000)),
        ours("session_stop", session("stop")?, Some(150_000)),
        ours("sample_path_panics", panics(image("sample-path")?)?, Some(0)),
        theirs("magcal_push", mean("magcal_push")?),
        theirs("magcal_push_worst", worst("magcal_push_worst")?),
        theirs("magcal_solve", once("magcal_solve")?),
        theirs("magcal_apply", mean("magcal_apply")?),
        ours("core_text_bytes", more(&core, ".text"), Some(20_000)),
        ours("core_rodata_bytes", more(&core, ".rodata"), None),
        theirs("magcal_text_bytes", more(&magcal, ".text")),
        theirs("magcal_rodata_bytes", more(&magcal, ".rodata")),
        ours("state_bytes", bytes("state")?, Some(400)),
        ours("session_bytes", bytes("session_bytes")?, Some(1_600)),
        theirs("magcal_state_bytes", bytes("magcal_state")?),
        ours("learner_bytes", bytes("learner_bytes")?, Some(6_144)),
        ours("why_stack_bytes", bytes("why_stack")?, None),
        ours("stack_bytes", bytes("stack_solve")?, None),
        ours("stack_push_bytes", bytes("stack_push")?, None),
        theirs("magcal_stack_bytes", bytes("magcal_stack_solve")?),
    ];
    Ok(Measured { figures })
}

impl Measured {
    /// The value of a figure.
    pub fn value(&self, key: &str) -> Option<u64> {
        self.figures.iter().find(|f| f.key == key).map(|f| f.value)
    }

    /// The JSON object of the bench: instructions and bytes.
    pub fn json(&self) -> serde_json::Value {
        const KEYS: [&str; 20] = [
            "push",
            "push_worst",
            "trace_solve",
            "adjusted_solve",
            "apply",
            "study_push",
            "learn_push",
            "why",
            "why_step_worst",
            "learner_bytes",
            "session_push",
            "session_push_worst",
            "session_stop",
            "session_bytes",
            "magcal_push",
            "magcal_solve",
            "core_text_bytes",
            "state_bytes",
            "magcal_state_bytes",
            "stack_bytes",
        ];
        KEYS.iter().map(|key| ((*key).to_owned(), serde_json::json!(self.value(key)))).collect()
    }

    /// The readable table.
    pub fn table(&self) -> String {
        let mut text = String::from("figure                    value      limit\n");
        for f in &self.figures {
            let limit = f.limit.map_or(String::from("-"), |l| l.to_string());
            text += &format!("{:<20} {:>10} {:>10}\n", f.key, f.value, limit);
        }
        text
    }

    /// Figures above their limits, one sentence each.
    pub fn over_limit(&self) -> Vec<String> {
        self.figures
            .iter()
            .filter_map(|f| f.limit.filter(|l| f.value > *l).map(|l| (f, l)))
            .map(|(f, l)| format!("{} is {}, its limit is {l}", f.key, f.value))
            .collect()
    }
}
