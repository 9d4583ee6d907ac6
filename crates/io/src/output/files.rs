//! Writes files so that every write error is reported; JSON in and out.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Component, Path, absolute};
use std::sync::OnceLock;

use serde::{Serialize, de::DeserializeOwned};

use super::{names::RECORD, write_error};
use crate::formats::regular_bytes_of;
use willis_core::error::{Fault, Result};

/// Whether the process has been asked to stop, where somebody listens.
static STOPPED: OnceLock<fn() -> bool> = OnceLock::new();

/// From now on what is being written when `is_stopped` becomes true is given up; progress that is kept is written all the same.
pub fn give_up_when(is_stopped: fn() -> bool) {
    let _ = STOPPED.set(is_stopped);
}

/// A file that remembers its first write error. After that it accepts everything and writes nothing: archive writers, which
/// finish what they began in any case, then report no second error.
#[derive(Debug)]
pub struct DiskFile {
    file: File,
    fault: Option<io::Error>,
    /// Whether it is given up when the process is asked to stop.
    stops: bool,
    /// Where the next byte would go, and how long the file would be.
    at: u64,
    length: u64,
}

impl DiskFile {
    /// A new empty file in place of one that is there, or of a link, which is not followed; whether it is given up when the process is asked to stop.
    pub fn create_new(path: &Path, stops: bool) -> io::Result<Self> {
        match std::fs::remove_file(path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => {}
        }
        Ok(Self { file: File::create_new(path)?, fault: None, stops, at: 0, length: 0 })
    }

    /// Flushes the file to the disk, or returns the first error.
    pub fn finish(self) -> io::Result<()> {
        self.fault.map_or_else(|| self.file.sync_all(), Err)
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut written = bytes.len();
        if self.fault.is_none() && self.stops && STOPPED.get().is_some_and(|is_stopped| is_stopped()) {
            self.fault = Some(io::Error::other("a signal asked to stop"));
        }
        if self.fault.is_none() {
            match self.file.write(bytes) {
                Err(e) if e.kind() == io::ErrorKind::Interrupted => return Err(e),
                Err(e) => self.fault = Some(e),
                Ok(0) if !bytes.is_empty() => self.fault = Some(io::ErrorKind::WriteZero.into()),
                Ok(n) => written = n,
            }
        }
        self.at += written as u64;
        self.length = self.length.max(self.at);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for DiskFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
        };
        let at = at.ok_or(io::ErrorKind::InvalidInput)?;
        if self.fault.is_none()
            && let Err(e) = self.file.seek(SeekFrom::Start(at))
        {
            self.fault = Some(e);
        }
        self.at = at;
        Ok(at)
    }
}

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

/// Reads a value from JSON that this program wrote into a folder, or that stands in one by its name; `expected` describes the file for the error.
///
/// # Errors
///
/// The file cannot be read, or holds no such value; the error names it.
pub fn read_json<T: DeserializeOwned>(path: &Path, expected: &str) -> Result<T> {
    serde_json::from_slice(&regular_bytes_of(path)?).map_err(|e| Fault::file(e.to_string(), expected).in_file(path))
}

/// Writes a file that replaces an earlier one completely or not at all.
///
/// # Errors
///
/// As [`write_file`]; the earlier one then stays.
pub fn replace_file(path: &Path, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> std::io::Result<()>) -> Result<()> {
    let unfinished = path.with_extension(super::in_progress::UNFINISHED);
    // What a killed run left of it, or a link that somebody put there.
    let _ = fs::remove_file(&unfinished);
    let written = write_with(&unfinished, fill, false).and_then(|()| fs::rename(&unfinished, path).map_err(write_error(path)));
    if written.is_err() {
        // It may be the file that filled the disk.
        let _ = fs::remove_file(&unfinished);
    }
    written?;
    super::in_progress::sync_folder(super::lock::parent(path))
}

/// Writes a new file through a buffer and flushes it to the disk; an error names the file.
///
/// # Errors
///
/// The error of the system or of `fill`, with the path.
pub fn write_file(path: &Path, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> std::io::Result<()>) -> Result<()> {
    write_with(path, fill, true)
}

fn write_with(path: &Path, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> std::io::Result<()>, stops: bool) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut out = BufWriter::new(DiskFile::create_new(path, stops)?);
        fill(&mut out)?;
        out.into_inner()?.finish()
    };
    write().map_err(write_error(path))
}

/// The path from a folder to a file or a folder, with `/` between its steps.
pub fn relative(file: &Path, folder: &Path) -> Option<String> {
    let (file, folder) = (plain(file)?, plain(folder)?);
    let shared = file.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    // On another drive there is no path.
    let up = std::iter::repeat_n("..".to_owned(), (shared > 0).then(|| folder.len() - shared)?);
    Some(up.chain(file[shared..].iter().cloned()).collect::<Vec<_>>().join("/"))
}

/// The steps to a path from the root, none of which leads back.
pub fn plain(path: &Path) -> Option<Vec<String>> {
    let mut steps: Vec<String> = Vec::new();
    for step in absolute(path).ok()?.components() {
        match step {
            Component::ParentDir => drop(steps.pop()),
            Component::CurDir => {}
            step => steps.push(step.as_os_str().to_str()?.to_owned()),
        }
    }
    Some(steps)
}
