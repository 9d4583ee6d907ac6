//! Segmentation masks and images.

pub(crate) mod metaimage;
pub(crate) mod nifti;
pub(crate) mod numpy;
mod voxels;
