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
    const STEPS: f64 = (1 << 24) as f64;
    (x * STEPS).round() / STEPS + 0.0
}

/// Lexicographic order.
pub fn compare(a: &[f64], b: &[f64]) -> Ordering {
    a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::{TIE, exceeds, near_zero, steady};

    #[test]
    fn what_rounding_parts_exceeds_nothing() {
        assert!(!exceeds(0.1 + 0.2, 0.3) && !exceeds(0.3, 0.1 + 0.2) && !exceeds(0.0, 0.0));
        assert!(exceeds(1.0 + 2.0 * TIE, 1.0) && !exceeds(1.0, 1.0 + 2.0 * TIE) && exceeds(1.0, 0.0) && exceeds(1.0, -1.0));
        assert!(!exceeds(f64::NAN, 0.0) && exceeds(f64::MIN_POSITIVE, 0.0));
    }

    #[test]
    fn differences_that_are_rounding_are_zero() {
        assert_eq!(
            [near_zero(0.3 - 0.1 - 0.2), near_zero(-1e-12), near_zero(1.0 / 3.0 - 0.25)],
            [0.0, 0.0, near_zero(1.0 / 12.0)]
        );
        assert_eq!(near_zero(-1e-12).to_bits(), 0);
    }

    #[test]
    fn what_rounding_parts_is_equal_again_and_what_differs_stays_different() {
        assert_eq!(steady(0.1 + 0.2), steady(0.3));
        assert_eq!(steady(-3.000_000_000_000_000_4), -3.0);
        assert_eq!([steady(0.0), steady(1.5), steady(f64::INFINITY)], [0.0, 1.5, f64::INFINITY]);
        assert!(steady(1.0 + 1e-9) > 1.0 && (steady(0.7) - 0.7).abs() < 1e-9);
    }
}
