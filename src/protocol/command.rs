//! What can be asked of the board.

use super::cov::{Assignments, assignments};
use super::load::{self, Load};
use crate::fit::Method;
use crate::number::read;

/// What is sent unasked, one line a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StreamMode {
    /// Nothing.
    #[default]
    Off,
    /// `R,t_ms,x,y,z` in counts.
    Raw,
    /// `C,t_ms,x_ut,y_ut,z_ut,norm_ut,residual_ut` with the calibration in use.
    Calibrated,
    /// `Raw:0,0,0,0,0,0,mx,my,mz` in 0.1 µT, as the program MotionCal reads it.
    MotionCal,
    /// `L,t_ms,seq,x,y,z,…` in counts with every column that is known, for a log; `H,…` names the columns.
    Log,
}

/// The most characters of an effect's id.
pub const MAX_ID: usize = 48;

/// An effect's id, as it was typed.
pub type EffectId = heapless::String<MAX_ID>;

/// A command, read.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "one at a time, executed immediately; there is no heap to box it on"
)]
pub enum Command {
    /// `help`
    Help,
    /// `version`
    Version,
    /// `status`
    Status,
    /// `cal start`; with `level` for a vehicle that only turns level.
    CalStart {
        /// Whether for level headings.
        level: bool,
    },
    /// `cal stop`
    CalStop,
    /// `cal accept`; with `force` also where it is clearly worse than the one in use.
    CalAccept {
        /// Whether it was insisted.
        force: bool,
    },
    /// `cal cancel`
    CalCancel,
    /// `cal show`
    CalShow,
    /// `cal clear`
    CalClear,
    /// `cal load …`: a calibration that comes in over the console.
    CalLoad(Load),
    /// `cal zero`: the offset anew, with the matrix in use; `cal zero start` forgets what was seen so far.
    CalZero {
        /// Whether it begins.
        begins: bool,
    },
    /// `cal dump`: the calibration's record, byte by byte.
    CalDump,
    /// `cal method adjusted|trace|constant`
    CalMethod(Method),
    /// `stream off|raw|cal|motioncal|log`
    Stream(StreamMode),
    /// `field UT`: the expected magnitude in µT.
    Field(f64),
    /// `cov NAME=VALUE …`: what columns that effects may follow are now.
    Cov(Assignments),
    /// `heading`, with the declination in degrees, east positive, where it is given.
    Heading(Option<f64>),
    /// `why`
    Why,
    /// `effect list`
    EffectList,
    /// `effect add ID`
    EffectAdd(EffectId),
    /// `effect remove ID`
    EffectRemove(EffectId),
}

/// Why a line is no command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParseError {
    /// Its first word is not known.
    Unknown,
    /// The command is known and not written like that; the text says how it is.
    Usage(&'static str),
}

/// The magnitudes that `field` takes, µT: the Earth's is 22 to 67, a coil's may be more.
const FIELD_UT: core::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// Reads one line. Words are separated by spaces; upper and lower case differ.
///
/// # Errors
/// [`ParseError`], with how to write the command.
pub fn parse(line: &str) -> Result<Command, ParseError> {
    let mut words = line.split(' ').filter(|word| !word.is_empty());
    let first = words.next().ok_or(ParseError::Usage("an empty command; try help"))?;
    if first == "cov" {
        return assignments(words).map(Command::Cov).map_err(ParseError::Usage);
    }
    let (second, third) = (words.next(), words.next());
    if (first, second) == ("cal", Some("load")) {
        return load::parse(third, words).map(Command::CalLoad).ok_or(ParseError::Usage(load::USAGE));
    }
    let too_many = words.next().is_some();
    let (command, usage) = match first {
        "help" => (plain(second, Command::Help), "help takes no argument"),
        "version" => (plain(second, Command::Version), "version takes no argument"),
        "status" => (plain(second, Command::Status), "status takes no argument"),
        "cal" => (
            cal(second, third),
            "cal start [level]|stop|accept [force]|cancel|show|clear|zero [start]|dump, cal load ..., or cal method adjusted|trace|constant",
        ),
        "stream" => (third.is_none().then(|| stream(second)).flatten(), "stream off|raw|cal|motioncal|log"),
        "field" => (
            third.is_none().then(|| field(second)).flatten(),
            "field UT, the expected magnitude, 1 to 1000 microtesla",
        ),
        "heading" => (
            third.is_none().then(|| heading(second)).flatten(),
            "heading, or heading DECLINATION_DEG, east positive, -180 to 180",
        ),
        "why" => (plain(second, Command::Why), "why takes no argument"),
        "effect" => (
            effect(second, third),
            "effect list, effect add ID or effect remove ID, as in effect add offset:temp_c",
        ),
        _ => return Err(ParseError::Unknown),
    };
    command.filter(|_| !too_many).ok_or(ParseError::Usage(usage))
}

fn plain(argument: Option<&str>, command: Command) -> Option<Command> {
    argument.is_none().then_some(command)
}

fn cal(verb: Option<&str>, argument: Option<&str>) -> Option<Command> {
    let command = match (verb?, argument) {
        ("start", None) => Command::CalStart { level: false },
        ("start", Some("level")) => Command::CalStart { level: true },
        ("stop", None) => Command::CalStop,
        ("accept", None) => Command::CalAccept { force: false },
        ("accept", Some("force")) => Command::CalAccept { force: true },
        ("cancel", None) => Command::CalCancel,
        ("show", None) => Command::CalShow,
        ("clear", None) => Command::CalClear,
        ("zero", None) => Command::CalZero { begins: false },
        ("zero", Some("start")) => Command::CalZero { begins: true },
        ("dump", None) => Command::CalDump,
        ("method", Some(word)) => Command::CalMethod(Method::parse(word)?),
        _ => return None,
    };
    Some(command)
}

fn stream(mode: Option<&str>) -> Option<Command> {
    let mode = match mode? {
        "off" => StreamMode::Off,
        "raw" => StreamMode::Raw,
        "cal" => StreamMode::Calibrated,
        "motioncal" => StreamMode::MotionCal,
        "log" => StreamMode::Log,
        _ => return None,
    };
    Some(Command::Stream(mode))
}

fn field(value: Option<&str>) -> Option<Command> {
    let ut = read(value?)?;
    FIELD_UT.contains(&ut).then_some(Command::Field(ut))
}

fn heading(declination: Option<&str>) -> Option<Command> {
    let Some(text) = declination else { return Some(Command::Heading(None)) };
    let degrees = read(text)?;
    (-180.0..=180.0).contains(&degrees).then_some(Command::Heading(Some(degrees)))
}

fn effect(verb: Option<&str>, id: Option<&str>) -> Option<Command> {
    match (verb?, id) {
        ("list", None) => Some(Command::EffectList),
        ("add", Some(id)) => EffectId::try_from(id).ok().map(Command::EffectAdd),
        ("remove", Some(id)) => EffectId::try_from(id).ok().map(Command::EffectRemove),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Command, ParseError, StreamMode, parse};
    use crate::effect::ColumnName;
    use crate::fit::Method;
    use crate::protocol::cov::{Assigned, Assignments};

    fn cov(list: &[(&str, Assigned)]) -> Command {
        let pairs = list.iter().map(|(name, value)| (ColumnName::new(name).unwrap(), *value));
        Command::Cov(pairs.collect::<Assignments>())
    }

    #[test]
    fn every_command_of_the_contract() {
        for (line, command) in [
            ("help", Command::Help),
            ("version", Command::Version),
            ("status", Command::Status),
            ("cal start", Command::CalStart { level: false }),
            ("cal start level", Command::CalStart { level: true }),
            ("cal stop", Command::CalStop),
            ("cal accept", Command::CalAccept { force: false }),
            ("cal accept force", Command::CalAccept { force: true }),
            ("cal cancel", Command::CalCancel),
            ("cal show", Command::CalShow),
            ("cal clear", Command::CalClear),
            ("cal zero", Command::CalZero { begins: false }),
            ("cal zero start", Command::CalZero { begins: true }),
            ("cal dump", Command::CalDump),
            ("cal method adjusted", Command::CalMethod(Method::Adjusted)),
            ("cal method trace", Command::CalMethod(Method::Trace)),
            ("cal method constant", Command::CalMethod(Method::Constant)),
            ("stream off", Command::Stream(StreamMode::Off)),
            ("stream raw", Command::Stream(StreamMode::Raw)),
            ("stream cal", Command::Stream(StreamMode::Calibrated)),
            ("stream motioncal", Command::Stream(StreamMode::MotionCal)),
            ("stream log", Command::Stream(StreamMode::Log)),
            ("field 48.5", Command::Field(48.5)),
            ("cov current_a=-3.2", cov(&[("current_a", Assigned::Value(-3.2))])),
            ("cov a=1 b=-", cov(&[("a", Assigned::Value(1.0)), ("b", Assigned::Forgotten)])),
            ("cov adc0_v=on", cov(&[("adc0_v", Assigned::Own)])),
            ("heading", Command::Heading(None)),
            ("heading -3.5", Command::Heading(Some(-3.5))),
            ("why", Command::Why),
            ("effect list", Command::EffectList),
            ("effect add offset:temp_c", Command::EffectAdd("offset:temp_c".try_into().unwrap())),
            ("effect remove step", Command::EffectRemove("step".try_into().unwrap())),
            ("  cal   start ", Command::CalStart { level: false }),
        ] {
            assert_eq!(parse(line), Ok(command), "{line}");
        }
    }

    #[test]
    fn a_known_command_written_wrongly_says_how_it_is_written() {
        for line in [
            "help me",
            "status now please thanks",
            "cal",
            "cal begin",
            "cal start now",
            "cal zero now",
            "cal start a b",
            "cal method",
            "cal method magic",
            "cal method trace x",
            "stream",
            "stream fast",
            "stream raw cal",
            "field",
            "field north",
            "field nan",
            "field inf",
            "field -48",
            "field 0",
            "field 1e9",
            "field 48 uT",
            "cov",
            "cov temp_c",
            "cov temp_c=warm",
            "cov temp_c=nan",
            "cov temp_c=1e39",
            "cov =3",
            "cov temp_c=1 2",
            "cov a=1 b=warm",
            "cov a=1 a=2",
            "cov a=1 b=2 c=3 d=4 e=5 f=6 g=7",
            "heading north",
            "heading 181",
            "heading nan",
            "heading 1 2",
            "why not",
            "effect",
            "effect add",
            "effect add a b",
            "effect list all",
            "effect add an_id_that_is_longer_than_any_effect_could_ever_be_called",
            "cov a_name_longer_than_any_column_may_be=1",
            "   ",
        ] {
            assert!(matches!(parse(line), Err(ParseError::Usage(_))), "{line}");
        }
    }

    #[test]
    fn other_words_are_unknown() {
        for line in ["hlep", "HELP", "Cal start", "calibrate", "calstart"] {
            assert_eq!(parse(line), Err(ParseError::Unknown), "{line}");
        }
    }
}
