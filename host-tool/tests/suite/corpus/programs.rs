//! Autopilots and robots: tables that their tools export.

use super::sample::{Row, Sample, lines};

pub fn samples(rows: &[Row]) -> Vec<Sample> {
    vec![
        Sample::new(
            "PX4 ulog2csv, vehicle_magnetometer",
            format!(
                "timestamp,timestamp_sample,device_id,magnetometer_ga[0],magnetometer_ga[1],magnetometer_ga[2],calibration_count\n{}",
                lines(rows, |_, r| {
                    let us = 5_000_000 + (r.t * 1e6).round() as u64;
                    format!("{us},{},396809,{:.6},{:.6},{:.6},1", us - 3000, r.m[0] / 1e2, r.m[1] / 1e2, r.m[2] / 1e2)
                })
            ),
            1e-4,
        ),
        Sample::new(
            "PX4 ulog2csv, sensor_mag",
            format!(
                "timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count\n{}",
                lines(rows, |_, r| {
                    let us = 5_000_000 + (r.t * 1e6).round() as u64;
                    format!("{us},{},396809,{:.6},{:.6},{:.6},{:.2},0", us - 3000, r.m[0] / 1e2, r.m[1] / 1e2, r.m[2] / 1e2, r.temp)
                })
            ),
            1e-4,
        ),
        Sample::new(
            "ArduPilot MAG messages as CSV, two instances, offsets applied",
            format!(
                "timestamp,TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S\n{}",
                lines(rows, |_, r| {
                    let us = 60_000_000 + (r.t * 1e6).round() as u64;
                    let [x, y, z] = r.m.map(|v| (v * 10.0).round());
                    let s = us as f64 / 1e6 + 1.7e9;
                    format!(
                        "{s:.6},{us},0,{},{},{},-12,40,7,3,0,-2,1,{us}\n{s:.6},{us},1,{},{},{},0,0,0,0,0,0,1,{us}",
                        x - 12.0 + 3.0, y + 40.0, z + 7.0 - 2.0, y, x, z
                    )
                })
            ),
            0.1,
        )
        .instance(0),
        Sample::new(
            "blackbox_decode",
            format!(
                "loopIteration, time (us), axisP[0], gyroADC[0], gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], magADC[0], magADC[1], magADC[2], motor[0], vbatLatest (V), amperageLatest (A)\n{}",
                lines(rows, |index, r| {
                    let [x, y, z] = r.m.map(|v| (v / 0.0917).round() as i64);
                    let g = r.g.map(|v| v.to_degrees().round() as i64);
                    let a = r.a.map(|v| (v / 9.80665 * 2048.0).round() as i64);
                    format!(
                        "{index}, {:.0}, 0, {}, {}, {}, {}, {}, {}, {x}, {y}, {z}, {}, 16.41, {:.2}",
                        1e6 + r.t * 1e6, g[0], g[1], g[2], a[0], a[1], a[2], 1100 + index % 7, 3.0 + r.t / 100.0
                    )
                })
            ),
            0.0917,
        )
        .scale(0.0917)
        .gyro(),
        Sample::new(
            "ROS 1, rostopic echo -p",
            format!(
                "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.magnetic_field.x,field.magnetic_field.y,field.magnetic_field.z,field.magnetic_field_covariance0,field.magnetic_field_covariance1\n{}",
                lines(rows, |index, r| {
                    let ns = 1_700_000_000_000_000_000_i64 + (r.t * 1e9).round() as i64;
                    let [x, y, z] = r.m.map(|v| v * 1e-6);
                    format!("{},{index},{ns},imu_link,{x:.6e},{y:.6e},{z:.6e},0.0,0.0", ns + 700_000)
                })
            ),
            1e-4,
        ),
        Sample::new(
            "ROS 2, ros2 topic echo --csv",
            lines(rows, |_, r| {
                let ns = (r.t * 1e9).round() as u64;
                let [x, y, z] = r.m.map(|v| v * 1e-6);
                let stamp = 1_700_000_000 + ns / 1_000_000_000;
                format!("{stamp},{},imu_link,{x:.6e},{y:.6e},{z:.6e},0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0", ns % 1_000_000_000)
            }),
            1e-4,
        ),
        Sample::new(
            "PlotJuggler",
            format!(
                "__time,/imu/mag/magnetic_field/x,/imu/mag/magnetic_field/y,/imu/mag/magnetic_field/z\n{}",
                lines(rows, |_, r| {
                    let [x, y, z] = r.m.map(|v| v * 1e-6);
                    format!("{:.6},{x:.6e},{y:.6e},{z:.6e}", 1.7e9 + r.t)
                })
            ),
            1e-4,
        ),
        Sample::new(
            "MAVLink RAW_IMU as a table",
            format!(
                "time_usec,xacc_mg,yacc_mg,zacc_mg,xmag_mG,ymag_mG,zmag_mG\n{}",
                lines(rows, |_, r| {
                    let a = r.a.map(|v| v / 9.80665e-3);
                    let m = r.m.map(|v| v * 10.0);
                    format!("{:.0},{:.1},{:.1},{:.1},{:.2},{:.2},{:.2}", r.t * 1e6, a[0], a[1], a[2], m[0], m[1], m[2])
                })
            ),
            1e-3,
        )
        .accel(1e-3),
    ]
}
