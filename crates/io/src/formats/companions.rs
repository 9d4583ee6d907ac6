//! Finds the other files of an input in its folder, by its format: the second of two tables, the files of an iCafe tracing, voxels.

use std::path::{Path, PathBuf};

use crate::formats::format::{Format, format_of};
use crate::formats::images::{metaimage, nrrd};
use crate::formats::input::without_mark;
use crate::formats::tables::pairs::{find_nodes_table, head, other_table};
use crate::formats::vendors::icafe::{IMAGE, TABLE_OF_VESSELS, find, find_tracing, image_spacing};
use willis_core::error::Result;

/// The other files that [`read`](super::read::read) reads for `path`, as the folder is now, sorted by name.
pub fn companion_files(path: &Path) -> Vec<PathBuf> {
    let head = head(path);
    let bytes = without_mark(&head);
    let mut found: Vec<PathBuf> = match format_of(path, bytes) {
        Ok(Format::Csv) => find_nodes_table(path).into_iter().collect(),
        Ok(Format::Voreen | Format::VesselVio) => {
            other_table(path, bytes).ok().and_then(|(_, other)| other).into_iter().collect()
        }
        Ok(Format::Swc) => [find(path, TABLE_OF_VESSELS), find(path, IMAGE)].into_iter().flatten().collect(),
        Ok(Format::ICafe) => [find_tracing(path).ok(), find(path, IMAGE)].into_iter().flatten().collect(),
        Ok(Format::MetaImage) => metaimage::file_of_voxels(path, bytes).into_iter().collect(),
        Ok(Format::Nrrd) => nrrd::file_of_voxels(path, bytes).into_iter().collect(),
        _ => Vec::new(),
    };
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

/// Where the voxel spacing of an input is stated: a mask in NIfTI, MetaImage, NRRD or TIFF states its own, and Image_info.txt that of an iCafe tracing
/// beside it.
///
/// # Errors
///
/// A file beside it that is there and cannot be read.
pub fn stated_spacing(path: &Path) -> Result<StatedSpacing> {
    let head = head(path);
    Ok(match format_of(path, without_mark(&head)) {
        Ok(Format::Nifti | Format::MetaImage | Format::Nrrd | Format::Tiff) => StatedSpacing::Within,
        Ok(Format::Swc | Format::ICafe) => image_spacing(path)?.map_or(StatedSpacing::Nowhere, StatedSpacing::Beside),
        _ => StatedSpacing::Nowhere,
    })
}
