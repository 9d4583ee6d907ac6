//! Groups of options that several commands share, each with the options of the library that it means.

pub mod arteries;
pub mod candidates;
pub mod figures;
pub mod pulse;
pub mod reading;
pub mod sampling;

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::de::DeserializeOwned;

use crate::internals::pipeline::of_word;
use crate::internals::support::endings::without_ending;
use crate::{BoundaryOptions, Unfed};

/// A parser for an enum of the library by the words that serde writes, each with its help.
pub fn words<T: DeserializeOwned + Clone + Send + Sync + 'static>(
    words: &[(&'static str, &'static str)],
) -> impl TypedValueParser<Value = T> {
    let value = |(word, help): &(&'static str, &'static str)| match *help {
        "" => PossibleValue::new(*word),
        help => PossibleValue::new(*word).help(help),
    };
    PossibleValuesParser::new(words.iter().map(value)).try_map(|word| of_word(&word).ok_or("expected one of the words"))
}

/// The words for what becomes of vessels that no inlet feeds.
pub fn unfed() -> impl TypedValueParser<Value = Unfed> {
    words(&[("drop", "They are left out"), ("keep", "They stay, without flow")])
}

/// Conditions with the file of them that goes with an input.
pub fn boundary_for(options: &BoundaryOptions, input: &Path) -> BoundaryOptions {
    BoundaryOptions { conditions: options.conditions.as_ref().map(|name| file_of(name, input)), ..options.clone() }
}

/// A file named for every input: `{}` in its name is the input without its ending, `{dir}` the folder of the input.
pub fn file_of(name: &Path, input: &Path) -> PathBuf {
    let Some(text) = name.to_str().filter(|text| text.contains('{')) else { return name.to_owned() };
    let folder = input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let whole = if input.is_dir() { input.to_owned() } else { without_ending(input) };
    // Split first, so that braces in the name of a folder stay as they are.
    let parts = text.split("{dir}").map(|part| part.replace("{}", &whole.to_string_lossy()));
    parts.collect::<Vec<_>>().join(&folder.to_string_lossy()).into()
}
