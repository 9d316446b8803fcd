//! The firmware in QEMU beside the page: from start to an accepted calibration and `why`, by clicks alone.

use crate::common::{folder, ironout, text, write};
use crate::page::board::live;
use crate::page::browser::{number, scenario, turn, words};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// What a session by clicks shows, whatever the wire is.
fn assert_session(seen: &Value) {
    let turning = number(&seen["turning"]);
    assert!((10.0..=180.0).contains(&turning) && seen["turned"] == true, "{seen}");
    for (key, part) in [
        ("link", "mps2 with LSM303DLHC"),
        ("started", "done: cal start"),
        ("hint", "side"),
        ("stopped", "done: cal stop"),
        ("judged", "Accepted"),
        ("accepted", "done: cal accept"),
        ("reading", "magnitude 4"),
        ("whyAnswer", "done: why"),
        ("why", "Why is it off?"),
        ("advice", "ready to export"),
    ] {
        assert!(words(&seen[key]).contains(part), "{key} without {part}: {seen}");
    }
    assert_eq!(seen["recording"], "log.csv", "{seen}");
}

/// What is named is added by a click, and the error falls to the noise; removed, it is back.
pub fn assert_learned(seen: &Value, id: &str, noise_ut: f64) {
    assert_eq!(seen["verdict"], "missing", "{seen}");
    assert!(words(&seen["why"]).contains(id), "{seen}");
    for (key, part) in
        [("added", "done: effect add"), ("whyLearned", "in-use"), ("removed", "done: effect remove")]
    {
        assert!(words(&seen[key]).contains(part), "{key} without {part}: {seen}");
    }
    let (learned, removed) = (number(&seen["errorLearned"]), number(&seen["errorRemoved"]));
    // Of the last seconds, in which a busy host feeds columns late, and of some two hundred samples: falls, not the last tenth.
    assert!(learned < 3.0 * noise_ut && removed > 1.4 * learned, "{learned} {removed}: {seen}");
}

/// The recording that the page saved, read by the command line.
fn assert_recording(here: &Path, seen: &Value) {
    let log = write(here, "recording.csv", words(&seen["log"]));
    let fit = ironout(["fit", text(&log), "--json"]);
    assert_eq!(fit.status, 0, "{} {}", fit.stdout, fit.stderr);
    let fit = fit.json();
    for axis in 0..3 {
        assert!((number(&fit["offset_ut"][axis]) - 93.0).abs() < 1.0, "{fit}");
    }
}

#[cfg(unix)]
#[test]
fn a_board_is_calibrated_by_clicks_on_the_served_page() {
    // The board first: others wait for it too, and the browser is free meanwhile.
    let Some(_board) = ironout_rig::qemu::turn("live --qemu") else { return };
    let Some(_turn) = turn("live") else { return };
    let here = folder("page-live");
    let (_program, address) = live(&["--qemu", "--hidden", "temperature"]);
    // What the emulated sensor's noise alone makes.
    let noise_ut = 0.25;
    let hidden = json!({"id": "offset:temp_c", "noise_ut": noise_ut});
    let seen = scenario("live", json!({"address": address, "hidden": hidden}));
    assert_session(&seen);
    assert_learned(&seen, "offset:temp_c", noise_ut);
    assert_recording(&here, &seen);
}

/// Switches the emulated board of a thread off when it goes.
struct Off {
    stop: Arc<AtomicBool>,
    served_at: String,
    bridge: Option<JoinHandle<()>>,
}

impl Drop for Off {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // It may be waiting for a client.
        drop(std::net::TcpStream::connect(&self.served_at));
        if let Some(bridge) = self.bridge.take() {
            // A board that has failed has said so.
            let _ = bridge.join();
        }
    }
}

#[cfg(unix)]
#[test]
fn a_board_is_calibrated_over_a_serial_port_of_the_browser() {
    use ironout_rig::qemu::{self, Emulator, Firmware, Options};
    use ironout_simulation::{World, WorldOptions};
    let Some(_board) = qemu::turn("the page on a serial port") else { return };
    let Some(_turn) = turn("the page on a serial port") else { return };
    let here = folder("page-serial");
    let made = ironout(["web", "-o", text(&here)]);
    assert_eq!(made.status, 0, "{}", made.stderr);
    let firmware = Firmware::build().unwrap_or_else(|error| panic!("{error}"));
    let mut board = Emulator::start(&firmware, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let world = World::new(WorldOptions {
        seed: 72,
        field_ut: 48.0,
        hard_iron_ut: Some([93.0; 3]),
        seconds: 600.0,
        ..WorldOptions::default()
    });
    board.wait_for_samples().expect("samples");
    board.set_field_ut(world.sensor_ut(0.0)).expect("a field");
    // The page may open the port any number of times; at the end the board is switched off.
    let stop = Arc::new(AtomicBool::new(false));
    let (stopped, served_at) = (Arc::clone(&stop), address.clone());
    let bridge = std::thread::spawn(move || {
        let turn = |board: &mut Emulator, _: &str, sample: u64| {
            board.set_field_ut(world.sensor_ut((sample as f64 * 0.04) % 600.0))
        };
        while !stopped.load(Ordering::Relaxed) && board.serve(&listener, turn).is_ok() {}
    });
    let _off = Off { stop, served_at, bridge: Some(bridge) };
    let seen = scenario("serial", json!({"file": here.join("index.html"), "address": address}));
    assert!(words(&seen["gone"]).contains("waiting for it"), "{seen}");
    assert_eq!(seen["rates"].as_array().and_then(|rates| rates.first()), Some(&json!(115_200)), "{seen}");
    assert_session(&seen);
    // Nothing is hidden from it.
    assert_eq!(seen["verdict"], "complete", "{seen}");
    assert_recording(&here, &seen);
}
