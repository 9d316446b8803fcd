//! Replies that cannot be malformed: whatever a command does, it ends in exactly one `ok` or `err` line.

use core::fmt;

/// The reasons an `err` line may give.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Code {
    /// No such command.
    Unknown,
    /// The command is not written like that.
    Usage,
    /// The line was longer than 80 characters.
    Long,
    /// Not now; ask again.
    Busy,
    /// Not in this state.
    State,
    /// The data do not support a calibration.
    Refused,
    /// The sensor does not work.
    Sensor,
    /// The memory for the calibration does not work.
    Store,
}

impl Code {
    /// The word in the line.
    pub const fn word(self) -> &'static str {
        match self {
            Code::Unknown => "unknown",
            Code::Usage => "usage",
            Code::Long => "long",
            Code::Busy => "busy",
            Code::State => "state",
            Code::Refused => "refused",
            Code::Sensor => "sensor",
            Code::Store => "store",
        }
    }
}

/// Proof that a command was answered: only [`Reply::ok`] and [`Reply::err`] make one.
#[must_use]
#[derive(Debug)]
pub struct Answered(fmt::Result);

impl Answered {
    /// Whether the whole answer could be written.
    ///
    /// # Errors
    /// That of the output.
    pub const fn result(self) -> fmt::Result {
        self.0
    }
}

/// The answer to one line, while it is written. Consumed by its last line.
#[derive(Debug)]
pub struct Reply<'a, W> {
    out: &'a mut W,
    result: fmt::Result,
}

impl<'a, W: fmt::Write> Reply<'a, W> {
    /// An answer into `out`.
    pub const fn new(out: &'a mut W) -> Self {
        Self { out, result: Ok(()) }
    }

    /// Begins anew, before anything was written: for an answer that another function writes whole.
    pub(crate) fn into_out(self) -> &'a mut W {
        self.out
    }

    /// One line of the answer before its last: `+ text`.
    pub fn line(&mut self, text: fmt::Arguments<'_>) {
        self.put("+ ", text);
    }

    /// The last line of a command that was done: `ok text`.
    pub fn ok(mut self, text: fmt::Arguments<'_>) -> Answered {
        self.put("ok ", text);
        Answered(self.result)
    }

    /// The last line of a command without anything to tell: `ok`.
    pub fn done(mut self) -> Answered {
        self.put("ok", format_args!(""));
        Answered(self.result)
    }

    /// The last line of a command that was not done: `err CODE text`.
    pub fn err(mut self, code: Code, text: fmt::Arguments<'_>) -> Answered {
        self.put("err ", format_args!("{} {text}", code.word()));
        Answered(self.result)
    }

    fn put(&mut self, start: &str, text: fmt::Arguments<'_>) {
        if self.result.is_ok() {
            let mut line = OneLine(&mut *self.out);
            self.result =
                fmt::write(&mut line, format_args!("{start}{text}")).and_then(|()| self.out.write_char('\n'));
        }
    }
}

/// Keeps a text within one line of printable ASCII, so that no message can break the framing.
struct OneLine<'a, W>(&'a mut W);

impl<W: fmt::Write> fmt::Write for OneLine<'_, W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for part in text.split_inclusive(|c: char| !matches!(c, ' '..='~')) {
            let kept = part.trim_end_matches(|c: char| !matches!(c, ' '..='~'));
            self.0.write_str(kept)?;
            let Some(last) = part.get(kept.len()..).and_then(|rest| rest.chars().next()) else { continue };
            self.0.write_str(match last {
                '\u{b5}' => "u",
                '\u{b0}' => " deg",
                '\u{2212}' => "-",
                '\u{d7}' => "x",
                '\u{3c3}' => "sigma",
                _ => " ",
            })?;
        }
        Ok(())
    }
}

/// A value that may be unknown: `-` then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opt<T>(pub Option<T>);

impl<T: fmt::Display> fmt::Display for Opt<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(value) => value.fmt(f),
            None => f.write_str("-"),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Code, Opt, Reply};
    use std::string::String;

    #[test]
    fn an_answer_is_lines_and_then_one_last_line() {
        let mut out = String::new();
        let mut reply = Reply::new(&mut out);
        reply.line(format_args!("offset_ut={},{}", 1.5, -2));
        reply.ok(format_args!("n={}", Opt::<u32>(None))).result().unwrap();
        Reply::new(&mut out).done().result().unwrap();
        Reply::new(&mut out).err(Code::State, format_args!("not now")).result().unwrap();
        assert_eq!(out, "+ offset_ut=1.5,-2\nok n=-\nok\nerr state not now\n");
    }

    #[test]
    fn no_text_can_break_the_framing() {
        let mut out = String::new();
        Reply::new(&mut out).err(Code::Refused, format_args!("0.3 µT\nok at 5°\tÄ")).result().unwrap();
        assert_eq!(out, "err refused 0.3 uT ok at 5 deg  \n");
    }
}
