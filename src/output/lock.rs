//! The lock of a folder in which an output is made, so that no other process makes the same.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use crate::error::Error;

/// The name of the file that is locked.
pub const LOCK: &str = "lock";
/// How often, and how long apart, a lock is tried that another process may hold for a moment only, to clear up.
pub const TRIES: usize = 25;
const BETWEEN: Duration = Duration::from_millis(20);

/// Why there is no lock.
pub enum Refused {
    /// Another process has it, by its number where that is known.
    Busy(String),
    /// The system's word.
    System(io::Error),
}

impl Refused {
    /// The error for an output.
    pub fn of(self, target: &Path) -> Error {
        match self {
            Self::Busy(process) => {
                let accepted = format!("another willis{process} is writing there; wait for it, or choose another --output");
                Error::parameter("output", target.display(), accepted)
            }
            Self::System(source) => Error::Write { path: target.to_owned(), source },
        }
    }
}

/// Makes a folder and takes its lock, which ends with the process, however that ends.
pub fn lock(folder: &Path, tries: usize) -> Result<File, Refused> {
    let path = folder.join(LOCK);
    for at in 0..tries {
        fs::create_dir_all(folder).map_err(Refused::System)?;
        let file = match File::options().write(true).create(true).truncate(false).open(&path) {
            // The folder was cleared away in this moment.
            Err(e) if e.kind() == io::ErrorKind::NotFound && at + 1 < tries => continue,
            opened => opened.map_err(Refused::System)?,
        };
        match file.try_lock() {
            Ok(()) if is_at(&file, &path) => {
                // For people; without it the lock is as good.
                let _ = fs::write(&path, std::process::id().to_string());
                return Ok(file);
            }
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => sleep(BETWEEN),
            // A file system without locks is no reason to stop.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
    let process = fs::read_to_string(&path).ok().filter(|id| !id.is_empty() && id.bytes().all(|b| b.is_ascii_digit()));
    Err(Refused::Busy(process.map(|id| format!(" (process {id})")).unwrap_or_default()))
}

/// Whether a file that is open is still the one at a path: its last holder may have taken it away.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let same = |a: &fs::Metadata, b: &fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
    file.metadata().ok().zip(fs::metadata(path).ok()).is_some_and(|(a, b)| same(&a, &b))
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}
