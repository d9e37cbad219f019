//! The command line: parses, calls the library, prints.

mod args;
mod bar;
mod check;
mod extract;
mod info;
mod input;
mod options;
mod phantom;
mod report;
mod signals;
mod steps;
mod term;
mod value;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use term::Term;

use crate::error::Kind;

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let term = Term::new(&cli.common);
    let cancel = signals::cancel_on_signals();
    let result = match cli.command {
        Some(Command::Info(args)) => info::run(&args, &cancel),
        Some(Command::Check(args)) => Ok(check::run(&args)),
        Some(Command::Phantom(args)) => phantom::run(&args, term, &cancel),
        None => options::extract(&cli.extract).map(|options| extract::run(&options, term, &cancel)),
    };
    match result {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(Kind::Interrupted)) => ExitCode::from(130),
        Ok(Err(_)) => ExitCode::from(1),
        Err(usage) => {
            Term::usage(&usage);
            ExitCode::from(2)
        }
    }
}
