//! |Ẽ|: how many vessels are open in each sample of a block, counted in bit planes.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::tally::Samples;
use crate::simd::{Simd, masked, plus, splat};

/// The number of words in which the bit of each sample is set.
#[inline(always)]
pub fn open_vessels<S: Simd>(simd: S, masks: &[u64]) -> Samples {
    let mut planes = [0_u64; 32];
    let (eights, rest) = masks.as_chunks();
    for [a, b, c, d, e, f, g, h] in eights {
        let pairs = [[a, b], [c, d], [e, f], [g, h]].map(|[a, b]| add_bits(&mut planes[0], *a, *b));
        let fours = [[pairs[0], pairs[1]], [pairs[2], pairs[3]]].map(|[a, b]| add_bits(&mut planes[1], a, b));
        let carry = add_bits(&mut planes[2], fours[0], fours[1]);
        count_bits(&mut planes[3..], carry);
    }
    for mask in rest {
        count_bits(&mut planes, *mask);
    }
    let (mut open, mut worth) = (Samples::ZERO, splat(simd, 1.0));
    let used = planes.iter().rposition(|plane| *plane != 0).map_or(0, |last| last + 1);
    for plane in &planes[..used] {
        open = plus(simd, &open, &masked(simd, &worth, *plane, 0));
        worth = plus(simd, &worth, &worth);
    }
    open
}

/// Adds two to a plane of bits; returns what is carried to the next one.
#[inline(always)]
fn add_bits(plane: &mut u64, a: u64, b: u64) -> u64 {
    let differ = *plane ^ a;
    let carry = (*plane & a) | (differ & b);
    *plane = differ ^ b;
    carry
}

/// Adds a word to the planes of a count.
#[inline(always)]
fn count_bits(planes: &mut [u64], mut carry: u64) {
    for plane in planes {
        if carry == 0 {
            break;
        }
        (*plane, carry) = (*plane ^ carry, *plane & carry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Scalar;

    /// Every word has bit i set in the first i of them, so that sample i is open in min(i, words) of them.
    #[test]
    fn open_vessels_are_counted() {
        for words in [0, 1, 7, 8, 9, 63, 64, 100] {
            let masks: Vec<u64> = (0..words).map(|word| (0..64).filter(|i| word < *i).map(|i| 1 << i).sum()).collect();
            let counted = open_vessels(Scalar::new(), &masks);
            for (sample, counted) in counted.iter().enumerate() {
                assert_eq!(*counted, sample.min(words) as f64, "{words} words, sample {sample}");
            }
        }
    }
}
