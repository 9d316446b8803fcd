//! `cargo bench`: the core on the host, beside the crate `magcal` on the same counts in the same run. The last lines are
//! the ratios; times are shown, not asserted.

use divan::Bencher;
use ironout::calibration::Calibration;
use ironout::fit::{FitOptions, Method, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use ironout_host_tests::paper::{Sampler, eq_16};
use std::hint::black_box;
use std::time::Instant;

const SCALE: f64 = 1.0 / 500.0;

fn counts() -> Vec<[i16; 3]> {
    let samples = eq_16().samples(&mut Sampler::new(1), 10_000, 0.01, nalgebra::Vector3::z(), 1.0);
    samples.iter().map(|s| s.map(|v| (v / SCALE).round() as i16)).collect()
}

fn moments(counts: &[[i16; 3]]) -> Moments {
    let mut moments = Moments::new();
    counts.iter().for_each(|c| moments.push(*c));
    moments
}

fn magcal_solver(counts: &[[i16; 3]]) -> magcal::Solver {
    let mut solver = magcal::Solver::new();
    counts.iter().for_each(|c| solver.push_sample(*c));
    solver
}

fn solve(moments: &Moments, method: Method) -> Calibration {
    let scatter = Scatter::from_moments(moments, [SCALE; 3]).expect("the samples are good");
    fit(&scatter, &FitOptions { method, ..FitOptions::default() }).expect("the samples are good").calibration
}

#[divan::bench]
fn push_10000(bencher: Bencher) {
    let counts = counts();
    bencher.bench_local(|| moments(black_box(&counts)));
}

#[divan::bench]
fn push_10000_magcal(bencher: Bencher) {
    let counts = counts();
    bencher.bench_local(|| magcal_solver(black_box(&counts)));
}

#[divan::bench(args = ["constant", "trace", "adjusted"])]
fn solve_with_errors(bencher: Bencher, method: &str) {
    let moments = moments(&counts());
    let method = Method::parse(method).expect("the name of a method");
    bencher.bench_local(|| solve(black_box(&moments), method));
}

#[divan::bench]
fn solve_magcal(bencher: Bencher) {
    let mut solver = magcal_solver(&counts());
    bencher.bench_local(|| black_box(&mut solver).solve_ellipsoid().is_ok());
}

#[divan::bench]
fn apply_10000(bencher: Bencher) {
    let counts = counts();
    let calibration = solve(&moments(&counts), Method::Adjusted).cast::<f32>();
    bencher.bench_local(|| {
        for c in &counts {
            black_box(calibration.apply(c.map(f32::from)));
        }
    });
}

#[divan::bench]
fn apply_10000_magcal(bencher: Bencher) {
    let counts = counts();
    let found = magcal_solver(&counts).solve_ellipsoid().expect("the samples are good");
    bencher.bench_local(|| {
        for c in &counts {
            black_box(found.apply(*c));
        }
    });
}

/// The median time of a run, seconds.
fn median_s(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..31)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    divan::main();
    let counts = counts();
    let sums = moments(&counts);
    let mut solver = magcal_solver(&counts);
    let push = median_s(|| _ = black_box(moments(black_box(&counts))));
    let push_magcal = median_s(|| _ = black_box(magcal_solver(black_box(&counts))));
    let adjusted = median_s(|| _ = black_box(solve(black_box(&sums), Method::Adjusted)));
    let trace = median_s(|| _ = black_box(solve(black_box(&sums), Method::Trace)));
    let solve_magcal = median_s(|| _ = black_box(solver.solve_ellipsoid()));
    println!("ironout over magcal, the same counts in the same run:");
    println!(
        "  push            {:5.2}   ({:.1} ns and {:.1} ns a sample)",
        push / push_magcal,
        push * 1e5,
        push_magcal * 1e5
    );
    println!("  solve, trace    {:5.2}   (with standard errors; magcal has none)", trace / solve_magcal);
    println!("  solve, adjusted {:5.2}   (with standard errors and the noise)", adjusted / solve_magcal);
}
