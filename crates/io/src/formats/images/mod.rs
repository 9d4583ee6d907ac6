//! Segmentation masks and images.

use std::collections::BTreeMap;

use crate::masks::Mask;

pub(crate) mod metaimage;
pub(crate) mod nifti;
pub(crate) mod nrrd;
pub(crate) mod numpy;
mod pieces;
pub(crate) mod tiff;
mod voxels;

/// A mask with what its file says of its classes.
#[derive(Debug, Clone)]
pub struct Segmentation {
    /// The mask.
    pub mask: Mask,
    /// What classes are called; others are known by their number.
    pub names: BTreeMap<u8, String>,
    /// Notes for the user about how it was read, one line each.
    pub notes: Vec<String>,
}

impl From<Mask> for Segmentation {
    fn from(mask: Mask) -> Self {
        Self { mask, names: BTreeMap::new(), notes: Vec::new() }
    }
}
