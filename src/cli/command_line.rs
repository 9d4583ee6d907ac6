//! The command line that is at work: its words, the line that repeats its run, what its parser refuses, and options as they are typed.

use std::{borrow::Cow, collections::HashSet, path::Path, path::PathBuf, sync::RwLock};

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::{Error, Result, internals::support::suggestions::did_you_mean};

/// Options that change no result.
const IMMATERIAL: [&str; 9] =
    ["output", "threads", "checkpoint", "quiet", "verbose", "force", "json", "record-failure", "skip-bids-validator"];

/// Options of `willis bids` that choose the masks.
const CHOICES: [&str; 3] = ["participant-label", "session-label", "filter"];

/// A part of a command line: an option with its values, or a word by itself, of which the first is the subcommand.
#[derive(Debug, Clone)]
pub struct LinePart {
    /// The long name of the option, however it was typed.
    option: Option<String>,
    words: Vec<String>,
}

impl LinePart {
    fn alone(word: &str) -> Self {
        Self { option: None, words: vec![word.to_owned()] }
    }

    /// An option with its value.
    pub fn option(name: &str, value: &str) -> Self {
        Self { option: Some(name.to_owned()), words: vec![format!("--{name}"), value.to_owned()] }
    }

    /// The path of an input, which may begin as an option does.
    fn input(path: &Path) -> Self {
        let path = path.to_string_lossy();
        Self::alone(&if path.starts_with('-') { format!("./{path}") } else { path.into_owned() })
    }

    fn is_one_of(&self, options: &[&str]) -> bool {
        self.option.as_ref().is_some_and(|option| options.contains(&&**option))
    }
}

/// The parts of a command line, given by its words after the name of the program.
pub fn parts(parser: &clap::Command, words: &[String]) -> Vec<LinePart> {
    let command = subcommand(parser, words).and_then(|name| parser.find_subcommand(name));
    let own = command.into_iter().flat_map(clap::Command::get_arguments);
    let known: Vec<&clap::Arg> = own.chain(parser.get_arguments()).collect();
    let (mut parts, mut rest) = (Vec::new(), words.iter().peekable());
    while let Some(word) = rest.next() {
        let options = options_in(word, &known);
        if options.is_empty() {
            parts.push(LinePart::alone(word));
        }
        for (arg, typed) in options {
            let name = arg.get_long().unwrap_or(arg.get_id().as_str());
            let mut part = LinePart { option: Some(name.to_owned()), words: vec![typed] };
            if arg.get_action().takes_values() && is_bare(&part.words[0]) {
                let values = arg.get_num_args().unwrap_or(1.into());
                let is_value = |n: usize, word: &str| n <= values.min_values() || !word.starts_with('-');
                while part.words.len() <= values.max_values()
                    && let Some(value) = rest.next_if(|word| is_value(part.words.len(), word))
                {
                    part.words.push(value.clone());
                }
            }
            parts.push(part);
        }
        if word == "--" {
            parts.extend(rest.by_ref().map(|word| LinePart::alone(word)));
        }
    }
    parts
}

/// The options in a word, each as it is typed by itself: `-qn64` is -q and -n64. None in a word that is no option.
fn options_in<'a>(word: &str, known: &[&'a clap::Arg]) -> Vec<(&'a clap::Arg, String)> {
    if let Some(long) = word.strip_prefix("--") {
        let name = long.split('=').next().unwrap_or_default();
        let has_alias = |arg: &clap::Arg| arg.get_all_aliases().is_some_and(|aliases| aliases.contains(&name));
        let arg = known.iter().find(|arg| arg.get_long() == Some(name) || has_alias(arg));
        return arg.map(|arg| (*arg, word.to_owned())).into_iter().collect();
    }
    let (mut found, mut letters) = (Vec::new(), word.strip_prefix('-').unwrap_or_default());
    while let Some(letter) = letters.chars().next()
        && let Some(arg) = known.iter().find(|arg| arg.get_short() == Some(letter))
    {
        let length = if arg.get_action().takes_values() { letters.len() } else { letter.len_utf8() };
        let (typed, rest) = letters.split_at(length);
        found.push((*arg, format!("-{typed}")));
        letters = rest;
    }
    found
}

/// Whether an option is typed without a value: `--name`, `-n`.
fn is_bare(typed: &str) -> bool {
    if typed.starts_with("--") { !typed.contains('=') } else { typed.chars().count() == 2 }
}

/// This process's command line without the options that change no result, quoted for a shell, with `-o` and an output that is called
/// `again`, where that is not empty: it repeats the run as it stands.
pub fn command_line(again: &str) -> String {
    line_of(parts_at_work(), again)
}

/// The name of the part in whose place the input of each row goes.
const INPUT: &str = "INPUT";

/// The parts of a command line that all rows of a cohort share, with one place for an input where some were `given`.
pub fn shared_parts(all: Vec<LinePart>, given: &[PathBuf]) -> Vec<LinePart> {
    let given: HashSet<Cow<'_, str>> = given.iter().map(|path| path.to_string_lossy()).collect();
    let (mut parts, mut is_command, mut has_place) = (Vec::new(), true, false);
    for part in all {
        let is_input = part.option.is_none() && !is_command && given.contains(&*part.words[0]);
        is_command &= part.option.is_some();
        if !is_input {
            parts.push(part);
        } else if !has_place {
            has_place = true;
            parts.push(LinePart { option: Some(INPUT.to_owned()), words: Vec::new() });
        }
    }
    parts
}

/// The parts of a command line for one `input` alone, with `options` of its own, by name and value, in the place of those that all share.
pub fn row_parts(shared: &[LinePart], input: &Path, options: &[(String, String)]) -> Vec<LinePart> {
    let own: Vec<(String, &String)> = options.iter().map(|(name, value)| (name.replace('_', "-"), value)).collect();
    let is_own = |part: &&LinePart| own.iter().any(|(name, _)| part.is_one_of(&[name.as_str()]));
    let parts = shared.iter().filter(|part| !is_own(part));
    let parts = parts.map(|part| if part.is_one_of(&[INPUT]) { LinePart::input(input) } else { part.clone() }).collect();
    let own = own.iter().map(|(name, value)| LinePart { option: Some(name.clone()), words: vec![format!("--{name}={value}")] });
    with_options(parts, own)
}

/// The parts of `willis infer` for one mask of those that `willis bids` was given.
pub fn infer_parts(given: Vec<LinePart>, mask: &Path) -> Vec<LinePart> {
    let (mut parts, mut is_infer) = (Vec::new(), false);
    for part in given.into_iter().filter(|part| !part.is_one_of(&CHOICES)) {
        if part.option.is_some() {
            parts.push(part);
        } else if !is_infer {
            is_infer = true;
            parts.extend([LinePart::alone("infer"), LinePart::input(mask)]);
        }
    }
    parts
}

/// The same with options at the end, where no `--` makes words of them.
pub fn with_options(mut parts: Vec<LinePart>, options: impl IntoIterator<Item = LinePart>) -> Vec<LinePart> {
    let end = parts.iter().position(|part| part.option.is_none() && part.words[0] == "--").unwrap_or(parts.len());
    parts.splice(end..end, options);
    parts
}

/// The words of some parts.
pub fn words_of(parts: Vec<LinePart>) -> Vec<String> {
    parts.into_iter().flat_map(|part| part.words).collect()
}

/// The command line of the parts that change a result.
pub fn line_of(mut parts: Vec<LinePart>, again: &str) -> String {
    parts.retain(|part| !part.is_one_of(&IMMATERIAL));
    let output = ["-o".to_owned(), again.to_owned()].into();
    let output = (!again.is_empty()).then(|| LinePart { option: Some("output".to_owned()), words: output });
    let words = words_of(with_options(parts, output));
    ["willis".to_owned()].into_iter().chain(words.iter().map(|word| quoted(word))).collect::<Vec<_>>().join(" ")
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
    let command = subcommand(&parser, &words).map(str::to_owned);
    if let Ok(mut now) = AT_WORK.write() {
        *now = Some(CommandLine { words, parser, command, as_typed });
    }
}

/// The first word that is the name of a subcommand.
fn subcommand<'a>(parser: &clap::Command, words: &'a [String]) -> Option<&'a str> {
    let is_command = |word: &&str| *word != "help" && parser.get_subcommands().any(|own| own.get_name() == *word);
    words.iter().map(String::as_str).find(is_command)
}

/// What a function says of the command line that is at work; `None` where there is none.
fn of_line<T>(say: impl FnOnce(&CommandLine) -> Option<T>) -> Option<T> {
    AT_WORK.read().ok()?.as_ref().and_then(say)
}

/// The parts of the command line.
pub fn parts_at_work() -> Vec<LinePart> {
    of_line(|line| Some(parts(&line.parser, &line.words))).unwrap_or_default()
}

/// Whether a word is the name of an option of a command, or of any.
pub fn is_option(word: &str, of: Option<&str>) -> bool {
    let has = |command: &clap::Command| {
        of.is_none_or(|of| command.get_name() == of) && command.get_arguments().any(|option| option.get_long() == Some(word))
    };
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

/// A field as the argument of the subcommand at work.
fn flag(field: &str) -> Option<String> {
    let flag = field.replace('_', "-");
    let is_common = matches!(flag.as_str(), "threads" | "force");
    let typed = |command: &clap::Command| {
        // What is typed without a name has that of its place: OUT.
        let place = command.get_arguments().find(|arg| arg.is_positional() && arg.get_id().as_str() == field);
        if let Some(place) = place.and_then(clap::Arg::get_value_names) {
            return place.first().map(ToString::to_string);
        }
        let is_one = is_common || command.get_arguments().any(|arg| is_called(arg, &flag));
        let dashes = if flag.len() == 1 { "-" } else { "--" };
        is_one.then(|| format!("{dashes}{flag}"))
    };
    of_line(|line| line.parser.find_subcommand(line.typed()?).and_then(typed))
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
        ErrorKind::MissingRequiredArgument => return Error::parameter(name, "", "is needed here"),
        _ => match (std::error::Error::source(error), text(ContextKind::ValidValue)) {
            (Some(source), _) => source.to_string(),
            (None, Some(valid)) if !valid.is_empty() => format!("expected one of {valid}"),
            _ => first,
        },
    };
    Error::parameter(name, format!("\"{value}\""), accepted)
}

/// The field that an argument is: `max_gap` for `--max-gap <LENGTH>`, `INPUT` for `<INPUT>...`.
fn field(arg: &str) -> String {
    let name = arg.trim_start_matches(['-', '<']).split([' ', '=', '[', '<', '>']).next();
    name.unwrap_or_default().replace('-', "_")
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
