//! The base image with the core: push, adjusted least squares with standard errors and verdict figures, apply.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use ironout::fit::{FitOptions, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use ironout_m4_bench::board::exit;

#[entry]
fn main() -> ! {
    let mut moments = Moments::new();
    for _ in 0..1000 {
        moments.push(black_box([1i16, 2, 3]));
    }
    let solved = Scatter::from_moments(&moments, [0.1; 3]).and_then(|s| fit(&s, &FitOptions::default()));
    let Ok(report) = black_box(solved) else { exit(true) };
    let calibration = report.calibration.cast::<f32>();
    exit(black_box(calibration.apply(black_box([1.0, 2.0, 3.0])))[0] > 0.0)
}
