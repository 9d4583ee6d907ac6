//! Features of the gap: how far, in widths and in spacings.

use super::span::Span;

/// A gap in widths beyond which it is just long.
const MOST_WIDTHS: f64 = 10.0;
/// The least distance to a wall, in spacings.
const LEAST_WALL: f64 = 0.5;

/// ln d/D: d the gap, D the child's width. Gestalt proximity; a gap is as long as the vessels are wide (inference.md §5).
pub fn log_gap(s: &Span) -> f64 {
    (s.gap / s.width()).ln()
}

/// min(d/D, 10): long gaps are rarer than their logarithm says.
pub fn gap(s: &Span) -> f64 {
    (s.gap / s.width()).min(MOST_WIDTHS)
}

/// ln d/h: h the spacing; gaps of one voxel are dropouts of the segmentation.
pub fn log_gap_in_spacings(s: &Span) -> f64 {
    (s.gap / s.extraction.spacing).ln()
}

/// ln max(d - r, h/2)/D with r the parent's radius where it is met on its way: the gap to its wall, not to its axis.
pub fn log_gap_to_wall(s: &Span) -> f64 {
    let wall = s.gap - s.on_the_way() * s.parent_radius;
    (wall.max(LEAST_WALL * s.extraction.spacing) / s.width()).ln()
}

/// ln of path along the vessels over gap, at most 200, of a bridge within a fragment; 0 between fragments.
pub fn log_detour(s: &Span) -> f64 {
    s.detour.map_or(0.0, f64::ln)
}
