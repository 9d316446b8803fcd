//! One trace: a board in a world with a hidden effect, its chips and its feeds, and what its console says of it.

use ironout::device::Pace;
use ironout_rig::board::{SimBoard, SimOptions};
use ironout_simulation::{EffectSpec, Motion, Temperature, World, WorldOptions};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What is hidden in a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing.
    Clean,
    /// An offset proportional to the chip's temperature.
    Temperature,
    /// An offset that follows a current.
    Current,
    /// A late sensor.
    Lag,
    /// A jump of the offset.
    Step,
    /// A temperature that goes one way, as the clock does.
    Ramp,
}

impl Kind {
    /// Those with one hidden effect that can be told.
    pub const HIDDEN: [Kind; 4] = [Kind::Temperature, Kind::Current, Kind::Lag, Kind::Step];

    /// The id by which the board names it.
    pub const fn id(self) -> &'static str {
        match self {
            Kind::Clean => "",
            Kind::Temperature | Kind::Ramp => "offset:temp_c",
            Kind::Current => "offset:current_a",
            Kind::Lag => "lag",
            Kind::Step => "step",
        }
    }

    /// The name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Clean => "clean",
            Kind::Temperature => "temperature",
            Kind::Current => "current",
            Kind::Lag => "lag",
            Kind::Step => "step",
            Kind::Ramp => "temperature as the clock",
        }
    }

    pub(super) fn spec(self, strength: f64) -> Option<EffectSpec> {
        let text = match self {
            Kind::Clean => return None,
            // In time: three noises are 18 ms.
            Kind::Lag => format!("lag={}ms", 6.0 * strength),
            _ => format!("{}={strength}", self.id()),
        };
        Some(EffectSpec::parse(&text).expect("an effect of the simulation"))
    }
}

/// How a trace is made.
#[derive(Clone, Copy, Debug)]
pub struct TraceOptions {
    /// Of everything random.
    pub seed: u64,
    /// What is hidden.
    pub kind: Kind,
    /// How large it is, in noises.
    pub strength: f64,
    /// How the board is turned.
    pub motion: Motion,
    /// Noise of the sensor on each axis, µT, ...
    pub noise_ut: f64,
    /// ... and its correlation from one conversion (75 a second) to the next.
    pub correlation: f64,
    /// Seconds that are collected before `why`.
    pub seconds: u64,
    /// Whether there is a gyro where there is an accelerometer.
    pub gyro: bool,
}

impl TraceOptions {
    /// A trace of 80 s with an effect of three noises.
    pub fn new(kind: Kind, seed: u64) -> Self {
        Self {
            seed,
            kind,
            strength: 3.0,
            motion: Motion::Sphere,
            noise_ut: 0.25,
            correlation: 0.0,
            seconds: 80,
            gyro: true,
        }
    }
}

/// The answer to `why`.
#[derive(Clone, Debug)]
pub struct Said {
    /// All lines.
    pub lines: Vec<String>,
}

impl Said {
    fn value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
        line.split(' ').find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
    }

    /// A value of the last line.
    pub fn last(&self, key: &str) -> &str {
        self.lines.last().and_then(|line| Self::value(line, key)).unwrap_or("")
    }

    /// A value of the first line.
    pub fn base(&self, key: &str) -> f64 {
        self.lines
            .first()
            .and_then(|line| Self::value(line, key))
            .and_then(|text| text.parse().ok())
            .unwrap_or(f64::NAN)
    }

    /// A value of an effect's line.
    pub fn of(&self, id: &str, key: &str) -> Option<&str> {
        let line = self.lines.iter().find(|line| Self::value(line, "id") == Some(id))?;
        Self::value(line, key)
    }

    /// The verdict.
    pub fn verdict(&self) -> &str {
        self.last("verdict")
    }

    /// The effect that is named first.
    pub fn first(&self) -> &str {
        self.last("first")
    }
}

/// A board in its world.
pub struct Trace {
    /// The world.
    pub world: World,
    /// The board.
    pub board: SimBoard,
    options: TraceOptions,
    /// The clock of the world at the board's power-up, s.
    ms: u64,
    rng: ChaCha8Rng,
    current: bool,
    motion: bool,
}

impl Trace {
    /// A board in a world, powered up.
    pub fn new(options: TraceOptions) -> Self {
        let temperature = if options.kind == Kind::Ramp { Temperature::Ramp } else { Temperature::WarmUp };
        let world = World::new(WorldOptions {
            seed: options.seed,
            seconds: options.seconds as f64 + 1.0,
            motion: options.motion,
            noise_ut: options.noise_ut,
            temperature,
            effects: options.kind.spec(options.strength).into_iter().collect(),
            ..WorldOptions::default()
        });
        let field = Coloured {
            world: world.clone(),
            rng: ChaCha8Rng::seed_from_u64(options.seed ^ 0x636f_6c6f_7572),
            rho: options.correlation,
            noise_ut: options.noise_ut,
            now: [0.0; 3],
        };
        // White noise is the chip's own.
        let chip_ut = if options.correlation > 0.0 { 0.0 } else { options.noise_ut };
        // Each conversion as it comes, so that no sample is old before it is read.
        let sim = SimOptions { pace: Pace::EachConversion, ..SimOptions::default() };
        let board = SimBoard::with(sim, field, chip_ut, options.seed);
        let current = matches!(options.kind, Kind::Current | Kind::Clean | Kind::Temperature | Kind::Step);
        let rng = ChaCha8Rng::seed_from_u64(options.seed ^ 0x6d6f_7469_6f6e);
        let motion = matches!(options.kind, Kind::Lag | Kind::Clean);
        Self { world, board, options, ms: 0, rng, current, motion }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }

    /// Feeds the chips and the board with what the world has now.
    fn feed(&mut self) {
        let t_s = self.board.clock.ms() as f64 * 1e-3;
        self.board.mag.borrow_mut().temperature_c = self.world.covariate("temp_c", t_s);
        if self.motion {
            let accel = self.world.accel_mps2(t_s).map(|force| (force + 0.05 * self.normal()) as f32);
            let rates = self.world.rates_radps(t_s);
            let turn = rates.map(|rate| (rate + 0.005 * self.normal()) as f32);
            self.board.device.on_motion(Some(accel), self.options.gyro.then_some(turn));
        }
        if self.current && self.ms.is_multiple_of(20) {
            let current_a = self.world.covariate("current_a", t_s);
            self.board.send(format!("cov current_a={current_a:.3}\n").as_bytes());
        }
    }

    /// Lets it run, fed all the while.
    pub fn run_ms(&mut self, ms: u64) {
        // Motion is as fresh as the sample.
        let beat_ms = if self.motion { 2 } else { 10 };
        for _ in 0..ms / beat_ms {
            self.feed();
            self.board.run_ms(beat_ms);
            self.ms += beat_ms;
        }
    }

    /// The last line of the answer to a command.
    pub fn last(&mut self, command: &str) -> String {
        self.board.command(command).pop().unwrap_or_default()
    }

    /// Collects, and accepts what comes of it if it is accepted.
    pub fn calibrate(&mut self) {
        self.run_ms(200);
        self.last("field 50");
        assert_eq!(self.last("cal start"), "ok state=collecting");
        self.run_ms(1000 * self.options.seconds);
        // One that lacks an effect may be refused: the study goes on from what there is.
        if self.last("cal stop").starts_with("ok verdict=accepted") {
            assert!(self.last("cal accept").starts_with("ok calibrated=1 "));
        }
    }

    /// The values of the last of each `C` line over some seconds: the residual of the corrected magnitude, µT, and the corrected field.
    pub fn streamed(&mut self, seconds: u64) -> Vec<([f64; 3], f64)> {
        self.last("stream cal");
        self.run_ms(1000 * seconds);
        let lines = self.board.received();
        self.last("stream off");
        let numbers = |line: &String| -> Option<Vec<f64>> {
            line.strip_prefix("C,")?.split(',').map(|word| word.parse().ok()).collect()
        };
        lines.iter().filter_map(numbers).map(|v| ([v[1], v[2], v[3]], v[5])).collect()
    }

    /// Rms of the residual that is streamed, µT; NaN where nothing is.
    pub fn streamed_rms_ut(&mut self, seconds: u64) -> f64 {
        let values = self.streamed(seconds);
        (values.iter().map(|(_, residual)| residual * residual).sum::<f64>() / values.len() as f64).sqrt()
    }

    /// What `why` says.
    pub fn why(&mut self) -> Said {
        Said { lines: self.board.command("why") }
    }
}

/// Noise with a memory, from one conversion to the next.
struct Coloured {
    world: World,
    rng: ChaCha8Rng,
    rho: f64,
    noise_ut: f64,
    now: [f64; 3],
}

impl ironout_rig::chips::FieldSource for Coloured {
    fn field_ut(&mut self, t_s: f64) -> [f64; 3] {
        let clean = self.world.sensor_ut(t_s);
        if self.rho <= 0.0 {
            return clean;
        }
        let fresh = (1.0 - self.rho * self.rho).sqrt() * self.noise_ut;
        std::array::from_fn(|axis| {
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            self.now[axis] = self.rho * self.now[axis] + fresh * normal;
            clean[axis] + self.now[axis]
        })
    }
}
