//! The command line: parses, calls the library, prints.

mod args;
mod bar;
mod batch;
mod check;
mod config;
mod extract;
mod gate;
mod info;
mod input;
mod job;
mod level;
mod man;
mod options;
mod output;
mod pattern;
mod phantom;
mod report;
mod signals;
mod steps;
mod study;
mod term;
mod trouble;
mod usage;
mod value;
mod wrong;

use std::process::ExitCode;

use clap::CommandFactory;

use args::{Cli, Command};
use term::Term;

use crate::cancel::Cancel;
use crate::error::{Kind, readable};

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    let cli = match config::parse(std::env::args_os().collect()) {
        Ok(cli) => cli,
        Err((error, is_json)) => {
            Term::error(&error);
            if is_json {
                let input = error.path().map_or_else(String::new, readable);
                Term::json(&report::failed("mcubes/1", &input, &error.into())).ok();
            }
            return ExitCode::from(2);
        }
    };
    let term = Term::new(&cli.common);
    let cancel = match cli.command {
        None | Some(Command::Info(_) | Command::Check(_) | Command::Phantom(_)) => {
            signals::cancel_on_signals()
        }
        Some(Command::Completions { .. } | Command::Man) => {
            signals::end_on_signals();
            Cancel::new()
        }
    };
    let result = match cli.command {
        Some(Command::Info(args)) => info::run(&args, term, &cancel),
        Some(Command::Check(args)) => Ok(check::run(&args, &cancel)),
        Some(Command::Phantom(args)) => phantom::run(&args, term, &cancel),
        Some(Command::Completions { shell }) => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "mcubes", &mut script);
            Ok(Term::text(&String::from_utf8_lossy(&script)))
        }
        Some(Command::Man) => Ok(Term::text(&man::page())),
        None => options::run(&cli.extract).and_then(|run| batch::run(&run, term, &cancel)),
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
