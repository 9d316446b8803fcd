//! Logs of many kinds whose truth is known: human and machine motion, noise of several colours, columns that cause
//! nothing, gaps, and from none to three hidden effects from weak to overwhelming.

use crate::attitude::Motion;
use crate::decoy::Decoy;
use crate::effects::EffectSpec;
use crate::noise::Noise;
use crate::options::WorldOptions;
use crate::world::World;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// What is hidden in a log, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One effect; white noise, of first order, or a rolling mean.
    One,
    /// One effect under 1/f noise.
    OneFlicker,
    /// A nonlinearity or a cross-axis disturbance, up to 20 times the noise.
    OfAttitude,
    /// A strong effect: 12 to 20 times the noise.
    Strong,
    /// Two or three effects.
    Several,
    /// Nothing; white noise, of first order, or a rolling mean.
    Nothing,
    /// Nothing, under 1/f noise.
    NothingFlicker,
    /// An effect whose column is not in the log.
    Deleted,
    /// An effect of a column with another beside it that moves alike.
    Alike,
    /// The same with gaps in the cause's column.
    AlikeGaps,
    /// A tone, the rows stamped when they arrive.
    Arrival,
    /// A nonlinearity or a cross-axis disturbance of 20 to 40 times the noise.
    OfAttitudeStrong,
}

impl Kind {
    /// All, in the order of the table.
    pub const ALL: [Kind; 12] = [
        Kind::One,
        Kind::OneFlicker,
        Kind::OfAttitude,
        Kind::Strong,
        Kind::Several,
        Kind::Nothing,
        Kind::NothingFlicker,
        Kind::Deleted,
        Kind::Alike,
        Kind::AlikeGaps,
        Kind::Arrival,
        Kind::OfAttitudeStrong,
    ];

    /// A word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::One => "one",
            Kind::OneFlicker => "one-flicker",
            Kind::OfAttitude => "of-attitude",
            Kind::Strong => "strong",
            Kind::Several => "several",
            Kind::Nothing => "nothing",
            Kind::NothingFlicker => "nothing-flicker",
            Kind::Deleted => "deleted",
            Kind::Alike => "alike",
            Kind::AlikeGaps => "alike-gaps",
            Kind::Arrival => "arrival",
            Kind::OfAttitudeStrong => "of-attitude-strong",
        }
    }
}

/// A drawn world with what is hidden in it.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The world.
    pub world: World,
    /// Ids of the hidden effects, as a diagnosis names them.
    pub hidden: Vec<String>,
    /// The kinds in words: motion, noise, effects with their strengths.
    pub words: String,
}

/// No hidden effect is a larger share of the field than this.
const MOST_OF_FIELD: f64 = 0.2;
/// Rows of the longest log.
const MOST_ROWS: f64 = 16_000.0;
/// Draws until a world is one that could be measured.
const MOST_DRAWS: u64 = 60;

const COLUMNS: [&str; 6] = ["temp_c", "current_a", "height_m", "throttle", "servo", "load"];

fn one_of<T: Copy>(list: &[T], rng: &mut ChaCha8Rng) -> T {
    list[rng.random_range(0..list.len())]
}

/// Evenly over the logarithm.
fn about(low: f64, high: f64, rng: &mut ChaCha8Rng) -> f64 {
    (rng.random_range(low.ln()..high.ln())).exp()
}

fn of_column(rng: &mut ChaCha8Rng) -> String {
    let column = one_of(&COLUMNS, rng);
    match rng.random_range(0..8) {
        0 => "offset:current_a^2".into(),
        1 => "offset:current_a@delay".into(),
        2 => format!("gain:{column}"),
        3 => "field:height_m".into(),
        _ => format!("offset:{column}"),
    }
}

fn any(rng: &mut ChaCha8Rng) -> String {
    match rng.random_range(0..12) {
        0 => "drift".into(),
        1 => "step".into(),
        2 => "lag".into(),
        3 => "eddy".into(),
        4 => "periodic".into(),
        5 => "nonlinearity".into(),
        6 => "cross-axis".into(),
        _ => of_column(rng),
    }
}

/// The effects of a kind of log, as `ID=STRENGTH`.
fn effects(kind: Kind, rng: &mut ChaCha8Rng) -> Vec<String> {
    let sized = |id: String, low: f64, high: f64, rng: &mut ChaCha8Rng| {
        match id.as_str() {
            // What the magnitude does not see is measured against the accelerometer, not against the noise.
            "lag" => format!("{id}={:.1}ms", about(15.0, 80.0, rng)),
            _ => format!("{id}={:.3}", about(low, high, rng)),
        }
    };
    match kind {
        Kind::One | Kind::OneFlicker => {
            let id = any(rng);
            vec![sized(id, 1.5, 10.0, rng)]
        }
        Kind::OfAttitude | Kind::OfAttitudeStrong => {
            let id = one_of(&["nonlinearity", "nonlinearity", "cross-axis"], rng);
            let (low, high) = if kind == Kind::OfAttitude { (1.5, 20.0) } else { (20.0, 40.0) };
            vec![sized(id.into(), low, high, rng)]
        }
        Kind::Strong => {
            let column = one_of(&COLUMNS, rng);
            let id = match rng.random_range(0..6) {
                0 => "offset:current_a^2".into(),
                1 => "offset:current_a@delay".into(),
                2 => format!("gain:{column}"),
                3 => "field:height_m".into(),
                4 => "step".into(),
                _ => format!("offset:{column}"),
            };
            vec![sized(id, 12.0, 20.0, rng)]
        }
        Kind::Several => {
            let count = if rng.random_range(0..3) == 0 { 3 } else { 2 };
            let mut list: Vec<String> = Vec::new();
            let base = |id: &str| id.split(['=', '^', '@']).next().unwrap_or("").replace("eddy", "lag");
            while list.len() < count {
                let id = any(rng);
                if list.iter().all(|other| base(other) != base(&id)) {
                    list.push(sized(id, 2.0, 8.0, rng));
                }
            }
            list
        }
        Kind::Nothing | Kind::NothingFlicker => Vec::new(),
        Kind::Deleted | Kind::Alike | Kind::AlikeGaps => {
            let column = one_of(&COLUMNS, rng);
            let id = if rng.random_range(0..4) == 0 { "gain" } else { "offset" };
            vec![sized(format!("{id}:{column}"), 1.5, 10.0, rng)]
        }
        Kind::Arrival => vec![sized("periodic".into(), 2.0, 8.0, rng)],
    }
}

fn options(kind: Kind, seed: u64, rng: &mut ChaCha8Rng) -> (WorldOptions, String) {
    let motions =
        [Motion::Tumbling, Motion::Eights, Motion::Waving, Motion::Table, Motion::Rings, Motion::Acro];
    let motion = one_of(&motions, rng);
    let rate_hz = match kind {
        Kind::Arrival => about(30.0, 200.0, rng),
        _ => about(10.0, 200.0, rng),
    }
    .round();
    let seconds = about(30.0, 400.0, rng).min(MOST_ROWS / rate_hz).round();
    let noise_ut = about(0.05, 0.6, rng);
    let (noise, noise_correlation, colour) = match kind {
        Kind::OneFlicker | Kind::NothingFlicker => (Noise::Flicker, 0.0, "1/f".to_string()),
        _ => match rng.random_range(0..4) {
            0 | 1 => (Noise::Memory, 0.0, "white".into()),
            2 => {
                let rho = rng.random_range(0.3..0.9);
                (Noise::Memory, rho, format!("AR {rho:.2}"))
            }
            _ => {
                let of = rng.random_range(2..9);
                (Noise::RollingMean(of), 0.0, format!("mean of {of}"))
            }
        },
    };
    let list = effects(kind, rng);
    let effects: Vec<EffectSpec> = list.iter().filter_map(|item| EffectSpec::parse(item).ok()).collect();
    let cause = effects.first().and_then(|spec| spec.columns().next()).unwrap_or("temp_c").to_string();
    let mut decoys = Vec::new();
    let plain = [Decoy::Walk, Decoy::Mode, Decoy::Switch, Decoy::Battery];
    for (index, decoy) in plain.into_iter().enumerate() {
        if rng.random_bool(0.5) {
            let names = ["baro", "mode", "switch", "battery_v"];
            decoys.push((names[index].to_string(), decoy));
        }
    }
    let mut empty_cells = Vec::new();
    let mut alike = String::new();
    if matches!(kind, Kind::Alike | Kind::AlikeGaps) {
        let correlation = rng.random_range(0.7..0.97);
        alike = format!(", alike {correlation:.2}");
        decoys.push(("alike".into(), Decoy::Alike { column: cause.clone(), correlation }));
        if kind == Kind::AlikeGaps {
            empty_cells.push((cause.clone(), rng.random_range(0.05..0.25)));
        }
    }
    let lsb_ut = noise_ut * one_of(&[0.0, 0.1, 0.3, 1.0], rng);
    let jitter = if kind == Kind::Arrival { rng.random_range(0.5..3.0) } else { 0.0 };
    let words = format!(
        "{motion:?} {seconds:.0} s {rate_hz:.0} Hz, {noise_ut:.2} µT {colour}, lsb {lsb_ut:.2}{alike}, {}",
        list.join(" ")
    );
    let options = WorldOptions {
        seed,
        seconds,
        rate_hz,
        noise_ut,
        noise_correlation,
        noise,
        lsb_ut,
        field_ut: rng.random_range(25.0..65.0),
        dip_deg: rng.random_range(20.0..75.0) * one_of(&[1.0, -1.0], rng),
        motion,
        effects,
        decoys,
        empty_cells,
        arrival_jitter_rows: jitter,
        drop_columns: if kind == Kind::Deleted { vec![cause] } else { Vec::new() },
        ..WorldOptions::default()
    };
    (options, words)
}

/// The log `number` of a kind. `family` keeps those that something was tuned on apart from those that it is measured on.
pub fn draw(kind: Kind, family: u64, number: u64) -> Drawn {
    let mut drawn = None;
    for attempt in 0..MOST_DRAWS {
        let seed = family
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(number.wrapping_mul(0xbf58_476d_1ce4_e5b9))
            .wrapping_add((kind as u64).wrapping_mul(0x94d0_49bb_1331_11eb))
            .wrapping_add(attempt.wrapping_mul(0xd6e8_feb8_6659_fd93));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (options, words) = options(kind, seed, &mut rng);
        let field = options.field_ut;
        let world = World::new(options);
        let size = world.disturbance_ut();
        let hidden: Vec<String> = world.hidden().iter().map(|effect| effect.kind.id()).collect();
        let plausible =
            hidden.is_empty() || (size > 0.0 && size < MOST_OF_FIELD * field && world.is_settled());
        drawn = Some(Drawn { world, hidden, words });
        if plausible {
            break;
        }
    }
    // At least one draw was made.
    drawn.unwrap_or_else(|| Drawn {
        world: World::new(WorldOptions::default()),
        hidden: Vec::new(),
        words: String::new(),
    })
}
