//! Reads TOML, and writes texts as TOML has them.

use serde::de::DeserializeOwned;

use crate::error::Fault;

/// What a TOML text holds.
///
/// # Errors
///
/// The line of what is wrong, what it is, and the accepted form.
pub fn parse<T: DeserializeOwned>(text: &str, accepted: &str) -> Result<T, Fault> {
    toml::from_str(text).map_err(|error| {
        let before = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = text[..before].matches('\n').count() + 1;
        Fault::line(line, error.message().replace('\n', " "), accepted)
    })
}

/// A text between quotation marks.
pub fn text(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007F")
}

/// A list of texts.
pub fn list(texts: &[String]) -> String {
    let texts: Vec<String> = texts.iter().map(|t| text(t)).collect();
    format!("[{}]", texts.join(", "))
}
