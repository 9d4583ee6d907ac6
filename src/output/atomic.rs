//! Output that appears whole or not at all: written beside its place, brought onto the disk, then renamed.

use std::fs;
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::disk::DiskFile;
use super::in_progress::{
    IN_THE_MAKING, Making, UNFINISHED, is_in_the_making, keeps, sweep, sweep_beside, sync_folder, write_error,
};
use super::ownership::{entries, stranger};
use crate::error::{Error, Result};

/// Refuses an output that exists, unless it may be replaced, and a place where nothing can be written.
fn vacant(target: &Path, force: bool) -> Result<()> {
    if target.exists() && !force {
        return Err(Error::Exists { path: target.to_owned() });
    }
    let standing = target.ancestors().skip(1).find(|p| p.as_os_str().is_empty() || p.exists());
    let folder = standing.filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match tempfile::Builder::new().prefix(IN_THE_MAKING).tempdir_in(folder) {
        Ok(_) => Ok(()),
        Err(e) => {
            // The rest of the system's words puzzle: a folder that stands but takes no entry is "not found".
            let why = match e.kind() {
                kind @ (ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem | ErrorKind::StorageFull) => {
                    format!(": {kind}")
                }
                _ => String::new(),
            };
            let accepted = format!("cannot be made: nothing can be written into {}{why}", folder.display());
            Err(Error::parameter("output", target.display(), accepted))
        }
    }
}

/// Clears what killed runs left in the making in a folder that is this program's own; what is kept to go on from stays.
///
/// # Errors
///
/// The system refuses.
pub fn sweep_own(folder: &Path) -> Result<()> {
    sweep(folder);
    let left = entries(folder).unwrap_or_default().into_iter().filter(|path| is_in_the_making(path) && path.is_dir());
    for path in left.filter(|path| !keeps(path)) {
        fs::remove_dir_all(&path).map_err(write_error(&path))?;
    }
    Ok(())
}

/// A folder in the making; no other process makes it meanwhile.
#[derive(Debug)]
pub struct StagedFolder {
    making: Making,
    /// What stays beside it when it is not put in its place.
    kept: Mutex<Vec<PathBuf>>,
}

impl StagedFolder {
    /// Whether a run may write to `target` at all; to be asked before the work begins. What killed runs left beside it is cleared.
    ///
    /// # Errors
    ///
    /// It exists and `force` is off, it is something that this program did not make, or another process is making it.
    pub fn check(target: &Path, force: bool) -> Result<()> {
        sweep_beside(target);
        Self::may_stand(target, force)?;
        Making::check(target)
    }

    fn may_stand(target: &Path, force: bool) -> Result<()> {
        vacant(target, force)?;
        match stranger(target).filter(|_| target.exists()) {
            None => Ok(()),
            Some(path) => {
                let accepted =
                    format!("--force replaces only a folder of an earlier run, and {} is none of its files", path.display());
                Err(Error::parameter("output", target.display(), accepted))
            }
        }
    }

    /// Takes the folder of an earlier run away, whole at once.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::check`] with `force`, or the system refuses.
    pub fn remove(target: &Path) -> Result<()> {
        Self::may_stand(target, true)?;
        let making = Making::new(target)?;
        // Under this name it is not put back.
        fs::rename(target, making.folder().join("new")).map_err(write_error(target))
    }

    /// Starts a folder that will stand at `target`.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::check`], or the folder cannot be made.
    pub fn new(target: &Path, force: bool) -> Result<Self> {
        Self::may_stand(target, force)?;
        let making = Making::new(target)?;
        // Another process may have put it there before its lock was free.
        Self::may_stand(target, force)?;
        fs::create_dir(making.new_one()).map_err(write_error(target))?;
        Ok(Self { making, kept: Mutex::default() })
    }

    /// Where to write meanwhile.
    pub fn path(&self) -> PathBuf {
        self.making.new_one()
    }

    /// Where to put a file that stays when the run ends before its folder stands, for a later run to find.
    pub fn keep(&self, name: &str) -> PathBuf {
        let path = self.making.kept(name);
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).push(path.clone());
        path
    }

    /// Whether a file is one of those that this run keeps.
    pub fn is_kept(&self, path: &Path) -> bool {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).iter().any(|kept| kept == path)
    }

    /// The folder where what is kept is.
    pub fn kept_in(&self) -> &Path {
        self.making.folder()
    }

    /// Puts the folder in its place, the earlier one aside until then, and takes away what was kept.
    ///
    /// # Errors
    ///
    /// The system refuses; the earlier folder then stands as it was.
    pub fn commit(self) -> Result<()> {
        sync_all(&self.path())?;
        self.making.put()?;
        for path in self.kept.into_inner().unwrap_or_else(PoisonError::into_inner) {
            // What stays is only found by the same run again.
            let _ = fs::remove_file(path);
        }
        Ok(())
    }
}

/// Brings the names in a folder and those below it onto the disk; their contents are there already.
fn sync_all(folder: &Path) -> Result<()> {
    for path in entries(folder).unwrap_or_default().into_iter().filter(|path| path.is_dir()) {
        sync_all(&path)?;
    }
    sync_folder(folder)
}

/// A file in the making; no other process makes it meanwhile.
#[derive(Debug)]
pub struct StagedFile {
    making: Making,
}

impl StagedFile {
    /// Whether a run may write to `target` at all; to be asked before the work begins. What killed runs left beside it is cleared.
    ///
    /// # Errors
    ///
    /// It exists and `force` is off, it is a folder, or another process is making it.
    pub fn check(target: &Path, force: bool) -> Result<()> {
        sweep_beside(target);
        Self::may_stand(target, force)?;
        Making::check(target)
    }

    fn may_stand(target: &Path, force: bool) -> Result<()> {
        if target.is_dir() {
            return Err(Error::parameter("output", target.display(), "is a folder; expected a file name"));
        }
        vacant(target, force)
    }

    /// Starts a file that will stand at `target`.
    ///
    /// # Errors
    ///
    /// As [`StagedFile::check`], or the file cannot be made.
    pub fn new(target: &Path, force: bool) -> Result<Self> {
        Self::may_stand(target, force)?;
        let making = Making::new(target)?;
        Self::may_stand(target, force)?;
        Ok(Self { making })
    }

    /// Where to write meanwhile.
    pub fn path(&self) -> PathBuf {
        self.making.new_one()
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    ///
    /// The system refuses; an earlier file then stands as it was.
    pub fn commit(self) -> Result<()> {
        self.making.put()
    }
}

/// Writes a file that takes the place of an earlier one whole or not at all.
///
/// # Errors
///
/// As [`write_file`]; the earlier one then stands.
pub fn replace_file(path: &Path, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> std::io::Result<()>) -> Result<()> {
    let unfinished = path.with_extension(UNFINISHED);
    let written = write_file(&unfinished, fill).and_then(|()| fs::rename(&unfinished, path).map_err(write_error(path)));
    if written.is_err() {
        // It may be what fills the disk.
        let _ = fs::remove_file(&unfinished);
    }
    written?;
    sync_folder(path.parent().unwrap_or(Path::new(".")))
}

/// Writes a file through a buffer and onto the disk, or says which file it was.
///
/// # Errors
///
/// Whatever the system or `fill` says, with the path.
pub fn write_file(path: &Path, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> std::io::Result<()>) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut out = BufWriter::new(DiskFile::create(path)?);
        fill(&mut out)?;
        out.into_inner()?.finish()
    };
    write().map_err(write_error(path))
}
