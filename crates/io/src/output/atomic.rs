//! Output that appears complete or not at all: written next to its place, flushed to the disk, then renamed.

use std::fs::{self, Metadata};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use super::in_progress::{check_file_size, check_vacant, entries, folder_of, followed, sync_folder};
use super::lock::{identity, is_own_folder};
use super::{InProgress, files::DiskFile, names::SET, own_files::foreign_file, read_json, replace_file, write_error, write_file};
use willis_core::error::{Error, Result, require};

/// An output folder being written; no other process can write it at the same time.
#[derive(Debug)]
pub struct StagedFolder {
    in_progress: InProgress,
    /// Files that stay if the run ends before the folder is complete.
    kept: Mutex<Vec<PathBuf>>,
}

impl StagedFolder {
    /// Checks, before the work begins, that a run may write to `target`. Removes what a killed run left of it.
    ///
    /// # Errors
    ///
    /// It exists and `force` is off, it holds files that willis did not write, or another process is writing it.
    pub fn check(target: &Path, force: bool) -> Result<()> {
        InProgress::check(target, || Self::check_target(target, force).and_then(|()| check_file_size(target)))
    }

    fn check_target(target: &Path, force: bool) -> Result<()> {
        check_vacant(target, force)?;
        match foreign_file(target).filter(|_| target.exists()) {
            None => Ok(()),
            Some(path) => {
                let accepted =
                    format!("`force` replaces only a folder of an earlier run, and {} is not one of its files", path.display());
                Err(Error::parameter("output", target.display(), accepted))
            }
        }
    }

    /// Removes the folder of an earlier run in one step.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::check`] with `force`, or the system refuses.
    pub fn remove(target: &Path) -> Result<()> {
        let in_progress = InProgress::of_vacant(target, || Self::check_target(target, true))?;
        // Under this name it is not moved back.
        fs::rename(&in_progress.target, in_progress.new_path()).map_err(write_error(target))
    }

    /// Starts a folder that will replace `target`.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::check`], or the folder cannot be made.
    pub fn new(target: &Path, force: bool) -> Result<Self> {
        let in_progress = InProgress::of_vacant(target, || Self::check_target(target, force))?;
        fs::create_dir(in_progress.new_path()).map_err(write_error(target))?;
        Ok(Self { in_progress, kept: Mutex::default() })
    }

    /// Fills a folder that appears complete or not at all; an earlier one is replaced with `force`.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::new`], `write` and [`StagedFolder::commit`].
    pub fn fill<T>(target: &Path, force: bool, write: impl FnOnce(&Self) -> Result<T>) -> Result<T> {
        let folder = Self::new(target, force)?;
        let written = write(&folder)?;
        folder.commit()?;
        Ok(written)
    }

    /// Where to write until then.
    pub fn path(&self) -> PathBuf {
        self.in_progress.new_path()
    }

    /// The path of a file that stays if the run ends early, so that a later run can continue from it.
    pub fn keep(&self, name: &str) -> PathBuf {
        let path = self.in_progress.kept(name);
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).push(path.clone());
        path
    }

    /// Whether a file is a checkpoint of this run.
    pub fn is_kept(&self, path: &Path) -> bool {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).iter().any(|kept| kept == path)
    }

    /// The folder with the checkpoints.
    pub fn checkpoint_folder(&self) -> &Path {
        &self.in_progress.folder
    }

    /// Moves the folder to its place, with the earlier one set aside until then, and removes the checkpoints.
    ///
    /// # Errors
    ///
    /// The system refuses; the earlier folder then stays as it was.
    pub fn commit(self) -> Result<()> {
        sync_all(&self.path())?;
        self.in_progress.put()?;
        for path in self.kept.into_inner().unwrap_or_else(PoisonError::into_inner) {
            // One that stays is used only by the same run again.
            let _ = fs::remove_file(path);
        }
        Ok(())
    }
}

/// Flushes the names in a folder and below it to the disk; the contents are there already.
fn sync_all(folder: &Path) -> Result<()> {
    entries(folder).unwrap_or_default().iter().filter(|path| path.is_dir()).try_for_each(|path| sync_all(path))?;
    sync_folder(folder)
}

/// The output files of one command, such as a table and the one beside it; no other process can write them at the same time. All are staged before
/// the first is moved to its place, and the main one, which was named, is moved last. Where that is there all are there; where a kill left some
/// without it, the same command replaces them without `force`.
#[derive(Debug)]
pub struct StagedFiles {
    /// By their targets; the main file first.
    files: Vec<(PathBuf, InProgress)>,
    /// What a killed command put beside the main file.
    partial: PartialSet,
    force: bool,
}

impl StagedFiles {
    /// Checks, before the work begins, that a command may write to `main` and to `others` beside it. Removes what a killed run left of them.
    ///
    /// # Errors
    ///
    /// One of them exists and `force` is off, it is a folder, or another process is writing it.
    pub fn check<'a>(main: &Path, others: impl IntoIterator<Item = &'a PathBuf>, force: bool) -> Result<()> {
        let partial = PartialSet::of(main);
        let check = |path: &Path, force: bool| InProgress::check(path, || Self::check_target(path, force));
        check(main, force)?;
        others.into_iter().try_for_each(|path| check(path, force || partial.holds(path)))
    }

    fn check_target(target: &Path, force: bool) -> Result<()> {
        require(!target.is_dir(), "output", target.display(), "is a folder; expected a file name")?;
        check_vacant(target, force)
    }

    /// Starts a set with its main file.
    ///
    /// # Errors
    ///
    /// As [`StagedFiles::check`], or the file cannot be made.
    pub fn new(main: &Path, force: bool) -> Result<Self> {
        let file = Self::stage(main, force)?;
        Ok(Self { files: vec![(main.to_owned(), file)], partial: PartialSet::of(main), force })
    }

    /// Starts a file that will replace `target`.
    fn stage(target: &Path, force: bool) -> Result<InProgress> {
        InProgress::of_vacant(target, || Self::check_target(target, force))
    }

    /// Writes one file that appears complete or not at all; an earlier one is replaced with `force`.
    ///
    /// # Errors
    ///
    /// As [`StagedFiles::new`] and [`write_file`].
    pub fn write_one(target: &Path, force: bool, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> io::Result<()>) -> Result<()> {
        let file = Self::new(target, force)?;
        file.write_main(fill)?;
        file.commit().map(drop)
    }

    /// Where to write the main file.
    pub fn path(&self) -> PathBuf {
        self.files[0].1.new_path()
    }

    /// Starts one more file; where to write it.
    ///
    /// # Errors
    ///
    /// As [`StagedFiles::new`].
    pub fn add(&mut self, path: &Path) -> Result<PathBuf> {
        let file = Self::stage(path, self.force || self.partial.holds(path))?;
        let place = file.new_path();
        self.files.push((path.to_owned(), file));
        Ok(place)
    }

    /// Writes one more file.
    ///
    /// # Errors
    ///
    /// As [`StagedFiles::add`] and [`write_file`].
    pub fn write(&mut self, path: &Path, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> io::Result<()>) -> Result<()> {
        write_file(&self.add(path)?, fill)
    }

    /// Writes the main file.
    ///
    /// # Errors
    ///
    /// As [`write_file`].
    pub fn write_main(&self, fill: impl FnOnce(&mut BufWriter<DiskFile>) -> io::Result<()>) -> Result<()> {
        write_file(&self.path(), fill)
    }

    /// Moves the files to their places, the main one last; their paths, the main one first.
    ///
    /// # Errors
    ///
    /// The system refuses; the main file then stays as it was, and the same command can be given again.
    pub fn commit(mut self) -> Result<Vec<PathBuf>> {
        let paths = self.files.iter().map(|(path, _)| path.clone()).collect();
        if self.files.len() > 1 {
            self.partial.record(self.files[1..].iter().map(|(path, file)| (path.as_path(), file.new_path())))?;
        }
        // Each gives its lock back before the next is moved.
        self.files.rotate_left(1);
        self.files.into_iter().try_for_each(|(_, file)| file.put())?;
        Ok(paths)
    }
}

/// The files beside a main file that is not there yet, which a killed command put in their places: the same command replaces them without being
/// told to.
#[derive(Debug)]
struct PartialSet {
    place: PathBuf,
    files: Vec<Member>,
}

/// A file of the set, known by its name, by what the file system calls it and by when it was written: another that was put there since is not it, even
/// where the file system gives it the number of one that is gone.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
struct Member {
    name: String,
    identity: [u64; 2],
    modified: SystemTime,
}

impl Member {
    /// The file at a path, which is to be called as `target`.
    fn of(path: &Path, target: &Path) -> Option<Self> {
        let about = fs::symlink_metadata(path).ok().filter(Metadata::is_file)?;
        let name = target.file_name()?.to_string_lossy().into_owned();
        Some(Self { name, identity: identity(&about), modified: about.modified().ok()? })
    }
}

impl PartialSet {
    /// What was put beside `main`; nothing where that is there.
    fn of(main: &Path) -> Self {
        let place = followed(main);
        let folder = folder_of(&place);
        let is_partial = fs::symlink_metadata(&place).is_err() && is_own_folder(&folder);
        // One that was cut was written before any file was moved.
        let files = if is_partial { read_json(&folder.join(SET), "").unwrap_or_default() } else { Vec::new() };
        Self { place: folder.join(SET), files }
    }

    /// Whether a file was put there by the killed command.
    fn holds(&self, path: &Path) -> bool {
        Member::of(path, path).is_some_and(|file| self.files.contains(&file))
    }

    /// Records the files that are now moved from where they are staged to their targets, beside those of before.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    fn record<'a>(&mut self, files: impl Iterator<Item = (&'a Path, PathBuf)>) -> Result<()> {
        self.files.extend(files.filter_map(|(target, staged)| Member::of(&staged, target)));
        replace_file(&self.place, |out| Ok(serde_json::to_writer(out, &self.files)?))
    }
}
