//! Features of the radii: whether the two vessels could be one, or the one a branch of the other.
//!
//! r_c is the child's radius, r_p the parent's.

use super::span::Span;

/// Bound of the step between two free ends before it is squared, in ln.
const MOST_STEP: f64 = 1.5;
/// Bounds of ln r_c/r_p where the parent is met on its way.
const RATIOS: [f64; 2] = [-2.0, 1.0];

/// |ln r_c/r_p| where two free ends meet, else 0: one vessel keeps its radius across a gap.
pub fn radius_step(s: &Span) -> f64 {
    (1.0 - s.on_the_way()) * log_ratio(s).abs()
}

/// [`radius_step`] squared, the step at most 1.5: small steps are noise.
pub fn radius_step_squared(s: &Span) -> f64 {
    radius_step(s).min(MOST_STEP).powi(2)
}

/// ln r_c/r_p in [-2, 1] where the parent is met on its way, else 0: a branch is no wider than its parent (Murray's law).
pub fn branch_ratio(s: &Span) -> f64 {
    s.on_the_way() * log_ratio(s).clamp(RATIOS[0], RATIOS[1])
}

/// [`branch_ratio`] squared: nor is it ever so thin.
pub fn branch_ratio_squared(s: &Span) -> f64 {
    branch_ratio(s).powi(2)
}

/// ln of the thinner of the two radii over that of the widest free end of all: bridges of a circle are thick vessels.
pub fn relative_size(s: &Span) -> f64 {
    let widest = s.extraction.ends.iter().map(|end| end.radius).fold(0.0, f64::max);
    (s.child.radius.min(s.parent_radius) / widest).ln()
}

/// ln r_c/r_p.
fn log_ratio(s: &Span) -> f64 {
    (s.child.radius / s.parent_radius).ln()
}
