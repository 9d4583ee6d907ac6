//! Output that appears whole or not at all: written beside its place, then renamed.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::{Error, Result};

/// The record by which a folder of this program is known.
const MARK: &str = "run.json";
/// All that such a folder may hold; --force replaces no folder with anything else in it.
const FILES: &[&str] = &[
    "edges.csv",
    "nodes.csv",
    "likelihood.npy",
    "likelihood.npz",
    "likelihood.png",
    "likelihood.svg",
    "convergence.png",
    "convergence.svg",
    "flow.png",
    "flow.svg",
    MARK,
    "report.html",
    "candidates.graphml",
    "topology.graphml",
    "topology.vtp",
    "topology.swc",
    "topology-median.graphml",
    "topology-median.vtp",
    "classes.csv",
    "hypertension.csv",
    "samples.npz",
    "modulation.png",
    "modulation.svg",
    "hypertension.png",
    "hypertension.svg",
    "phenotype.json",
    "phenotype.csv",
    "collateral.csv",
];
const AGREEMENT: &str = "agreement.csv";
/// The record by which the folder of a cohort is known.
pub const COHORT_MARK: &str = "cohort.json";
/// What such a folder holds beside the folders of its subjects.
const COHORT_FILES: &[&str] = &[COHORT_MARK, "cohort.csv", "cohort.html"];
/// How the name of everything in the making begins.
pub const IN_THE_MAKING: &str = ".willis-";

/// The paths in a folder; `None` when it cannot be read.
fn entries(folder: &Path) -> Option<Vec<PathBuf>> {
    fs::read_dir(folder).ok()?.map(|entry| entry.ok().map(|e| e.path())).collect()
}

fn is_named(path: &Path, names: &[&str]) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| names.contains(&name))
}

/// The first path in a folder that no run of this program made; `None` when all are ours, or there are none.
fn stranger(folder: &Path) -> Option<PathBuf> {
    let Some(paths) = entries(folder) else { return Some(folder.to_owned()) };
    let record = |mark| fs::read(folder.join(mark)).ok().and_then(|b| serde_json::from_slice::<serde_json::Value>(&b).ok());
    let is_ours = |mark| record(mark).is_some_and(|r| r.get("willis").is_some());
    if folder.join(MARK).exists() {
        return if is_ours(MARK) { paths.into_iter().find(|p| !is_named(p, FILES)) } else { Some(folder.join(MARK)) };
    }
    if folder.join(COHORT_MARK).exists() {
        let of_cohort =
            |path: PathBuf| if path.is_dir() { stranger(&path) } else { (!is_named(&path, COHORT_FILES)).then_some(path) };
        let mut rest = paths.into_iter().filter(|path| !is_in_the_making(path));
        return if is_ours(COHORT_MARK) { rest.find_map(of_cohort) } else { Some(folder.join(COHORT_MARK)) };
    }
    paths.into_iter().find_map(|path| {
        if path.is_dir() && path.join(MARK).exists() {
            return stranger(&path);
        }
        (!is_named(&path, &[AGREEMENT])).then_some(path)
    })
}

/// Whether a path is the temporary of a run that is at work, or was killed.
fn is_in_the_making(path: &Path) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with(IN_THE_MAKING))
}

/// Removes what killed runs left in the making in a folder.
///
/// # Errors
///
/// The system refuses.
pub fn sweep(folder: &Path) -> Result<()> {
    for path in entries(folder).unwrap_or_default().into_iter().filter(|path| is_in_the_making(path) && path.is_dir()) {
        fs::remove_dir_all(&path).map_err(write_error(&path))?;
    }
    Ok(())
}

fn write_error(path: &Path) -> impl Fn(std::io::Error) -> Error + '_ {
    move |source| Error::Write { path: path.to_owned(), source }
}

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
            let accepted = format!("{} cannot be written to: {}", folder.display(), e.kind());
            Err(Error::parameter("--output", target.display(), accepted))
        }
    }
}

/// A hidden folder beside `target`, with its missing parents made.
fn beside(target: &Path) -> Result<TempDir> {
    let parent = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(write_error(parent))?;
    tempfile::Builder::new().prefix(IN_THE_MAKING).tempdir_in(parent).map_err(write_error(target))
}

/// A folder in the making.
#[derive(Debug)]
pub struct StagedFolder {
    target: PathBuf,
    temporary: TempDir,
}

impl StagedFolder {
    /// Whether a run may write to `target` at all; to be asked before the work begins.
    ///
    /// # Errors
    ///
    /// It exists and `force` is off, or it is something that this program did not make.
    pub fn check(target: &Path, force: bool) -> Result<()> {
        vacant(target, force)?;
        match stranger(target).filter(|_| target.exists()) {
            None => Ok(()),
            Some(path) => {
                let accepted =
                    format!("--force replaces only a folder of an earlier run, and {} is none of its files", path.display());
                Err(Error::parameter("--output", target.display(), accepted))
            }
        }
    }

    /// Takes the folder of an earlier run away, whole at once.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::check`] with `force`, or the system refuses.
    pub fn remove(target: &Path) -> Result<()> {
        Self::check(target, true)?;
        let temporary = beside(target)?;
        fs::rename(target, temporary.path().join("old")).map_err(write_error(target))
    }

    /// Starts a folder that will stand at `target`.
    ///
    /// # Errors
    ///
    /// As [`StagedFolder::check`], or the folder cannot be made.
    pub fn new(target: &Path, force: bool) -> Result<Self> {
        Self::check(target, force)?;
        let temporary = beside(target)?;
        fs::create_dir(temporary.path().join("new")).map_err(write_error(target))?;
        Ok(Self { target: target.to_owned(), temporary })
    }

    /// Where to write meanwhile.
    pub fn path(&self) -> PathBuf {
        self.temporary.path().join("new")
    }

    /// Puts the folder in its place, the earlier one aside until then.
    ///
    /// # Errors
    ///
    /// The system refuses; the earlier folder then stands as it was.
    pub fn commit(self) -> Result<()> {
        let error = write_error(&self.target);
        let old = self.temporary.path().join("old");
        let replaces = self.target.exists();
        if replaces {
            fs::rename(&self.target, &old).map_err(&error)?;
        }
        if let Err(source) = fs::rename(self.path(), &self.target) {
            if replaces {
                fs::rename(&old, &self.target).map_err(&error)?;
            }
            return Err(error(source));
        }
        Ok(())
    }
}

/// A file in the making.
#[derive(Debug)]
pub struct StagedFile {
    target: PathBuf,
    temporary: TempDir,
}

impl StagedFile {
    /// Whether a run may write to `target` at all; to be asked before the work begins.
    ///
    /// # Errors
    ///
    /// It exists and `force` is off, or it is a folder.
    pub fn check(target: &Path, force: bool) -> Result<()> {
        if target.is_dir() {
            return Err(Error::parameter("--output", target.display(), "is a folder; expected a file name"));
        }
        vacant(target, force)
    }

    /// Starts a file that will stand at `target`.
    ///
    /// # Errors
    ///
    /// As [`StagedFile::check`], or the folder cannot be made.
    pub fn new(target: &Path, force: bool) -> Result<Self> {
        Self::check(target, force)?;
        Ok(Self { target: target.to_owned(), temporary: beside(target)? })
    }

    /// Where to write meanwhile.
    pub fn path(&self) -> PathBuf {
        self.temporary.path().join("new")
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    ///
    /// The system refuses.
    pub fn commit(self) -> Result<()> {
        fs::rename(self.path(), &self.target).map_err(write_error(&self.target))
    }
}

/// Writes the record of a run into its folder.
///
/// # Errors
///
/// As [`write_file`].
pub fn write_record(folder: &Path, record: &impl serde::Serialize) -> Result<()> {
    write_file(&folder.join(MARK), |out| {
        serde_json::to_writer_pretty(&mut *out, record)?;
        out.write_all(b"\n")
    })
}

/// Writes a file through a buffer and onto the disk, or says which file it was.
///
/// # Errors
///
/// Whatever the system or `fill` says, with the path.
pub fn write_file(path: &Path, fill: impl FnOnce(&mut std::io::BufWriter<fs::File>) -> std::io::Result<()>) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut out = std::io::BufWriter::new(fs::File::create(path)?);
        fill(&mut out)?;
        out.into_inner()?.sync_all()
    };
    write().map_err(write_error(path))
}
