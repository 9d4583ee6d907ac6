//! Which vessels are open in each sample: drawn patterns, or every possible pattern.

use super::options::SamplingOptions;
use crate::error::{Error, Result};
use crate::perturbation::enumeration::MOST_UNCERTAIN;
use crate::perturbation::{Enumeration, Occlusion};
use crate::support::random::BLOCK;

/// Where the patterns come from.
#[derive(Debug)]
pub enum Patterns {
    /// Drawn at random from the streams of a seed.
    Drawn {
        /// The chances of the vessels.
        occlusion: Occlusion,
        /// The seed.
        seed: u64,
    },
    /// Each once, with its probability.
    Enumerated(Enumeration),
}

impl Patterns {
    /// From the keep probability of each vessel.
    ///
    /// # Errors
    ///
    /// Too many uncertain vessels to enumerate.
    pub fn new(keep: Vec<f64>, params: &SamplingOptions) -> Result<Self> {
        if !params.exact {
            return Ok(Self::Drawn { occlusion: Occlusion::new(keep), seed: params.seed });
        }
        let refused = |uncertain| {
            let accepted = format!("expected at most {MOST_UNCERTAIN}; sample without `exact`");
            Error::parameter("exact", format!("with {uncertain} uncertain vessels"), accepted)
        };
        Enumeration::new(&keep).map(Self::Enumerated).map_err(refused)
    }

    /// How many samples a run of `asked` takes: all patterns in an enumeration.
    pub fn samples(&self, asked: u64) -> u64 {
        match self {
            Self::Drawn { .. } => asked,
            Self::Enumerated(patterns) => patterns.patterns(),
        }
    }

    /// Fills in block `block`: bit i of word e says whether vessel e is open in sample i. In an enumeration it fills in the `probability` of
    /// each sample too, and returns true.
    pub fn fill(&self, block: u64, masks: &mut Vec<u64>, probability: &mut [f64; BLOCK as usize]) -> bool {
        match self {
            Self::Drawn { occlusion, seed } => {
                occlusion.draw(*seed, block, masks);
                false
            }
            Self::Enumerated(patterns) => {
                patterns.fill(block, masks, probability);
                true
            }
        }
    }
}
