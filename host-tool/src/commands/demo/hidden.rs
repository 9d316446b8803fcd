//! The story of a hidden effect: the board calibrates itself, is still wrong, says why, learns it and keeps it.
//!
//! The clock of the story is the board's own: the field moves on when the board has sampled it, and a question that the
//! samples do not carry yet is asked again after more of them. A slow machine takes longer and tells the same.

use crate::cli::{DemoArgs, HiddenArg};
use crate::commands::demo::talk::{Talk, numbers};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::output::line;
use crate::progress::Progress;
use ironout_simulation::{EffectSpec, World, WorldOptions};

/// The Earth's field, µT.
const FIELD_UT: f64 = 48.0;
/// Hard iron on every axis: the emulated sensor knows no negative fields.
const HARD_IRON_UT: [f64; 3] = [93.0; 3];
/// Noise of the sensor on each axis, µT.
const NOISE_UT: f64 = 0.25;
/// How strong the hidden effect is, in noises.
const STRENGTH: f64 = 5.0;
/// Attitudes a second of the simulated world, which is what the board takes two samples for.
const RATE_HZ: f64 = 25.0;
/// Attitudes of the calibration, and of all that the simulated world has.
const CALIBRATION: usize = 400;
const ATTITUDES: usize = 1400;
/// Attitudes in which an error is measured.
const PROBES: usize = 50;
/// Without the effect nothing has to be known of its column: the error is looked at over all that happens there and back.
const STRIDE: usize = 2 * ATTITUDES / PROBES;
/// More of them before the question is asked again, and how often.
const MORE: usize = 200;
const ROUNDS: usize = 12;
/// Attitudes in which a column may stay unknown to a board that has just started.
const PATIENCE: usize = 200;
/// With the effect the error may be this many times that of the noise: over so few probes noise alone varies by a tenth.
const GOOD: f64 = 1.35;

impl HiddenArg {
    fn id(self) -> &'static str {
        match self {
            HiddenArg::Temperature => "offset:temp_c",
            HiddenArg::Current => "offset:current_a",
            HiddenArg::Step => "step",
        }
    }

    /// Attitudes of the work after the calibration, in which it acts: a column has to go through its range, a jump to happen.
    fn work(self) -> usize {
        if self == HiddenArg::Step { 1000 } else { 700 }
    }

    /// The column that it follows; any where it follows none.
    fn column(self) -> &'static str {
        if self == HiddenArg::Current { "current_a" } else { "temp_c" }
    }

    fn words(self) -> &'static str {
        match self {
            HiddenArg::Temperature => "the chip warms up, and its offset moves with its temperature",
            HiddenArg::Current => {
                "the motors run, and their current moves the offset (the board is told it: cov current_a=…)"
            }
            HiddenArg::Step => "something magnetic is attached, and the offset jumps",
        }
    }
}

/// Errors of the magnitude, µT rms.
struct Figures {
    floor: f64,
    before: f64,
    learnt: f64,
    restarted: f64,
    removed: f64,
    rounds: usize,
    first: String,
}

/// Tells the story, or gives its figures as JSON.
pub fn run(effect: HiddenArg, arguments: &DemoArgs, json: bool) -> Outcome<u8> {
    if !json {
        line("A board calibrates itself, is still wrong, and says why.\n");
    }
    let talk = Talk::start(arguments, json)?;
    let emulated = talk.emulated;
    let figures = Story { talk, world: Turning::new(effect)?, effect, fed: None }.run()?;
    let good = figures.first == effect.id()
        && figures.learnt.max(figures.restarted) <= GOOD * figures.floor
        && figures.before.min(figures.removed) >= 2.0 * figures.learnt;
    if json {
        line(
            &serde_json::json!({
                "emulated": emulated, "hidden": effect.id(), "named_first": figures.first, "asked": figures.rounds,
                "floor_ut": figures.floor, "before_ut": figures.before, "learnt_ut": figures.learnt,
                "after_restart_ut": figures.restarted, "removed_ut": figures.removed,
            })
            .to_string(),
        );
    } else {
        line(&format!(
            "\nerror of the magnitude, rms:  calibrated {:.2} µT  →  with {} {:.2} µT  →  after the power cut {:.2} µT\n\
             →  without it again {:.2} µT; the sensor's noise alone makes {:.2} µT",
            figures.before,
            effect.id(),
            figures.learnt,
            figures.restarted,
            figures.removed,
            figures.floor
        ));
    }
    Ok(if good { EXIT_OK } else { EXIT_REFUSED })
}

/// A board in the hand: one attitude after the other, with what the chips feel there. While it is calibrated nothing but the
/// attitude changes; the hidden effect acts afterwards.
struct Turning {
    calm: World,
    world: World,
    /// Noise of each axis, µT, over and over.
    noise_ut: Vec<[f64; 3]>,
    /// The value of the column at which the effect is nothing, and from which it goes on after the calibration.
    reference: f64,
    from: usize,
    effect: HiddenArg,
    attitude: usize,
}

impl Turning {
    fn new(effect: HiddenArg) -> Outcome<Self> {
        let spec = EffectSpec::parse(&format!("{}={STRENGTH}", effect.id()))
            .map_err(|error| Failure::usage(error.to_string()))?;
        let options = WorldOptions {
            seed: 2015,
            field_ut: FIELD_UT,
            hard_iron_ut: Some(HARD_IRON_UT),
            noise_ut: NOISE_UT,
            lsb_ut: 0.0,
            seconds: ATTITUDES as f64 / RATE_HZ,
            rate_hz: RATE_HZ,
            ..WorldOptions::default()
        };
        let calm = World::new(options.clone());
        let world = World::new(WorldOptions { effects: vec![spec], ..options });
        let log = calm.run();
        let axes =
            ["mx_ut", "my_ut", "mz_ut"].map(|name| log.position(name).and_then(|at| log.columns.get(at)));
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(Failure::usage("the simulation has no magnetometer"));
        };
        let noise_ut = (x.iter().zip(y).zip(z).enumerate())
            .map(|(row, ((x, y), z))| {
                let clean = calm.sensor_ut(row as f64 / RATE_HZ);
                [x - clean[0], y - clean[1], z - clean[2]]
            })
            .collect();
        let reference = world.hidden().first().map_or(0.0, |hidden| hidden.drawn.reference);
        let column = |row: usize| world.covariate(effect.column(), row as f64 / RATE_HZ);
        let from = (0..ATTITUDES).find(|row| column(*row) >= reference).unwrap_or(0);
        Ok(Turning { calm, world, noise_ut, reference, from, effect, attitude: 0 })
    }

    /// Whether it is being calibrated, and nothing but the attitude changes.
    fn is_calm(&self) -> bool {
        self.attitude < CALIBRATION && self.effect != HiddenArg::Step
    }

    /// The time in the world: what happens there goes back and forth, but for what happens once.
    fn t_s(&self) -> f64 {
        let (way, there) = (2 * ATTITUDES - 2, ATTITUDES - 1);
        let at = if self.is_calm() || self.effect == HiddenArg::Step {
            self.attitude
        } else {
            self.from + self.attitude.saturating_sub(CALIBRATION)
        } % way;
        let row = if at > there { way - at } else { at };
        row as f64 / RATE_HZ
    }

    /// The field along the sensor's axes, noise and all, µT.
    fn field_ut(&self) -> [f64; 3] {
        let world = if self.is_calm() { &self.calm } else { &self.world };
        let mut clean = world.sensor_ut(self.t_s());
        if self.effect == HiddenArg::Step && self.attitude >= ATTITUDES {
            // On the way back it stays attached.
            let end_s = (ATTITUDES - 1) as f64 / RATE_HZ;
            let (with, without) = (self.world.sensor_ut(end_s), self.calm.sensor_ut(end_s));
            let calm = self.calm.sensor_ut(self.t_s());
            clean = [0, 1, 2].map(|axis| calm[axis] + with[axis] - without[axis]);
        }
        let noise =
            self.noise_ut.get(self.attitude % self.noise_ut.len().max(1)).copied().unwrap_or_default();
        [0, 1, 2].map(|axis| clean[axis] + noise[axis])
    }

    fn column(&self, name: &str) -> f64 {
        if self.is_calm() && name == self.effect.column() {
            return self.reference;
        }
        self.world.covariate(name, self.t_s())
    }
}

struct Story {
    talk: Talk,
    world: Turning,
    effect: HiddenArg,
    /// The current that the board was told last.
    fed: Option<f64>,
}

impl Story {
    fn run(mut self) -> Outcome<Figures> {
        self.talk.ask("version")?;
        self.talk
            .say(&format!("\nThe board stands in a field of {FIELD_UT} µT and is calibrated in peace.\n"));
        self.talk.ok(&format!("field {FIELD_UT}"))?;
        self.talk.quiet("stream raw")?;
        // The emulated sensor starts without any field at all, which is no attitude.
        self.attitude()?;
        self.talk.ok("cal start")?;
        self.talk.say(&format!("Turning it through {CALIBRATION} attitudes …"));
        self.turn(CALIBRATION)?;
        self.talk.quiet("stream off")?;
        self.talk.ok("cal stop")?;
        self.talk.ok("cal accept")?;
        self.talk.say(&format!(
            "\nNow it works for {} attitudes, and what nobody has told it: {}.",
            self.effect.work(),
            self.effect.words()
        ));
        self.talk.quiet("stream raw")?;
        self.turn(self.effect.work())?;
        self.talk.quiet("stream off")?;
        let before = self.error(1)?;
        self.talk.say(&format!(
            "  it is off by {before:.2} µT rms, and its noise alone would make {NOISE_UT:.2} µT. Why?\n"
        ));
        let id = self.effect.id();
        let (first, rounds) = self.named_and_added(id)?;
        let learnt = self.error(1)?;
        self.talk.say(&format!("  now it is off by {learnt:.2} µT\n"));

        let how = if self.talk.emulated { " (kill -9)" } else { "" };
        self.talk.say(&format!("Cutting the power{how}, and starting the board again:"));
        let Story { talk, world, effect, .. } = self;
        let mut again = Story { talk: talk.power_cut()?, world, effect, fed: None };
        again.talk.ask("cal show")?;
        let restarted = again.error(1)?;
        again.talk.say(&format!("  it has kept what it learnt: off by {restarted:.2} µT\n"));
        again.talk.say("And to see that it is this effect and nothing else:");
        again.talk.ok(&format!("effect remove {id}"))?;
        let removed = again.error(STRIDE)?;
        again.talk.say(&format!("  without it the old error is back: {removed:.2} µT"));
        Ok(Figures { floor: NOISE_UT, before, learnt, restarted, removed, rounds, first })
    }

    /// Asks what is missing and adds it; where the samples do not carry that yet, turns the board further and asks again.
    fn named_and_added(&mut self, id: &str) -> Outcome<(String, usize)> {
        let mut asked = 0;
        loop {
            let (first, round) = self.why(asked)?;
            let command = format!("effect add {id}");
            let answer = self.talk.board.command(&command)?;
            self.talk.show(&command, &answer);
            if answer.is_ok() {
                return Ok((first, round));
            }
            if round == ROUNDS || !answer.closing.contains("refused not-needed") {
                return Err(Failure::refused(format!(
                    "the board answered `{command}` with: {}",
                    answer.closing
                )));
            }
            self.talk.say("  it is seen, and unseen samples do not bear it out yet; turning it further …");
            self.talk.quiet("stream raw")?;
            self.turn(MORE)?;
            self.talk.quiet("stream off")?;
            asked = round;
        }
    }

    /// Asks until the samples carry an answer that names something; the id that comes first, and how often it was asked.
    fn why(&mut self, asked: usize) -> Outcome<(String, usize)> {
        for round in asked + 1..=ROUNDS {
            // Asked quietly first: an answer that there is not enough yet is no part of the story.
            let answer = self.talk.board.command("why")?;
            let first = answer.values("first").next().unwrap_or("-").to_string();
            if answer.is_ok() && first != "-" {
                self.talk.show("why", &answer);
                return Ok((first, round));
            }
            if round == ROUNDS {
                self.talk.show("why", &answer);
                break;
            }
            self.talk.say(&format!("  not enough to tell yet ({}); turning it further …", answer.closing));
            self.talk.quiet("stream raw")?;
            self.turn(MORE)?;
            self.talk.quiet("stream off")?;
        }
        Err(Failure::refused("the board names no effect, though there is one: see the answers to `why`"))
    }

    fn turn(&mut self, attitudes: usize) -> Outcome<()> {
        let mut progress = Progress::new("turning", attitudes as u64, !self.talk.json);
        for attitude in 0..attitudes {
            self.attitude()?;
            progress.at(attitude as u64);
        }
        Ok(())
    }

    /// Puts the board into the next attitude, with what it is told there; the line of the stream about it.
    fn attitude(&mut self) -> Outcome<String> {
        let field_ut = self.world.field_ut();
        self.talk.board.warm(self.world.column("temp_c"))?;
        if self.effect == HiddenArg::Current {
            // What an ammeter shows.
            let current_a = (self.world.column("current_a") * 20.0).round() / 20.0;
            if self.fed != Some(current_a) {
                self.talk.quiet(&format!("cov current_a={current_a}"))?;
                self.fed = Some(current_a);
            }
        }
        self.world.attitude += 1;
        self.talk.board.expose(field_ut)
    }

    /// Rms of the corrected magnitude about F, µT, in attitudes that come next, or each so many of them.
    fn error(&mut self, stride: usize) -> Outcome<f64> {
        self.talk.quiet("stream cal")?;
        let (mut squares, mut probes, mut unknown) = (0.0, 0, 0);
        while probes < PROBES {
            let text = self.attitude()?;
            self.world.attitude += stride - 1;
            let Some(norm) = numbers(text.strip_prefix("C,").unwrap_or_default(), 4).first().copied() else {
                // A column that the effect needs is not known yet.
                unknown += 1;
                if unknown > PATIENCE {
                    return Err(Failure::refused(format!(
                        "the board does not correct: it streams \"{text}\""
                    )));
                }
                continue;
            };
            squares += (norm - FIELD_UT) * (norm - FIELD_UT);
            probes += 1;
        }
        self.talk.quiet("stream off")?;
        Ok((squares / PROBES as f64).sqrt())
    }
}
