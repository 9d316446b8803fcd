//! The program itself, run once: how long, how much processor, how much memory.

use std::io::{self, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What a run took.
#[derive(Debug, Clone)]
pub struct Cost {
    /// From start to end.
    pub wall: Duration,
    /// On all processors together; `None` where the system does not say.
    pub cpu: Option<Duration>,
    /// The most memory it ever held, bytes; `None` where the system does not say.
    pub peak: Option<u64>,
    /// Standard output.
    pub answer: String,
}

/// Runs `program` and watches it.
///
/// # Errors
/// It cannot be run, or ends with anything but 0.
pub fn run(program: &Path, arguments: &[&str]) -> io::Result<Cost> {
    let start = Instant::now();
    let mut child = Command::new(program).args(arguments).stdout(Stdio::piped()).spawn()?;
    let mut stdout = child.stdout.take().ok_or_else(|| io::Error::other("no standard output"))?;
    let answer = std::thread::spawn(move || {
        let mut answer = String::new();
        stdout.read_to_string(&mut answer).map(|_| answer)
    });
    let (mut cpu, mut peak) = (None, None);
    // The system keeps the peak while the process lives: the last look before the end has it.
    let status = loop {
        cpu = cpu_time(child.id()).or(cpu);
        peak = peak_memory(child.id()).or(peak);
        if let Some(status) = child.try_wait()? {
            break status;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let wall = start.elapsed();
    let answer = answer.join().map_err(|_| io::Error::other("its output was lost"))??;
    if !status.success() {
        return Err(io::Error::other(format!("{} {arguments:?} ended with {status}", program.display())));
    }
    Ok(Cost { wall, cpu, peak, answer })
}

/// `VmHWM` of Linux.
fn peak_memory(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// User and system time of Linux, in hundredths of a second.
fn cpu_time(process: u32) -> Option<Duration> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name in brackets may hold blanks; user and system time are the 12th and 13th field after it.
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(11);
    let ticks: u64 = fields.next()?.parse::<u64>().ok()? + fields.next()?.parse::<u64>().ok()?;
    Some(Duration::from_millis(ticks * 10))
}
