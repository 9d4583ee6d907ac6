//! The SHA-256 by which a file is known again.

use std::fs::File;
use std::io::{self, Read, Sink, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::error::{Error, Result};

/// The SHA-256 of some bytes in hexadecimal digits.
pub fn checksum(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// The [`checksum`] of what `fill` writes, which need not be in memory at once.
///
/// # Errors
///
/// Those of `fill`.
pub fn checksum_of(fill: impl FnOnce(&mut Checksummed<Sink>) -> io::Result<()>) -> io::Result<String> {
    let mut summed = Checksummed::new(io::sink());
    fill(&mut summed)?;
    Ok(summed.finish())
}

/// The [`checksum`] of a file of any size.
///
/// # Errors
///
/// It cannot be read: names it.
pub fn checksum_of_file(path: &Path) -> Result<String> {
    let read = checksum_of(|out| io::copy(&mut File::open(path)?, out).map(drop));
    read.map_err(|source| Error::Read { path: path.to_owned(), source })
}

fn hexadecimal(bytes: &[u8]) -> String {
    let digits = |byte: &u8| [byte >> 4, byte & 15].map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)]));
    bytes.iter().flat_map(digits).collect()
}

/// Reads or writes on while it takes the [`checksum`] of what passes.
pub struct Checksummed<F> {
    file: F,
    sum: Sha256,
}

impl<F> Checksummed<F> {
    /// Reads from `file`, or writes to it.
    pub fn new(file: F) -> Self {
        Self { file, sum: Sha256::new() }
    }

    /// The checksum of all that was read and written.
    pub fn finish(self) -> String {
        hexadecimal(&self.sum.finalize())
    }
}

impl<W: Write> Write for Checksummed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl<R: Read> Read for Checksummed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(bytes)?;
        self.sum.update(&bytes[..read]);
        Ok(read)
    }
}
