//! What the tests on the simulated board share.

pub mod records;

use ironout_rig::board::SimBoard;
use ironout_simulation::{Motion, World, WorldOptions};

/// Where the simulated board's hard iron is, µT.
pub const HARD_IRON_UT: [f64; 3] = [93.0, 40.0, -70.0];
/// Noise of the simulated sensor on each axis, µT.
pub const NOISE_UT: f64 = 0.05;

/// A board's magnetic world: 50 µT, soft iron of some 10 %.
pub fn world(motion: Motion, seed: u64) -> World {
    world_with_hard_iron(HARD_IRON_UT, motion, seed)
}

/// The same with another hard iron, µT.
pub fn world_with_hard_iron(hard_iron_ut: [f64; 3], motion: Motion, seed: u64) -> World {
    World::new(WorldOptions { seed, motion, hard_iron_ut: Some(hard_iron_ut), ..WorldOptions::default() })
}

/// A board in such a world, powered up, its EEPROM erased.
pub fn world_board(motion: Motion, seed: u64) -> SimBoard {
    let world = world(motion, seed);
    SimBoard::new(move |t_s| world.sensor_ut(t_s), NOISE_UT, seed)
}

/// A board that was calibrated on its console, running.
pub fn accepted_board(seed: u64) -> SimBoard {
    let mut board = world_board(Motion::Sphere, seed);
    board.run_ms(100);
    let verdict = calibrate(&mut board, 60);
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1 "));
    board
}

/// Collects for some seconds; the answer to `cal stop`.
pub fn calibrate(board: &mut SimBoard, seconds: u64) -> String {
    assert_eq!(last(board, "cal start"), "ok state=collecting");
    board.run_ms(1000 * seconds);
    last(board, "cal stop")
}

/// The last line of the answer to a command.
pub fn last(board: &mut SimBoard, command: &str) -> String {
    board.command(command).pop().unwrap_or_default()
}

/// The value of `key=` in a line.
pub fn value<'a>(line: &'a str, key: &str) -> &'a str {
    let is_it = |word: &&str| word.split_once('=').is_some_and(|(name, _)| name == key);
    line.split(' ').find(is_it).map_or_else(|| panic!("no {key} in {line:?}"), |word| &word[key.len() + 1..])
}
