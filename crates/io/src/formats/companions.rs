//! Finds the other files of an input in its folder, by its format: the second of two tables, the files of an iCafe tracing, voxels.

use std::path::{Path, PathBuf};

use super::images::{metaimage, nrrd};
use super::tables::pairs::{find_nodes_table, head, other_table};
use super::vendors::icafe::{IMAGE, TABLE_OF_VESSELS, find, find_tracing, image_spacing};
use super::{Format, FormatTrait, format::format_of, input::without_mark};

/// The other files that [`read`](super::read) reads for `path`, as the folder is now, sorted by name.
pub fn companion_files(path: &Path) -> Vec<PathBuf> {
    let head = head(path);
    let bytes = without_mark(&head);
    let found = match format_of(path, bytes) {
        Ok(Format::Csv) => [find_nodes_table(path), None],
        Ok(Format::Voreen | Format::VesselVio) => [other_table(path, bytes).ok().and_then(|(_, other)| other), None],
        Ok(Format::Swc) => [find(path, TABLE_OF_VESSELS), find(path, IMAGE)],
        Ok(Format::ICafe) => [find_tracing(path).ok(), find(path, IMAGE)],
        Ok(Format::MetaImage) => [metaimage::file_of_voxels(path, bytes), None],
        Ok(Format::Nrrd) => [nrrd::file_of_voxels(path, bytes), None],
        _ => [None, None],
    };
    let mut found: Vec<PathBuf> = found.into_iter().flatten().collect();
    found.sort();
    found
}

/// Where the voxel spacing of an input is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatedSpacing {
    /// In the file itself, whose coordinates are in mm.
    Within,
    /// In a file beside it, in mm: its coordinates are in voxels.
    Beside(f64),
    /// Nowhere.
    Nowhere,
}

/// Where the voxel spacing of an input is stated: most masks state their own, and Image_info.txt that of an iCafe tracing beside it.
///
/// # Errors
///
/// A file beside it that is there and cannot be read.
pub fn stated_spacing(path: &Path) -> willis_core::error::Result<StatedSpacing> {
    let head = head(path);
    let format = format_of(path, without_mark(&head)).ok();
    let is = |what: FormatTrait| format.is_some_and(|format| format.is(what));
    if is(FormatTrait::OwnSpacing) {
        return Ok(StatedSpacing::Within);
    }
    let beside = if is(FormatTrait::SpacingBeside) { image_spacing(path)? } else { None };
    Ok(beside.map_or(StatedSpacing::Nowhere, StatedSpacing::Beside))
}
