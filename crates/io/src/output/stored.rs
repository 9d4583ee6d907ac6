//! What a later process goes on from: a value as JSON, with the checksum of that behind it.

use std::io::{self, Write};

use serde::{Serialize, de::DeserializeOwned};

use crate::formats::{Checksummed, checksum};
use willis_core::error::Fault;

/// Writes a value as JSON, and behind it the 64 digits of its SHA-256.
///
/// # Errors
///
/// A value that JSON cannot hold, or the writer's own.
pub fn write_stored(mut out: impl Write, value: &impl Serialize) -> io::Result<()> {
    let mut summed = Checksummed::new(&mut out);
    serde_json::to_writer(&mut summed, value)?;
    let sum = summed.finish();
    out.write_all(sum.as_bytes())?;
    out.flush()
}

/// Reads what [`write_stored`] wrote.
///
/// # Errors
///
/// Bytes that were cut or altered, or that hold another value.
pub fn read_stored<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Fault> {
    let wrong = |found: String| Fault::file(found, "expected what willis wrote, whole and unaltered");
    let whole = bytes.split_last_chunk::<64>().filter(|(json, sum)| checksum(json).as_bytes() == *sum);
    let (json, _) = whole.ok_or_else(|| wrong("its checksum is not that of its content".to_owned()))?;
    serde_json::from_slice(json).map_err(|error| wrong(error.to_string()))
}
