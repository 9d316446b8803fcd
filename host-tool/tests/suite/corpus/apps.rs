//! Telephone apps.

use super::sample::{Row, Sample, lines};

pub fn samples(rows: &[Row]) -> Vec<Sample> {
    let norm = |r: &Row| r.m.iter().map(|v| v * v).sum::<f64>().sqrt();
    vec![
        Sample::new(
            "phyphox, CSV with commas",
            format!(
                "\"Time (s)\",\"Magnetic field x (µT)\",\"Magnetic field y (µT)\",\"Magnetic field z (µT)\",\"Absolute field (µT)\",\"Accuracy\"\n{}",
                lines(rows, |_, r| format!("{:.9E},{:.6E},{:.6E},{:.6E},{:.6E},3.0E0", r.t, r.m[0], r.m[1], r.m[2], norm(r)))
            ),
            1e-4,
        ),
        Sample::new(
            "phyphox in German, semicolons and decimal commas",
            format!(
                "\"Zeit (s)\";\"Magnetfeld x (µT)\";\"Magnetfeld y (µT)\";\"Magnetfeld z (µT)\";\"Absolutes Feld (µT)\"\n{}",
                lines(rows, |_, r| {
                    format!("{:.6E};{:.6E};{:.6E};{:.6E};{:.6E}", r.t, r.m[0], r.m[1], r.m[2], norm(r)).replace('.', ",")
                })
            ),
            1e-4,
        ),
        Sample::new(
            "Sensor Logger, z before x, two times",
            format!(
                "time,seconds_elapsed,z,y,x\n{}",
                lines(rows, |_, r| {
                    let ns = 1_700_000_000_000_000_000_i64 + (r.t * 1e9).round() as i64;
                    format!("{ns},{:.6},{:.6},{:.6},{:.6}", r.t, r.m[2], r.m[1], r.m[0])
                })
            ),
            1e-5,
        ),
        Sample::new(
            "Sensor Logger, JSON of several sensors",
            format!(
                "[{}]",
                lines(rows, |_, r| {
                    let ns = 1_700_000_000_000_000_000_i64 + (r.t * 1e9).round() as i64;
                    format!(
                        "{{\"sensor\":\"Accelerometer\",\"time\":\"{ns}\",\"z\":{},\"y\":{},\"x\":{}}},\
                         {{\"sensor\":\"MagnetometerUncalibrated\",\"time\":\"{ns}\",\"z\":{:.4},\"y\":{:.4},\"x\":{:.4}}},",
                        r.a[2], r.a[1], r.a[0], r.m[2], r.m[1], r.m[0]
                    )
                })
                .trim_end()
                .trim_end_matches(',')
            ),
            1e-4,
        ),
        Sample::new(
            "Physics Toolbox, all sensors",
            format!(
                "time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz,Bx,By,Bz,Azimuth,Pitch,Roll,\n{}",
                lines(rows, |_, r| {
                    let f = r.a.map(|v| v / 9.80665);
                    format!(
                        "{:.3},{:.5},{:.5},{:.5},0.01,0.02,0.03,{:.5},{:.5},{:.5},{:.4},{:.4},{:.4},12.5,3.1,-4.2,",
                        r.t, f[0], f[1], f[2], r.g[0], r.g[1], r.g[2], r.m[0], r.m[1], r.m[2]
                    )
                })
            ),
            1e-4,
        )
        .map(&["ax_mps2=gFx[g],ay_mps2=gFy[g],az_mps2=gFz[g]"])
        .accel(1e-4)
        .gyro(),
        Sample::new(
            "AndroSensor",
            format!(
                "ACCELEROMETER X (m/s²);ACCELEROMETER Y (m/s²);ACCELEROMETER Z (m/s²);GRAVITY X (m/s²);GRAVITY Y (m/s²);GRAVITY Z (m/s²);GYROSCOPE X (rad/s);GYROSCOPE Y (rad/s);GYROSCOPE Z (rad/s);MAGNETIC FIELD X (μT);MAGNETIC FIELD Y (μT);MAGNETIC FIELD Z (μT);ORIENTATION Z (azimuth °);Time since start in ms ;YYYY-MO-DD HH-MI-SS_SSS\n{}",
                lines(rows, |_, r| {
                    format!(
                        "{:.4};{:.4};{:.4};0.1;0.2;9.8;{:.4};{:.4};{:.4};{:.4};{:.4};{:.4};120.5;{:.0};2026-05-04 12-00-00_001",
                        r.a[0], r.a[1], r.a[2], r.g[0], r.g[1], r.g[2], r.m[0], r.m[1], r.m[2], r.t * 1e3
                    )
                })
            ),
            1e-4,
        )
        .accel(1e-4)
        .gyro(),
        Sample::new(
            "SensorLog of an iPhone",
            format!(
                "loggingTime(txt),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G),motionUserAccelerationX(G),motionUserAccelerationY(G),motionUserAccelerationZ(G),magnetometerX(µT),magnetometerY(µT),magnetometerZ(µT)\n{}",
                lines(rows, |_, r| {
                    let a = r.a.map(|v| v / 9.80665);
                    let ms = (r.t * 1e3).round() as u64;
                    format!(
                        "2026-05-04 12:00:{:02}.{:03} +0200,{:.4},{:.6},{:.6},{:.6},0.1,0.1,0.1,{:.4},{:.4},{:.4}",
                        ms / 1000, ms % 1000, 5000.0 + r.t, a[0], a[1], a[2], r.m[0], r.m[1], r.m[2]
                    )
                })
            ),
            1e-4,
        )
        .accel(1e-5),
    ]
}
