//! What the command line parser refuses, as an error of the library, which names fields.

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::error::Error;

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
