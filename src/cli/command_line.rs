//! The command line that is at work: its words, the line that repeats its run, what its parser refuses, and options as they are typed.

use std::{path::Path, path::PathBuf, sync::RwLock};

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::{Error, Result, internals::support::suggestions::did_you_mean};

/// Options that change no result: those that a value follows, and the others.
const VALUED: [&str; 6] = ["-o", "--output", "--threads", "--checkpoint", "--n-cpus", "--n_cpus"];
const IMMATERIAL: [&str; 7] = ["-q", "--quiet", "-v", "--verbose", "--force", "--json", "--record-failure"];
const NO_VALIDATOR: [&str; 2] = ["--skip-bids-validator", "--skip_bids_validator"];

/// Options of `willis bids` that choose the masks.
const CHOICES: [&str; 5] = ["--participant-label", "--participant_label", "--session-label", "--session_label", "--filter"];

/// This process's command line without the options that change no result, quoted for a shell, with `-o` and an output that is called
/// `again`, where that is not empty: it repeats the run as it stands.
pub fn command_line(again: &str) -> String {
    line_of_words(words_at_work(), again)
}

/// The words `all` of a command line for one `input` alone of those that were `given`, with `options` of its own, by name and value,
/// in the place of those of all.
pub fn row_words(
    mut all: impl Iterator<Item = String>,
    input: &Path,
    given: &[PathBuf],
    options: &[(String, String)],
) -> Vec<String> {
    let own: Vec<_> = options.iter().map(|(name, value)| (format!("--{}", name.replace('_', "-")), value.as_str())).collect();
    let (mut words, mut input) = (Vec::new(), Some(input.to_string_lossy().into_owned()));
    while let Some(word) = all.next() {
        if own.iter().any(|(name, _)| *name == word) {
            all.next();
        } else if given.iter().any(|path| path.to_string_lossy() == *word) {
            words.extend(input.take());
        } else if !own.iter().any(|(name, _)| is_joined(&word, name)) {
            words.push(word);
        }
    }
    words.extend(own.iter().map(|(name, value)| format!("{name}={value}")));
    words
}

/// The words of `willis infer` for one mask of those that `willis bids` was given; `places` are the words that say which dataset, where to
/// and which level.
pub fn infer_words(given: impl Iterator<Item = String>, input: &str, places: &[String]) -> Vec<String> {
    let (mut words, mut places) = (Vec::new(), places.to_vec());
    let (mut is_infer, mut is_chosen) = (false, false);
    for word in given {
        if word == "bids" && !is_infer {
            is_infer = true;
            words.extend(["infer".to_owned(), input.to_owned()]);
        } else if CHOICES.iter().any(|name| word == *name || is_joined(&word, name)) {
            is_chosen = !word.contains('=');
        } else if is_chosen && !word.starts_with('-') {
            // A value of the choice, which may have several.
        } else if let Some(at) = places.iter().position(|place| *place == word) {
            places.remove(at);
        } else {
            is_chosen = false;
            words.push(word);
        }
    }
    words
}

/// The command line of these words, of which those count that change a result.
pub fn line_of_words(mut rest: impl Iterator<Item = String>, again: &str) -> String {
    let mut words = vec!["willis".to_owned()];
    while let Some(word) = rest.next() {
        let has_value = VALUED.iter().any(|name| is_joined(&word, name));
        if VALUED.contains(&&*word) {
            rest.next();
        } else if !has_value && IMMATERIAL.iter().chain(&NO_VALIDATOR).all(|name| word != *name) {
            words.push(quoted(&word));
        }
    }
    if !again.is_empty() {
        words.extend(["-o".to_owned(), again.to_owned()]);
    }
    words.join(" ")
}

/// `--output=x` or `-ox`.
fn is_joined(word: &str, name: &str) -> bool {
    word.strip_prefix(name).is_some_and(|rest| rest.starts_with('=') || !name.starts_with("--"))
}

/// A word as a POSIX shell takes it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

/// The command line that is at work.
static AT_WORK: RwLock<Option<CommandLine>> = RwLock::new(None);

/// A command line.
struct CommandLine {
    /// Its words after the name of the program.
    words: Vec<String>,
    /// The parser of all commands.
    parser: clap::Command,
    /// The subcommand.
    command: Option<String>,
    /// Whether errors name options as they are typed.
    as_typed: bool,
}

impl CommandLine {
    /// The subcommand, where errors name options as they are typed.
    fn typed(&self) -> Option<&String> {
        self.command.as_ref().filter(|_| self.as_typed)
    }
}

/// Makes a command line, given by its words after the name of the program, the one that is at work; whether errors name its options as they
/// are typed.
pub fn begin(words: Vec<String>, parser: clap::Command, as_typed: bool) {
    let is_command = |word: &&String| *word != "help" && parser.get_subcommands().any(|own| own.get_name() == *word);
    let command = words.iter().find(is_command).cloned();
    if let Ok(mut now) = AT_WORK.write() {
        *now = Some(CommandLine { words, parser, command, as_typed });
    }
}

/// What a function says of the command line that is at work; `None` where there is none.
fn of_line<T>(say: impl FnOnce(&CommandLine) -> Option<T>) -> Option<T> {
    AT_WORK.read().ok()?.as_ref().and_then(say)
}

/// The words of the command line.
pub fn words_at_work() -> impl Iterator<Item = String> {
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
pub fn parsed<A: clap::FromArgMatches>(words: &[String]) -> Result<A> {
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
    if of_line(|line| line.typed().map(drop)).is_none() {
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
    let is_one = of_line(|line| line.parser.find_subcommand(line.typed()?).map(has))?;
    let dashes = if flag.len() == 1 { "-" } else { "--" };
    is_one.then(|| format!("{dashes}{flag}"))
}

/// The error of the library that refused a value, where it was one: it says itself what it is about.
pub fn of_library(error: &clap::Error) -> Option<Error> {
    match std::error::Error::source(error)?.downcast_ref()? {
        Error::Parameter { name, value, accepted } => {
            Some(Error::Parameter { name: name.clone(), value: value.clone(), accepted: accepted.clone() })
        }
        _ => None,
    }
}

/// What is wrong with words, as an error of the library.
pub fn as_error(error: &clap::Error) -> Error {
    if let Some(own) = of_library(error) {
        return own;
    }
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => Some(texts.join(", ")),
        _ => None,
    };
    let rendered = error.render().to_string();
    let first = rendered.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    let Some(name) = text(ContextKind::InvalidArg).map(|arg| field(&arg)) else {
        return Error::parameter("command", text(ContextKind::InvalidSubcommand).unwrap_or_default(), first);
    };
    let value = text(ContextKind::InvalidValue).unwrap_or_default();
    let accepted = match error.kind() {
        ErrorKind::ArgumentConflict => {
            let other = text(ContextKind::PriorArg).map_or_else(|| "another option".to_owned(), |arg| field(&arg));
            format!("does not go with {other}")
        }
        ErrorKind::UnknownArgument => "is no option of this command".to_owned(),
        _ => match (std::error::Error::source(error), text(ContextKind::ValidValue)) {
            (Some(source), _) => source.to_string(),
            (None, Some(valid)) if !valid.is_empty() => format!("expected one of {valid}"),
            _ => first,
        },
    };
    Error::parameter(name, format!("\"{value}\""), accepted)
}

/// The field that an option is: `max_gap` for `--max-gap <LENGTH>`.
fn field(arg: &str) -> String {
    let name = arg.split([' ', '=', '[', '<']).next().unwrap_or_default();
    name.trim_start_matches('-').replace('-', "_")
}

/// What the parser refuses of the command line that is at work, in one line that says what to type instead.
pub fn one_line(error: &clap::Error) -> String {
    if let Some(own) = of_library(error) {
        return with_flags(&own);
    }
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let mut said = String::new();
    for line in lines.filter(|line| !line.is_empty() && !line.starts_with("For more") && !line.starts_with("tip: to pass")) {
        let line = line.trim_start_matches("error: ");
        let tip = line.strip_prefix("tip: ").map(meant);
        said += if said.is_empty() { "" } else { tip.as_ref().map_or(" ", |_| "; ") };
        said += tip.as_deref().unwrap_or(line);
    }
    let parser = of_line(|line| Some(line.parser.clone())).unwrap_or_default();
    let names: Vec<&str> = parser.get_subcommands().map(clap::Command::get_name).collect();
    if let (ErrorKind::InvalidSubcommand, false) = (error.kind(), said.contains("did you mean"))
        && let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
    {
        if word == "train" {
            return format!("{said}; this willis was built without it: add `--features train` to the command that builds it");
        }
        said = format!("{said}; {}expected {}", did_you_mean(word, names.iter().copied()), names.join(", "));
    }
    let command = of_line(|line| line.command.as_ref().map(|name| format!(" {name}"))).unwrap_or_default();
    format!("{said}; see willis help{command}")
}

/// What a tip proposes, as a question.
fn meant(tip: &str) -> String {
    let similar = tip.strip_prefix("a similar ").and_then(|rest| rest.split_once(" exists: "));
    similar.map_or_else(|| tip.to_owned(), |(_, name)| format!("did you mean {name}?"))
}
