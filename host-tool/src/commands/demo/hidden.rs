//! The story of a hidden effect: the board calibrates itself, is still wrong, says why, learns it and keeps it.
//!
//! The clock of the story is the board's own: the field moves on when the board has sampled it, and a question that the
//! samples do not suffice for yet is asked again after more of them. A slow machine takes longer and tells the same.

use crate::cli::{DemoArgs, HiddenArg};
use crate::commands::demo::talk::{Talk, numbers};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::output::line;
use crate::progress::Progress;
use crate::turned::{ATTITUDES, FIELD_UT, NOISE_UT, Turned};

/// Attitudes of the calibration.
const CALIBRATION: usize = 400;
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

/// Attitudes of the work after the calibration, in which it acts: a column has to go through its range, a jump to happen.
fn work(effect: HiddenArg) -> usize {
    if effect == HiddenArg::Step { 1000 } else { 700 }
}

fn words(effect: HiddenArg) -> &'static str {
    match effect {
        HiddenArg::Temperature => "the chip warms up, and its offset moves with its temperature",
        HiddenArg::Current => {
            "the motors run, and their current moves the offset (sent to the board with cov current_a=…)"
        }
        HiddenArg::Step => "something magnetic is attached, and the offset jumps",
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
        line("A board calibrates itself, still has an error, and finds the cause.\n");
    }
    let talk = Talk::start(arguments, json)?;
    let emulated = talk.emulated;
    let figures = Story { talk, world: Turned::new(effect)?, effect, fed: None }.run()?;
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
             →  without it again {:.2} µT; noise floor {:.2} µT",
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

struct Story {
    talk: Talk,
    world: Turned,
    effect: HiddenArg,
    /// The current that the board was told last.
    fed: Option<f64>,
}

impl Story {
    fn run(mut self) -> Outcome<Figures> {
        self.talk.ask("version")?;
        self.talk
            .say(&format!("\nThe field is {FIELD_UT} µT. The board is calibrated without disturbance.\n"));
        self.talk.ok(&format!("field {FIELD_UT}"))?;
        self.talk.quiet("stream raw")?;
        // The emulated sensor starts without any field at all, which is not an attitude.
        self.attitude()?;
        self.talk.ok("cal start")?;
        self.talk.say(&format!("Rotating it through {CALIBRATION} orientations …"));
        if self.effect == HiddenArg::Step {
            // It jumps in its own time, once.
            self.world.work();
        }
        self.turn(CALIBRATION)?;
        self.world.work();
        self.talk.quiet("stream off")?;
        self.talk.ok("cal stop")?;
        self.talk.ok("cal accept")?;
        self.talk.say(&format!(
            "\nNow it runs for {} orientations, with a hidden effect: {}.",
            work(self.effect),
            words(self.effect)
        ));
        self.talk.quiet("stream raw")?;
        self.turn(work(self.effect))?;
        self.talk.quiet("stream off")?;
        let before = self.error(1)?;
        self.talk.say(&format!("  error {before:.2} µT rms (noise alone: {NOISE_UT:.2} µT). Why?\n"));
        let id = self.effect.id();
        let (first, rounds) = self.named_and_added(id)?;
        let learnt = self.error(1)?;
        self.talk.say(&format!("  error now: {learnt:.2} µT\n"));

        let how = if self.talk.emulated { " (kill -9)" } else { "" };
        self.talk.say(&format!("Cutting the power{how}, and starting the board again:"));
        let Story { talk, world, effect, .. } = self;
        let mut again = Story { talk: talk.power_cut()?, world, effect, fed: None };
        again.talk.ask("cal show")?;
        let restarted = again.error(1)?;
        again.talk.say(&format!("  it has kept the effect: error {restarted:.2} µT\n"));
        again.talk.say("Check: without this effect the error must return:");
        again.talk.ok(&format!("effect remove {id}"))?;
        let removed = again.error(STRIDE)?;
        again.talk.say(&format!(
            "  error without it: {removed:.2} µT (offset and matrix were fitted again together with it)"
        ));
        Ok(Figures { floor: NOISE_UT, before, learnt, restarted, removed, rounds, first })
    }

    /// Asks what is missing and adds it; if the samples do not suffice yet, turns the board further and asks again.
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
            self.talk.say("  significant, but not yet in held-out samples; rotating it further …");
            self.talk.quiet("stream raw")?;
            self.turn(MORE)?;
            self.talk.quiet("stream off")?;
            asked = round;
        }
    }

    /// Asks until the samples carry an answer that names something; the id that comes first, and how often it was asked.
    fn why(&mut self, asked: usize) -> Outcome<(String, usize)> {
        for round in asked + 1..=ROUNDS {
            // Asked quietly first: an answer that there is not enough yet is not a part of the story.
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
            self.talk.say(&format!("  not enough samples yet ({}); rotating it further …", answer.closing));
            self.talk.quiet("stream raw")?;
            self.turn(MORE)?;
            self.talk.quiet("stream off")?;
        }
        Err(Failure::refused("the board found no effect, although there is one. See the answers to `why`"))
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
        self.world.turn(1);
        self.talk.board.expose(field_ut)
    }

    /// Rms of the corrected magnitude about F, µT, in attitudes that come next, or each so many of them.
    fn error(&mut self, stride: usize) -> Outcome<f64> {
        self.talk.quiet("stream cal")?;
        let (mut squares, mut probes, mut unknown) = (0.0, 0, 0);
        while probes < PROBES {
            let text = self.attitude()?;
            self.world.turn(stride - 1);
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
