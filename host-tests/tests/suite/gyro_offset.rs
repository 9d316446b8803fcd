//! The offset of a moved battery with the gyro and without it, on recordings whose orientation cameras measured.

use ironout::rezero::{GyroUse, OffsetChange, Rezero};
use ironout_host_tests::accuracy::optical;
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};
use std::io::Write;
use std::path::Path;

/// Change of the offset that is added, µT.
const ADDED_UT: Vector3<f64> = Vector3::new(6.0, -4.0, 5.0);
/// Error of a corrected reading that the matrix makes, 0.5 % of the field, µT.
const MATRIX_UT: f32 = 0.22;
/// Looks of one offset.
const LOOKS: usize = 64;

/// A sample: time, s; measured field, µT; rate of turn, rad/s; and the room's axes in the sensor's, where the cameras saw it.
struct Sample {
    t_s: f64,
    measured_ut: Vector3<f64>,
    turn_radps: [f32; 3],
    from_room: Option<Rotation3<f64>>,
}

fn samples(folder: &Path, name: &str) -> Vec<Sample> {
    let (log, truth) = optical::columns_of(&folder.join(format!("{name}.csv"))).expect("a recording");
    let column = |name: &str| optical::column(&log, name);
    let seen = |name: &str| optical::column(&truth, name);
    let vector = |names: [&str; 3], at: usize| Vector3::from(names.map(|name| column(name)[at]));
    let times = seen("t_s");
    (0..column("t_s").len())
        .map(|at| {
            let t_s = column("t_s")[at];
            let place = times.partition_point(|time| *time < t_s - 1e-3);
            let unit = times.get(place).filter(|time| (**time - t_s).abs() < 2e-3).and_then(|_| {
                let [w, x, y, z] = ["qw", "qx", "qy", "qz"].map(|name| seen(name)[place]);
                let unit = UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 0.5)?;
                unit.coords.iter().all(|value| value.is_finite()).then_some(unit)
            });
            Sample {
                t_s,
                measured_ut: vector(["mx_ut", "my_ut", "mz_ut"], at),
                turn_radps: vector(["gx_radps", "gy_radps", "gz_radps"], at).map(|rate| rate as f32).into(),
                from_room: unit.map(|unit| unit.inverse().to_rotation_matrix()),
            }
        })
        .collect()
}

/// Offset and matrix from the cameras: `measured = A (from_room · h) + b`.
fn calibrated(samples: &[Sample]) -> (Matrix3<f64>, Vector3<f64>) {
    let mut field = Vector3::new(20.0, 0.0, -40.0);
    let (mut matrix, mut offset) = (Matrix3::identity(), Vector3::zeros());
    for _ in 0..20 {
        let (mut normal, mut right) = (SMatrix::<f64, 4, 4>::zeros(), SMatrix::<f64, 4, 3>::zeros());
        for (sample, rotation) in samples.iter().filter_map(|sample| Some((sample, sample.from_room?))) {
            let row = (rotation * field).push(1.0);
            normal += row * row.transpose();
            right += row * sample.measured_ut.transpose();
        }
        let found = normal.cholesky().expect("all directions").solve(&right);
        let soft = found.fixed_view::<3, 3>(0, 0).transpose();
        (matrix, offset) = (soft.try_inverse().expect("a matrix"), found.row(3).transpose());
        let seen = samples.iter().filter_map(|sample| {
            Some(sample.from_room?.inverse() * (matrix * (sample.measured_ut - offset)))
        });
        let (sum, n) = seen.fold((Vector3::zeros(), 0.0), |(sum, n), seen| (sum + seen, n + 1.0));
        // The scale is the sensor's own.
        field = sum / n * soft.determinant().cbrt();
    }
    (matrix, offset)
}

/// The offset of corrected readings by the cameras.
fn offset_by_cameras(corrected: impl Iterator<Item = (Vector3<f64>, Rotation3<f64>)>) -> Vector3<f64> {
    let (mut normal, mut right) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
    for (corrected, rotation) in corrected {
        let mut rows = SMatrix::<f64, 3, 6>::zeros();
        rows.fixed_view_mut::<3, 3>(0, 0).copy_from(rotation.matrix());
        rows.fixed_view_mut::<3, 3>(0, 3).fill_with_identity();
        normal += rows.transpose() * rows;
        right += rows.transpose() * corrected;
    }
    normal.cholesky().expect("turns").solve(&right).fixed_rows::<3>(3).into_owned()
}

/// How far from the truth offsets are, µT, with their own errors.
#[derive(Default)]
struct Errors {
    off_ut: Vec<f64>,
    /// More than two standard errors (of the worst direction) from the truth.
    beyond: usize,
    undetermined: usize,
    used: usize,
}

impl Errors {
    fn add(&mut self, found: Option<OffsetChange>, truth: Vector3<f64>) {
        // Where noise decides, the error is the whole field in every direction.
        let Some(found) = found.filter(|found| found.error_ut > found.least_error_ut) else {
            self.undetermined += 1;
            return;
        };
        let off = (Vector3::from(found.change_ut.map(f64::from)) - truth).norm();
        self.beyond += usize::from(off > 2.0 * f64::from(found.error_ut));
        self.used += usize::from(found.gyro == GyroUse::Used);
        self.off_ut.push(off);
    }

    fn median_ut(&mut self) -> f64 {
        self.off_ut.sort_by(f64::total_cmp);
        self.off_ut.get(self.off_ut.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

#[test]
fn the_offset_of_real_turns_is_more_exact_with_the_gyro() {
    let Some(folder) = optical::folder() else {
        // Written directly: the test harness swallows eprintln!.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the recordings with optical truth are not here");
        return;
    };
    let (matrix, offset) = calibrated(&samples(&folder, "04_undisturbed_slow_rotation_with_breaks_A"));
    for name in [
        "03_undisturbed_slow_rotation_C",
        "06_undisturbed_fast_rotation_A",
        "10_undisturbed_slow_translation_A",
        "24_disturbed_tapping_A",
    ] {
        let samples = samples(&folder, name);
        let corrected = |sample: &Sample| matrix * (sample.measured_ut - offset) + ADDED_UT;
        let seen = samples.iter().filter_map(|sample| Some((corrected(sample), sample.from_room?)));
        let truth = offset_by_cameras(seen);
        let (mut without, mut with) = (Errors::default(), Errors::default());
        let mut both = [Rezero::new(), Rezero::new()];
        for sample in &samples {
            let [alone, aided] = &mut both;
            let (t_ms, reading) =
                ((1000.0 * sample.t_s) as u64, corrected(sample).map(|value| value as f32).into());
            alone.push(t_ms, reading, None);
            aided.push(t_ms, reading, Some(sample.turn_radps));
            if alone.count() == LOOKS {
                without.add(alone.solve(MATRIX_UT).ok(), truth);
                with.add(aided.solve(MATRIX_UT).ok(), truth);
                both.iter_mut().for_each(Rezero::clear);
            }
        }
        let n = with.off_ut.len() + with.undetermined;
        let (off, off_with) = (without.median_ut(), with.median_ut());
        println!(
            "{name}: {n} offsets; {off:.2} µT without the gyro ({} undetermined, {} beyond 2σ), {off_with:.2} with it ({} used, {} beyond 2σ, worst {:.2})",
            without.undetermined,
            without.beyond,
            with.used,
            with.beyond,
            with.off_ut.last().unwrap_or(&f64::NAN)
        );
        assert_eq!((with.undetermined, with.used), (0, n), "{name}");
        if name.starts_with("10") {
            assert!(
                without.undetermined == n && off_with < 6.0,
                "{name}: a small turn is enough for the gyro"
            );
        } else {
            assert!(off_with <= off, "{name}: {off_with} {off}");
        }
        assert!(10 * with.beyond <= n + 9, "{name}: {} of {n}", with.beyond);
    }
}
