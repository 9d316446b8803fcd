//! One trace through the firmware and through the same core on the host: every digit of what both say is the same.
//!
//! What the board did is all in what it streams: between the lines of `stream log`, in their order, stand its answers.

use crate::qemu::support::{FIELD_UT, attitudes, board, ok};
use ironout_host_tests::learning::Board;
use ironout_rig::board::SimBoard;
use ironout_rig::qemu::{self, Emulator, SAMPLE_LIMIT};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Noise that the emulated chip does not have, µT on each axis.
const NOISE_UT: f64 = 0.25;
/// The field of the wires, µT/A, and of the warmth, µT/°C.
const PER_AMPERE_UT: [f64; 3] = [0.12, -0.3, 0.2];
const PER_DEGREE_UT: [f64; 3] = [0.3, 0.1, -0.25];
/// Samples to calibrate with, and to learn from.
const CALIBRATED: usize = 400;
const LEARNT: usize = 900;

/// The firmware in QEMU, and the core on the host that is told what the firmware says it has measured.
struct Pair {
    emulated: Emulator,
    host: Board,
    columns: Vec<String>,
    known: Vec<String>,
    rng: ChaCha8Rng,
}

impl Pair {
    /// What the board has streamed, told to the host.
    fn tell(&mut self, line: &str) {
        let words: Vec<&str> = line.split(',').collect();
        match words.as_slice() {
            ["H", "t_ms", "seq", "x", "y", "z", columns @ ..] => {
                self.columns = columns.iter().map(|name| (*name).to_owned()).collect();
                self.known = vec![String::new(); columns.len()];
            }
            ["L", t_ms, _, x, y, z, values @ ..] => {
                for (place, value) in values.iter().enumerate() {
                    // What the chip says of its temperature comes with no answer: with the line that follows.
                    if self.columns[place] == "temp_c" && self.known[place] != *value && *value != "-" {
                        self.host.fed("temp_c", value.parse().unwrap());
                        self.known[place] = (*value).to_owned();
                    }
                }
                let counts = [x, y, z].map(|count| count.parse().unwrap());
                self.host.sampled(t_ms.parse().unwrap(), counts);
            }
            _ => panic!("{line}"),
        }
    }

    fn tell_all(&mut self) {
        for line in self.emulated.console.take_streamed() {
            self.tell(&line);
        }
    }

    /// A command to both; what was streamed before its answer was measured before it. Both answers are the same.
    fn both(&mut self, command: &str) -> String {
        let answer = ok(&mut self.emulated, command).to_string();
        self.tell_all();
        let own = self.host.command(command).join("\n");
        assert_eq!(answer, own, "{command}: the firmware, and the core on the host");
        answer
    }

    /// Samples with this current, which the board is fed, and of this temperature.
    fn turn(&mut self, indices: std::ops::Range<usize>) {
        let way: Vec<[f64; 3]> = attitudes(CALIBRATED).collect();
        for index in indices {
            let learns = index >= CALIBRATED;
            let current_a = if learns && index / 23 % 2 == 1 { 6.5 } else { 0.0 };
            let warm_c = if learns { 12.0 * (index as f64 * 0.017).sin() } else { 0.0 };
            let field_ut = std::array::from_fn(|axis| {
                let noise: f64 = StandardNormal.sample(&mut self.rng);
                let effects = PER_AMPERE_UT[axis] * current_a + PER_DEGREE_UT[axis] * warm_c;
                way[index % way.len()][axis] + effects + NOISE_UT * noise
            });
            self.emulated.pause().unwrap();
            self.emulated.put_field_ut(field_ut).unwrap();
            if index > 0 && index % 23 == 0 {
                self.emulated.set_temperature_c(25.0 + warm_c).unwrap();
            }
            self.emulated.resume().unwrap();
            if index > 0 && index % 23 == 0 {
                self.both(&format!("cov current_a={current_a}"));
            }
            let line = self.emulated.console.next_streamed(SAMPLE_LIMIT).unwrap();
            self.tell(&line);
        }
    }

    /// The host is told of samples until its study has so many; those that came later the firmware did not learn from.
    fn tell_until(&mut self, rows: u32) {
        let streamed = self.emulated.console.take_streamed();
        let mut streamed = streamed.iter();
        while self.host.device().learner().rows() < rows {
            self.tell(streamed.next().expect("the firmware has learned from what it has streamed"));
        }
    }

    /// `why`, of the same samples.
    fn why(&mut self) -> String {
        let why = ok(&mut self.emulated, "why").to_string();
        self.tell_until(number(&why, " n="));
        let own = self.host.command("why").join("\n");
        assert_eq!(without_steps(&why), without_steps(&own), "the firmware, and the core on the host");
        why
    }

    /// `effect add`, of the same samples, and the calibration that it makes.
    fn add(&mut self, id: &str) -> String {
        let added = ok(&mut self.emulated, &format!("effect add {id}")).to_string();
        let shown = ok(&mut self.emulated, "cal show").to_string();
        self.tell_until(number(&shown, " n="));
        assert_eq!(added, self.host.command(&format!("effect add {id}")).join("\n"));
        assert_eq!(shown, self.host.command("cal show").join("\n"));
        shown
    }
}

/// How many pieces of work an answer took depends on the processor.
fn without_steps(answer: &str) -> &str {
    answer.rsplit_once(" steps=").map_or(answer, |(answer, _)| answer)
}

fn number(answer: &str, key: &str) -> u32 {
    let rest = answer.split_once(key).unwrap_or_else(|| panic!("no{key} in {answer}")).1;
    rest.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number")
}

#[test]
fn the_firmware_and_the_core_on_the_host_say_the_same_to_the_last_digit() {
    let Some(_turn) = qemu::turn("same trace") else { return };
    let sensor = SimBoard::new(|_| [0.0; 3], 0.0, 1).sensor();
    let mut pair = Pair {
        emulated: board(),
        host: Board::with_sensor(sensor),
        columns: Vec::new(),
        known: Vec::new(),
        rng: ChaCha8Rng::seed_from_u64(31),
    };
    pair.both(&format!("field {FIELD_UT}"));
    ok(&mut pair.emulated, "stream log");
    pair.turn(0..3);
    pair.both("cal start");
    pair.turn(3..CALIBRATED);
    // One that is in use: a study begins at it at once.
    let stopped = pair.both("cal stop");
    assert!(stopped.contains("verdict=accepted"), "{stopped}");
    pair.both("cal accept");
    pair.both("cal start");
    pair.turn(CALIBRATED..CALIBRATED + LEARNT);
    let why = pair.why();
    println!("{why}");
    for id in ["offset:current_a", "offset:temp_c"] {
        assert!(why.lines().any(|line| line.contains(&format!("id={id} status=missing"))), "{why}");
    }
    let shown = pair.add("offset:current_a");
    println!("{shown}");
    assert!(shown.contains("effect=offset:current_a coefficients="), "{shown}");
}
