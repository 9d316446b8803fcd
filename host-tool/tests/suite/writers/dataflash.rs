//! A DataFlash log, binary and as text, from ArduPilot's LogStructure.h.

use std::fmt::Write;

/// The kinds of message of the test, as ArduPilot 4.5 defines them: type, name, letters, labels.
const KINDS: [(u8, &str, &str, &str); 10] = [
    (129, "PARM", "QNff", "TimeUS,Name,Value,Default"),
    (130, "MAG", "QBhhhhhhhhhBI", "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S"),
    (131, "IMU", "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
    (132, "BAT", "QBffffffcf", "TimeUS,Inst,Volt,VoltR,Curr,CurrTot,EnrgTot,Res,Temp,RemPct"),
    (133, "MSG", "QZ", "TimeUS,Message"),
    (134, "GPS", "QBBIHBcLLeff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs"),
    (135, "ESC", "QBffffcfcf", "TimeUS,Instance,RPM,RawRPM,Volt,Curr,Temp,CTot,MotTemp,Err"),
    (137, "XKQ", "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4"),
    (138, "ATT", "QccccCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    (136, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4"),
];

/// One cell.
#[derive(Clone, Copy)]
pub enum Cell<'a> {
    /// A number, in the unit after the letter's scale.
    N(f64),
    /// A text.
    T(&'a str),
}

/// Both forms of the same log.
#[derive(Default)]
pub struct Dataflash {
    pub binary: Vec<u8>,
    pub text: String,
}

impl Dataflash {
    pub fn new() -> Self {
        let mut file = Dataflash::default();
        file.define(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
        for (kind, name, letters, labels) in KINDS {
            file.define(kind, name, letters, labels);
        }
        file
    }

    pub fn define(&mut self, kind: u8, name: &str, letters: &str, labels: &str) {
        let length = 3 + letters.bytes().map(size).sum::<usize>();
        self.binary.extend([0xa3, 0x95, 128, kind, length as u8]);
        for (text, width) in [(name, 4), (letters, 16), (labels, 64)] {
            assert!(text.len() <= width, "{text}");
            self.binary.extend(text.bytes().chain(std::iter::repeat(0)).take(width));
        }
        let _ = write!(self.text, "FMT, {kind}, {length}, {name}, {letters}, {labels}\r\n");
    }

    /// One message, its cells in the order of the labels.
    pub fn message(&mut self, name: &str, cells: &[Cell]) {
        let (kind, _, letters, _) = KINDS.iter().find(|kind| kind.1 == name).expect("defined above");
        assert_eq!(letters.len(), cells.len(), "{name}");
        self.binary.extend([0xa3, 0x95, *kind]);
        self.text.push_str(name);
        for (letter, cell) in letters.bytes().zip(cells) {
            match *cell {
                Cell::N(value) => {
                    number(letter, value, &mut self.binary);
                    let _ = match letter {
                        b'c' | b'C' | b'e' | b'E' => write!(self.text, ", {value:.2}"),
                        b'L' => write!(self.text, ", {value:.7}"),
                        b'f' => write!(self.text, ", {}", value as f32),
                        _ => write!(self.text, ", {}", value.round() as i64),
                    };
                }
                Cell::T(text) => {
                    let width = size(letter);
                    self.binary.extend(text.bytes().chain(std::iter::repeat(0)).take(width));
                    let _ = write!(self.text, ", {text}");
                }
            }
        }
        self.text.push_str("\r\n");
    }
}

fn size(letter: u8) -> usize {
    match letter {
        b'b' | b'B' => 1,
        b'h' | b'H' | b'c' | b'C' => 2,
        b'i' | b'I' | b'e' | b'E' | b'f' | b'L' | b'n' => 4,
        b'Q' => 8,
        b'N' => 16,
        b'Z' => 64,
        other => panic!("no letter {other}"),
    }
}

fn number(letter: u8, value: f64, out: &mut Vec<u8>) {
    let whole = value.round();
    match letter {
        b'B' => out.push(whole as u8),
        b'h' => out.extend((whole as i16).to_le_bytes()),
        b'H' => out.extend((whole as u16).to_le_bytes()),
        b'c' => out.extend(((value * 100.0).round() as i16).to_le_bytes()),
        b'C' => out.extend(((value * 100.0).round() as u16).to_le_bytes()),
        b'e' => out.extend(((value * 100.0).round() as i32).to_le_bytes()),
        b'L' => out.extend(((value * 1e7).round() as i32).to_le_bytes()),
        b'I' => out.extend((whole as u32).to_le_bytes()),
        b'f' => out.extend((value as f32).to_le_bytes()),
        b'Q' => out.extend((whole as u64).to_le_bytes()),
        other => panic!("no number of letter {other}"),
    }
}
