//! The ending of a file's name: `.swc`, and `.nii.gz` as one.

use std::path::{Path, PathBuf};

/// A path without its ending: `scan` of `scan.swc`, `scan.nii.gz` and `scan.swc.gz`.
pub fn without_ending(path: &Path) -> PathBuf {
    let bare = path.with_extension("");
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz")) { bare.with_extension("") } else { bare }
}

/// The name of a file without its ending.
pub fn stem(path: &Path) -> String {
    without_ending(path).file_name().unwrap_or_default().to_string_lossy().into_owned()
}
