//! Options from a file: `--config FILE.toml`, every option by its long name. The command line wins.
//!
//! What the file says is put before what was typed and parsed as if it had been typed, so that an
//! option means the same in both places.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, CommandFactory, Parser};
use toml::{Table, Value};

use super::args::Cli;
use super::wrong;
use crate::error::{Error, Failure, Kind};
use crate::source::SourceError;

/// Options that a file cannot have.
const NOT_HERE: [&str; 3] = ["config", "help", "version"];

/// More bytes than any configuration has.
const MAX_BYTES: u64 = 1 << 20;

/// What is wrong with a configuration file.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ConfigError {
    #[error("line {line}: {what}")]
    Syntax { line: usize, what: String },
    #[error("no option is called {key:?}")]
    UnknownKey { key: String, nearest: Option<String> },
    #[error("{key}: expected {wanted}, found {found}")]
    Type { key: String, wanted: &'static str, found: &'static str },
    #[error("{0}")]
    Value(String),
    #[error(transparent)]
    Io(SourceError),
    #[error("has more than {MAX_BYTES} bytes, which is no list of options")]
    TooLong,
}

impl Failure for ConfigError {
    fn kind(&self) -> Kind {
        Kind::BadConfig
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::UnknownKey { nearest: Some(name), .. } => Some(format!("is {name} meant?")),
            Self::UnknownKey { .. } => {
                Some("keys are the long options of mcubes --help, without --".to_owned())
            }
            _ => None,
        }
    }
}

/// The command line, with what the file that it names adds to it. Ends the process as clap does
/// where what was typed is wrong by itself.
///
/// # Errors
/// A file that cannot be read or used; with whether failures are wanted as JSON.
pub(crate) fn parse(typed: Vec<OsString>) -> Result<Cli, (Error, bool)> {
    let matches = Cli::command().try_get_matches_from(&typed).unwrap_or_else(|e| wrong::end(&e));
    let path = match matches.subcommand_name() {
        None => matches.get_one::<PathBuf>("config").cloned(),
        Some(_) => None,
    };
    let Some(path) = path else {
        return Ok(Cli::try_parse_from(&typed).unwrap_or_else(|e| wrong::end(&e)));
    };
    let mut is_json = matches.get_flag("json");
    let mut parse = || {
        let table = table(&path)?;
        is_json |= table.get("json") == Some(&Value::Boolean(true));
        let added = added(&table, &matches)?;
        let (program, rest) = typed.split_at(1.min(typed.len()));
        Cli::try_parse_from([program, added.as_slice(), rest].concat())
            .map_err(|error| ConfigError::Value(wrong::line(&error)))
    };
    let parsed: Result<Cli, ConfigError> = parse();
    parsed.map_err(|error| (Error::at(path, error), is_json))
}

/// The file's options that were not typed, as if they had been.
fn added(table: &Table, typed: &ArgMatches) -> Result<Vec<OsString>, ConfigError> {
    let command = Cli::command();
    let mut words = Vec::new();
    for (key, value) in table {
        let arg = find(&command, key)?;
        let new = as_typed(arg, key, value)?;
        if !is_overruled(&command, arg, typed) {
            words.extend(new.into_iter().map(OsString::from));
        }
    }
    Ok(words)
}

/// What the file says, which may be a device that never ends.
fn table(path: &Path) -> Result<Table, ConfigError> {
    let mut text = String::new();
    let io = |e: std::io::Error| ConfigError::Io(e.into());
    let file = std::fs::File::open(path).map_err(io)?;
    file.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(io)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(ConfigError::TooLong);
    }
    text.parse().map_err(|e| syntax(&text, &e))
}

fn syntax(text: &str, error: &toml::de::Error) -> ConfigError {
    let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
    let what = error.message().lines().next().unwrap_or_default().to_owned();
    ConfigError::Syntax { line: before.matches('\n').count() + 1, what }
}

fn find<'c>(command: &'c Command, key: &str) -> Result<&'c Arg, ConfigError> {
    let known = || {
        let longs = command.get_arguments().filter_map(|arg| Some((arg, arg.get_long()?)));
        longs.filter(|(_, name)| !NOT_HERE.contains(name))
    };
    let found = known().find(|(_, name)| *name == key);
    found.map(|(arg, _)| arg).ok_or_else(|| {
        let near = known().map(|(_, name)| (distance(key, name), name)).min();
        let near = near.filter(|(n, name)| *n <= 1 + name.len() / 3);
        ConfigError::UnknownKey {
            key: key.to_owned(),
            nearest: near.map(|(_, name)| name.to_owned()),
        }
    })
}

/// Whether the option, or one that it cannot stand beside, was typed.
fn is_overruled(command: &Command, arg: &Arg, typed: &ArgMatches) -> bool {
    let was_typed =
        |arg: &Arg| typed.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
    let excludes = |a: &Arg, b: &Arg| {
        command.get_arg_conflicts_with(a).iter().any(|c| c.get_id() == b.get_id())
    };
    command
        .get_arguments()
        .filter(|other| was_typed(other))
        .any(|other| other.get_id() == arg.get_id() || excludes(arg, other) || excludes(other, arg))
}

/// One entry of the file in the words of the command line.
fn as_typed(arg: &Arg, key: &str, value: &Value) -> Result<Vec<String>, ConfigError> {
    let wrong = |wanted| ConfigError::Type { key: key.to_owned(), wanted, found: value.type_str() };
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        return match value {
            Value::Boolean(true) => Ok(vec![format!("--{key}")]),
            Value::Boolean(false) => Ok(Vec::new()),
            _ => Err(wrong("true or false")),
        };
    }
    let word = |value: &Value| match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(n) => Ok(n.to_string()),
        Value::Float(x) => Ok(x.to_string()),
        _ => Err(wrong("a text, a number or a list of them")),
    };
    let words = match value {
        Value::Array(all) => all.iter().map(word).collect::<Result<Vec<_>, _>>()?,
        one => vec![word(one)?],
    };
    let option = |word: String| format!("--{key}={word}");
    Ok(match arg.get_action() {
        ArgAction::Append => words.into_iter().map(option).collect(),
        _ => vec![option(words.join(","))],
    })
}

/// How many letters must be put in, left out or changed to make one word of the other
/// (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut left = i + 1;
        let mut above_left = i;
        for (y, above) in b.iter().zip(row.iter_mut().skip(1)) {
            let here = (above_left + usize::from(x != *y)).min(left + 1).min(*above + 1);
            above_left = std::mem::replace(above, here);
            left = here;
        }
    }
    if b.is_empty() { a.chars().count() } else { row.last().copied().unwrap_or(0) }
}

#[cfg(test)]
mod tests {
    use super::distance;

    #[test]
    fn letters_are_counted() {
        for (a, b, n) in [("", "", 0), ("abc", "", 3), ("", "ab", 2), ("iso", "iso", 0)] {
            assert_eq!(distance(a, b), n, "{a} {b}");
        }
        for (a, b, n) in [("tread", "threads", 2), ("kitten", "sitting", 3), ("formt", "format", 1)]
        {
            assert_eq!((distance(a, b), distance(b, a)), (n, n), "{a} {b}");
        }
    }
}
