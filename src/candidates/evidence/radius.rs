//! Features of the radii: whether the two vessels could be one, or the one a branch of the other.

use super::span::Span;
use super::steady::steady;

/// |ln r_c/r_p| where two free ends meet, else 0: one vessel keeps its radius across a gap.
pub fn radius_step(s: &Span) -> f64 {
    (1.0 - s.on_the_way()) * log_ratio(s).abs()
}

/// max(ln r_c/r_p, 0) where the parent is met on its way, else 0: a branch is no wider than its parent (Murray's law).
pub fn too_wide(s: &Span) -> f64 {
    s.on_the_way() * log_ratio(s).max(0.0)
}

/// ln of the radius behind the child's end over that of the end: a vessel tapers towards its true end.
pub fn taper(s: &Span) -> f64 {
    s.child.taper
}

/// Whether the child is the widest free end of its fragment, 1 or 0: a fragment hangs on its thick end.
pub fn widest_end(s: &Span) -> f64 {
    let widest = s.extraction.fragments[s.child.fragment].widest_end;
    if widest.is_some_and(|w| steady(s.child.radius / w) >= 1.0) { 1.0 } else { 0.0 }
}

/// ln of the thinner of the two radii over that of the widest free end of all: bridges of a circle are thick vessels.
pub fn relative_size(s: &Span) -> f64 {
    let widest = s.extraction.ends.iter().map(|end| end.radius).fold(0.0, f64::max);
    (s.child.radius.min(s.parent_radius) / widest).ln()
}

/// r_c the child's radius over r_p the parent's.
fn log_ratio(s: &Span) -> f64 {
    (s.child.radius / s.parent_radius).ln()
}
