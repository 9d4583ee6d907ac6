//! The hidden, locked folder `.willis-NAME` in which an output is built; folders that killed runs left behind are cleared.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use crate::error::{Error, Result};
use crate::io::checksum;
use crate::output::ownership::entries;

/// How the name of everything in the making begins.
pub const HIDDEN_PREFIX: &str = ".willis-";
const NEW: &str = "new";
const OLD: &str = "old";
/// How the name of everything begins that stays when a run does not come to its end.
const KEPT: &str = "checkpoint-";
/// The ending of such a thing while it is being written.
pub const UNFINISHED: &str = "unfinished";
/// The longest name of an output that goes into that of the folder, in bytes.
const LONGEST: usize = 200;
/// What the system says of a path that cannot be written.
pub fn write_error(path: &Path) -> impl Fn(io::Error) -> Error + '_ {
    move |source| Error::Write { path: final_path(path), source }
}

/// Whether a path is the temporary of a run that is at work, or was killed.
pub fn is_in_progress(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(HIDDEN_PREFIX.as_bytes()))
}

/// An output in the making.
#[derive(Debug)]
pub struct InProgress {
    target: PathBuf,
    folder: PathBuf,
    /// Parents of the target that were made for it, the innermost first.
    parents: Vec<PathBuf>,
    /// Held until everything is cleared.
    lock: Option<File>,
}

impl InProgress {
    /// Makes the folder beside `target`, with missing parents, and keeps other processes out.
    ///
    /// # Errors
    ///
    /// Another process is making the same output, or the system refuses.
    pub fn new(target: &Path) -> Result<Self> {
        let missing = |p: &&Path| !p.as_os_str().is_empty() && !p.exists();
        let parents = target.ancestors().skip(1).take_while(missing).map(Path::to_owned).collect();
        let folder = folder_of(target);
        let mut started = Self { target: target.to_owned(), folder, parents, lock: None };
        started.lock = Some(lock(&started.folder, TRIES).map_err(|refused| refused.of(target))?);
        clear(&started.folder, Some(target));
        Ok(started)
    }

    /// Refuses an output that another process is making at the moment.
    ///
    /// # Errors
    ///
    /// As [`InProgress::new`].
    pub fn check(target: &Path) -> Result<()> {
        let folder = folder_of(target);
        if folder.join(LOCK).exists() { lock(&folder, TRIES).map(drop).map_err(|refused| refused.of(target)) } else { Ok(()) }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where the output is made.
    pub fn new_path(&self) -> PathBuf {
        self.folder.join(NEW)
    }

    /// The path of something that stays when the run does not come to its end.
    pub fn kept(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{KEPT}{name}"))
    }

    /// Puts the output in its place: a file in one step, a folder with the earlier one aside until then.
    ///
    /// # Errors
    ///
    /// The system refuses; the earlier one then stands as it was.
    pub fn put(&self) -> Result<()> {
        let (error, old) = (write_error(&self.target), self.folder.join(OLD));
        let replaces = self.target.is_dir();
        if replaces {
            fs::rename(&self.target, &old).map_err(&error)?;
        }
        if let Err(source) = fs::rename(self.new_path(), &self.target) {
            if replaces {
                fs::rename(&old, &self.target).map_err(&error)?;
            }
            return Err(error(source));
        }
        sync_folder(parent(&self.target))
    }
}

impl Drop for InProgress {
    fn drop(&mut self) {
        if self.lock.is_some() {
            clear(&self.folder, Some(&self.target));
            discard(&self.folder);
        }
        for parent in &self.parents {
            // One with something in it stays.
            let _ = fs::remove_dir(parent);
        }
    }
}

fn parent(target: &Path) -> &Path {
    target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The folder in which an output is made.
fn folder_of(target: &Path) -> PathBuf {
    // Paths as `.` and `a/..` have no name of their own.
    let whole = if target.file_name().is_none() { target.canonicalize().ok() } else { None };
    let target = whole.as_deref().unwrap_or(target);
    let (name, mut hidden) = (target.file_name().unwrap_or_default(), OsString::from(HIDDEN_PREFIX));
    if name.len() > LONGEST {
        hidden.push(checksum(name.as_encoded_bytes()));
    } else {
        hidden.push(name);
    }
    target.with_file_name(hidden)
}

/// Clears a folder in the making, whose lock is held, of what was being made. An earlier output that was put aside is put back where
/// no new one came.
fn clear(folder: &Path, target: Option<&Path>) {
    let old = folder.join(OLD);
    // What cannot be cleared now can be later.
    if old.exists()
        && let Some(target) = target
    {
        let _ = if target.exists() { fs::remove_dir_all(&old) } else { fs::rename(&old, target) };
    }
    let made = entries(folder).unwrap_or_default();
    for path in made.iter().filter(|path| path.ends_with(NEW) || path.extension().is_some_and(|e| e == UNFINISHED)) {
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

/// Takes a folder in the making away, unless something is kept there; its lock must be held.
fn discard(folder: &Path) {
    let rest = entries(folder).unwrap_or_default();
    if rest.iter().all(|path| path.ends_with(LOCK)) {
        let _ = fs::remove_file(folder.join(LOCK));
        let _ = fs::remove_dir(folder);
    }
}

/// Clears what killed runs left in the making in a folder; what a run that lives is at, what is kept to go on from, and what others
/// may have put there stays.
pub fn clear_dead_runs(folder: &Path) {
    for path in entries(folder).unwrap_or_default().into_iter().filter(|path| is_in_progress(path) && path.is_dir()) {
        if !path.join(LOCK).exists() {
            // Only where it is empty.
            let _ = fs::remove_dir(&path);
        } else if let Ok(_lock) = lock(&path, 1) {
            let name = path.file_name().and_then(OsStr::to_str).and_then(|name| name.strip_prefix(HIDDEN_PREFIX));
            clear(&path, name.filter(|name| !is_checksum(name)).map(|name| folder.join(name)).as_deref());
            discard(&path);
        }
    }
}

/// Whether a folder in the making holds something to go on from.
pub fn has_checkpoint(folder: &Path) -> bool {
    let is_kept = |path: &PathBuf| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(KEPT.as_bytes()));
    entries(folder).unwrap_or_default().iter().any(is_kept)
}

/// A path in the making as the person who reads of it knows it: where it would have come to stand.
pub fn final_path(path: &Path) -> PathBuf {
    let mut known = PathBuf::new();
    let mut parts = path.components();
    while let Some(part) = parts.next() {
        let name = part.as_os_str().to_str().and_then(|name| name.strip_prefix(HIDDEN_PREFIX));
        match name.filter(|_| parts.clone().next().is_some_and(|next| next.as_os_str() == NEW)) {
            Some(name) => {
                known.push(name);
                parts.next();
            }
            None => known.push(part),
        }
    }
    known
}

/// The same in the folder of an output.
pub fn clear_leftovers_beside(target: &Path) {
    clear_dead_runs(parent(target));
}

fn is_checksum(name: &str) -> bool {
    name.len() == 64 && name.bytes().all(|b| b.is_ascii_hexdigit())
}

/// Brings the names in a folder onto the disk.
pub fn sync_folder(folder: &Path) -> Result<()> {
    #[cfg(unix)]
    match File::open(folder).and_then(|open| open.sync_all()) {
        // Some file systems know no such thing.
        Err(e) if !matches!(e.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            return Err(Error::Write { path: folder.to_owned(), source: e });
        }
        _ => {}
    }
    Ok(())
}

/// The name of the file that is locked.
pub const LOCK: &str = "lock";
/// How often, and how long apart, a lock is tried that another process may hold for a moment only, to clear up.
pub const TRIES: usize = 25;
const BETWEEN: Duration = Duration::from_millis(20);

/// Why there is no lock.
pub enum LockError {
    /// Another process has it, by its number where that is known.
    Busy(String),
    /// The system's word.
    System(io::Error),
}

impl LockError {
    /// The error for an output.
    pub fn of(self, target: &Path) -> Error {
        match self {
            Self::Busy(process) => {
                let accepted = format!("another willis{process} is writing there; wait for it, or choose another --output");
                Error::parameter("--output", target.display(), accepted)
            }
            Self::System(source) => Error::Write { path: target.to_owned(), source },
        }
    }
}

/// Makes a folder and takes its lock, which ends with the process, however that ends.
pub fn lock(folder: &Path, tries: usize) -> Result<File, LockError> {
    let path = folder.join(LOCK);
    for at in 0..tries {
        fs::create_dir_all(folder).map_err(LockError::System)?;
        let file = match File::options().write(true).create(true).truncate(false).open(&path) {
            // The folder was cleared away in this moment.
            Err(e) if e.kind() == io::ErrorKind::NotFound && at + 1 < tries => continue,
            opened => opened.map_err(LockError::System)?,
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
    Err(LockError::Busy(process.map(|id| format!(" (process {id})")).unwrap_or_default()))
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
