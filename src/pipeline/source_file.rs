//! Files that a run read beside its input, and the words that stand for such a file, as run.json names them; and how such a file is refused.

use std::{path::Path, path::PathBuf};

use serde::{Deserialize, Serialize, de::DeserializeOwned, de::IntoDeserializer, de::value::StrDeserializer};

use crate::Result;
use willis_core::error::Fault;
pub use willis_core::error::require;
use willis_io::formats::{bytes_of, check_name, checksum};

/// Refuses a file or folder, unless something holds.
///
/// # Errors
///
/// Says what was `found` there, and what is accepted.
pub fn require_in(path: &Path, holds: bool, found: impl Into<String>, accepted: impl Into<String>) -> Result<()> {
    if holds { Ok(()) } else { Err(Fault::file(found, accepted).in_file(path)) }
}

/// A file that was read beside the input.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFile {
    /// Its path as given.
    pub path: PathBuf,
    /// The SHA-256 of its bytes.
    pub sha256: String,
}

impl SourceFile {
    /// A file and what it holds.
    pub(crate) fn read(path: &Path) -> Result<(Vec<u8>, Self)> {
        check_name(path)?;
        let bytes = bytes_of(path)?;
        let sha256 = checksum(&bytes);
        Ok((bytes, Self { path: path.to_owned(), sha256 }))
    }

    /// A file of text, such as a model, and what `reader` makes of it; where it is no text, what was `expected`.
    pub(crate) fn read_text<T>(path: &Path, expected: &str, reader: impl FnOnce(&str) -> Result<T, Fault>) -> Result<(T, Self)> {
        let (bytes, source) = Self::read(path)?;
        let text = std::str::from_utf8(&bytes).map_err(|_| Fault::file("not UTF-8", expected));
        Ok((text.and_then(reader).map_err(|fault| fault.in_file(path))?, source))
    }
}

/// Where a model or a prior comes from, as run.json names it: a word for what ships with willis, or a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ModelSource {
    /// A word.
    Word(String),
    /// A file.
    File(SourceFile),
}

/// The choice that serde writes as this word, or that a file of this name is.
pub fn of_word<T: DeserializeOwned>(word: &str) -> Option<T> {
    let word: StrDeserializer<'_, serde::de::value::Error> = word.into_deserializer();
    T::deserialize(word).ok()
}

/// The ending of a file, in small letters.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
