//! What is said: errors, notes and summaries to standard error, what was asked for to standard
//! output.

use std::io::{IsTerminal, Write};

use anstyle::{AnsiColor, Style};

use super::args::{CommonArgs, When};
use super::options::Usage;
use crate::error::Error;

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
        Self::say("error", AnsiColor::Red, &error.to_string());
        if let Some(hint) = error.hint() {
            Self::say("hint", AnsiColor::Cyan, &hint);
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
            let _ = writeln!(anstream::stderr(), "{line}");
        }
    }

    pub(crate) fn details(self, lines: &str) {
        if self.verbose {
            let _ = write!(anstream::stderr(), "{lines}");
        }
    }

    /// One object, one line, flushed.
    pub(crate) fn json(object: &serde_json::Value) {
        let mut out = std::io::stdout().lock();
        let _ = writeln!(out, "{object}").and_then(|()| out.flush());
    }

    /// Text that was asked for.
    pub(crate) fn text(text: &str) {
        let mut out = anstream::stdout().lock();
        let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    }

    fn say(word: &str, color: AnsiColor, line: &str) {
        let style = Style::new().bold().fg_color(Some(color.into()));
        // A name may hold anything; a line stays one line.
        let line: String = line.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        let _ = writeln!(anstream::stderr(), "{style}{word}:{style:#} {line}");
    }
}
