//! Counts instructions on the emulated board and prints `key=value` lines. Ticks are of TIMER0; the host turns them into
//! instructions.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::hint::black_box;
use cortex_m_rt::entry;
use ironout::calibration::Calibration;
use ironout::effect::{AmbientField, Bends, BuiltIn, ColumnName, Drift, Gain, Offset};
use ironout::extended::{ExtendedCalibration, FittedEffect, Live, Slots};
use ironout::fit::{FitOptions, FitReport, Method, fit};
use ironout::learn::{Inquiry, Learner, Motion};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use ironout::session::{Session, SessionConfig};
use ironout::study::{Model, Observation, Residual, Study, Term};
use ironout_m4_bench::board::{Console, exit, stack_of, start_clock, ticks_of};
use ironout_m4_bench::samples::{COUNT, Turned, UT_PER_COUNT, fill};

#[inline(never)]
fn push(moments: &mut Moments, counts: [i16; 3]) {
    moments.push(counts);
}

#[inline(never)]
fn push_magcal(solver: &mut magcal::Solver, counts: [i16; 3]) {
    solver.push_sample(counts);
}

#[inline(never)]
fn solve(moments: &Moments, method: Method) -> Option<FitReport> {
    let scatter = Scatter::from_moments(moments, [UT_PER_COUNT; 3]).ok()?;
    fit(&scatter, &FitOptions { method, ..FitOptions::default() }).ok()
}

#[inline(never)]
fn solve_magcal(solver: &mut magcal::Solver) -> Option<magcal::MagCal> {
    solver.solve_ellipsoid().ok()
}

#[inline(never)]
fn apply(calibration: &Calibration<f32>, measured: [f32; 3]) -> [f32; 3] {
    calibration.apply(measured)
}

/// A calibration with two effects at work: the gain with temperature, the offset with a current.
fn live(base: Calibration<f32>) -> Option<Live<f32>> {
    let mut calibration = ExtendedCalibration::plain(base);
    let temperature = ColumnName::new("temp_c").ok()?;
    let current = ColumnName::new("current_a").ok()?;
    let effects = [
        BuiltIn::Gain(Gain { column: temperature, reference: 25.0 }),
        BuiltIn::Offset(Offset::linear(current, 0.5)),
    ];
    for effect in effects {
        let mut fitted = FittedEffect::new(effect, [0.0; 9], [0.0; 9]);
        fitted.coefficients[..3].copy_from_slice(&[1e-3, -2e-3, 3e-3]);
        calibration.effects.push(fitted).ok()?;
    }
    Live::new(&calibration).ok()
}

/// One sample with both columns fresh, as where they are measured as often as the field.
#[inline(never)]
fn apply_effects(live: &mut Live<f32>, slots: [Slots; 2], measured: [f32; 3], columns: [f32; 2]) -> [f32; 3] {
    live.set_slots(slots[0], columns[0]);
    live.set_slots(slots[1], columns[1]);
    live.apply(measured, None).unwrap_or_default()
}

/// A study of 22 columns: the base model's nine, and five effects with thirteen coefficients as candidates.
type Study22 = Study<f32, 22, 4, 5>;

/// The effects of [`Study22`].
fn candidates() -> Option<[BuiltIn<f32>; 5]> {
    let temperature = ColumnName::new("temp_c").ok()?;
    let current = ColumnName::new("current_a").ok()?;
    Some([
        BuiltIn::Offset(Offset::linear(temperature, 25.0)),
        BuiltIn::Gain(Gain { column: temperature, reference: 25.0 }),
        BuiltIn::Offset(Offset::linear(current, 0.5)),
        BuiltIn::Drift(Drift { reference_s: 10.0 }),
        BuiltIn::Field(AmbientField { column: current, reference: 0.5 }),
    ])
}

#[inline(never)]
fn push_study(study: &mut Study22, block: usize, reading: &Observation<f32>, terms: &[Term<'_, f32>; 5]) {
    // A row that is not finite is left out, and the counts below would show it.
    let _ = study.push(block, reading, terms);
}

#[inline(never)]
fn apply_magcal(calibration: &magcal::MagCal, counts: [i16; 3]) -> [f32; 3] {
    calibration.apply(counts)
}

struct Each {
    total: u32,
    worst: u32,
}

fn each(table: &[[i16; 3]], work: impl FnMut([i16; 3])) -> Each {
    each_of(table.iter().copied(), work)
}

fn each_of(samples: impl Iterator<Item = [i16; 3]>, mut work: impl FnMut([i16; 3])) -> Each {
    let mut result = Each { total: 0, worst: 0 };
    for counts in samples {
        let ticks = ticks_of(|| work(black_box(counts)));
        result.total += ticks;
        result.worst = result.worst.max(ticks);
    }
    result
}

fn say(key: &str, ticks: u32) {
    let _ = writeln!(Console, "{key}={ticks}");
}

/// Ticks of a whole table through the study.
#[inline(never)]
fn study(table: &[[i16; 3]; COUNT], moments: &Moments) -> Option<u32> {
    let calibration = solve(moments, Method::Adjusted)?.calibration.cast::<f32>();
    let effects = candidates()?;
    const NO_TURN: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let model = Model::new(calibration.offset_ut, calibration.matrix, calibration.field_ut, NO_TURN, 0.0)?;
    let mut study = Study22::new(Residual::Magnitude, model, 13);
    let mut terms = [0, 1, 2, 3, 4].map(|i| Term {
        effect: &effects[i] as _,
        coefficients: [0.0; 9],
        inputs: [0.0; 2],
        bends: Bends::Reading,
    });
    let mut sample = 0u16;
    let pushed = each(table, |counts| {
        sample += 1;
        let t = f32::from(sample) * 0.02;
        for (term, input) in terms.iter_mut().zip([25.0 + t, 25.0 + t, 0.5 + t, t, 0.5 + t]) {
            term.inputs[0] = input;
        }
        let measured_ut = counts.map(|c| f32::from(c) * UT_PER_COUNT as f32);
        let reading = Observation { measured_ut, turn_radps: None, down: None };
        push_study(&mut study, usize::from(sample / 300), &reading, &terms);
    });
    let rows: u32 = study.blocks().iter().map(|block| block.rows()).sum();
    (rows as usize == COUNT).then_some(pushed.total)
}

#[inline(never)]
fn push_learner(learner: &mut Learner, measured_ut: [f32; 3], t_ms: u64, motion: &Motion) {
    learner.push(measured_ut, t_ms, motion);
}

#[inline(never)]
fn step_inquiry(inquiry: &mut Inquiry, learner: &Learner) -> bool {
    inquiry.step(learner).is_some()
}

/// The board's own study of a table with all that it can be fed, and the question what is missing.
#[inline(never)]
fn learn(table: &[[i16; 3]; COUNT], moments: &Moments) -> Option<()> {
    let calibration = solve(moments, Method::Adjusted)?.calibration;
    let mut learner = Learner::new();
    learner.begin(&calibration);
    let names =
        [ColumnName::new("temp_c").ok()?, ColumnName::new("current_a").ok()?, ColumnName::new("fan").ok()?];
    let mut sample = 0u16;
    let pushed = each(table, |counts| {
        sample += 1;
        let t = f32::from(sample) * 0.02;
        for (place, name) in names.iter().enumerate() {
            // A few times a second, as such columns are.
            if sample % 10 == 1 {
                learner.feed(name, t * (place as f32 + 1.0) % 7.0);
            }
        }
        let measured_ut = counts.map(|c| f32::from(c) * UT_PER_COUNT as f32);
        let motion = Motion { accel_mps2: Some([0.1 * t, 0.2, -9.8]), turn_radps: Some([0.3, -0.2, 0.1]) };
        push_learner(&mut learner, measured_ut, u64::from(sample) * 20, &motion);
    });
    let mut inquiry = Inquiry::new(&learner, Default::default());
    let (mut total, mut worst, mut answered) = (0, 0, false);
    while !answered {
        let ticks = ticks_of(|| answered = step_inquiry(black_box(&mut inquiry), black_box(&learner)));
        total += ticks;
        worst = worst.max(ticks);
    }
    say("learn_push", pushed.total);
    say("learn_push_worst", pushed.worst);
    say("why", total);
    say("why_step_worst", worst);
    say(
        "why_stack",
        stack_of(|| {
            let mut inquiry = Inquiry::new(&learner, Default::default());
            while !step_inquiry(&mut inquiry, &learner) {}
        }),
    );
    say("learner_bytes", size_of::<Learner>() as u32);
    Some(())
}

#[inline(never)]
fn push_session(session: &mut Session, counts: [i16; 3]) {
    session.push(ironout::sensor::Sample::valid(counts));
}

/// A whole calibration as the firmware runs it; says what its pushes took, what its stop, and what of that was the fit.
#[inline(never)]
fn session(name: &str, samples: impl Iterator<Item = [i16; 3]>) {
    let mut session = Session::new(SessionConfig {
        ut_per_count: [UT_PER_COUNT; 3],
        field_ut: Some(50.0),
        method: Method::Adjusted,
        samples_per_block: 16,
        axes: None,
    });
    session.start();
    let pushed = each_of(samples, |counts| push_session(&mut session, counts));
    let mut fitted = None;
    let fit = ticks_of(|| fitted = black_box(&session).fit_so_far());
    let mut accepted = false;
    let stop = ticks_of(|| accepted = black_box(&mut session).stop().is_ok_and(|o| o.verdict.accepted));
    if !(accepted && matches!(fitted, Some(Ok(_)))) {
        exit(false)
    }
    for (what, ticks) in [("push", pushed.total), ("push_worst", pushed.worst), ("stop", stop), ("fit", fit)]
    {
        let _ = writeln!(Console, "session_{name}_{what}={ticks}");
    }
}

#[entry]
fn main() -> ! {
    let mut table = [[0i16; 3]; COUNT];
    fill(&mut table);
    start_clock();

    let mut moments = Moments::new();
    say("samples", COUNT as u32);
    say(
        "overhead",
        each(&table, |counts| {
            black_box(counts);
        })
        .total,
    );
    let pushed = each(&table, |counts| push(&mut moments, counts));
    say("push", pushed.total);
    say("push_worst", pushed.worst);
    let mut solver = magcal::Solver::new();
    let pushed = each(&table, |counts| push_magcal(&mut solver, counts));
    say("magcal_push", pushed.total);
    say("magcal_push_worst", pushed.worst);

    for (key, method) in [
        ("trace_solve", Method::Trace),
        ("adjusted_solve", Method::Adjusted),
        ("constant_solve", Method::Constant),
    ] {
        let mut report = None;
        say(key, ticks_of(|| report = solve(black_box(&moments), black_box(method))));
        let Some(report) = report else { exit(false) };
        let _ = writeln!(
            Console,
            "{key}_check={} {} {}",
            report.calibration.offset_ut[0].to_bits(),
            report.calibration.matrix[1][2].to_bits(),
            report.std_errors.matrix[2][2].to_bits()
        );
        if method == Method::Adjusted {
            let calibration = report.calibration.cast::<f32>();
            let applied = each(&table, |counts| {
                black_box(apply(&calibration, counts.map(f32::from)));
            });
            say("apply_base", applied.total);
            let Some(mut live) = live(calibration) else { exit(false) };
            let slots = [live.slots("temp_c"), live.slots("current_a")];
            let mut corrected = [0.0; 3];
            let applied = each(&table, |counts| {
                corrected = apply_effects(&mut live, slots, counts.map(f32::from), black_box([31.0, 2.5]));
            });
            say("apply", applied.total);
            if black_box(corrected).iter().all(|axis| *axis == 0.0) {
                exit(false)
            }
        }
    }
    say("study_push", study(&table, &moments).unwrap_or_else(|| exit(false)));
    if learn(&table, &moments).is_none() {
        exit(false)
    }
    let mut found = None;
    say("magcal_solve", ticks_of(|| found = solve_magcal(black_box(&mut solver))));
    let Some(found) = found else { exit(false) };
    let applied = each(&table, |counts| {
        black_box(apply_magcal(&found, counts));
    });
    say("magcal_apply", applied.total);

    say(
        "stack_push",
        stack_of(|| {
            push(&mut moments, black_box([120, -300, 455]));
        }),
    );
    say(
        "stack_solve",
        stack_of(|| {
            black_box(solve(&moments, black_box(Method::Adjusted)));
        }),
    );
    say(
        "magcal_stack_solve",
        stack_of(|| {
            black_box(solve_magcal(&mut solver));
        }),
    );
    session("turned", Turned::new());
    session("scattered", table.iter().copied());
    say("turned", Turned::COUNT);
    say("session_bytes", size_of::<Session>() as u32);
    say("state", size_of::<Moments>() as u32);
    say("magcal_state", size_of::<magcal::Solver>() as u32);
    exit(true)
}
