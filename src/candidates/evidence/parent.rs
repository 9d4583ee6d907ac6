//! Features of the parent: what kind of meeting, and what kind of fragment the child would hang on.

use super::extraction::Extraction;
use super::fragment::Fragment;
use super::span::Span;

/// Added to a share, so that the shortest fragment has a logarithm.
const LEAST_SHARE: f64 = 0.01;

/// Whether the parent is met at a free end (1) or on its way (0): most gaps are breaks, not lost branches.
pub fn at_free_end(s: &Span) -> f64 {
    1.0 - s.on_the_way()
}

/// ln(L/L_max + 0.01) of the parent's fragment: L_max the length of the longest fragment. Fragments hang on large ones.
pub fn parent_share(s: &Span) -> f64 {
    share(s.extraction, parent(s))
}

/// Whether the parent's fragment holds an inlet, 1 or 0.
pub fn parent_fed(s: &Span) -> f64 {
    if parent(s).fed { 1.0 } else { 0.0 }
}

fn parent<'a>(s: &Span<'a>) -> &'a Fragment {
    &s.extraction.fragments[s.extraction.fragment[s.point]]
}

/// ln(1 + L/(2 r + h)) of a fragment: L its length, r its mean radius, h the spacing. Short fat fragments are noise.
pub fn slenderness(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.length / (2.0 * fragment.radius + extraction.spacing)).ln_1p()
}

/// ln(L/L_max + 0.01) of a fragment.
pub fn share(extraction: &Extraction, fragment: &Fragment) -> f64 {
    let longest = extraction.fragments.iter().map(|f| f.length).fold(0.0, f64::max);
    let share = if longest > 0.0 { fragment.length / longest } else { 1.0 };
    (share + LEAST_SHARE).ln()
}
