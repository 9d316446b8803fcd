//! The core, and `magcal` on the same counts.

use crate::data::{self, SAMPLES, calibration, counts, live, magcal_solver, moments};
use divan::Bencher;
use divan::counter::ItemsCount;
use ironout::fit::Method;
use std::hint::black_box;

#[divan::bench]
fn push(bencher: Bencher) {
    let counts = counts();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| moments(black_box(&counts)));
}

#[divan::bench]
fn push_magcal(bencher: Bencher) {
    let counts = counts();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| magcal_solver(black_box(&counts)));
}

#[divan::bench(args = ["constant", "trace", "adjusted"])]
fn solve(bencher: Bencher, method: &str) {
    let moments = moments(&counts());
    let method = Method::parse(method).expect("the name of a method");
    bencher.bench_local(|| data::solve(black_box(&moments), method));
}

#[divan::bench]
fn solve_magcal(bencher: Bencher) {
    let mut solver = magcal_solver(&counts());
    bencher.bench_local(|| black_box(&mut solver).solve_ellipsoid().is_ok());
}

#[divan::bench]
fn apply(bencher: Bencher) {
    let (counts, calibration) = (counts(), calibration());
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| data::apply(&calibration, black_box(&counts)));
}

#[divan::bench]
fn apply_two_effects(bencher: Bencher) {
    let (counts, (mut live, slots)) = (counts(), live());
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench_local(|| data::apply_effects(&mut live, slots, black_box(&counts)));
}

#[divan::bench]
fn apply_magcal(bencher: Bencher) {
    let counts = counts();
    let found = magcal_solver(&counts).solve_ellipsoid().expect("the samples are good");
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| data::apply_magcal(&found, black_box(&counts)));
}

#[divan::bench]
fn study_push(bencher: Bencher) {
    let (counts, calibration) = (counts(), calibration());
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| data::study(&calibration, black_box(&counts)));
}
