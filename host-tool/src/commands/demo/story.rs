//! The story of the demo, told on a board.

use crate::cli::DemoArgs;
use crate::commands::demo::hidden;
use crate::commands::demo::talk::{Talk, numbers};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::output::line;
use crate::progress::Progress;
use ironout_simulation::{World, WorldOptions};

/// The Earth's field of the demo, µT.
const FIELD_UT: f64 = 48.0;
/// Hard iron on every axis: the emulated sensor knows no negative fields, so all of them are lifted above zero.
const HARD_IRON_UT: [f64; 3] = [93.0; 3];
/// Soft iron of 10 %.
const SOFT_IRON: [[f64; 3]; 3] = [[1.10, 0.04, -0.03], [0.02, 0.96, 0.05], [-0.04, 0.03, 0.92]];
/// Attitudes of the trace, and the world's time between them.
const ATTITUDES: usize = 400;
const STEP_S: f64 = 0.075;
/// Attitudes in which the result is looked at, others than those of the trace.
const PROBES: usize = 100;
/// The demo has failed if the error after is larger, in percent of the field.
const GOOD_PERCENT: f64 = 1.0;

/// Tells the story, or gives its figures as JSON.
pub fn run(arguments: &DemoArgs, json: bool) -> Outcome<u8> {
    if let Some(effect) = arguments.hidden {
        return hidden::run(effect, arguments, json);
    }
    if !json {
        line("A board calibrates its own magnetometer.\n");
    }
    let talk = Talk::start(arguments, json)?;
    let emulated = talk.emulated;
    let figures = Story { talk }.run()?;
    let after = figures.after.max(figures.restarted);
    if json {
        line(
            &serde_json::json!({
                "emulated": emulated, "attitudes": ATTITUDES, "field_ut": FIELD_UT,
                "truth_offset_ut": HARD_IRON_UT, "offset_ut": figures.offset_ut,
                "before_percent": figures.before, "after_percent": figures.after,
                "after_restart_percent": figures.restarted,
            })
            .to_string(),
        );
    } else {
        line(&format!(
            "\nrms error of the magnitude, in % of the field:  before {:.1} %  →  after {:.3} %  →  after the power cut {:.3} %",
            figures.before, figures.after, figures.restarted
        ));
        if !emulated {
            line(
                "(simulated bus; with qemu-system-arm installed the same firmware runs on an emulated Cortex-M4F)",
            );
        }
    }
    Ok(if after <= GOOD_PERCENT { EXIT_OK } else { EXIT_REFUSED })
}

struct Figures {
    before: f64,
    after: f64,
    restarted: f64,
    offset_ut: Vec<f64>,
}

struct Story {
    talk: Talk,
}

impl Story {
    fn run(mut self) -> Outcome<Figures> {
        let world = World::new(WorldOptions {
            seed: 2014,
            field_ut: FIELD_UT,
            hard_iron_ut: Some(HARD_IRON_UT),
            soft_iron: Some(SOFT_IRON),
            seconds: ATTITUDES as f64 * STEP_S,
            ..WorldOptions::default()
        });
        self.talk.ask("version")?;
        self.talk.ask("status")?;
        self.talk.say(&format!(
            "\nThe field is {FIELD_UT} µT. The board has a hard iron of {} µT on every axis and 10 % soft iron.\nWithout a \
             calibration it measures:",
            HARD_IRON_UT[0]
        ));
        self.talk.ok(&format!("field {FIELD_UT}"))?;
        let before = self.raw_error(&world)?;
        self.talk.say(&format!(
            "  a magnitude with an error of {before:.1} % of the field (rms over {PROBES} orientations)\n"
        ));

        self.talk.ok("cal start")?;
        self.talk.say(&format!("Rotating it through {ATTITUDES} orientations …"));
        self.turn(&world)?;
        self.talk.ask("status")?;
        self.talk.ok("cal stop")?;
        self.talk.ok("cal accept")?;
        let shown = self.talk.ok("cal show")?;
        self.talk.say(&format!(
            "the truth: offset_ut={},{},{}",
            HARD_IRON_UT[0], HARD_IRON_UT[1], HARD_IRON_UT[2]
        ));
        let offset_ut = numbers(shown.values("offset_ut").next().unwrap_or_default(), 0);
        let after = self.corrected_error(&world)?;
        self.talk.say(&format!("  error of the magnitude now: {after:.3} %\n"));

        let how = if self.talk.emulated { " (kill -9)" } else { "" };
        self.talk.say(&format!("Cutting the power{how}, and starting the board again:"));
        let mut restarted = Story { talk: self.talk.power_cut()? };
        restarted.talk.ask("status")?;
        let again = restarted.corrected_error(&world)?;
        restarted
            .talk
            .say(&format!("  the stored calibration is applied from the start: error {again:.3} %"));
        Ok(Figures { before, after, restarted: again, offset_ut })
    }

    fn turn(&mut self, world: &World) -> Outcome<()> {
        self.talk.quiet("stream raw")?;
        let mut progress = Progress::new("turning", ATTITUDES as u64, !self.talk.json);
        for attitude in 0..ATTITUDES {
            self.talk.board.expose(world.sensor_ut(attitude as f64 * STEP_S))?;
            progress.at(attitude as u64);
        }
        self.talk.quiet("stream off")
    }

    /// Rms of the magnitude about F over F, percent, of what the board streams in attitudes of their own.
    fn error(
        &mut self,
        world: &World,
        stream: &str,
        magnitude: impl Fn(&str) -> Option<f64>,
    ) -> Outcome<f64> {
        self.talk.quiet(stream)?;
        let mut squares = 0.0;
        for probe in 0..PROBES {
            let t_s = (probe as f64 + 0.37) * STEP_S * (ATTITUDES / PROBES) as f64;
            let text = self.talk.board.expose(world.sensor_ut(t_s))?;
            let norm = magnitude(&text)
                .ok_or_else(|| Failure::refused(format!("the board streamed \"{text}\" after `{stream}`")))?;
            squares += (norm - FIELD_UT) * (norm - FIELD_UT);
        }
        self.talk.quiet("stream off")?;
        Ok((squares / PROBES as f64).sqrt() / FIELD_UT * 100.0)
    }

    fn raw_error(&mut self, world: &World) -> Outcome<f64> {
        let scale = self.talk.board.ut_per_count();
        self.error(world, "stream raw", |text| {
            let counts: [f64; 3] = numbers(text.strip_prefix("R,")?, 1).try_into().ok()?;
            Some(ironout::calibration::norm([0, 1, 2].map(|axis| counts[axis] * scale[axis])))
        })
    }

    fn corrected_error(&mut self, world: &World) -> Outcome<f64> {
        self.error(world, "stream cal", |text| numbers(text.strip_prefix("C,")?, 4).first().copied())
    }
}
