//! A blackbox log, from Betaflight's documentation ("Blackbox Internals"): headers, I and P frames.

/// Fields of the main frames, with the ways in which I and P frames write them.
const FIELDS: [(&str, bool, u8, u8, u8, u8); 14] = [
    // name, signed, predictor and encoding of I, of P
    ("loopIteration", false, 0, 1, 6, 9),
    ("time", false, 0, 1, 2, 0),
    ("vbatLatest", false, 9, 3, 1, 6),
    ("amperageLatest", true, 0, 0, 1, 6),
    ("magADC[0]", true, 0, 0, 1, 6),
    ("magADC[1]", true, 0, 0, 1, 6),
    ("magADC[2]", true, 0, 0, 1, 6),
    ("gyroADC[0]", true, 0, 0, 3, 0),
    ("gyroADC[1]", true, 0, 0, 3, 0),
    ("gyroADC[2]", true, 0, 0, 3, 0),
    ("accSmooth[0]", true, 0, 0, 3, 0),
    ("accSmooth[1]", true, 0, 0, 3, 0),
    ("accSmooth[2]", true, 0, 0, 3, 0),
    ("motor[0]", false, 11, 1, 1, 0),
];
/// Volts at arming, in hundredths.
const VBAT_REFERENCE: i32 = 1680;
const LEAST_MOTOR: i32 = 48;

/// A row: everything behind `loopIteration`, in the order of the fields.
pub type Row = [i32; 13];

/// One session; `firmware` as in its header.
pub fn session(firmware: &str, rows: &[Row]) -> Vec<u8> {
    let mut out =
        b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n".to_vec();
    let list = |get: &dyn Fn(usize) -> String| (0..FIELDS.len()).map(get).collect::<Vec<_>>().join(",");
    for (name, content) in [
        ("Field I name", list(&|i| FIELDS[i].0.into())),
        ("Field I signed", list(&|i| u8::from(FIELDS[i].1).to_string())),
        ("Field I predictor", list(&|i| FIELDS[i].2.to_string())),
        ("Field I encoding", list(&|i| FIELDS[i].3.to_string())),
        ("Field P predictor", list(&|i| FIELDS[i].4.to_string())),
        ("Field P encoding", list(&|i| FIELDS[i].5.to_string())),
        (
            "Field S name",
            "flightModeFlags,stateFlags,failsafePhase,rxSignalReceived,rxFlightChannelsValid".into(),
        ),
        ("Field S signed", "0,0,0,0,0".into()),
        ("Field S predictor", "0,0,0,0,0".into()),
        ("Field S encoding", "1,1,7,7,7".into()),
        ("Firmware type", "Cleanflight".into()),
        ("Firmware revision", firmware.into()),
        ("Craft name", "test".into()),
        ("I interval", "32".into()),
        ("P interval", "1".into()),
        ("motorOutput", format!("{LEAST_MOTOR},2047")),
        ("minthrottle", "1000".into()),
        // One degree a second, and 1/1000 of a degree a second.
        ("gyro_scale", format!("0x{:08x}", 0.001_f32.to_bits())),
        ("acc_1G", "20480".into()),
        ("vbatref", VBAT_REFERENCE.to_string()),
        ("features", "541130760".into()),
        ("debug_mode", "0".into()),
        ("motor_pwm_protocol", "6".into()),
    ] {
        out.extend(format!("H {name}:{content}\n").bytes());
    }
    let mut before: [Option<Row>; 2] = [None, None];
    for (iteration, row) in rows.iter().enumerate() {
        // An I frame now and then, as the firmware does.
        if iteration % 32 == 0 {
            intra(iteration as u32, row, &mut out);
            before = [Some(*row), Some(*row)];
        } else {
            let [last, last_last] = before.map(|row| row.expect("an I frame came first"));
            inter(row, &last, &last_last, iteration % 32 == 1, &mut out);
            before = [Some(*row), before[0]];
        }
    }
    // Event 255: the end of the log.
    out.extend(b"E\xffEnd of log\0");
    out
}

fn intra(iteration: u32, row: &Row, out: &mut Vec<u8>) {
    out.push(b'I');
    unsigned(iteration, out);
    unsigned(row[0] as u32, out);
    // Negative, of 14 bits, from the reference.
    unsigned(((VBAT_REFERENCE - row[1]) & 0x3fff) as u32, out);
    row[2..12].iter().for_each(|value| signed(*value, out));
    unsigned((row[12] - LEAST_MOTOR) as u32, out);
}

fn inter(row: &Row, last: &Row, last_last: &Row, after_intra: bool, out: &mut Vec<u8>) {
    out.push(b'P');
    // Time on the straight line through the last two; behind an I frame it has only one.
    let line = if after_intra { last[0] } else { 2 * last[0] - last_last[0] };
    signed(row[0] - line, out);
    let differences: Vec<i32> = (1..6).map(|i| row[i] - last[i]).collect();
    tag8_8svb(&differences, out);
    for i in 6..12 {
        let average = ((i64::from(last[i]) + i64::from(last_last[i])) / 2) as i32;
        signed(row[i] - average, out);
    }
    signed(row[12] - last[12], out);
}

/// Seven bits a byte, the lowest first.
fn unsigned(mut value: u32, out: &mut Vec<u8>) {
    while value > 0x7f {
        out.push((value as u8 & 0x7f) | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// The sign in the lowest bit.
fn signed(value: i32, out: &mut Vec<u8>) {
    unsigned(((value << 1) ^ (value >> 31)) as u32, out);
}

/// A byte that says which of up to eight values are not zero, and those.
fn tag8_8svb(values: &[i32], out: &mut Vec<u8>) {
    let tag = values.iter().enumerate().fold(0_u8, |tag, (i, value)| tag | (u8::from(*value != 0) << i));
    out.push(tag);
    values.iter().filter(|value| **value != 0).for_each(|value| signed(*value, out));
}
