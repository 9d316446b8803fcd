//! One recording through both: the board's core, row by row, and the host's analysis, as a table.

use super::trace::Said;
use ironout::device::{Action, Device, DeviceConfig, Pace, SensorAnswer, StoreAnswer, StoreTask};
use ironout::sensor::{Reading, Sensor};
use ironout_analysis::Table;
use ironout_simulation::Log;

/// µT a count of the sensor that both read: fine enough for any recording, within sixteen bits up to 256 µT, and the same number in
/// single and in double precision.
pub const UT_PER_COUNT: f64 = 1.0 / 128.0;

/// A recording as both are given it: the magnetometer in whole counts, every other value in single precision.
#[derive(Clone, Debug)]
pub struct Recording {
    counts: Vec<[i16; 3]>,
    columns: Vec<(String, Vec<f64>)>,
}

impl Recording {
    /// From columns named as in the log format. `t_s` is needed; where there is none, or no magnetometer, `None`.
    pub fn of<'a>(columns: impl IntoIterator<Item = (&'a str, &'a [f64])>) -> Option<Self> {
        let mut all: Vec<(String, Vec<f64>)> =
            columns.into_iter().map(|(name, values)| (name.to_owned(), values.to_vec())).collect();
        let of = |name: &str| all.iter().position(|(own, _)| own == name);
        let (field, time) = (["mx_ut", "my_ut", "mz_ut"].map(of), of("t_s")?);
        let [Some(x), Some(y), Some(z)] = field else { return None };
        let rows = all[x].1.len();
        let counts = (0..rows)
            .map(|row| [x, y, z].map(|axis| (all[axis].1[row] / UT_PER_COUNT).round() as i16))
            .collect::<Vec<_>>();
        for (index, axis) in [x, y, z].into_iter().enumerate() {
            all[axis].1 = counts.iter().map(|sample| f64::from(sample[index]) * UT_PER_COUNT).collect();
        }
        for (index, (_, values)) in all.iter_mut().enumerate() {
            if index == time {
                // The board's clock has milliseconds.
                values.iter_mut().for_each(|t_s| *t_s = (*t_s * 1e3).round() * 1e-3);
            } else if ![x, y, z].contains(&index) {
                values.iter_mut().for_each(|value| *value = f64::from(*value as f32));
            }
        }
        // A reference heading is never fitted, and a board has none.
        all.retain(|(name, _)| name != "heading_deg");
        Some(Self { counts, columns: all })
    }

    /// Of a simulated log, without the columns that this takes away.
    pub fn of_log(log: &Log, without: &[&str]) -> Option<Self> {
        Self::of(log.named().filter(|(name, _)| !without.contains(name)))
    }

    /// As the host sees it.
    ///
    /// # Panics
    /// Never: it has a magnetometer.
    pub fn table(&self) -> Table<'_> {
        let columns = self.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        let mut table = Table::from_columns(columns).expect("it has a magnetometer");
        table.counts = Some((&self.counts, [UT_PER_COUNT; 3]));
        table
    }

    fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(own, _)| own == name).map(|(_, values)| values.as_slice())
    }

    fn triple(&self, names: [&str; 3]) -> Option<[&[f64]; 3]> {
        let [x, y, z] = names.map(|name| self.column(name));
        Some([x?, y?, z?])
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.counts.len()
    }
}

/// The board's core in the hands of a recording.
pub struct Board {
    device: Device,
    now_ms: u64,
    /// Two slots.
    memory: [Vec<u8>; 2],
    out: String,
}

struct Everything<'a>(&'a mut String);

impl std::fmt::Write for Everything<'_> {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.push_str(text);
        Ok(())
    }
}

impl ironout::device::Output for Everything<'_> {
    fn takes(&self, _: usize) -> bool {
        true
    }
}

impl Board {
    /// One that has nothing stored.
    pub fn new(rate_hz: f32) -> Self {
        Self::with_sensor(Sensor::uniform("a recording", UT_PER_COUNT as f32, rate_hz))
    }

    /// One with this sensor, and nothing stored.
    pub fn with_sensor(sensor: Sensor) -> Self {
        let device = Device::new(DeviceConfig { board: "replay", sensor, pace: Pace::Pushed });
        let mut board =
            Self { device, now_ms: 0, memory: [vec![0xff; 1024], vec![0xff; 1024]], out: String::new() };
        board.settle();
        board
    }

    /// Polls until nothing is left to do; the clock of the board stands meanwhile but for pauses of its memory.
    fn settle(&mut self) {
        loop {
            match self.device.poll(self.now_ms, &mut Everything(&mut self.out)) {
                Action::Sensor(_) => self.device.complete_sensor(SensorAnswer::Started, self.now_ms),
                Action::Store(task) => {
                    let answer = self.store(&task);
                    self.device.complete_store(&answer, self.now_ms);
                }
                Action::Again => {}
                Action::Sleep if self.device.is_idle() => return,
                Action::Sleep => self.now_ms = self.device.next_deadline_ms().max(self.now_ms + 1),
            }
        }
    }

    fn store(&mut self, task: &StoreTask) -> StoreAnswer {
        let of = |slot: ironout::store::Slot| usize::from(slot == ironout::store::Slot::B);
        match task {
            StoreTask::Read { slot, at, length } => {
                let bytes = &self.memory[of(*slot)][*at..at + length];
                StoreAnswer::Read(bytes.iter().copied().collect())
            }
            StoreTask::Write { slot, at, bytes } => {
                self.memory[of(*slot)][*at..at + bytes.len()].copy_from_slice(bytes);
                StoreAnswer::Written
            }
        }
    }

    /// The lines of the answer to a command.
    pub fn command(&mut self, line: &str) -> Vec<String> {
        self.out.clear();
        for byte in line.bytes().chain(*b"\n") {
            while !self.device.take_byte(byte) {
                self.settle();
            }
        }
        self.settle();
        self.out.lines().map(str::to_owned).collect()
    }

    /// The last line of the answer.
    pub fn last(&mut self, line: &str) -> String {
        self.command(line).pop().unwrap_or_default()
    }

    /// Feeds some rows at the times that they were recorded, from the board's present on. Columns that are not among the ten of the
    /// log format's own are fed by their names where they are among `tested`.
    pub fn feed(&mut self, recording: &Recording, rows: std::ops::Range<usize>, tested: &[&str]) {
        let accel = recording.triple(["ax_mps2", "ay_mps2", "az_mps2"]);
        let turn = recording.triple(["gx_radps", "gy_radps", "gz_radps"]);
        let fed: Vec<(&str, &[f64])> =
            tested.iter().filter_map(|name| Some((*name, recording.column(name)?))).collect();
        let time = recording.column("t_s").unwrap_or(&[]);
        let begin_ms = self.now_ms + 10;
        let of = |columns: Option<[&[f64]; 3]>, row: usize| columns.map(|c| c.map(|v| v[row] as f32));
        for row in rows.clone() {
            let since_s = time[row] - time[rows.start];
            self.now_ms = self.now_ms.max(begin_ms + (since_s * 1e3).round() as u64);
            for (name, values) in &fed {
                self.device.on_column(name, values[row] as f32, self.now_ms);
            }
            self.device.on_motion(of(accel, row), of(turn, row));
            let reading = Reading { counts: recording.counts[row], overflow: [false; 3] };
            self.device.on_sample(&reading, self.now_ms);
            self.settle();
        }
    }

    /// A column's value, from now on.
    pub fn fed(&mut self, name: &str, value: f32) {
        self.device.on_column(name, value, self.now_ms);
    }

    /// A sample of the board's clock.
    pub fn sampled(&mut self, t_ms: u64, counts: [i16; 3]) {
        self.now_ms = self.now_ms.max(t_ms);
        self.device.on_sample(&Reading { counts, overflow: [false; 3] }, t_ms);
        self.settle();
    }

    /// What `why` says.
    pub fn why(&mut self) -> Said {
        Said { lines: self.command("why") }
    }

    /// The stored record of the calibration in use.
    pub fn record(&self) -> Option<&ironout::record::Record> {
        self.device.record()
    }

    /// The board's own study.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The board's clock when the first row of a recording fed now would come, ms.
    pub fn next_row_ms(&self) -> u64 {
        self.now_ms + 10
    }
}
