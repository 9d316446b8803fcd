//! The board's own study in the real firmware: a current that is fed and the chip's temperature are tested, the current is named,
//! taken in, and kept over a power cut. Paced by the board's own samples.

use crate::qemu::support::{FIELD_UT, ask, attitudes, board, firmware, ok, start};
use ironout_host_tests::learning::{EmulatedLengths, Kind, emulated};
use ironout_rig::qemu::{self, Emulator};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Noise that the emulated chip does not have, µT on each axis.
const NOISE_UT: f64 = 0.25;
/// The field of the wires, µT/A.
const PER_AMPERE_UT: [f64; 3] = [0.5, -0.3, 0.2];

#[test]
fn why_names_the_current_that_is_fed_and_it_stays_over_a_power_cut() {
    let Some(_turn) = qemu::turn("learning") else { return };
    let mut board = board();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
    ok(&mut board, &format!("field {FIELD_UT}"));
    ok(&mut board, "stream raw");
    board.expose(attitudes(400).next().unwrap()).unwrap();
    assert_eq!(ask(&mut board, "why").code(), Some("state"), "no samples to study yet");
    ok(&mut board, "cal start");
    // Twice around, so that the current is on and off in all directions.
    let way: Vec<[f64; 3]> = attitudes(400).collect();
    let mut turn = |board: &mut Emulator, from: usize, count: usize| {
        for index in from..from + count {
            let field_ut: [f64; 3] = way[index % way.len()];
            let current_a = if index / 23 % 2 == 0 { 0.0 } else { 4.0 };
            if index % 23 == 0 {
                ok(board, &format!("cov current_a={current_a}"));
                board.set_temperature_c(25.0 + (index as f64 * 0.013).sin() * 4.0).unwrap();
            }
            let disturbed = std::array::from_fn(|axis| {
                field_ut[axis] + PER_AMPERE_UT[axis] * current_a + NOISE_UT * normal()
            });
            board.expose(disturbed).unwrap();
        }
    };
    turn(&mut board, 0, 730);
    board.console.take_streamed();
    ok(&mut board, "stream off");
    // Refused for the error that the current makes, or accepted all the same: the study knows more.
    if ask(&mut board, "cal stop").is_ok() {
        ok(&mut board, "cal accept");
    }
    // The study begins anew while it finds a better point to stand at: what it then says is to turn the board further.
    let mut turned = 730;
    let why = loop {
        let why = ok(&mut board, "why");
        println!("{why}");
        if why.value("first") != Some("-") || turned > 2500 {
            break why;
        }
        ok(&mut board, "stream raw");
        turn(&mut board, turned, 460);
        turned += 460;
        board.console.take_streamed();
        ok(&mut board, "stream off");
    };
    assert_eq!(why.value("first"), Some("offset:current_a"), "{why}");
    let base = why.info.first().expect("a line of the base");
    assert!(base.contains("current_a") && base.contains("temp_c"), "{base}");
    let added = ok(&mut board, "effect add offset:current_a");
    let rms_ut = |key| added.value(key).and_then(|text| text.parse::<f64>().ok()).expect("a figure");
    assert!(rms_ut("rms_ut") < 0.7 * rms_ut("rms_before_ut"), "{added}");
    let shown = ok(&mut board, "cal show");
    let row = shown.info.iter().find(|line| line.starts_with("effect=offset:current_a coefficients="));
    let row = row.unwrap_or_else(|| panic!("{shown}"));
    let theta: Vec<f64> = row
        .split(['=', ' '])
        .nth(3)
        .expect("coefficients")
        .split(',')
        .map(|word| word.parse().expect("a number"))
        .collect();
    for (found, truth) in theta.iter().zip(PER_AMPERE_UT) {
        assert!((found - truth).abs() < 0.05, "{theta:?}");
    }
    let with = board.stack_used().unwrap();
    let mut board = start(board.power_cut().unwrap());
    assert_eq!(ok(&mut board, "cal show").to_string(), shown.to_string());
    ok(&mut board, "cov current_a=4");
    assert_eq!(ok(&mut board, "effect remove offset:current_a").value("effects"), Some("0"));
    // Of boards with this core the STM32F3DISCOVERY has the smallest region.
    let most = with.max(board.stack_used().unwrap());
    println!("stack used: {with} bytes to the effect's being stored, {most} with its removal");
    assert!(most < 40_704 - 1024, "{most} bytes of stack");
}

/// Two of the traces that the program `learning-qemu` runs; of those whose accelerometer a busy host cannot delay.
#[test]
#[ignore = "minutes on the emulated board: .ci/long runs it"]
fn a_hidden_current_is_named_learnt_kept_and_missed_again_and_a_clean_trace_is_not_accused() {
    let Some(_turn) = qemu::turn("learning") else { return };
    let lengths = EmulatedLengths { collect_s: 60.0, stream_s: 12.0 };
    let shown = emulated::run(firmware(), Kind::Current, 7001, lengths).unwrap();
    let learnt = shown.learnt.unwrap_or_else(|| panic!("{:?}", shown.said.lines));
    assert!(learnt.is_kept, "{}", learnt.answers);
    // 600 samples know a rms to 3 %.
    assert!(learnt.added.max(learnt.restarted) < 1.3 && learnt.removed > 1.5 * learnt.added, "{learnt:?}");
    let lengths = EmulatedLengths { collect_s: 40.0, ..lengths };
    let shown = emulated::run(firmware(), Kind::Clean, 7001, lengths).unwrap();
    assert!(shown.is_right, "{:?}", shown.said.lines);
}
