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
