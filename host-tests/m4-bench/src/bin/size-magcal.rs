//! The base image with the crate `magcal`: push, ellipsoid solve, apply.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use ironout_m4_bench::board::exit;

#[entry]
fn main() -> ! {
    let mut solver = magcal::Solver::new();
    for _ in 0..1000 {
        solver.push_sample(black_box([1i16, 2, 3]));
    }
    let Ok(found) = black_box(solver.solve_ellipsoid()) else { exit(true) };
    exit(black_box(found.apply(black_box([1, 2, 3])))[0] > 0.0)
}
