//! Which files of a set a killed command put in their places before the main one: the same command replaces them without being told to.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::files::{read_json, replace_file};
use super::in_progress::folder_of;
use super::lock::{identity, is_own_folder};
use super::names::SET;
use super::target::followed;
use willis_core::error::Result;

/// The files beside a main file that is not there yet.
#[derive(Debug)]
pub struct PartialSet {
    place: PathBuf,
    files: Vec<Member>,
}

/// A file of the set, known by its name and by what the file system calls it: another that was put there since is not it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Member {
    name: String,
    identity: [u64; 2],
}

impl Member {
    /// The file at a path, which is to be called as `target`.
    fn of(path: &Path, target: &Path) -> Option<Self> {
        let about = fs::symlink_metadata(path).ok().filter(Metadata::is_file)?;
        Some(Self { name: target.file_name()?.to_string_lossy().into_owned(), identity: identity(&about) })
    }
}

impl PartialSet {
    /// What was put beside `main`; nothing where that is there.
    pub fn of(main: &Path) -> Self {
        let place = followed(main);
        let folder = folder_of(&place);
        let is_partial = fs::symlink_metadata(&place).is_err() && is_own_folder(&folder);
        // One that was cut was written before any file was moved.
        let files = if is_partial { read_json(&folder.join(SET), "").unwrap_or_default() } else { Vec::new() };
        Self { place: folder.join(SET), files }
    }

    /// Whether a file was put there by the killed command.
    pub fn holds(&self, path: &Path) -> bool {
        Member::of(path, path).is_some_and(|file| self.files.contains(&file))
    }

    /// Records the files that are now moved from where they are staged to their targets, beside those of before.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    pub fn record<'a>(&mut self, files: impl Iterator<Item = (&'a Path, PathBuf)>) -> Result<()> {
        self.files.extend(files.filter_map(|(target, staged)| Member::of(&staged, target)));
        replace_file(&self.place, |out| Ok(serde_json::to_writer(out, &self.files)?))
    }
}
