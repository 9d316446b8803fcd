//! What boards print, as serial monitors and terminals keep it.

use super::sample::{Row, Sample, lines, nine, of_day};

/// A boot, and now and then a message between the rows.
fn chatter(text: String) -> String {
    let mut out = String::from(
        "ets Jun  8 2016 00:22:57\r\nrst:0x1 (POWERON_RESET),boot:0x13\r\nSensor found at 0x1E\r\n\r\n",
    );
    for (index, line) in text.lines().enumerate() {
        out.push_str(line);
        out.push_str("\r\n");
        if index % 400 == 200 {
            out.push_str("wifi: reconnecting ...\r\n");
        }
    }
    out
}

pub fn samples(rows: &[Row]) -> Vec<Sample> {
    let m = |r: &Row| r.m;
    vec![
        Sample::new(
            "X: Y: Z: with a unit behind, a boot before",
            chatter(lines(rows, |_, r| format!("X: {:.2}  Y: {:.2}  Z: {:.2}  uT", m(r)[0], m(r)[1], m(r)[2]))),
            1e-2,
        )
        .untimed(),
        Sample::new(
            "X: Y: Z: over three lines",
            lines(rows, |_, r| format!("Mag X: {:.2} uT\nMag Y: {:.2} uT\nMag Z: {:.2} uT", m(r)[0], m(r)[1], m(r)[2])),
            1e-2,
        )
        .untimed(),
        Sample::new(
            "serial plotter with labels, behind a monitor's time",
            chatter(lines(rows, |_, r| {
                format!("{} -> mx:{:.3},my:{:.3},mz:{:.3}", of_day(43_200.0 + r.t), m(r)[0], m(r)[1], m(r)[2])
            })),
            1e-3,
        ),
        Sample::new(
            "three numbers behind a monitor's time in brackets",
            lines(rows, |_, r| format!("[{}] {:.3}\t{:.3}\t{:.3}", of_day(3600.0 + r.t), m(r)[0], m(r)[1], m(r)[2])),
            1e-3,
        ),
        Sample::new(
            "ESP-IDF log with colours",
            lines(rows, |_, r| {
                format!("\u{1b}[0;32mI ({:.0}) mag: x={:.3} y={:.3} z={:.3}\u{1b}[0m", 300.0 + r.t * 1e3, m(r)[0], m(r)[1], m(r)[2])
            }),
            1e-3,
        ),
        Sample::new(
            "Zephyr log",
            lines(rows, |_, r| {
                format!("[{},000] <inf> main: mag: {:.3}, {:.3}, {:.3}", of_day(r.t), m(r)[0], m(r)[1], m(r)[2])
            }),
            1e-3,
        ),
        Sample::new(
            "SparkFun's ICM-20948 print",
            lines(rows, |_, r| {
                let a = r.a.map(|v| v / 9.80665e-3);
                let g = r.g.map(f64::to_degrees);
                format!(
                    "Scaled. Acc (mg) [ {:09.2}, {:09.2}, {:09.2} ], Gyr (DPS) [ {:.2}, {:.2}, {:.2} ], Mag (uT) [ {:.2}, {:.2}, {:.2} ], Tmp (C) [ {:.2} ]",
                    a[0], a[1], a[2], g[0], g[1], g[2], m(r)[0], m(r)[1], m(r)[2], r.temp
                )
            }),
            1e-2,
        )
        .accel(1e-4)
        .gyro()
        .untimed(),
        Sample::new(
            "ROS log lines",
            lines(rows, |_, r| {
                format!("[INFO] [{:.6}] [imu]: mag=({:.3}, {:.3}, {:.3})", 1.7e9 + r.t, m(r)[0], m(r)[1], m(r)[2])
            }),
            1e-3,
        ),
        Sample::new(
            "tuples as Python prints them",
            lines(rows, |_, r| format!("({:.3}, {:.3}, {:.3}, {:.3})", r.t, m(r)[0], m(r)[1], m(r)[2])),
            1e-3,
        ),
        Sample::new(
            "dictionaries as Python prints them",
            lines(rows, |_, r| format!("{{'t_s': {:.3}, 'mx': {:.3}, 'my': {:.3}, 'mz': {:.3}}}", r.t, m(r)[0], m(r)[1], m(r)[2])),
            1e-3,
        ),
        Sample::new(
            "sentences with a checksum",
            lines(rows, |_, r| format!("$MAG,{:.3},{:.3},{:.3},{:.3}*5A", r.t, m(r)[0], m(r)[1], m(r)[2])),
            1e-3,
        ),
        Sample::new(
            "JSON lines, nested",
            lines(rows, |_, r| {
                format!(
                    "{{\"t_ms\":{:.0},\"mag\":{{\"x\":{:.3},\"y\":{:.3},\"z\":{:.3}}},\"temp_c\":{:.2}}}",
                    r.t * 1e3, m(r)[0], m(r)[1], m(r)[2], r.temp
                )
            }),
            1e-3,
        ),
        Sample::new(
            "JSON lines, arrays, a boot before",
            chatter(lines(rows, |_, r| {
                format!("{{\"time_us\":{:.0},\"mag_ut\":[{:.3},{:.3},{:.3}]}}", r.t * 1e6, m(r)[0], m(r)[1], m(r)[2])
            })),
            1e-3,
        ),
        Sample::new("MotionCal, Raw: lines", chatter(lines(rows, |_, r| format!("Raw:{}", nine(r, ",")))), 0.1)
            .accel(9.80665 / 8192.0)
            .gyro()
            .untimed(),
        Sample::new(
            "MotionCal, Raw: and Uni: lines",
            lines(rows, |_, r| {
                format!(
                    "Raw:{}\nUni:{:.2},{:.2},{:.2},{:.4},{:.4},{:.4},{:.2},{:.2},{:.2}",
                    nine(r, ","), r.a[0], r.a[1], r.a[2], r.g[0], r.g[1], r.g[2], m(r)[0], m(r)[1], m(r)[2]
                )
            }),
            1e-2,
        )
        .accel(1e-2)
        .gyro()
        .untimed(),
        Sample::new(
            "MotionCal lines of an ironout board",
            lines(rows, |_, r| {
                let [x, y, z] = m(r).map(|v| (v * 10.0).round() as i64);
                format!("Raw:0,0,0,0,0,0,{x},{y},{z}")
            }),
            0.1,
        )
        .untimed(),
        Sample::new(
            "R, lines of an ironout board between replies",
            format!(
                "ok ironout 0.1\n+ state=idle\nok\n{}ok\nerr usage what?\n",
                lines(rows, |index, r| {
                    let [x, y, z] = m(r).map(|v| (v / 0.05).round() as i64);
                    let reply = if index % 300 == 7 { "+ n=12\nok state=collecting\n" } else { "" };
                    format!("{reply}R,{:.0},{x},{y},{z}", 1200.0 + r.t * 1e3)
                })
            ),
            0.05,
        )
        .scale(0.05),
        Sample::new(
            "C, lines of an ironout board",
            lines(rows, |_, r| {
                let [x, y, z] = m(r);
                format!("C,{:.0},{x:.3},{y:.3},{z:.3},{:.3},0.100", r.t * 1e3, (x * x + y * y + z * z).sqrt())
            }),
            1e-3,
        ),
    ]
}
