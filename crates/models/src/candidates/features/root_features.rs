//! Features of a fragment as a root: an inlet's tree, or no vessel at all.

use ndarray::Array2;

use super::candidate_features::{share, slenderness};
use super::extraction::Extraction;
use super::fragment::Fragment;

/// A feature of a fragment.
pub type RootFeature = fn(&Extraction, &Fragment) -> f64;

/// The features of a root, by name. Their products with the clutter let a whole brain of a hundred fragments and a circle of
/// ten differ: in a circle an inlet's tree is often a root, in a brain it is one of several parts of one tree.
pub const ROOT_FEATURES: &[(&str, RootFeature)] = &[
    // 1: how readily a fragment is a root.
    ("one", |_, _| 1.0),
    ("inlet", inlet),
    ("slim", slenderness),
    ("share", share),
    ("width", relative_width),
    ("resolution", width_in_spacings),
    ("clutter", clutter),
    ("radius_variation", radius_variation),
    // ln of the number of its free ends, at least 0: what branches is a vessel, and has more ends to be attached by.
    ("free_ends", |_, fragment| (fragment.free_ends as f64).max(1.0).ln()),
    // ln of one more than the number of its junctions.
    ("junctions", |_, fragment| (fragment.junctions as f64).ln_1p()),
    ("inlet_clutter", |e, f| inlet(e, f) * clutter(e, f)),
    ("slim_clutter", |e, f| slenderness(e, f) * clutter(e, f)),
    ("share_clutter", |e, f| share(e, f) * clutter(e, f)),
    ("width_clutter", |e, f| relative_width(e, f) * clutter(e, f)),
];

/// ln of a middling number of fragments.
const USUAL_CLUTTER: f64 = 3.0;
/// Bound of the variation of the radius.
const MOST_VARIATION: f64 = 0.6;

/// The features of every fragment as a root: a row a fragment, a column a feature of [`ROOT_FEATURES`].
pub fn root_features(extraction: &Extraction) -> Array2<f64> {
    let fragments = &extraction.fragments;
    Array2::from_shape_fn((fragments.len(), ROOT_FEATURES.len()), |(row, column)| {
        ROOT_FEATURES[column].1(extraction, &fragments[row])
    })
}

/// Whether it holds an inlet, 1 or 0.
pub fn inlet(_: &Extraction, fragment: &Fragment) -> f64 {
    if fragment.fed { 1.0 } else { 0.0 }
}

/// ln of the radius of its widest free end over that of the widest fragment's.
pub fn relative_width(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.end_radius(extraction.spacing) / extraction.largest.fragment_end).ln()
}

/// ln of the radius of its widest free end in spacings.
pub fn width_in_spacings(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.end_radius(extraction.spacing) / extraction.spacing).ln()
}

/// ln of the number of fragments, less 3: the more there are, the more are false.
pub fn clutter(extraction: &Extraction, _: &Fragment) -> f64 {
    (extraction.fragments.len() as f64).ln() - USUAL_CLUTTER
}

/// The standard deviation of ln of its radii along it, at most 0.6: vessels taper, noise has any radius.
pub fn radius_variation(_: &Extraction, fragment: &Fragment) -> f64 {
    fragment.radius_spread.min(MOST_VARIATION)
}
