//! Comparisons that rounding does not decide: numbers to 32 significant bits, and sums that are equal but for rounding.

use std::cmp::Ordering;

/// The nearest number of 32 significant bits.
///
/// Extractions lie on voxel grids, so equal distances are common, and rounding would decide between them: differently for
/// another unit of length, another order of the axes. Every decision of the search, and of what is an inlet, compares numbers rounded so.
pub fn steady(x: f64) -> f64 {
    const GONE: u32 = f64::MANTISSA_DIGITS - 32;
    f64::from_bits((x.to_bits() + (1 << (GONE - 1))) & !((1 << GONE) - 1))
}

/// Numbers are equal that are no further apart than this, in parts of the larger.
///
/// A sum of n figures that is taken pairwise is off by log₂(n)·2⁻⁵³ of it at most, 10⁻¹⁴ for any n here. Its figures are further off: the square of the
/// flow in a vessel whose drop is 10⁻⁵ of the pressures keeps 10⁻¹⁰ or so of itself. Two likelihoods that differ do not come as near as 10⁻⁹ but by
/// chance.
pub const TIE: f64 = 1e-9;

/// Whether a number is larger than another by more than rounding.
pub fn exceeds(x: f64, other: f64) -> bool {
    x - other > TIE * x.abs().max(other.abs())
}

/// The nearest multiple of 2⁻²⁴, for differences of numbers of about 1: one that is zero but for rounding is zero again.
pub fn near_zero(x: f64) -> f64 {
    in_steps(x, 24)
}

/// The nearest multiple of a power of 1/2; never -0.
pub fn in_steps(x: f64, power: u32) -> f64 {
    let steps = (1_u64 << power) as f64;
    (x * steps).round() / steps + 0.0
}

/// Some items by a figure, the largest first; in single precision, so that rounding does not change the order of equal ones.
pub fn largest_first<T>(items: impl IntoIterator<Item = T>, figure: impl Fn(&T) -> f64) -> Vec<T> {
    let mut items: Vec<T> = items.into_iter().collect();
    items.sort_by(|a, b| (figure(b) as f32).total_cmp(&(figure(a) as f32)));
    items
}

/// Lexicographic order.
pub fn compare(a: &[f64], b: &[f64]) -> Ordering {
    a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
}
