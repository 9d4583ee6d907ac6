//! What is measured of a whole fragment: its size, its ends, and the spread of its radii.

use crate::candidates::search::free_ends::FreeEnd;
use willis_core::network::may_be_speck;

/// What may be a speck is joined over no gap wider than so many of its lengths.
const SPECK_REACH: f64 = 2.0;

/// A connected part of what the image showed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fragment {
    /// The length of its vessels, m.
    pub length: f64,
    /// The geometric mean of its points' radii, m.
    pub radius: f64,
    /// The radius of its widest free end, m.
    pub widest_end: Option<f64>,
    /// The standard deviation of ln of its points' radii, averaged along the branches.
    pub radius_spread: f64,
    /// How many free ends it has.
    pub free_ends: usize,
    /// How many junctions it has.
    pub junctions: usize,
    /// Whether it holds an inlet.
    pub fed: bool,
}

impl Fragment {
    /// The widest gap (m) over which an automatic skeleton's fragment may be joined; infinite but for what may be a speck.
    pub fn reach(&self) -> f64 {
        if may_be_speck(self.length, 2.0 * self.radius) { SPECK_REACH * self.length } else { f64::INFINITY }
    }

    /// The radius (m) of its widest free end, half a spacing at least.
    pub fn end_radius(&self, spacing: f64) -> f64 {
        self.widest_end.unwrap_or(0.0).max(0.5 * spacing)
    }
}

/// The largest figures of an extraction, beside which those of its fragments and ends are measured.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Largest {
    /// Length of a fragment, m.
    pub length: f64,
    /// Radius of a free end, m.
    pub end: f64,
    /// Radius of a fragment's widest free end, half a spacing at least, m.
    pub fragment_end: f64,
}

impl Largest {
    /// Those of some fragments and free ends.
    pub fn of(fragments: &[Fragment], ends: &[FreeEnd], spacing: f64) -> Self {
        let most = |figures: &mut dyn Iterator<Item = f64>| figures.fold(0.0, f64::max);
        Self {
            length: most(&mut fragments.iter().map(|f| f.length)),
            end: most(&mut ends.iter().map(|end| end.radius)),
            fragment_end: most(&mut fragments.iter().map(|f| f.end_radius(spacing))),
        }
    }
}
