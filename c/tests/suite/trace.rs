//! A trace of a sensor that is turned by hand, and a record with an effect.

use ironout::calibration::Calibration;
use ironout::effect::{BuiltIn, ColumnName, Offset};
use ironout::extended::FittedEffect;
use ironout::math;
use ironout::record::Record;

/// µT per count.
pub const UT_PER_COUNT: [f32; 3] = [0.15, 0.15, 0.12];
/// Samples per second.
pub const RATE_HZ: f32 = 100.0;
/// The field, µT.
pub const FIELD_UT: f32 = 48.5;

/// One sample of the trace.
#[derive(Clone, Copy)]
pub struct Row {
    /// The time, ms; it wraps on the way.
    pub t_ms: u32,
    /// The counts.
    pub counts: [i16; 3],
    /// Whether the chip calls it out of range.
    pub out_of_range: bool,
    /// The specific force at it, m/s².
    pub accel_mps2: [f32; 3],
}

/// Seeded noise, near enough to a normal one, of variance one.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        (0..12).map(|_| uniform()).sum()
    }
}

/// Two seconds of rest, 20 s of turning with a gap of a second, repeated samples and some out of range.
pub fn rows() -> Vec<Row> {
    let sensor = Calibration {
        offset_ut: [61.0, -20.0, 33.0],
        matrix: [[1.05, 0.06, -0.03], [0.0, 0.96, 0.04], [0.0, 0.0, 1.01]],
        field_ut: f64::from(FIELD_UT),
    };
    let mut noise = Noise(7);
    let mut rows: Vec<Row> = Vec::new();
    for i in 0..2200u32 {
        let turned_s = f64::from(i.saturating_sub(200)) * 0.01 + if i >= 1300 { 1.0 } else { 0.0 };
        let (turn, tilt) = (2.1 * turned_s, 0.83 * turned_s + 0.4);
        let direction =
            [math::cos(tilt) * math::cos(turn), math::cos(tilt) * math::sin(turn), math::sin(tilt)];
        let field = direction.map(|value| value * f64::from(FIELD_UT));
        let measured = sensor.distort(field).expect("the sensor is regular");
        let mut counts = [0; 3];
        for axis in 0..3 {
            let value = measured[axis] + 0.25 * noise.next();
            counts[axis] = math::round(value / f64::from(UT_PER_COUNT[axis])) as i16;
        }
        let t_ms = (u32::MAX - 5_000).wrapping_add(i * 10 + if i >= 1300 { 1_000 } else { 0 });
        let accel_mps2 = [-direction[1] as f32, direction[0] as f32, -9.7];
        let row = Row { t_ms, counts, out_of_range: i % 400 == 399, accel_mps2 };
        rows.push(row);
        if i % 50 == 49 {
            rows.push(Row { t_ms: t_ms.wrapping_add(5), ..row });
        }
    }
    rows
}

/// The trace as lines of text: time, three counts, flag, three accelerations.
pub fn text() -> String {
    let line = |row: &Row| {
        let ([x, y, z], [a, b, c]) = (row.counts, row.accel_mps2);
        format!("{} {x} {y} {z} {} {a:e} {b:e} {c:e}\n", row.t_ms, u8::from(row.out_of_range))
    };
    rows().iter().map(line).collect()
}

/// The record whose offset follows the column `temp_c`, fitted from 10 to 40 °C, and the time since 1000 s.
pub fn record_with_effects(plain: Record) -> Record {
    let mut record = Record { sequence: 9, ..plain };
    let heat = Offset::linear(ColumnName::new("temp_c").expect("a name"), 25.0);
    let drift = Offset::linear(ColumnName::new("t_s").expect("a name"), 1000.0);
    let of = |effect, x: f64| {
        let theta = [x, -0.02, 0.03, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        FittedEffect::new(BuiltIn::Offset(effect), theta, [0.01; 9])
    };
    let heat = of(heat, 0.2).over([Some([10.0, 40.0]), None]);
    let drift = of(drift, 0.01).over([Some([1000.0, 1100.0]), None]);
    record.effects.push(heat).expect("room for one");
    record.effects.push(drift).expect("room for two");
    record
}
