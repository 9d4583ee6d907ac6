//! What contacts are judged by: the centerlines alone, their mask, or an image too; and the features that each has.

use super::evidence::MASK_FEATURES;
use super::features::skeleton_feature_names;
use super::image::IMAGE_FEATURES;
use willis_io::masks::{Field, Scene};

/// What contacts are judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Basis {
    /// The centerlines alone.
    Skeleton,
    /// Their mask.
    Mask,
    /// The mask and an image beside it.
    Image,
}

impl Basis {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Skeleton, Self::Mask, Self::Image];

    /// By what is there: an image without a mask says nothing.
    pub fn of(mask: Option<&Field>, scene: Option<&Scene>) -> Self {
        match (mask, scene) {
            (None, _) => Self::Skeleton,
            (Some(_), None) => Self::Mask,
            (Some(_), Some(_)) => Self::Image,
        }
    }

    /// The names of the features, in their order.
    pub fn feature_names(self) -> Vec<String> {
        let named = |of: &str, names: &str| names.split(' ').map(|name| format!("{of}_{name}")).collect::<Vec<String>>();
        match self {
            Self::Skeleton => skeleton_feature_names(),
            Self::Mask => named("mask", MASK_FEATURES),
            Self::Image => [named("mask", MASK_FEATURES), named("image", IMAGE_FEATURES)].concat(),
        }
    }
}
