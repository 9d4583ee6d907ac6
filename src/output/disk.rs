//! A file that remembers why it could not be written, so that whoever fills it comes to an end first.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// A file to be filled. After the first fault it takes everything and writes nothing: writers of archives, which finish what they
/// began whatever happened, then have nothing to complain of.
#[derive(Debug)]
pub struct DiskFile {
    file: File,
    fault: Option<io::Error>,
    /// Where the next byte would go, and how long the file would be.
    at: u64,
    length: u64,
}

impl DiskFile {
    /// An empty file.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { file: File::create(path)?, fault: None, at: 0, length: 0 })
    }

    /// Brings it onto the disk, or says what was wrong first.
    pub fn finish(self) -> io::Result<()> {
        match self.fault {
            None => self.file.sync_all(),
            Some(fault) => Err(fault),
        }
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut written = bytes.len();
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
