//! A vehicle that turns level, and what the console says of it.

extern crate std;

use super::machine::Device;
use super::tests::{answer, number, turned};
use crate::math::{cos, sin};
use crate::protocol::Command;
use crate::record::Record;
use crate::sensor::Reading;

/// Milliseconds from one sample to the next, and samples of a circle.
const STEP_MS: u64 = 20;
const CIRCLE: u64 = 600;

/// A vehicle with a sensor of 0.1 µT a count.
struct Vehicle {
    device: Device,
    t_ms: u64,
    heading: f64,
    /// Counts.
    offset: [f64; 3],
    random: u64,
}

impl Vehicle {
    /// With a calibration in use, the identity, and an offset that has moved since.
    fn calibrated(offset: [f64; 3]) -> Self {
        Self { device: turned(0.0, [0; 3], 1), t_ms: 1000, heading: 0.3, offset, random: 5 }
    }

    /// Without a calibration.
    fn new(offset: [f64; 3]) -> Self {
        let mut vehicle = Self::calibrated(offset);
        vehicle.device.active = None;
        vehicle
    }

    /// The reading at a pitch, rad, and what the accelerometer shows.
    fn sample(&mut self, pitch: f64, sideways_mps2: f64) {
        let [ahead, right, down] = [200.0 * cos(self.heading), -200.0 * sin(self.heading), 450.0];
        let (s, c) = (sin(pitch), cos(pitch));
        let field = [ahead * c - down * s, right, ahead * s + down * c];
        let force = [9.81 * s, sideways_mps2, -9.81 * c].map(|axis| axis as f32);
        // Rounding to counts alone would be too good for a sensor.
        let counts = [0, 1, 2].map(|axis| {
            self.random =
                self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let noise = 8.0 * ((self.random >> 40) as f64 / (1_u64 << 24) as f64 - 0.5);
            crate::math::round(field[axis] + self.offset[axis] + noise) as i16
        });
        self.device.on_motion(Some(force), None);
        self.device.on_sample(&Reading { counts, overflow: [false; 3] }, self.t_ms);
        self.t_ms += STEP_MS;
    }

    /// Circles to the right, or with a negative number to the left.
    fn circles(&mut self, turns: f64, sideways_mps2: f64) {
        let sense = if turns < 0.0 { -1.0 } else { 1.0 };
        for i in 0..(turns.abs() * CIRCLE as f64) as u64 {
            self.heading += sense * core::f64::consts::TAU / CIRCLE as f64;
            self.sample(0.02 * sin(0.05 * i as f64), sense * sideways_mps2);
        }
    }

    fn say(&mut self, line: &str) -> std::string::String {
        answer(&mut self.device, line, self.t_ms)
    }

    fn waiting(&self) -> Record {
        self.device.waiting().expect("it waits for cal accept")
    }
}

/// The heading of a level board less its own, degrees from −180 to 180.
fn heading_error_deg(record: &Record, offset: [f64; 3], heading: f64) -> f64 {
    let field = [20.0 * cos(heading), -20.0 * sin(heading), 45.0];
    let corrected = record.calibration.apply([0, 1, 2].map(|axis| field[axis] + 0.1 * offset[axis]));
    let got = crate::heading::heading_deg(corrected, [0.0, 0.0, -9.81], 0.0).expect("level");
    let off = got - heading.to_degrees();
    off - 360.0 * crate::math::floor(off / 360.0 + 0.5)
}

#[test]
fn circles_after_a_battery_swap_give_level_headings_and_say_for_which_tilts() {
    let offset = [60.0, -40.0, 30.0];
    let mut vehicle = Vehicle::calibrated(offset);
    vehicle.sample(0.0, 0.0);
    assert!(vehicle.say("cal start level").starts_with("ok state=collecting level=1"));
    assert!(vehicle.say("status").contains("+ hint turn level: two full circles"));
    vehicle.circles(2.0, 0.2);
    vehicle.circles(-2.0, 0.2);
    let status = vehicle.say("status");
    assert!(
        status.contains("+ hint a level heading is right to ") && status.contains("cal stop"),
        "{status}"
    );
    let stopped = vehicle.say("cal stop");
    assert!(stopped.starts_with("ok verdict=accepted model=level "), "{stopped}");
    let (error_deg, holds_deg) = (number(&stopped, "heading_error_deg="), number(&stopped, "holds_to_deg="));
    assert!(error_deg < 1.0 && (3.0..20.0).contains(&holds_deg), "{stopped}");
    let record = vehicle.waiting();
    for place in 0..12 {
        let off = heading_error_deg(&record, offset, 0.52 * f64::from(place));
        assert!(off.abs() < 3.0 * error_deg, "{place}: {off} of {error_deg}");
    }
    assert_eq!(Record::decode(record.encode().expect("it fits").as_bytes()), Ok(record));

    // In use, it says what it is for, and when it is not.
    super::active::Active::install(
        &mut vehicle.device.active,
        crate::store::Slot::A,
        &record,
        crate::sensor::AxisMap::IDENTITY,
    );
    vehicle.say("stream cal");
    vehicle.sample(0.0, 0.0);
    let level = vehicle.say("status");
    assert!(level.contains(&std::format!("+ holds_for tilt_deg={holds_deg} ")), "{level}");
    assert!(!level.contains("tilted") && vehicle.say("heading").starts_with("ok heading_deg="), "{level}");
    vehicle.sample(0.5, 0.0);
    let tilted = vehicle.say("heading");
    assert!(tilted.contains(",tilted\n") || tilted.starts_with("+ tilted"), "{tilted}");
    assert!(tilted.contains(&std::format!("+ tilted tilt_deg=29 holds_to_deg={holds_deg};")), "{tilted}");
    assert!(vehicle.say("status").contains("+ tilted tilt_deg=29"));
    assert!(vehicle.say("cal show").contains("+ holds_for tilt_deg="));
}

#[test]
fn too_little_of_a_circle_is_refused_and_going_on_is_enough() {
    let mut vehicle = Vehicle::calibrated([60.0, -40.0, 30.0]);
    vehicle.sample(0.0, 0.0);
    vehicle.say("cal start level");
    vehicle.circles(0.3, 0.2);
    let refused = vehicle.say("cal stop");
    assert!(refused.starts_with("err refused error-too-large ") && refused.contains("circles"), "{refused}");
    assert!(vehicle.say("status").contains("ok state=collecting"), "the samples are kept");
    vehicle.circles(2.0, 0.2);
    vehicle.circles(-2.0, 0.2);
    assert!(vehicle.say("cal stop").starts_with("ok verdict=accepted"), "{}", vehicle.say("status"));
}

#[test]
fn without_a_calibration_the_vertical_offset_is_unknown_and_the_tilts_are_few() {
    let mut vehicle = Vehicle::new([60.0, -40.0, 30.0]);
    vehicle.sample(0.0, 0.0);
    vehicle.say("cal start level");
    vehicle.circles(2.0, 0.1);
    vehicle.circles(-2.0, 0.1);
    let stopped = vehicle.say("cal stop");
    assert!(stopped.starts_with("ok verdict=accepted model=level "), "{stopped}");
    assert!((1.0..5.0).contains(&number(&stopped, "holds_to_deg=")), "{stopped}");
    // 60 µT of hard iron: nobody knows how much of it is vertical.
    let mut magnetised = Vehicle::new([600.0, -400.0, 300.0]);
    magnetised.sample(0.0, 0.0);
    magnetised.say("cal start level");
    magnetised.circles(2.0, 0.1);
    magnetised.circles(-2.0, 0.1);
    let refused = magnetised.say("cal stop");
    assert!(refused.starts_with("err refused error-too-large ") && refused.contains("vertical"), "{refused}");
}

#[test]
fn a_field_that_varies_is_refused_and_so_are_effects() {
    let mut vehicle = Vehicle::calibrated([0.0; 3]);
    vehicle.sample(0.0, 0.0);
    vehicle.say("cal start level");
    for i in 0..8 {
        vehicle.offset = if i % 2 == 0 { [45.0, 0.0, 0.0] } else { [-30.0, 30.0, 0.0] };
        vehicle.circles(if i < 4 { 0.5 } else { -0.5 }, 0.1);
    }
    let refused = vehicle.say("cal stop");
    assert!(refused.starts_with("err refused error-too-large ") && refused.contains("steel"), "{refused}");
    assert!(vehicle.say("cal cancel").starts_with("ok state=idle"));
    assert!(matches!(crate::protocol::parse("cal start level"), Ok(Command::CalStart { level: true })));
    let column = crate::effect::ColumnName::new("current_a").expect("a name");
    let linear = crate::effect::BuiltIn::Offset(crate::effect::Offset::linear(column, 1.0));
    vehicle.device.active.as_mut().expect("in use").record.effects = super::tests::record(linear).effects;
    assert!(vehicle.say("cal start level").starts_with("err state the calibration in use has effects"));
}
