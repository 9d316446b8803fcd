//! Tables: separators, commas, encodings, names, units.

use super::sample::{Row, Sample, lines, nine, of_day};

fn table(header: &str, rows: &[Row], line: impl FnMut(usize, &Row) -> String) -> String {
    format!("{header}\n{}", lines(rows, line))
}

fn comma(text: String) -> String {
    text.replace('.', ",")
}

pub fn samples(rows: &[Row]) -> Vec<Sample> {
    let utf16 = |text: &str, big: bool| -> Vec<u8> {
        let units = std::iter::once(0xfeff).chain(text.encode_utf16());
        units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
    };
    let semicolons = table("Time (s);MagX (µT);MagY (µT);MagZ (µT)", rows, |_, r| {
        comma(format!("{:.3};{:.3};{:.3};{:.3}", r.t, r.m[0], r.m[1], r.m[2]))
    });
    let latin: Vec<u8> = semicolons.chars().map(|c| u8::try_from(u32::from(c)).expect("Latin-1")).collect();
    vec![
        Sample::new("semicolons, decimal comma", semicolons.clone(), 1e-3),
        Sample::new("UTF-16 little endian with a mark", utf16(&semicolons, false), 1e-3),
        Sample::new("UTF-16 big endian with a mark", utf16(&semicolons, true), 1e-3),
        Sample::new("UTF-8 with a mark", format!("\u{feff}{semicolons}"), 1e-3),
        Sample::new("Latin-1", latin, 1e-3),
        Sample::new(
            "tabs, Windows line ends, trailing tab",
            table("time [ms]\tmag_x [nT]\tmag_y [nT]\tmag_z [nT]\t\r", rows, |_, r| {
                format!("{:.0}\t{:.1}\t{:.1}\t{:.1}\t\r", r.t * 1e3, r.m[0] * 1e3, r.m[1] * 1e3, r.m[2] * 1e3)
            }),
            1e-4,
        ),
        Sample::new(
            "blanks, aligned",
            table("time_s   mag_x_mG   mag_y_mG   mag_z_mG", rows, |_, r| {
                format!("{:8.3} {:10.3} {:10.3} {:10.3}", r.t, r.m[0] * 10.0, r.m[1] * 10.0, r.m[2] * 10.0)
            }),
            1e-4,
        ),
        Sample::new(
            "quotes around everything, decimal comma between commas",
            table("\"t_ms\",\"Mag X (G)\",\"Mag Y (G)\",\"Mag Z (G)\"", rows, |_, r| {
                comma(format!(
                    "\"{:.1}\";\"{:.6}\";\"{:.6}\";\"{:.6}\"",
                    r.t * 1e3,
                    r.m[0] / 1e2,
                    r.m[1] / 1e2,
                    r.m[2] / 1e2
                ))
                .replace(';', ",")
            }),
            1e-4,
        ),
        Sample::new(
            "bars, and a comment above",
            format!(
                "# exported by a logger\n{}",
                table("timestamp_us|mx_nT|my_nT|mz_nT|temperature (K)", rows, |_, r| {
                    format!(
                        "{:.0}|{:.0}|{:.0}|{:.0}|{:.2}",
                        r.t * 1e6,
                        r.m[0] * 1e3,
                        r.m[1] * 1e3,
                        r.m[2] * 1e3,
                        r.temp + 273.15
                    )
                })
            ),
            1e-3,
        ),
        Sample::new(
            "header as a comment",
            table("# time_s, bx_ut, by_ut, bz_ut", rows, |_, r| {
                format!("{:.3}, {:.4}, {:.4}, {:.4}", r.t, r.m[0], r.m[1], r.m[2])
            }),
            1e-4,
        ),
        Sample::new(
            "capitals of the own names, nanotesla and milliseconds",
            table("T_MS,MX_NT,MY_NT,MZ_NT,AX_MPS2,AY_MPS2,AZ_MPS2", rows, |_, r| {
                let [x, y, z] = r.m.map(|v| v * 1e3);
                format!("{:.1},{x:.1},{y:.1},{z:.1},{:.4},{:.4},{:.4}", r.t * 1e3, r.a[0], r.a[1], r.a[2])
            }),
            1e-4,
        )
        .accel(1e-4),
        Sample::new(
            "own names in milligauss, degrees and g",
            table("t_us,mx_mG,my_mG,mz_mG,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps", rows, |_, r| {
                let ([x, y, z], [a, b, c], [p, q, s]) =
                    (r.m.map(|v| v * 10.0), r.a.map(|v| v / 9.80665), r.g.map(f64::to_degrees));
                format!("{:.0},{x:.3},{y:.3},{z:.3},{a:.6},{b:.6},{c:.6},{p:.4},{q:.4},{s:.4}", r.t * 1e6)
            }),
            1e-4,
        )
        .accel(1e-5)
        .gyro(),
        Sample::new(
            "date and time of day, tesla",
            table("Date;Bx [T];By [T];Bz [T]", rows, |_, r| {
                let ms = (r.t * 1e3).round() as u64;
                let [x, y, z] = r.m.map(|v| v * 1e-6);
                format!("2026-05-04T23:59:{:02}.{:03}Z;{x:.4e};{y:.4e};{z:.4e}", 20 + ms / 1000, ms % 1000)
            }),
            2e-2,
        ),
        Sample::new(
            "a time of day over midnight",
            table("time,magX_uT,magY_uT,magZ_uT,note", rows, |_, r| {
                format!("{},{:.3},{:.3},{:.3},ok", of_day(86_390.0 + r.t), r.m[0], r.m[1], r.m[2])
            }),
            1e-3,
        ),
        Sample::new(
            "no unit in any name, floats",
            table("timestamp,MagX,MagY,MagZ,AccX,AccY,AccZ", rows, |_, r| {
                format!(
                    "{:.3},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}",
                    r.t, r.m[0], r.m[1], r.m[2], r.a[0], r.a[1], r.a[2]
                )
            }),
            1e-4,
        )
        .accel(1e-4),
        Sample::new(
            "a unit by --map",
            table("when,a1,a2,a3", rows, |_, r| {
                let [x, y, z] = r.m.map(|v| v * 10.0);
                format!("{:.0},{x:.2},{y:.2},{z:.2}", r.t * 1e3)
            }),
            1e-3,
        )
        .map(&["t_s=when[ms],mx_ut=a1[mG],my_ut=a2[mG],mz_ut=a3[mG]"]),
        Sample::new(
            "3 numbers a line",
            lines(rows, |_, r| format!("{:.4} {:.4} {:.4}", r.m[0], r.m[1], r.m[2])),
            1e-4,
        )
        .untimed(),
        Sample::new(
            "4 numbers a line",
            lines(rows, |_, r| format!("{:.3},{:.4},{:.4},{:.4}", r.t, r.m[0], r.m[1], r.m[2])),
            1e-4,
        ),
        Sample::new(
            "6 numbers a line",
            lines(rows, |_, r| {
                format!(
                    "{:.4}\t{:.4}\t{:.4}\t{:.4}\t{:.4}\t{:.4}",
                    r.a[0], r.a[1], r.a[2], r.m[0], r.m[1], r.m[2]
                )
            }),
            1e-4,
        )
        .accel(1e-4)
        .untimed(),
        Sample::new("9 whole numbers a line, as MotionCal has them", lines(rows, |_, r| nine(r, ",")), 0.1)
            .accel(9.80665 / 8192.0)
            .gyro()
            .untimed(),
        Sample::new(
            "10 numbers a line",
            lines(rows, |_, r| {
                let [p, q, s] = r.g.map(|v| v.to_degrees() * 3.0);
                format!(
                    "{:.0} {:.4} {:.4} {:.4} {p:.3} {q:.3} {s:.3} {:.4} {:.4} {:.4}",
                    r.t * 1e3,
                    r.a[0],
                    r.a[1],
                    r.a[2],
                    r.m[0],
                    r.m[1],
                    r.m[2]
                )
            }),
            1e-4,
        )
        .accel(1e-4)
        .gyro()
        .map(&["mx_ut=column 8[uT],my_ut=column 9[uT],mz_ut=column 10[uT]"]),
        Sample::new(
            "two sensors in the rows of one table",
            table("t_ms,sensor,x_uT,y_uT,z_uT", rows, |_, r| {
                format!(
                    "{:.0},0,{:.3},{:.3},{:.3}\n{:.0},1,{:.3},{:.3},{:.3}",
                    r.t * 1e3,
                    r.m[1] + 5.0,
                    r.m[0],
                    r.m[2],
                    r.t * 1e3 + 3.0,
                    r.m[0],
                    r.m[1],
                    r.m[2]
                )
            }),
            1e-3,
        )
        .instance(1),
        Sample::new(
            "two sensors in the columns of one table",
            table("t_s,mag0_x_uT,mag0_y_uT,mag0_z_uT,mag1_x_uT,mag1_y_uT,mag1_z_uT", rows, |_, r| {
                let [x, y, z] = r.m;
                format!("{:.3},{x:.3},{y:.3},{z:.3},{:.3},{:.3},{:.3}", r.t, y + 7.0, x, z)
            }),
            1e-3,
        ),
    ]
}
