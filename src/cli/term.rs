//! What is said: errors, notes and summaries to standard error, what was asked for to standard
//! output.

use std::io::{IsTerminal, Write};

use anstyle::{AnsiColor, Style};

use super::args::{CommonArgs, When};
use super::signals::while_taken;
use super::trouble::Trouble;
use super::usage::Usage;
use crate::error::{Error, Kind};
use crate::sink::SinkError;

/// How much is said, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    quiet: bool,
    verbose: bool,
}

impl Term {
    pub(crate) fn new(args: &CommonArgs) -> Self {
        match args.color {
            Some(When::Always) => anstream::ColorChoice::Always.write_global(),
            Some(When::Never) => anstream::ColorChoice::Never.write_global(),
            Some(When::Auto) | None => {}
        }
        Self { quiet: args.quiet, verbose: args.verbose }
    }

    /// Whether a bar may be drawn.
    pub(crate) fn is_live(self) -> bool {
        !self.quiet && std::io::stderr().is_terminal()
    }

    pub(crate) fn error(error: &Error) {
        Self::trouble(&error.into());
    }

    pub(crate) fn trouble(trouble: &Trouble) {
        Self::say("error", AnsiColor::Red, &trouble.message);
        if let Some(hint) = &trouble.hint {
            Self::say("hint", AnsiColor::Cyan, hint);
        }
    }

    pub(crate) fn usage(usage: &Usage) {
        Self::say("error", AnsiColor::Red, &usage.message);
        if let Some(hint) = &usage.hint {
            Self::say("hint", AnsiColor::Cyan, hint);
        }
    }

    pub(crate) fn note(self, line: &str) {
        if !self.quiet {
            Self::say("note", AnsiColor::Yellow, line);
        }
    }

    pub(crate) fn summary(self, line: &str) {
        if !self.quiet {
            Self::aside(format_args!("{line}\n"));
        }
    }

    pub(crate) fn details(self, lines: &str) {
        if self.verbose {
            Self::aside(format_args!("{lines}"));
        }
    }

    /// One object, one line, flushed.
    pub(crate) fn json(object: &serde_json::Value) -> Result<(), Kind> {
        let mut out = std::io::stdout().lock();
        Self::told(while_taken(|| writeln!(out, "{object}").and_then(|()| out.flush())))
    }

    /// Text that was asked for.
    pub(crate) fn text(text: &str) -> Result<(), Kind> {
        let mut out = anstream::stdout().lock();
        Self::told(while_taken(|| out.write_all(text.as_bytes()).and_then(|()| out.flush())))
    }

    /// A reader that has closed its pipe wants no more, which is no error.
    fn told(written: std::io::Result<()>) -> Result<(), Kind> {
        match written {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
                let error = Error::at("standard output", SinkError::Io(e));
                Self::error(&error);
                Err(error.kind())
            }
            _ => Ok(()),
        }
    }

    /// To standard error; where that fails there is nobody to tell.
    fn aside(text: std::fmt::Arguments<'_>) {
        let _ = while_taken(|| anstream::stderr().write_fmt(text));
    }

    fn say(word: &str, color: AnsiColor, line: &str) {
        let style = Style::new().bold().fg_color(Some(color.into()));
        Self::aside(format_args!("{style}{word}:{style:#} {}\n", one_line(line)));
    }
}

/// A line that stays one line: a name in it may hold anything.
pub(crate) fn one_line(line: &str) -> String {
    line.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}
