//! Features of the gap: how far, in widths of the child, and how far it is to the parent's wall.
//!
//! d is the gap, D = 2 r + h the child's width, h the spacing.

use super::span::Span;

/// A gap in widths beyond which it is just long.
const MOST_WIDTHS: f64 = 10.0;
/// The least distance to a wall in [`log_gap_to_wall`], in spacings.
const LEAST_WALL: f64 = 0.5;
/// A child so many widths from the wall touches it ...
const TOUCH: f64 = 0.6;
/// ... and beyond so many it is out of its reach, and far out of it.
const REACH: f64 = 1.5;
const FAR_REACH: f64 = 3.0;

/// min(d/D, 10). Gestalt proximity: a gap is as long as the vessels are wide (inference.md §5).
pub fn gap(s: &Span) -> f64 {
    (s.gap / s.width()).min(MOST_WIDTHS)
}

/// [`gap`] where the parent is met at a free end, else 0: breaks and lost branches have gaps of their own lengths.
pub fn gap_at_free_end(s: &Span) -> f64 {
    (1.0 - s.on_the_way()) * gap(s)
}

/// [`gap`] where the parent is met on its way, else 0.
pub fn gap_on_the_way(s: &Span) -> f64 {
    s.on_the_way() * gap(s)
}

/// ln max(d - r, h/2)/D with r the parent's radius where it is met on its way: the gap to its wall, not to its axis.
pub fn log_gap_to_wall(s: &Span) -> f64 {
    let wall = s.gap - s.on_the_way() * s.parent_radius;
    (wall.max(LEAST_WALL * s.extraction.spacing) / s.width()).ln()
}

/// The gap to the wall in widths where the parent is met on its way, else 0: a branch begins at the wall of its parent.
pub fn wall_on_the_way(s: &Span) -> f64 {
    s.on_the_way() * wall(s)
}

/// How many widths the gap to the wall is beyond 1.5, at least 0: what falls with distance falls otherwise near and far.
pub fn wall_beyond_reach(s: &Span) -> f64 {
    (wall(s) - REACH).max(0.0)
}

/// How many widths the gap to the wall is beyond 3, at least 0.
pub fn wall_far_beyond_reach(s: &Span) -> f64 {
    (wall(s) - FAR_REACH).max(0.0)
}

/// Whether the gap to the wall of a parent met on its way is below 0.6 widths, 1 or 0: no more than what thinning takes away.
pub fn touches_wall(s: &Span) -> f64 {
    if wall(s) < TOUCH { s.on_the_way() } else { 0.0 }
}

/// ln D/h where the parent is met on its way, else 0: branches of well resolved vessels are lost less.
pub fn log_width_on_the_way(s: &Span) -> f64 {
    s.on_the_way() * (s.width() / s.extraction.spacing).ln()
}

/// ln of path along the vessels over gap, at most 200, of a bridge within a fragment; 0 between fragments.
pub fn log_detour(s: &Span) -> f64 {
    s.detour.map_or(0.0, f64::ln)
}

/// max(d - r, 0)/D, at most 10: r the parent's radius where it is met on its way, else 0.
fn wall(s: &Span) -> f64 {
    ((s.gap - s.on_the_way() * s.parent_radius).max(0.0) / s.width()).min(MOST_WIDTHS)
}
