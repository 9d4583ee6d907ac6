//! The place of an output: where a link leads, and what cannot be replaced, which is said before the work begins.

use std::path::{Path, PathBuf};
use std::{fs, io::ErrorKind};

use willis_core::error::{Error, Result};

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
    let refused = |accepted: &str| Err(Error::parameter("output", target.display(), accepted));
    if fs::symlink_metadata(target).is_err_and(|e| e.kind() == ErrorKind::InvalidFilename) {
        let bytes = target.file_name().unwrap_or_default().len();
        return refused(&format!("its name has {bytes} bytes, more than the file system takes; choose a shorter one"));
    }
    let there = target.exists();
    if !there && fs::symlink_metadata(target).is_ok() {
        return refused("is a link to nothing; remove it, or name what it is to point to");
    }
    if there && !force {
        return Err(Error::Exists { path: target.to_owned() });
    }
    let place = followed(target);
    if there {
        if !place.is_file() && !place.is_dir() {
            return refused("is a device or a pipe; expected the name of a file or a folder");
        }
        if is_current(&place) {
            return refused(
                "is the current folder or has it in it, which cannot be replaced; expected the name of another folder",
            );
        }
        if is_mounted(&place) {
            return refused("is where a file system is mounted, which cannot be replaced; expected the name of a folder in it");
        }
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
            refused(&format!("cannot be made: nothing can be written into {}{why}", folder.display()))
        }
    }
}

/// Whether a folder is the one in which the process is, or has that in it.
fn is_current(place: &Path) -> bool {
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    here.ok().zip(place.canonicalize().ok()).is_some_and(|(here, place)| here.starts_with(place))
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
