//! Reads and writes TOML.

use std::{fmt::Debug, io, io::Write};

use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer, Serialize};

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
        // A key in backticks would be told as the option of that name.
        Fault::line(line, error.message().replace('\n', " ").replace('`', "\""), accepted)
    })
}

/// Writes a value as TOML under a comment; every number is read back as it was. Lists that are `long` get a line for each item.
///
/// # Errors
///
/// Those of `out`.
pub fn write(mut out: impl Write, comment: &str, long: bool, value: &impl Serialize) -> io::Result<()> {
    let text = if long { toml::to_string_pretty(value) } else { toml::to_string(value) };
    write!(out, "{comment}\n{}", text.map_err(io::Error::other)?)?;
    out.flush()
}

/// Numbers of which every one should be finite.
pub trait FiniteNumbers {
    /// Whether every one is.
    fn are_finite(&self) -> bool;
}

impl FiniteNumbers for f64 {
    fn are_finite(&self) -> bool {
        self.is_finite()
    }
}

impl<T: FiniteNumbers, const N: usize> FiniteNumbers for [T; N] {
    fn are_finite(&self) -> bool {
        self.iter().all(T::are_finite)
    }
}

/// Reads numbers of a file, each of which is finite.
///
/// # Errors
///
/// One is not.
pub fn finite<'de, D: Deserializer<'de>, T: Deserialize<'de> + FiniteNumbers + Debug>(from: D) -> Result<T, D::Error> {
    let numbers = T::deserialize(from)?;
    if numbers.are_finite() { Ok(numbers) } else { Err(D::Error::custom(format!("{numbers:?}, which is not finite"))) }
}
