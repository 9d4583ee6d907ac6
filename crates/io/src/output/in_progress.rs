//! The hidden, locked folder `.willis-NAME` in which an output is built; folders that killed runs left behind are cleared. The place of an output: where
//! a link leads, and what cannot be replaced, which is said before the work begins.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::lock::{LOCK, TRIES, is_own_folder, lock, parent};
use willis_core::error::{Error, Result, ensure};

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

    /// The same for an output that `vacant` finds in nobody's way.
    ///
    /// # Errors
    ///
    /// Those of `vacant` and of [`InProgress::new`].
    pub fn of_vacant(target: &Path, vacant: impl Fn() -> Result<()>) -> Result<Self> {
        vacant()?;
        let started = Self::new(target)?;
        // Another process may have written it before it released the lock.
        vacant().map(|()| started)
    }

    /// Checks, before the work begins, that [`InProgress::of_vacant`] would start the output, and clears what a killed process left of it.
    ///
    /// # Errors
    ///
    /// As [`InProgress::of_vacant`].
    pub fn check(target: &Path, vacant: impl Fn() -> Result<()>) -> Result<()> {
        let is_left = fs::symlink_metadata(folder_of(&followed(target))).is_ok();
        // What a run left that was killed at its end goes too where its output refuses the next.
        let (is_vacant, cleared) = (vacant(), if is_left { Self::new(target).map(drop) } else { Ok(()) });
        is_vacant.and(cleared)
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
        remove(&folder.join(super::names::SET));
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

/// Removes what killed runs left unfinished in a folder that willis wrote. Output of a run at work, checkpoints, links, what other users made, and files
/// that others may have put there stay.
///
/// # Errors
///
/// The system refuses.
pub fn clear_leftovers(folder: &Path) -> Result<()> {
    let is_checksum = |name: &str| name.len() == 64 && name.bytes().all(|b| b.is_ascii_hexdigit());
    let left = || entries(folder).unwrap_or_default().into_iter().filter(|path| is_in_progress(path) && is_own_folder(path));
    for path in left() {
        if fs::symlink_metadata(path.join(LOCK)).is_err() {
            // Only if it is empty.
            let _ = fs::remove_dir(&path);
        } else if let Ok(_lock) = lock(&path, &path, 1) {
            let name = path.file_name().and_then(std::ffi::OsStr::to_str).and_then(|name| name.strip_prefix(HIDDEN_PREFIX));
            clear(&path, name.filter(|name| !is_checksum(name)).map(|name| folder.join(name)).as_deref());
            discard(&path);
        }
    }
    let is_kept = |path: &PathBuf| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(KEPT.as_bytes()));
    for path in left().filter(|path| !entries(path).unwrap_or_default().iter().any(is_kept)) {
        fs::remove_dir_all(&path).map_err(write_error(&path))?;
    }
    Ok(())
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

/// Where an output goes: a link is followed, so that it stays and what it points to is written.
pub fn followed(target: &Path) -> PathBuf {
    let is_link = fs::symlink_metadata(target).is_ok_and(|about| about.is_symlink());
    // Paths such as `.` and `a/..` have no name of their own.
    let whole = if is_link || target.file_name().is_none() { target.canonicalize().ok() } else { None };
    whole.unwrap_or_else(|| target.to_owned())
}

/// The folder of a run has files of about this size, bytes.
const RUN: u64 = 1 << 20;

/// Checks that the files of a run may be as large as they are.
///
/// # Errors
///
/// The limit of the shell is lower.
pub fn check_file_size(target: &Path) -> Result<()> {
    match willis_core::support::limits::file_size() {
        Some(most) if most < RUN => {
            let accepted = format!("files may have {most} bytes at most here; raise the limit (ulimit -f) to {RUN} at least");
            Err(Error::parameter("output", target.display(), accepted))
        }
        _ => Ok(()),
    }
}

/// Checks that an output does not exist, or may be replaced, and that its folder can be written to.
///
/// # Errors
///
/// It exists and `force` is off; a link to nothing; a device, a pipe, the current folder, the root of a file system; a folder above it that
/// takes no file.
pub fn check_vacant(target: &Path, force: bool) -> Result<()> {
    let refused = |accepted: &str| Error::parameter("output", target.display(), accepted);
    if fs::symlink_metadata(target).is_err_and(|e| e.kind() == ErrorKind::InvalidFilename) {
        let bytes = target.file_name().unwrap_or_default().len();
        return Err(refused(&format!("its name has {bytes} bytes, more than the file system takes; choose a shorter one")));
    }
    let there = target.exists();
    let leads_nowhere = !there && fs::symlink_metadata(target).is_ok();
    ensure(!leads_nowhere, || refused("is a link to nothing; remove it, or name what it is to point to"))?;
    ensure(force || !there, || Error::Exists { path: target.to_owned() })?;
    let place = followed(target);
    if there {
        let is_usual = place.is_file() || place.is_dir();
        ensure(is_usual, || refused("is a device or a pipe; expected the name of a file or a folder"))?;
        let here = std::env::current_dir().and_then(|here| here.canonicalize());
        let holds_here = here.ok().zip(place.canonicalize().ok()).is_some_and(|(here, place)| here.starts_with(place));
        let accepted = "is the current folder or has it in it, which cannot be replaced; expected the name of another folder";
        ensure(!holds_here, || refused(accepted))?;
        let accepted = "is where a file system is mounted, which cannot be replaced; expected the name of a folder in it";
        ensure(!is_mounted(&place), || refused(accepted))?;
    }
    let standing = place.ancestors().skip(1).find(|p| p.as_os_str().is_empty() || p.exists());
    let folder = standing.filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match tempfile::tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(e) => {
            // Other system messages mislead: a folder that exists but takes no entry is "not found".
            use ErrorKind::{PermissionDenied, ReadOnlyFilesystem, StorageFull};
            let is_plain = matches!(e.kind(), PermissionDenied | ReadOnlyFilesystem | StorageFull);
            let why = if is_plain { format!(": {}", e.kind()) } else { String::new() };
            Err(refused(&format!("cannot be made: nothing can be written into {}{why}", folder.display())))
        }
    }
}

/// Whether something is mounted at a path, as a container's `/out` is: it cannot be moved.
#[cfg(unix)]
fn is_mounted(place: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let Ok(place) = place.canonicalize() else { return false };
    let device = |path: &Path| fs::metadata(path).map(|about| about.dev()).ok();
    if place.parent().is_none_or(|parent| device(parent) != device(&place)) {
        return true;
    }
    // A folder of the same file system that is mounted again; Linux lists it, with blanks and the like as octal numbers.
    let listed = fs::read_to_string("/proc/self/mountinfo").unwrap_or_default();
    let escaped = |c: char| if matches!(c, ' ' | '\t' | '\n' | '\\') { format!("\\{:03o}", c as u32) } else { c.to_string() };
    let name: String = place.to_string_lossy().chars().map(escaped).collect();
    listed.lines().any(|line| line.split(' ').nth(4) == Some(&name))
}

#[cfg(not(unix))]
fn is_mounted(place: &Path) -> bool {
    place.canonicalize().is_ok_and(|place| place.parent().is_none())
}
