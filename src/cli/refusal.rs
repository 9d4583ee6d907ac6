//! What the command line parser refuses, in one line that says what to type instead.

use crate::internals::support::suggestions::did_you_mean;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

use super::at_work::with_flags;
use super::parser_error::of_library;

/// The error in one line; `given` are the words of the command line, and `parser` is that of all commands.
pub fn one_line(error: &Error, given: &[String], parser: &clap::Command) -> String {
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
    let names: Vec<&str> = parser.get_subcommands().map(clap::Command::get_name).collect();
    if let (ErrorKind::InvalidSubcommand, false) = (error.kind(), said.contains("did you mean"))
        && let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
    {
        if word == "train" {
            return format!("{said}; this willis was built without it: add `--features train` to the command that builds it");
        }
        said = format!("{said}; {}expected {}", did_you_mean(word, names.iter().copied()), names.join(", "));
    }
    format!("{said}; see willis help{}", command_in(given, parser).map_or(String::new(), |name| format!(" {name}")))
}

/// The subcommand among the words of a command line.
pub fn command_in(given: &[String], parser: &clap::Command) -> Option<String> {
    given.iter().find(|word| *word != "help" && parser.get_subcommands().any(|own| own.get_name() == *word)).cloned()
}

/// What a tip proposes, as a question.
fn meant(tip: &str) -> String {
    match tip.strip_prefix("a similar ").and_then(|rest| rest.split_once(" exists: ")) {
        Some((_, name)) => format!("did you mean {name}?"),
        None => tip.to_owned(),
    }
}
