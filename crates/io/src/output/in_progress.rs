//! The hidden, locked folder `.willis-NAME` in which an output is built; folders that killed runs left behind are cleared.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::lock::{LOCK, TRIES, foreign, is_own_folder, lock};
use super::{names::SET, target::followed};
use willis_core::error::{Error, Result};

/// The beginning of the name of every unfinished output.
const HIDDEN_PREFIX: &str = ".willis-";
const NEW: &str = "new";
const OLD: &str = "old";
/// The beginning of the name of every checkpoint.
const KEPT: &str = "checkpoint-";
/// The file ending of a checkpoint while it is being written.
pub const UNFINISHED: &str = "unfinished";
/// The longest output name that becomes part of the folder's name, in bytes.
const LONGEST: usize = 200;
/// The error that a path cannot be written.
pub fn write_error(path: &Path) -> impl Fn(io::Error) -> Error + '_ {
    move |source| Error::Write { path: final_path(path), source }
}

/// Whether a path is the hidden folder of a run that is at work, or was killed.
pub fn is_in_progress(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(HIDDEN_PREFIX.as_bytes()))
}

/// An output being written, in its hidden folder.
#[derive(Debug)]
pub struct InProgress {
    /// Where the output goes.
    pub target: PathBuf,
    /// The folder.
    pub folder: PathBuf,
    /// Parents of the target that were created for it, the innermost first.
    parents: Vec<PathBuf>,
    /// Held until everything is removed.
    lock: Option<File>,
}

impl InProgress {
    /// Creates the hidden folder next to `target`, or next to what that is a link to, with missing parents, and locks it.
    ///
    /// # Errors
    ///
    /// Another process is writing the same output, something that this user did not make is in the way, or the system refuses.
    pub fn new(target: &Path) -> Result<Self> {
        let place = followed(target);
        let missing = |p: &&Path| !p.as_os_str().is_empty() && !p.exists();
        let parents = place.ancestors().skip(1).take_while(missing).map(Path::to_owned).collect();
        let folder = folder_of(&place);
        let mut started = Self { target: place, folder, parents, lock: None };
        started.lock = Some(lock(&started.folder, target, TRIES)?);
        clear(&started.folder, Some(&started.target));
        Ok(started)
    }

    /// Checks that no other process is writing the output at the moment, and clears what a killed one left of it.
    ///
    /// # Errors
    ///
    /// As [`InProgress::new`].
    pub fn check(target: &Path) -> Result<()> {
        let place = followed(target);
        let folder = folder_of(&place);
        if fs::symlink_metadata(&folder).is_err() {
            return Ok(());
        }
        if !is_own_folder(&folder) {
            return Err(foreign(&folder, target));
        }
        let _lock = lock(&folder, target, TRIES)?;
        clear(&folder, Some(&place));
        discard(&folder);
        Ok(())
    }

    /// Where the output is written.
    pub fn new_path(&self) -> PathBuf {
        self.folder.join(NEW)
    }

    /// The path of a checkpoint.
    pub fn kept(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{KEPT}{name}"))
    }

    /// Moves the output to its place: a file in one step, a folder with the earlier one set aside until then.
    ///
    /// # Errors
    ///
    /// The system refuses; the earlier one then stays as it was.
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
            // A parent that is not empty stays.
            let _ = fs::remove_dir(parent);
        }
    }
}

fn parent(target: &Path) -> &Path {
    target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The hidden folder in which an output is written.
pub fn folder_of(target: &Path) -> PathBuf {
    let (name, mut hidden) = (target.file_name().unwrap_or_default(), std::ffi::OsString::from(HIDDEN_PREFIX));
    if name.len() > LONGEST {
        hidden.push(crate::formats::checksum(name.as_encoded_bytes()));
    } else {
        hidden.push(name);
    }
    target.with_file_name(hidden)
}

/// Empties a hidden folder, whose lock must be held, of unfinished output. An earlier output that was set aside is moved back if
/// there is no new one.
fn clear(folder: &Path, target: Option<&Path>) {
    let old = folder.join(OLD);
    // What cannot be removed now can be removed later.
    if let Ok(about) = fs::symlink_metadata(&old)
        && let Some(target) = target
    {
        if about.is_symlink() || target.exists() {
            remove(&old);
        } else {
            let _ = fs::rename(&old, target);
        }
    }
    if target.is_none_or(|target| fs::symlink_metadata(target).is_ok()) {
        // The set is complete.
        remove(&folder.join(SET));
    }
    let made = entries(folder).unwrap_or_default();
    for path in made.iter().filter(|path| path.ends_with(NEW) || path.extension().is_some_and(|e| e == UNFINISHED)) {
        remove(path);
    }
}

/// Removes a file, a link, or a folder with all that is in it; once more where the disk faltered, so that no lock is left for nothing.
fn remove(path: &Path) {
    let is_folder = fs::symlink_metadata(path).is_ok_and(|about| about.is_dir());
    let once = || if is_folder { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    if once().is_err_and(|error| error.kind() != io::ErrorKind::NotFound) {
        let _ = once();
    }
}

/// Removes a hidden folder, whose lock must be held, unless it holds a checkpoint.
fn discard(folder: &Path) {
    let rest = entries(folder).unwrap_or_default();
    if rest.iter().all(|path| path.ends_with(LOCK)) {
        remove(&folder.join(LOCK));
        if fs::remove_dir(folder).is_err() {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Removes what killed runs left in a folder that willis wrote. Output of a run at work, checkpoints, links, what other users made, and files
/// that others may have put there stay.
pub fn clear_dead_runs(folder: &Path) {
    for path in entries(folder).unwrap_or_default().into_iter().filter(|path| is_in_progress(path) && is_own_folder(path)) {
        if fs::symlink_metadata(path.join(LOCK)).is_err() {
            // Only if it is empty.
            let _ = fs::remove_dir(&path);
        } else if let Ok(_lock) = lock(&path, &path, 1) {
            let name = path.file_name().and_then(std::ffi::OsStr::to_str).and_then(|name| name.strip_prefix(HIDDEN_PREFIX));
            clear(&path, name.filter(|name| !is_checksum(name)).map(|name| folder.join(name)).as_deref());
            discard(&path);
        }
    }
}

/// Whether a hidden folder holds a checkpoint.
pub fn has_checkpoint(folder: &Path) -> bool {
    let is_kept = |path: &PathBuf| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(KEPT.as_bytes()));
    entries(folder).unwrap_or_default().iter().any(is_kept)
}

/// The path at which an unfinished output will stand, for messages.
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

fn is_checksum(name: &str) -> bool {
    name.len() == 64 && name.bytes().all(|b| b.is_ascii_hexdigit())
}

/// Flushes the names in a folder to the disk.
pub fn sync_folder(folder: &Path) -> Result<()> {
    #[cfg(unix)]
    match File::open(folder).and_then(|open| open.sync_all()) {
        // Some file systems cannot do this.
        Err(e) if !matches!(e.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            return Err(Error::Write { path: folder.to_owned(), source: e });
        }
        _ => {}
    }
    Ok(())
}

/// The paths in a folder; `None` when it cannot be read.
pub fn entries(folder: &Path) -> Option<Vec<PathBuf>> {
    fs::read_dir(folder).ok()?.map(|entry| entry.ok().map(|e| e.path())).collect()
}
