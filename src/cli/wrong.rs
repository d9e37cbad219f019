//! What clap has to say of a command line, as mcubes says things: a line, and a hint.

use std::process::exit;

use clap::error::{ContextKind, ContextValue};

use super::term::Term;
use super::usage::Usage;

/// Ends the process: with help or the version if that is what was asked for, else as wrong use.
pub(super) fn end(error: &clap::Error) -> ! {
    if !error.use_stderr() {
        let told = Term::text(&error.render().ansi().to_string());
        exit(i32::from(told.is_err()));
    }
    Term::usage(&Usage { message: line(error), hint: Some(hint(error)) });
    exit(2)
}

/// What was wrong: clap's first paragraph, which may be a line with a list below it.
pub(super) fn line(error: &clap::Error) -> String {
    let text = error.to_string();
    let paragraph = text.lines().map(str::trim).take_while(|line| !line.is_empty());
    paragraph.collect::<Vec<_>>().join(" ").trim_start_matches("error: ").to_owned()
}

fn hint(error: &clap::Error) -> String {
    let likely =
        [ContextKind::SuggestedArg, ContextKind::SuggestedValue, ContextKind::SuggestedSubcommand];
    let likely = likely.into_iter().find_map(|kind| match error.get(kind) {
        Some(ContextValue::String(name)) => Some(name.as_str()),
        Some(ContextValue::Strings(names)) => names.first().map(String::as_str),
        _ => None,
    });
    match likely {
        Some(name) => format!("is {name} meant?"),
        None => "mcubes --help says more".to_owned(),
    }
}
