//! `cargo picture [--check]`: draws `docs/picture.svg` from what the program itself says of a simulated log; `--check` compares instead.
//!
//! It runs the commands of the tutorial (`simulate`, `fit`, `fit --add`, `apply`) and reads the files they write, so that
//! the picture shows the program's own figures. Left the samples of a slice before and after, right the error that the
//! missing effect makes over time, and how it falls.

use std::error::Error;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

/// The motor current that is hidden in the log.
const EFFECT: &str = "offset:current_a";
/// Samples whose corrected vector is this near the plane of x and y, as a share of its length, are in the slice.
const SLICE: f64 = 0.15;
/// The stretch of time drawn, s.
const TIME_S: [f64; 2] = [20.0, 50.0];

const RAW: &str = "#c2410c";
const GOOD: &str = "#0f766e";
const INK: &str = "#334155";
const FAINT: &str = "#cbd5e1";

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let file = |name: &str| folder.path().join(name).into_os_string();
    let hidden = format!("{EFFECT}=3");
    let (log, plain, full) = (file("log.csv"), file("plain.json"), file("full.json"));
    let (by_plain, by_full) = (file("by-plain.csv"), file("by-full.csv"));
    let words = |list: &[&str]| list.iter().map(OsString::from).collect::<Vec<_>>();
    for (command, arguments) in [
        (
            "simulate",
            [
                words(&["--seed", "17", "--seconds", "120", "--rate", "50", "--effect", &hidden, "-o"]),
                vec![log.clone()],
            ],
        ),
        ("fit", [vec![log.clone(), "-o".into(), plain.clone()], vec![]]),
        ("fit", [vec![log.clone(), "-o".into(), full.clone()], words(&["--add", EFFECT])]),
        ("apply", [vec![log.clone(), "--cal".into(), plain.clone()], vec!["-o".into(), by_plain.clone()]]),
        ("apply", [vec![log.clone(), "--cal".into(), full.clone()], vec!["-o".into(), by_full.clone()]]),
    ] {
        let line = words(&["ironout", command]).into_iter().chain(arguments.into_iter().flatten()).collect();
        if ironout_cli::run(line) != ExitCode::SUCCESS {
            return Err(format!("ironout {command} did not succeed").into());
        }
    }
    let svg = draw(
        &Corrected::read(&by_plain)?,
        &Corrected::read(&by_full)?,
        &[Errors::read(&plain)?, Errors::read(&full)?],
    );
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/picture.svg");
    if !std::env::args().any(|word| word == "--check") {
        std::fs::write(path, svg)?;
    } else if std::fs::read_to_string(path)? != svg {
        return Err("docs/picture.svg is not what the program draws. Fix: cargo picture".into());
    }
    Ok(ExitCode::SUCCESS)
}

/// A log as `apply` writes it.
struct Corrected {
    raw_ut: Vec<[f64; 3]>,
    corrected_ut: Vec<[f64; 3]>,
    residual_ut: Vec<f64>,
    current_a: Vec<f64>,
    time_s: Vec<f64>,
}

impl Corrected {
    fn read(path: impl AsRef<Path>) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(path)?;
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let header: Vec<&str> = lines.next().ok_or("an empty log")?.split(',').collect();
        let at = |name: &str| {
            header.iter().position(|own| *own == name).ok_or_else(|| format!("the log has no {name}"))
        };
        let raw = [at("mx_ut")?, at("my_ut")?, at("mz_ut")?];
        let corrected = [at("cx_ut")?, at("cy_ut")?, at("cz_ut")?];
        let (residual, current, time) = (at("residual_ut")?, at("current_a")?, at("t_s")?);
        let mut read = Self {
            raw_ut: vec![],
            corrected_ut: vec![],
            residual_ut: vec![],
            current_a: vec![],
            time_s: vec![],
        };
        for line in lines {
            let cells: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
            // A repeated row has no corrected vector.
            let Ok(cells) = cells else { continue };
            if cells.len() != header.len() {
                return Err("a ragged row".into());
            }
            read.raw_ut.push(raw.map(|i| cells[i]));
            read.corrected_ut.push(corrected.map(|i| cells[i]));
            read.residual_ut.push(cells[residual]);
            read.current_a.push(cells[current]);
            read.time_s.push(cells[time]);
        }
        Ok(read)
    }
}

/// What a calibration file says of its error, µT.
struct Errors {
    field_ut: f64,
    unseen_ut: f64,
    floor_ut: f64,
}

impl Errors {
    fn read(path: impl AsRef<Path>) -> Result<Self, Box<dyn Error>> {
        let object: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        let number = |key: &str| object[key].as_f64().ok_or_else(|| format!("no number {key}"));
        Ok(Self {
            field_ut: number("field_ut")?,
            unseen_ut: number("holdout_rms_ut")?,
            floor_ut: number("residual_floor_ut")?,
        })
    }
}

/// A plot's frame: where it stands on the page, and what its edges mean.
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        (self.left + self.width * share(x, self.x), self.top + self.height * (1.0 - share(y, self.y)))
    }

    /// A line across the frame.
    fn line(&self, svg: &mut String, from: (f64, f64), to: (f64, f64), colour: &str) {
        let ((x1, y1), (x2, y2)) = (self.at(from.0, from.1), self.at(to.0, to.1));
        let _ = writeln!(svg, r#"<path d="M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}" stroke="{colour}"/>"#);
    }

    /// Points as one path of dots: thousands of circles would make the file large.
    fn dots(&self, svg: &mut String, points: impl Iterator<Item = (f64, f64)>, colour: &str, size: f64) {
        let mut path = String::new();
        for (x, y) in points {
            let (x, y) = self.at(x, y);
            let _ = write!(path, "M{x:.1} {y:.1}h0");
        }
        let _ = writeln!(
            svg,
            r#"<path d="{path}" stroke="{colour}" stroke-width="{size}" stroke-linecap="round" stroke-opacity="0.55"/>"#
        );
    }
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, style: &str, words: &str) {
    let _ = writeln!(svg, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}" {style}>{words}</text>"#);
}

const SMALL: &str = r##"font-size="13" fill="#334155""##;
const TITLE: &str = r##"font-size="15" font-weight="600" fill="#0f172a""##;

fn draw(plain: &Corrected, full: &Corrected, errors: &[Errors; 2]) -> String {
    let mut svg = String::from(
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 436" font-family="Helvetica, Arial, sans-serif" role="img" aria-label="A simulated log before and after calibration, and how much the error falls once the missing effect is in the model">
<rect width="960" height="436" fill="#ffffff"/>
<g fill="none">
"##,
    );
    slice(&mut svg, full, errors[1].field_ut);
    current(&mut svg, full);
    residual(&mut svg, STRIPS[1].0, plain, RAW);
    residual(&mut svg, STRIPS[2].0, full, GOOD);
    svg += "</g>\n";
    labels(&mut svg, errors);
    bars(&mut svg, errors);
    svg += "</svg>\n";
    svg
}

/// The samples whose corrected vector lies near the plane of x and y: a ring that should be a circle about zero.
fn slice(svg: &mut String, log: &Corrected, field_ut: f64) {
    let near: Vec<usize> =
        (0..log.raw_ut.len()).filter(|&row| log.corrected_ut[row][2].abs() < SLICE * field_ut).collect();
    let reach = near
        .iter()
        .flat_map(|&row| [log.raw_ut[row], log.corrected_ut[row]])
        .flat_map(|[x, y, _]| [x.abs(), y.abs()])
        .fold(field_ut, f64::max)
        * 1.05;
    let frame =
        Frame { left: 30.0, top: 52.0, width: 330.0, height: 330.0, x: [-reach, reach], y: [-reach, reach] };
    frame.line(svg, (-reach, 0.0), (reach, 0.0), FAINT);
    frame.line(svg, (0.0, -reach), (0.0, reach), FAINT);
    let points =
        |vectors: &[[f64; 3]]| near.iter().map(|&row| (vectors[row][0], vectors[row][1])).collect::<Vec<_>>();
    frame.dots(svg, points(&log.raw_ut).into_iter(), RAW, 3.0);
    frame.dots(svg, points(&log.corrected_ut).into_iter(), GOOD, 3.0);
    let (x, y) = frame.at(0.0, 0.0);
    let radius = field_ut / reach * frame.width / 2.0;
    let _ = writeln!(
        svg,
        r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius:.1}" stroke="{INK}" stroke-dasharray="2 4"/>"#
    );
}

/// The strips over time: top, height, ends of the scale, and what they show.
const STRIPS: [(f64, f64, [f64; 2], &str); 3] = [
    (48.0, 44.0, [0.0, 12.0], "motor current"),
    (114.0, 72.0, [-3.0, 3.0], "error, offset and matrix only"),
    (208.0, 72.0, [-3.0, 3.0], "error, with the current in the model"),
];

fn strip(top: f64) -> Frame {
    let (top, height, y, _) = STRIPS.into_iter().find(|strip| strip.0 == top).unwrap_or(STRIPS[0]);
    Frame { left: 450.0, top, width: 480.0, height, x: TIME_S, y }
}

/// What is drawn of a log over time.
fn over_time<'a>(log: &'a Corrected, values: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    let times = log.time_s.iter().copied();
    times.zip(values.iter().copied()).filter(|(time, _)| (TIME_S[0]..TIME_S[1]).contains(time))
}

fn current(svg: &mut String, log: &Corrected) {
    let frame = strip(STRIPS[0].0);
    let mut path = String::new();
    for (time, value) in over_time(log, &log.current_a) {
        let (x, y) = frame.at(time, value);
        let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' });
    }
    let _ = writeln!(svg, r#"<path d="{path}" stroke="{INK}" stroke-width="1.3"/>"#);
}

/// The error of the corrected magnitude.
fn residual(svg: &mut String, top: f64, log: &Corrected, colour: &str) {
    let frame = strip(top);
    frame.line(svg, (TIME_S[0], 0.0), (TIME_S[1], 0.0), FAINT);
    frame.dots(svg, over_time(log, &log.residual_ut), colour, 2.2);
}

fn labels(svg: &mut String, errors: &[Errors; 2]) {
    text(svg, (30.0, 28.0), "start", TITLE, "One slice of the sphere, x and y in µT");
    let key = |colour: &str| format!(r#"font-size="13" fill="{colour}""#);
    text(svg, (30.0, 410.0), "start", &key(RAW), "● measured");
    text(svg, (130.0, 410.0), "start", &key(GOOD), "● corrected");
    let circle = format!("┄ the field, {:.1} µT", errors[1].field_ut);
    text(svg, (235.0, 410.0), "start", SMALL, &circle);
    text(svg, (450.0, 28.0), "start", TITLE, "Half a minute of the same log");
    let faint = r##"font-size="11" fill="#64748b""##;
    for ((top, height, [low, high], words), colour) in STRIPS.into_iter().zip([INK, RAW, GOOD]) {
        text(svg, (930.0, top - 4.0), "end", &key(colour), words);
        let unit = if low < 0.0 { "µT" } else { "A" };
        text(svg, (442.0, top + 8.0), "end", faint, &format!("{high} {unit}"));
        text(svg, (442.0, top + height), "end", faint, &format!("{low}").replace('-', "−"));
    }
}

/// The falling error, on stretches of time that the fit had not seen.
fn bars(svg: &mut String, errors: &[Errors; 2]) {
    text(svg, (450.0, 318.0), "start", TITLE, "Held-out error, rms");
    let scale = 240.0 / errors[0].unseen_ut;
    let effect = format!("+ {EFFECT}");
    for (row, (name, value, colour)) in [
        ("offset and matrix", errors[0].unseen_ut, RAW),
        (effect.as_str(), errors[1].unseen_ut, GOOD),
        ("noise alone", errors[1].floor_ut, "#94a3b8"),
    ]
    .into_iter()
    .enumerate()
    {
        let y = 332.0 + 30.0 * row as f64;
        text(svg, (450.0, y + 15.0), "start", SMALL, name);
        let width = value * scale;
        let _ = writeln!(
            svg,
            r#"<rect x="600" y="{y:.1}" width="{width:.1}" height="20" rx="2" fill="{colour}"/>"#
        );
        text(svg, (608.0 + width, y + 15.0), "start", SMALL, &format!("{value:.2} µT"));
    }
}
