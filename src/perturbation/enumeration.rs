//! Every occlusion pattern of a small graph, each with its probability.

use crate::support::random::BLOCK;

/// Vessels that may be open or closed that can be enumerated at the most: 2²⁰ patterns.
pub const MOST_UNCERTAIN: usize = 20;

const LOW_BITS: usize = BLOCK.trailing_zeros() as usize;

/// The patterns of the vessels that are neither always nor never open, in blocks of 64.
///
/// The first six of them run through all patterns within a block, bit i of their pattern number set in sample i; the
/// others follow the Gray code of the block's number.
#[derive(Debug, Clone, PartialEq)]
pub struct Enumeration {
    /// Per vessel the word for those that do not change, or its place among those that do.
    vessels: Vec<Pattern>,
    /// The open probability of those that change.
    keep: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Pattern {
    Constant(u64),
    Changing(usize),
}

impl Enumeration {
    /// From the keep probability of each vessel.
    ///
    /// # Errors
    ///
    /// More than [`MOST_UNCERTAIN`] lie between 0 and 1: how many.
    pub fn new(keep: &[f64]) -> Result<Self, usize> {
        let mut changing = Vec::new();
        let vessels = keep.iter().map(|p| match p {
            p if *p >= 1.0 => Pattern::Constant(u64::MAX),
            p if *p > 0.0 => {
                changing.push(*p);
                Pattern::Changing(changing.len() - 1)
            }
            _ => Pattern::Constant(0),
        });
        let vessels = vessels.collect();
        if changing.len() > MOST_UNCERTAIN { Err(changing.len()) } else { Ok(Self { vessels, keep: changing }) }
    }

    /// How many patterns there are.
    pub fn patterns(&self) -> u64 {
        1 << self.keep.len()
    }

    /// Block `block`: bit i of word e says whether vessel e is open in pattern i, whose probability is `probability[i]`.
    pub fn fill(&self, block: u64, masks: &mut Vec<u64>, probability: &mut [f64; BLOCK as usize]) {
        let gray = block ^ (block >> 1);
        let is_open = |place: usize, pattern: usize| {
            if place < LOW_BITS { pattern >> place & 1 == 1 } else { gray >> (place - LOW_BITS) & 1 == 1 }
        };
        masks.clear();
        masks.extend(self.vessels.iter().map(|vessel| match *vessel {
            Pattern::Constant(word) => word,
            Pattern::Changing(place) => (0..BLOCK as usize).fold(0, |word, i| word | u64::from(is_open(place, i)) << i),
        }));
        for (pattern, probability) in probability.iter_mut().enumerate() {
            let factors = self.keep.iter().enumerate().map(|(place, p)| if is_open(place, pattern) { *p } else { 1.0 - p });
            *probability = factors.product();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pattern_comes_once_with_its_probability() {
        let keep = [0.5, 1.0, 0.25, 0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7];
        let all = Enumeration::new(&keep).expect("eight uncertain vessels");
        assert_eq!(all.patterns(), 256);
        let (mut masks, mut probability) = (Vec::new(), [0.0; 64]);
        let mut seen = std::collections::BTreeMap::new();
        for block in 0..4 {
            all.fill(block, &mut masks, &mut probability);
            for (i, p) in probability.iter().enumerate() {
                let pattern: Vec<bool> = masks.iter().map(|m| m >> i & 1 == 1).collect();
                assert!(pattern[1] && !pattern[3]);
                let product: f64 = keep.iter().zip(&pattern).map(|(k, open)| if *open { *k } else { 1.0 - k }).product();
                assert!((p - product).abs() < 1e-15);
                assert!(seen.insert(pattern, *p).is_none());
            }
        }
        assert_eq!(seen.len(), 256);
        assert!((seen.values().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(Enumeration::new(&[0.5; 21]), Err(21));
    }
}
