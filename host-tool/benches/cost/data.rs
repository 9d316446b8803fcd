//! What is measured: the same counts for everybody, and logs.

use ironout::calibration::Calibration;
use ironout::effect::{AmbientField, Bends, BuiltIn, ColumnName, Drift, Gain, Offset};
use ironout::extended::{ExtendedCalibration, FittedEffect, Live, Slots};
use ironout::fit::{FitOptions, Method, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use ironout::study::{Model, Observation, Residual, Study, Term};
use ironout_simulation::paper::{Sampler, eq_16};
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};
use std::hint::black_box;
use std::io::{self, Write};

/// Fields a count.
pub const SCALE: f64 = 1.0 / 500.0;
/// Samples of the core's benches.
pub const SAMPLES: usize = 10_000;

/// The paper's simulation, in counts.
pub fn counts() -> Vec<[i16; 3]> {
    let samples = eq_16().samples(&mut Sampler::new(1), SAMPLES, 0.01, nalgebra::Vector3::z(), 1.0);
    samples.iter().map(|s| s.map(|v| (v / SCALE).round() as i16)).collect()
}

/// The sums of all counts.
pub fn moments(counts: &[[i16; 3]]) -> Moments {
    let mut moments = Moments::new();
    counts.iter().for_each(|c| moments.push(*c));
    moments
}

/// The same with `magcal`.
pub fn magcal_solver(counts: &[[i16; 3]]) -> magcal::Solver {
    let mut solver = magcal::Solver::new();
    counts.iter().for_each(|c| solver.push_sample(*c));
    solver
}

/// From sums to a calibration with standard errors.
pub fn solve(moments: &Moments, method: Method) -> Calibration {
    let scatter = Scatter::from_moments(moments, [SCALE; 3]).expect("the samples are good");
    fit(&scatter, &FitOptions { method, ..FitOptions::default() }).expect("the samples are good").calibration
}

/// The correction as a board runs it.
pub fn calibration() -> Calibration<f32> {
    solve(&moments(&counts()), Method::Adjusted).cast()
}

/// Corrects all counts.
pub fn apply(calibration: &Calibration<f32>, counts: &[[i16; 3]]) {
    for c in counts {
        black_box(calibration.apply(c.map(f32::from)));
    }
}

/// Corrects all counts with `magcal`.
pub fn apply_magcal(calibration: &magcal::MagCal, counts: &[[i16; 3]]) {
    for c in counts {
        black_box(calibration.apply(*c));
    }
}

/// The correction with a gain that follows the temperature and an offset that follows a current.
pub fn live() -> (Live<f32>, [Slots; 2]) {
    let mut calibration = ExtendedCalibration::plain(calibration());
    let effects = [
        BuiltIn::Gain(Gain { column: name("temp_c"), reference: 25.0 }),
        BuiltIn::Offset(Offset::linear(name("current_a"), 0.5)),
    ];
    for effect in effects {
        let mut fitted = FittedEffect::new(effect, [0.0; 9], [0.0; 9]);
        fitted.coefficients[..3].copy_from_slice(&[1e-3, -2e-3, 3e-3]);
        assert!(calibration.effects.push(fitted).is_ok(), "a calibration carries four effects");
    }
    let live = Live::new(&calibration).expect("the effects are sound");
    let slots = [live.slots("temp_c"), live.slots("current_a")];
    (live, slots)
}

fn name(text: &str) -> ColumnName {
    ColumnName::new(text).expect("a short name")
}

/// Corrects all counts with both columns fresh at every one.
pub fn apply_effects(live: &mut Live<f32>, slots: [Slots; 2], counts: &[[i16; 3]]) {
    for c in counts {
        live.set_slots(slots[0], black_box(31.0));
        live.set_slots(slots[1], black_box(2.5));
        black_box(live.apply(c.map(f32::from), None).unwrap_or_default());
    }
}

/// A study of 22 columns, as `cargo bench-m4` has it: nine of the base model and thirteen of five candidates.
pub fn study(calibration: &Calibration<f32>, counts: &[[i16; 3]]) -> u32 {
    const NO_TURN: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (temperature, current) = (name("temp_c"), name("current_a"));
    let effects: [BuiltIn<f32>; 5] = [
        BuiltIn::Offset(Offset::linear(temperature, 25.0)),
        BuiltIn::Gain(Gain { column: temperature, reference: 25.0 }),
        BuiltIn::Offset(Offset::linear(current, 0.5)),
        BuiltIn::Drift(Drift { reference_s: 10.0 }),
        BuiltIn::Field(AmbientField { column: current, reference: 0.5 }),
    ];
    let model = Model::new(calibration.offset_ut, calibration.matrix, calibration.field_ut, NO_TURN, 0.0)
        .expect("the calibration is sound");
    let mut study = Study::<f32, 22, 4, 5>::new(Residual::Magnitude, model, 13);
    let mut terms: [Term<f32>; 5] = std::array::from_fn(|i| Term {
        effect: &effects[i],
        coefficients: [0.0; 9],
        inputs: [0.0; 2],
        bends: Bends::Reading,
    });
    for (row, c) in counts.iter().enumerate() {
        let t = row as f32 * 0.02;
        for (term, input) in terms.iter_mut().zip([25.0 + t, 25.0 + t, 0.5 + t, t, 0.5 + t]) {
            term.inputs[0] = input;
        }
        let measured_ut = c.map(|v| f32::from(v) * SCALE as f32);
        let reading = Observation { measured_ut, turn_radps: None, down: None };
        study.push(row * 4 / SAMPLES, &reading, &terms).expect("the samples are finite");
    }
    study.blocks().iter().map(|block| block.rows()).sum()
}

/// An ordinary log of 80 s at 50 Hz that hides this, or nothing.
pub fn log(hidden: &str) -> Log {
    World::new(WorldOptions { seed: 3, effects: effects(hidden), ..WorldOptions::default() }).run()
}

fn effects(hidden: &str) -> Vec<EffectSpec> {
    hidden
        .split(',')
        .filter(|item| !item.is_empty())
        .map(|item| EffectSpec::parse(item).expect("a known effect"))
        .collect()
}

/// Writes a long log, `rows` at 50 Hz with all sensors and ten covariates, a motor current hidden in it.
pub fn write_long(rows: usize, out: impl Write) -> io::Result<()> {
    const MORE: [&str; 7] =
        ["board_c", "motor_c", "servo_a", "fan_rpm", "battery_v", "throttle", "pressure_hpa"];
    let rate_hz = 50.0;
    let seconds = rows as f64 / rate_hz;
    let world = World::new(WorldOptions {
        seed: 5,
        seconds,
        rate_hz,
        effects: effects("offset:current_a=3"),
        ..WorldOptions::default()
    });
    let mut log = world.run();
    for name in MORE {
        log.names.push(name.into());
        log.columns.push((0..rows).map(|row| world.covariate(name, row as f64 / rate_hz)).collect());
    }
    log.write_csv(out, "a long log")
}
