//! Segmentation masks and images.

pub(crate) mod metaimage;
pub(crate) mod nifti;
pub(crate) mod nrrd;
pub(crate) mod numpy;
pub(crate) mod stored_image;
pub(crate) mod tiff;
pub(crate) mod voxels;
