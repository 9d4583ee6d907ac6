//! The command line that is at work: its words, and its parser, by which errors and notes name options as they are typed.

use std::sync::RwLock;

use clap::FromArgMatches;

use super::parser_error::as_error;
use crate::error::{Error, Result};

/// The command line that is at work.
static AT_WORK: RwLock<Option<CommandLine>> = RwLock::new(None);

/// A command line.
pub struct CommandLine {
    /// Its words after the name of the program.
    pub words: Vec<String>,
    /// The parser of all commands.
    pub parser: clap::Command,
    /// The subcommand, where errors name options as they are typed.
    pub command: Option<String>,
}

/// Makes a command line the one that is at work.
pub fn begin(line: CommandLine) {
    if let Ok(mut now) = AT_WORK.write() {
        *now = Some(line);
    }
}

/// What a function says of the command line that is at work; `None` where there is none.
fn of_line<T>(say: impl FnOnce(&CommandLine) -> Option<T>) -> Option<T> {
    AT_WORK.read().ok()?.as_ref().and_then(say)
}

/// The words of the command line.
pub fn words() -> impl Iterator<Item = String> {
    of_line(|line| Some(line.words.clone())).unwrap_or_default().into_iter()
}

/// Whether a word is the name of an option of any command.
pub fn is_option(word: &str) -> bool {
    let has = |command: &clap::Command| command.get_arguments().any(|option| option.get_long() == Some(word));
    of_line(|line| Some(line.parser.get_subcommands().any(has))).unwrap_or_default()
}

/// The arguments of a subcommand by other words than those at work, the subcommand among them.
///
/// # Errors
///
/// An option that the command does not have, or a value that it does not take.
pub fn parsed<A: FromArgMatches>(words: &[String]) -> Result<A> {
    let parser = of_line(|line| Some(line.parser.clone())).unwrap_or_default();
    let matches = parser.try_get_matches_from(std::iter::once("willis").chain(words.iter().map(String::as_str)));
    let parsed = matches.and_then(|mut matches| A::from_arg_matches(&matches.remove_subcommand().unwrap_or_default().1));
    parsed.map_err(|error| as_error(&error))
}

/// What went wrong, with options as they are typed where the library names fields: `--max-gap` for `max_gap`.
pub fn with_flags(error: &Error) -> String {
    let Error::Parameter { name, value, accepted } = error else { return flags_in(&error.to_string()) };
    let (field, rest) = name.split_once(' ').map_or((name.as_str(), ""), |(field, rest)| (field, rest));
    let name = flag(field).map_or_else(|| name.clone(), |flag| format!("{flag} {rest}").trim_end().to_owned());
    flags_in(&Error::Parameter { name, value: value.clone(), accepted: accepted.clone() }.to_string())
}

/// A text of the library with what it has in backticks as its reader types it: "give `default_radius`" becomes "give --default-radius", and
/// `units=voxel` becomes --units voxel. Inside of another program they are arguments: default_radius= and units=voxel.
pub fn flags_in(text: &str) -> String {
    replaced(text, as_typed)
}

/// A text with what it has in backticks as `say` has it; what that does not know stays.
pub fn replaced(text: &str, say: impl Fn(&str) -> Option<String>) -> String {
    let mut parts = text.split('`');
    let mut out = parts.next().unwrap_or_default().to_owned();
    while let Some(quoted) = parts.next() {
        match (say(quoted), parts.next()) {
            (Some(said), Some(after)) => out.extend([&said, after]),
            (_, after) => out.extend(["`", quoted, after.map_or("", |_| "`"), after.unwrap_or_default()]),
        }
    }
    out
}

/// `FIELD` or `FIELD=VALUE` as its reader types it, where it is an option.
fn as_typed(quoted: &str) -> Option<String> {
    if of_line(|line| line.command.as_ref().map(drop)).is_none() {
        return of_line(|line| argument(&line.parser, quoted));
    }
    let (field, value) = field_of(quoted);
    flag(field).map(|flag| value.map_or_else(|| flag.clone(), |value| format!("{flag} {value}")))
}

/// A field and the value that a text gives it.
fn field_of(quoted: &str) -> (&str, Option<&str>) {
    quoted.split_once('=').map_or((quoted, None), |(field, value)| (field, Some(value)))
}

/// The options that are lists of several in a binding.
const LISTS: [(&str, &str); 3] = [("inlet", "inlets"), ("outlet", "outlets"), ("flow", "flows")];

/// `FIELD` or `FIELD=VALUE` as the argument of a binding, if any command has such an option.
pub fn argument(parser: &clap::Command, quoted: &str) -> Option<String> {
    let (field, value) = field_of(quoted);
    let flag = field.replace('_', "-");
    let mut arguments = parser.get_subcommands().flat_map(clap::Command::get_arguments).chain(parser.get_arguments());
    // Where a result goes is not named.
    let is_option = field != "output" && arguments.any(|arg| is_called(arg, &flag));
    let name = LISTS.iter().find(|(one, _)| *one == field).map_or(field, |(_, several)| *several);
    is_option.then(|| format!("{name}={}", value.unwrap_or_default()))
}

/// Whether an option is typed so, after its dashes.
fn is_called(arg: &clap::Arg, flag: &str) -> bool {
    arg.get_long() == Some(flag) || arg.get_short().is_some_and(|short| flag == short.to_string())
}

/// A field as the option of the subcommand at work.
fn flag(field: &str) -> Option<String> {
    let flag = field.replace('_', "-");
    let is_common = matches!(flag.as_str(), "threads" | "force");
    let has = |command: &clap::Command| is_common || command.get_arguments().any(|arg| is_called(arg, &flag));
    let is_one = of_line(|line| line.parser.find_subcommand(line.command.as_ref()?).map(has))?;
    let dashes = if flag.len() == 1 { "-" } else { "--" };
    is_one.then(|| format!("{dashes}{flag}"))
}
