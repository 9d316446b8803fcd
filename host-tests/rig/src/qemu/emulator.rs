//! QEMU as a board on the bench: power, field, console.

use super::console::Console;
use super::debugger::Debugger;
use super::error::Error;
use super::firmware::Firmware;
use super::limits::MAX_FIELD_UT;
use super::program::PROGRAM;
use super::qmp::Qmp;
use serde_json::json;
use std::fs::File;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Bytes of the EEPROM.
const EEPROM_BYTES: usize = 4096;

/// How long QEMU may take to open its sockets; it usually takes some 20 ms, on a busy machine anything.
const START_LIMIT: Duration = Duration::from_secs(300);

/// How long a sample may take before the board counts as dead; it usually takes 20 ms, on a busy machine anything.
pub const SAMPLE_LIMIT: Duration = Duration::from_secs(300);

/// The names of the files in the board's own directory.
const UART: &str = "UART";
const QMP: &str = "QMP";
const GDB: &str = "GDB";
const EEPROM: &str = "eeprom.bin";
const LOG: &str = "defmt.bin";
const MEMORY: &str = "memory.bin";
const STDERR: &str = "qemu.err";

/// How the board is put together.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Whether the sensor is on the bus.
    pub sensor: bool,
    /// Whether the EEPROM is on the bus.
    pub eeprom: bool,
    /// Whether a debugger can be attached ([`Emulator::debugger`]).
    pub debugger: bool,
    /// Whether time goes by the instructions executed, 32 ns each: slower, and the same on every host. (An M4 at 25 MHz takes
    /// some 50 ns; counts are what this is for.)
    pub counted: bool,
    /// Where time is counted: whether a board that sleeps is waited for. Without, an hour of a board that mostly sleeps goes by in a
    /// minute or less.
    pub waited_for: bool,
    /// What the sensor's thermometer says at power on, °C.
    pub temperature_c: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            sensor: true,
            eeprom: true,
            debugger: false,
            counted: false,
            waited_for: true,
            temperature_c: 0.0,
        }
    }
}

/// What outlives a power cut: the board's directory with the EEPROM in it, and the firmware.
struct Bench {
    dir: TempDir,
    firmware: Firmware,
    options: Options,
}

impl Bench {
    fn file(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn read(&self, name: &str) -> Result<Vec<u8>, Error> {
        std::fs::read(self.file(name)).map_err(Error::io(format!("read the board's {name}")))
    }
}

/// A board without power.
pub struct PoweredOff {
    bench: Bench,
}

impl PoweredOff {
    /// A new board, its EEPROM erased.
    pub fn new(firmware: &Firmware, options: &Options) -> Result<Self, Error> {
        let dir = tempfile::Builder::new()
            .prefix("ironout-")
            .tempdir()
            .map_err(Error::io("make a temporary directory"))?;
        let off = Self { bench: Bench { dir, firmware: firmware.clone(), options: *options } };
        off.set_eeprom(&[0xFF; EEPROM_BYTES])?;
        Ok(off)
    }

    /// What the EEPROM holds.
    pub fn eeprom(&self) -> Result<Vec<u8>, Error> {
        self.bench.read(EEPROM)
    }

    /// Replaces what the EEPROM holds, as a torn write or decay would.
    pub fn set_eeprom(&self, image: &[u8]) -> Result<(), Error> {
        std::fs::write(self.bench.file(EEPROM), image).map_err(Error::io("write the EEPROM's image"))
    }

    /// Puts the sensor on the bus, or takes it off.
    pub fn with_sensor(mut self, sensor: bool) -> Self {
        self.bench.options.sensor = sensor;
        self
    }

    /// Puts the power on and lets the firmware run.
    pub fn start(self) -> Result<Emulator, Error> {
        let bench = self.bench;
        for socket in [UART, QMP, GDB] {
            match std::fs::remove_file(bench.file(socket)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(Error::io("remove an old socket")(error));
                }
                _ => {}
            }
        }
        let create = |name| File::create(bench.file(name)).map_err(Error::io(format!("create {name}")));
        // QEMU runs in the board's directory, and everything is named relative to it: a comma or a blank in the
        // directory's name would end an option.
        let mut command = Command::new(PROGRAM);
        command
            .current_dir(bench.dir.path())
            .stdin(Stdio::null())
            .stdout(create(LOG)?)
            .stderr(create(STDERR)?);
        command.args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        command.args(["-chardev", &format!("socket,id=u0,path={UART},server=on,wait=off")]);
        command.args(["-serial", "chardev:u0", "-qmp", &format!("unix:{QMP},server=on,wait=off")]);
        command.arg("-kernel").arg(bench.firmware.path()).arg("-S");
        if bench.options.counted {
            let sleep = if bench.options.waited_for { "on" } else { "off" };
            command.args(["-icount", &format!("shift=5,sleep={sleep}")]);
        }
        if bench.options.sensor {
            command.args(["-device", "lsm303dlhc_mag,id=mag,address=0x1e"]);
        }
        command.args(["-device", "tmp105,id=tmp,address=0x48"]);
        if bench.options.eeprom {
            command.args(["-drive", &format!("if=none,id=eed,format=raw,file={EEPROM}")]);
            command.args([
                "-device",
                &format!("at24c-eeprom,id=ee,address=0x50,rom-size={EEPROM_BYTES},drive=eed"),
            ]);
        }
        if bench.options.debugger {
            command.args(["-gdb", &format!("unix:{GDB},server=on,wait=off")]);
        }
        let child = command.spawn().map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => Error::NotInstalled,
            _ => Error::io("start qemu-system-arm")(error),
        })?;
        let mut process = Process { child };
        // The console is connected before the first instruction runs, so that nothing of it is lost.
        let console = process.connect(&bench, UART, "its console was being connected")?;
        let qmp = process.connect(&bench, QMP, "its machine protocol was being connected")?;
        let mut emulator = Emulator {
            console: Console::new(console),
            qmp: Qmp::new(qmp)?,
            last_values: None,
            process,
            bench,
        };
        if emulator.bench.options.sensor {
            emulator.set_temperature_c(emulator.bench.options.temperature_c)?;
        }
        emulator.resume()?;
        Ok(emulator)
    }
}

/// The child process; it ends with this value.
struct Process {
    child: Child,
}

impl Process {
    /// Connects to one of QEMU's sockets, which appear a moment after its start.
    fn connect(&mut self, bench: &Bench, socket: &str, during: &'static str) -> Result<UnixStream, Error> {
        let path = bench.file(socket);
        let started = Instant::now();
        loop {
            match UnixStream::connect(&path) {
                Ok(stream) => return Ok(stream),
                Err(error) if started.elapsed() > START_LIMIT => {
                    return Err(Error::io(format!("connect to QEMU's {socket} socket"))(error));
                }
                Err(_) => {}
            }
            if let Ok(Some(status)) = self.child.try_wait() {
                let said = String::from_utf8_lossy(&bench.read(STDERR)?).trim().to_owned();
                return Err(Error::Exited { status: status.to_string(), during, said });
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Ends QEMU as a power cut does: at once, at whatever it is doing.
    fn kill(&mut self) -> std::io::Result<()> {
        self.child.kill()?;
        self.child.wait().map(drop)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing left to do.
        let _ = self.kill();
    }
}

/// A board with power on.
pub struct Emulator {
    /// The board's console.
    pub console: Console,
    qmp: Qmp,
    /// What the last line that [`Emulator::expose`] returned says.
    last_values: Option<String>,
    // Declared before the bench: the process has to end before its directory goes.
    process: Process,
    bench: Bench,
}

impl Emulator {
    /// A new board, its EEPROM erased, with power on.
    pub fn start(firmware: &Firmware, options: &Options) -> Result<Self, Error> {
        PoweredOff::new(firmware, options)?.start()
    }

    /// Waits until the board takes samples. Before, its firmware may not have set the sensor's range yet, and the emulated sensor turns a
    /// field into counts when it is set, by the range that it has then: a later reading would be too large or too small by the ratio of
    /// the two ranges until the field is set again.
    ///
    /// # Errors
    /// [`Error::Timeout`] where no sample comes.
    pub fn wait_for_samples(&mut self) -> Result<(), Error> {
        self.console.command("stream raw")?;
        self.console.next_streamed(SAMPLE_LIMIT)?;
        self.console.command("stream off")?;
        self.console.drain(Duration::from_millis(1)).map(drop)
    }

    /// Sets the field at the sensor, chip axes, in µT. The machine stands still meanwhile, so that no sample sees one axis of
    /// the old field and two of the new one.
    ///
    /// # Errors
    /// [`Error::Field`] for an axis outside 0 to [`MAX_FIELD_UT`], which the emulated sensor refuses.
    pub fn set_field_ut(&mut self, field_ut: [f64; 3]) -> Result<(), Error> {
        self.pause()?;
        self.put_field_ut(field_ut)?;
        self.resume()
    }

    /// Sets the field of a machine that stands still ([`Emulator::pause`]), for whoever changes more than the field before it goes on.
    ///
    /// # Errors
    /// As [`Emulator::set_field_ut`].
    pub fn put_field_ut(&mut self, field_ut: [f64; 3]) -> Result<(), Error> {
        check(field_ut)?;
        self.write_field(field_ut)
    }

    fn write_field(&mut self, field_ut: [f64; 3]) -> Result<(), Error> {
        for (property, axis_ut) in ["mag-x", "mag-y", "mag-z"].into_iter().zip(field_ut) {
            self.qmp.set("/machine/peripheral/mag", property, (axis_ut * 1_000.0).round() as i64)?;
        }
        Ok(())
    }

    /// Sets the field and waits until the board has sampled it, which takes a stream to be on. Returns the stream's lines
    /// since the last call, the last of them of the new field.
    pub fn expose(&mut self, field_ut: [f64; 3]) -> Result<Vec<String>, Error> {
        check(field_ut)?;
        self.pause()?;
        let mut lines = self.console.drain(Duration::from_millis(1))?;
        self.write_field(field_ut)?;
        self.resume()?;
        // Of the next line it is not known whether its sample was taken before the pause. There is no noise, so a line that
        // says something new is of the new field; after any other the second one is.
        let before = lines.last().map(|line| values(line)).or(self.last_values.take());
        let mut line = self.console.next_streamed(SAMPLE_LIMIT)?;
        let mark = |text: &str| text.split(',').next().map(str::to_owned);
        let is_new = before.is_some_and(|old| mark(&old) == mark(&line) && old != values(&line));
        if !is_new {
            lines.push(line);
            line = self.console.next_streamed(SAMPLE_LIMIT)?;
        }
        self.last_values = Some(values(&line));
        lines.push(line);
        Ok(lines)
    }

    /// Sets the sensor's temperature.
    pub fn set_temperature_c(&mut self, temperature_c: f64) -> Result<(), Error> {
        self.qmp.set("/machine/peripheral/mag", "temperature", (temperature_c * 1_000.0).round() as i64)
    }

    /// Stops the machine's time.
    pub fn pause(&mut self) -> Result<(), Error> {
        self.qmp.execute("stop", json!({})).map(drop)
    }

    /// Lets the machine's time go on.
    pub fn resume(&mut self) -> Result<(), Error> {
        self.qmp.execute("cont", json!({})).map(drop)
    }

    /// Resets the machine, as its reset button does: memory keeps what it holds.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.qmp.execute("system_reset", json!({})).map(drop)
    }

    /// Attaches a debugger; the machine stops until it is dropped or lets it go.
    ///
    /// # Errors
    /// Without [`Options::debugger`].
    pub fn debugger(&mut self) -> Result<Debugger, Error> {
        let socket = self.process.connect(&self.bench, GDB, "its debugger was being connected")?;
        Debugger::new(socket)
    }

    /// What the firmware has logged so far: defmt's frames, to be decoded with the texts in the ELF.
    pub fn log(&self) -> Result<Vec<u8>, Error> {
        self.bench.read(LOG)
    }

    /// Copies `length` bytes of the board's memory from `address` on.
    pub fn memory(&mut self, address: u64, length: u64) -> Result<Vec<u8>, Error> {
        let arguments = json!({ "val": address, "size": length, "filename": MEMORY });
        self.qmp.execute("pmemsave", arguments)?;
        self.bench.read(MEMORY)
    }

    /// The most stack used since power-up, in bytes: the emulator's memory starts as zeros, so the lowest word that is not
    /// zero any more is where the stack has been.
    pub fn stack_used(&mut self) -> Result<u64, Error> {
        let bottom = self.bench.firmware.symbol("_stack_end")?;
        let length = self.bench.firmware.symbol("_stack_start")?.saturating_sub(bottom);
        let stack = self.memory(bottom, length)?;
        let untouched = stack.iter().take_while(|&&byte| byte == 0).count();
        Ok(length - untouched as u64)
    }

    /// The directory with everything of this board: sockets, EEPROM image, logs.
    pub fn directory(&self) -> &Path {
        self.bench.dir.path()
    }

    /// Cuts the power (`kill -9`).
    pub fn power_cut(mut self) -> Result<PoweredOff, Error> {
        self.process.kill().map_err(Error::io("kill QEMU"))?;
        Ok(PoweredOff { bench: self.bench })
    }
}

/// Whether the emulated sensor takes this field.
fn check(field_ut: [f64; 3]) -> Result<(), Error> {
    if field_ut.iter().all(|axis| (0.0..=MAX_FIELD_UT).contains(axis)) {
        Ok(())
    } else {
        Err(Error::Field { given: field_ut })
    }
}

/// A line of a stream without its time: what it says.
fn values(line: &str) -> String {
    let mut words = line.splitn(3, ',');
    let (mark, _time, rest) = (words.next(), words.next(), words.next());
    format!("{},{}", mark.unwrap_or_default(), rest.unwrap_or_default())
}
