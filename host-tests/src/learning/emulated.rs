//! The same traces on the firmware in QEMU: the chip model feels the world's field and temperature, the console is fed the rest.
//!
//! The board's own clock is the world's: after each sample that it streams the machine stands still while the world moves on, so
//! that a busy host takes longer and measures the same.

use super::table::is_right;
use super::trace::{Kind, Said};
use ironout_rig::qemu::{Emulator, Error, Firmware, Options, Reply, SAMPLE_LIMIT};
use ironout_simulation::{Temperature, World, WorldOptions};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The Earth's field, µT.
const FIELD_UT: f64 = 50.0;
/// Hard iron on every axis: the emulated sensor knows no negative fields.
const HARD_IRON_UT: f64 = 93.0;
/// Noise that the emulated chip does not have, µT on each axis.
const NOISE_UT: f64 = 0.25;
/// One count of the emulated LSM303DLHC on x and y at ±1.9 gauss (datasheet table 75), µT: its rounding is noise too.
const STEP_UT: f64 = 100.0 / 855.0;
/// How large a hidden effect is, in noises.
const STRENGTH: f64 = 3.0;
/// From one sample to the next, s of the board's clock.
const SAMPLE_S: f64 = 0.02;
/// Seconds between two looks at the chip's temperature, half the board's own.
const WARM_S: f64 = 0.125;

/// How long the parts of a trace are, s of the board's clock.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// What is collected before `why`.
    pub collect_s: f64,
    /// What is streamed to measure a residual.
    pub stream_s: f64,
}

/// What one trace has shown.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What `why` answered.
    pub said: Said,
    /// Whether that is right.
    pub is_right: bool,
    /// The last line that `cal stop` was answered: without an effect that is hidden its calibration may be refused.
    pub stopped: String,
    /// What was streamed once the effect was added, where it was asked for.
    pub learnt: Option<Learnt>,
    /// What its samples were.
    pub samples: Samples,
}

/// Samples of a trace, and those that a busy host spoilt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Samples {
    /// All.
    pub all: u64,
    /// Of those, how many saw the world of the sample before, because the host was late, ...
    pub late: u64,
    /// ... and how many the field of their own time, and accelerometer or gyro of the sample before.
    pub mixed: u64,
}

impl Samples {
    /// Whether the host was too busy for this trace to say anything: one in five with a motion that is a sample old is a delay of
    /// four milliseconds that nobody has hidden.
    pub fn is_spoilt(&self) -> bool {
        self.mixed * 5 > self.all
    }
}

/// Rms of what is streamed over what noise alone leaves of it: the very noise of those samples and the sensor's rounding. Of a lag,
/// which the magnitude does not show, that of the field along gravity; of the others that of the magnitude.
#[derive(Clone, Debug)]
pub struct Learnt {
    /// Before; `None` where no calibration was in use.
    pub before: Option<f64>,
    /// After `effect add`, ...
    pub added: f64,
    /// ... after a power cut, ...
    pub restarted: f64,
    /// ... after `effect remove`.
    pub removed: f64,
    /// Whether the calibration was the same after the power cut, to the last digit.
    pub is_kept: bool,
    /// What `effect add`, `cal show` and `effect remove` answered.
    pub answers: String,
}

/// A board in QEMU, in a world.
struct Bench {
    world: World,
    kind: Kind,
    board: Emulator,
    rng: ChaCha8Rng,
    /// The world's clock at the board's power-up, and at the sample that comes next, s.
    origin_s: f64,
    now_s: f64,
    warmed_s: f64,
    fed_a: Option<f64>,
    samples: Samples,
    /// Whether accelerometer and gyro are fed: where a delay is hidden, and in every second trace with nothing.
    motion: bool,
}

/// What a sample was streamed as, with the world's clock at it, the field without hard iron and the noise in it, both in the sensor's
/// axes.
struct Streamed {
    line: String,
    at_s: f64,
    field_ut: Vector3<f64>,
    noise_ut: Vector3<f64>,
}

impl Bench {
    fn start(firmware: &Firmware, kind: Kind, seed: u64, lengths: Lengths) -> Result<Self, Error> {
        let world = World::new(WorldOptions {
            seed,
            seconds: lengths.collect_s + 1.0,
            noise_ut: NOISE_UT,
            hard_iron_ut: Some([HARD_IRON_UT; 3]),
            temperature: if kind == Kind::Ramp { Temperature::Ramp } else { Temperature::WarmUp },
            effects: kind.spec(STRENGTH).into_iter().collect(),
            ..WorldOptions::default()
        });
        Ok(Self {
            world,
            kind,
            board: Emulator::start(firmware, &Options::default())?,
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0x7165_6d75),
            origin_s: 0.0,
            now_s: 0.0,
            warmed_s: f64::NEG_INFINITY,
            fed_a: None,
            samples: Samples::default(),
            motion: kind == Kind::Lag || kind == Kind::Clean && seed.is_multiple_of(2),
        })
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }

    /// What the board is told of the world before its next sample.
    fn feeds(&mut self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.motion {
            let accel = self.world.accel_mps2(self.now_s).map(|force| force + 0.05 * self.normal());
            let turn = self.world.rates_radps(self.now_s).map(|rate| rate + 0.005 * self.normal());
            lines
                .push(format!("cov ax_mps2={:.4} ay_mps2={:.4} az_mps2={:.4}", accel[0], accel[1], accel[2]));
            lines
                .push(format!("cov gx_radps={:.5} gy_radps={:.5} gz_radps={:.5}", turn[0], turn[1], turn[2]));
        }
        if !matches!(self.kind, Kind::Lag | Kind::Ramp) {
            let current_a = (self.world.covariate("current_a", self.now_s) * 100.0).round() / 100.0;
            if self.fed_a != Some(current_a) {
                lines.push(format!("cov current_a={current_a:.2}"));
                self.fed_a = Some(current_a);
            }
        }
        lines
    }

    /// Puts the board into the world as it is when its next sample comes, and waits for that sample. A stream has to be on.
    fn sample(&mut self) -> Result<Streamed, Error> {
        let feeds = self.feeds();
        let noise: [f64; 3] = std::array::from_fn(|_| NOISE_UT * self.normal());
        let clean = self.world.sensor_ut(self.now_s);
        self.board.pause()?;
        // Samples that came before the machine stood still saw what the last one saw.
        let late = self.board.console.take_streamed().len() as u64;
        self.board.put_field_ut([0, 1, 2].map(|axis| clean[axis] + noise[axis]))?;
        if self.now_s - self.warmed_s >= WARM_S {
            self.warmed_s = self.now_s;
            self.board.set_temperature_c(self.world.covariate("temp_c", self.now_s))?;
        }
        for line in &feeds {
            self.board.console.send(format!("{line}\n").as_bytes())?;
        }
        self.board.resume()?;
        for line in &feeds {
            let reply = self.board.console.reply(line)?;
            expected(line, &reply, reply.is_ok())?;
        }
        // A sample that came before the board had read all of it.
        self.samples.mixed += u64::from(self.motion && self.board.console.has_streamed());
        let line = self.board.console.next_streamed(SAMPLE_LIMIT)?;
        let t_ms = line.split(',').nth(1).and_then(|word| word.parse::<f64>().ok());
        let t_ms =
            t_ms.ok_or_else(|| Error::Protocol { line: line.clone(), expected: "R,t_ms,… or C,t_ms,…" })?;
        let at_s = self.now_s;
        self.now_s = self.origin_s + t_ms * 1e-3 + SAMPLE_S;
        self.samples.all += 1 + late;
        self.samples.late += late;
        let field_ut = Vector3::from(clean).add_scalar(-HARD_IRON_UT);
        Ok(Streamed { line, at_s, field_ut, noise_ut: Vector3::from(noise) })
    }

    fn run(&mut self, seconds: f64) -> Result<Vec<Streamed>, Error> {
        let end_s = self.now_s + seconds;
        let mut all = Vec::new();
        while self.now_s < end_s {
            all.push(self.sample()?);
        }
        Ok(all)
    }

    fn ok(&mut self, command: &str) -> Result<Reply, Error> {
        let reply = self.board.console.command(command)?;
        expected(command, &reply, reply.is_ok())?;
        Ok(reply)
    }

    /// Collects, and accepts what comes of it if it is accepted.
    fn calibrate(&mut self, lengths: Lengths) -> Result<Reply, Error> {
        self.ok(&format!("field {FIELD_UT}"))?;
        self.ok("stream raw")?;
        self.settle()?;
        self.ok("cal start")?;
        self.run(lengths.collect_s)?;
        self.quiet()?;
        let stopped = self.board.console.command("cal stop")?;
        if stopped.is_ok() {
            self.ok("cal accept")?;
        }
        Ok(stopped)
    }

    /// Until nothing is left of the emulated sensor's start, without any field and at no temperature of the world: the temperature is
    /// asked for four times a second.
    fn settle(&mut self) -> Result<(), Error> {
        self.run(0.6).map(drop)
    }

    fn quiet(&mut self) -> Result<(), Error> {
        self.ok("stream off")?;
        self.board.console.take_streamed();
        Ok(())
    }

    fn why(&mut self) -> Result<Said, Error> {
        let reply = self.ok("why")?;
        Ok(Said { lines: reply.to_string().lines().map(str::to_owned).collect() })
    }

    /// Rms of what is streamed over that of noise: [`Learnt`] says of what. `None` where the board corrects nothing.
    fn streamed(&mut self, seconds: f64) -> Result<Option<f64>, Error> {
        self.ok("stream cal")?;
        // One that needs a column waits for it.
        self.run(1.0)?;
        let streamed = self.run(seconds)?;
        self.quiet()?;
        let rows: Vec<(&Streamed, Vector3<f64>, f64)> = streamed
            .iter()
            .filter_map(|one| {
                let words: Vec<f64> =
                    one.line.strip_prefix("C,")?.split(',').map_while(|word| word.parse().ok()).collect();
                let &[_, x, y, z, _, residual] = words.as_slice() else { return None };
                Some((one, Vector3::new(x, y, z), residual))
            })
            .collect();
        // Nearly all: a column may have been forgotten for a moment.
        if rows.len() * 10 < streamed.len() * 9 {
            return Ok(None);
        }
        let (left, noise) = if self.kind == Kind::Lag {
            let measured: Vec<_> = rows.iter().map(|(one, field, _)| (*field, one.at_s)).collect();
            let down = |at_s| -Vector3::from(self.world.accel_mps2(at_s)).normalize();
            let noise = rows.iter().map(|(one, ..)| one.noise_ut.dot(&down(one.at_s)).powi(2)).sum::<f64>();
            (along_gravity(&self.world, &measured), noise)
        } else {
            let along = |one: &Streamed| one.noise_ut.dot(&one.field_ut.normalize());
            (rows.iter().map(|row| row.2 * row.2).sum(), rows.iter().map(|row| along(row.0).powi(2)).sum())
        };
        let rounding = rows.len() as f64 * STEP_UT * STEP_UT / 12.0;
        Ok(Some((left / (noise + rounding)).sqrt()))
    }

    /// Cuts the power; the world goes on.
    fn power_cut(self) -> Result<Self, Error> {
        let board = self.board.power_cut()?.start()?;
        let now_s = self.now_s;
        Ok(Self { board, origin_s: now_s, warmed_s: f64::NEG_INFINITY, fed_a: None, ..self })
    }
}

/// The sum of squares of what is left of the field along gravity by a constant and a tilt between the axes of both sensors.
fn along_gravity(world: &World, rows: &[(Vector3<f64>, f64)]) -> f64 {
    let down = |at_s: f64| -Vector3::from(world.accel_mps2(at_s)).normalize();
    let along = DVector::from_iterator(rows.len(), rows.iter().map(|(field, at_s)| field.dot(&down(*at_s))));
    let of_row = |row: usize| {
        let (field, at_s) = rows[row];
        let tilt = field.cross(&down(at_s));
        [1.0, tilt.x, tilt.y, tilt.z]
    };
    let design = DMatrix::from_fn(rows.len(), 4, |row, column| of_row(row)[column]);
    let normal = design.tr_mul(&design);
    let fitted = normal.cholesky().map(|factor| factor.solve(&design.tr_mul(&along)));
    fitted.map_or(f64::NAN, |fitted| (along - design * fitted).norm_squared())
}

fn expected(command: &str, reply: &Reply, is_right: bool) -> Result<(), Error> {
    if is_right {
        return Ok(());
    }
    Err(Error::Protocol { line: format!("{command}: {reply}"), expected: "ok" })
}

/// Runs a trace on a new board: calibrates, asks why, and where an effect is hidden that it names, adds it, cuts the power and takes it
/// out again.
///
/// # Errors
/// The emulator is gone, or the board refuses what it has to do.
pub fn run(firmware: &Firmware, kind: Kind, seed: u64, lengths: Lengths) -> Result<Shown, Error> {
    let mut bench = Bench::start(firmware, kind, seed, lengths)?;
    let stopped = bench.calibrate(lengths)?;
    let said = bench.why()?;
    let is_right = is_right(kind, &said);
    let mut samples = bench.samples;
    let learnt = if is_right && Kind::HIDDEN.contains(&kind) {
        let before = if stopped.is_ok() { bench.streamed(lengths.stream_s)? } else { None };
        let taken_in = bench.ok(&format!("effect add {}", kind.id()))?;
        let added = bench.streamed(lengths.stream_s)?;
        let shown = bench.ok("cal show")?;
        bench = bench.power_cut()?;
        bench.ok("stream raw")?;
        bench.settle()?;
        bench.quiet()?;
        // The study of the new session begins here.
        bench.ok("cal start")?;
        bench.ok("cal cancel")?;
        let is_kept = bench.ok("cal show")?.to_string() == shown.to_string();
        let restarted = bench.streamed(lengths.stream_s)?;
        let taken_out = bench.ok(&format!("effect remove {}", kind.id()))?;
        let removed = bench.streamed(lengths.stream_s)?;
        samples = bench.samples;
        Some(Learnt {
            before,
            added: added.unwrap_or(f64::NAN),
            restarted: restarted.unwrap_or(f64::NAN),
            removed: removed.unwrap_or(f64::NAN),
            is_kept,
            answers: format!("{taken_in}\n{shown}\n{taken_out}"),
        })
    } else {
        None
    };
    let stopped = stopped.to_string().lines().last().unwrap_or_default().to_owned();
    Ok(Shown { said, is_right, stopped, learnt, samples })
}
