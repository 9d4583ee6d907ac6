//! JSON files: written whole, read with what was expected of them.

use std::io::Write;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::atomic::write_file;
use super::names::RECORD;
use crate::error::{Fault, Result};
use crate::io::bytes_of;

/// Writes a value as JSON for people to read.
///
/// # Errors
///
/// As [`write_file`].
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_file(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        out.write_all(b"\n")
    })
}

/// Writes the record of a run into its folder.
///
/// # Errors
///
/// As [`write_file`].
pub fn write_record(folder: &Path, record: &impl Serialize) -> Result<()> {
    write_json(&folder.join(RECORD), record)
}

/// Reads a value from JSON; `expected` says what the file should be.
///
/// # Errors
///
/// The file cannot be read, or is not such a value: names it.
pub fn read_json<T: DeserializeOwned>(path: &Path, expected: &str) -> Result<T> {
    serde_json::from_slice(&bytes_of(path)?).map_err(|e| Fault::file(e.to_string(), expected).in_file(path))
}
