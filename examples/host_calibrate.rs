//! `ironout` in a host program: calibrates a CSV of µT triples and prints the correction.
//!
//!     cargo run --example host_calibrate              # makes its own data
//!     cargo run --example host_calibrate -- LOG.csv   # lines of x,y,z in µT; a header or other text is skipped

use ironout::fit::{FitOptions, fit};
use ironout::scatter::ScatterBuilder;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let samples = match std::env::args().nth(1) {
        Some(path) => read(&std::fs::read_to_string(path)?),
        None => turned_board(),
    };
    // The fit needs no samples, only their moments, taken about any point near them: the first sample will do.
    let mut moments = ScatterBuilder::new(*samples.first().ok_or("no line with three numbers")?);
    samples.iter().for_each(|&sample| moments.push(sample));
    // The step of the data's last digit is not known (0); without a field given, the mean magnitude is kept.
    let report = fit(&moments.finish(0.0)?, &FitOptions::default())?;

    let calibration = &report.calibration;
    println!("offset   {:9.3?} ± {:.3?} uT", calibration.offset_ut, report.std_errors.offset_ut);
    calibration.matrix.iter().for_each(|row| println!("matrix   {row:9.5?}"));
    println!("field    {:9.3} uT, noise {:.3} uT", calibration.field_ut, report.noise_ut);

    let magnitude = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let spread = |magnitudes: Vec<f64>| {
        let mean = magnitudes.iter().sum::<f64>() / magnitudes.len() as f64;
        let variance = magnitudes.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / magnitudes.len() as f64;
        100.0 * variance.sqrt() / mean
    };
    let before = spread(samples.iter().map(|&v| magnitude(v)).collect());
    let after = spread(samples.iter().map(|&v| magnitude(calibration.apply(v))).collect());
    println!("spread of the magnitude: {before:.2} % before, {after:.2} % after");
    Ok(())
}

/// The lines that hold three numbers.
fn read(text: &str) -> Vec<[f64; 3]> {
    let triple = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map_while(|cell| cell.trim().parse().ok()).collect();
        numbers.try_into().ok()
    };
    text.lines().filter_map(triple).collect()
}

/// A board turned in a field of 50 µT: hard iron of (93, -12, 4) µT, soft iron on x and between y and z.
fn turned_board() -> Vec<[f64; 3]> {
    (0..2000)
        .map(|i| (f64::from(i) * 0.013, f64::from(i) * 0.11))
        .map(|(tilt, turn)| [tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin()].map(|c| 50.0 * c))
        .map(|[x, y, z]| [1.1 * x + 93.0, y + 0.1 * z - 12.0, z + 4.0])
        // A sensor's digits.
        .map(|v| v.map(|c| (c * 10.0).round() / 10.0))
        .collect()
}
