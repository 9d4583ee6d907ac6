//! Which vessels are open in each sample, and which of the conditions found hold: drawn patterns, or every possible pattern.

use std::collections::BTreeMap;

use super::SamplingOptions;
use crate::error::{Error, Result};
use crate::perturbation::{Enumeration, MOST_UNCERTAIN, Occlusion};
use crate::{flow::boundary_conditions::Provisional, network::Network, support::random::BLOCK};

/// The patterns of a run.
///
/// A condition found holds in a sample where none of the candidates and contacts at its end is a true connection ([`SamplingOptions::provisional`]).
/// One is true with the probability A; it is open where it is true and not occluded. So of those that are closed one is true with the probability
/// εA/(1 - λA), and this is drawn too, after the vessels.
#[derive(Debug)]
pub struct Patterns {
    source: PatternSource,
    vessels: usize,
    /// Per condition that does not always hold the rows that speak against it: vessels, and after them what is drawn of closed ones.
    against: Vec<Vec<usize>>,
    /// Rows that the source fills in.
    rows: usize,
}

/// Where the patterns come from.
#[derive(Debug)]
enum PatternSource {
    /// Drawn at random from the streams of a seed.
    Drawn {
        /// The chances of the rows.
        occlusion: Occlusion,
        /// The seed.
        seed: u64,
    },
    /// Each once, with its probability.
    Enumerated(Enumeration),
}

impl Patterns {
    /// Of a network, some of whose conditions are `provisional` ([`SamplingOptions::provisional`]).
    ///
    /// # Errors
    ///
    /// Too many uncertain vessels to enumerate.
    pub fn new(network: &Network, provisional: &[Provisional], params: &SamplingOptions) -> Result<Self> {
        let (mut keep, vessels) = (params.keep_probabilities(network), network.vessel_count());
        let mut against: Vec<Vec<usize>> = provisional.iter().map(|at| at.others.clone()).collect();
        let mut drawn = BTreeMap::new();
        for rows in &mut against {
            for at in 0..rows.len() {
                let chance = params.occluded_though_true(network, rows[at]);
                if chance > 0.0 {
                    rows.push(*drawn.entry(rows[at]).or_insert_with(|| {
                        keep.push(chance);
                        keep.len() - 1
                    }));
                }
            }
        }
        let rows = keep.len();
        let twice = rows - vessels;
        let refused = |uncertain| {
            let ends = format!(", of which {twice} count twice, for they leave ends whose condition was found");
            let ends = if twice == 0 { "" } else { &ends };
            let accepted = format!("expected at most {MOST_UNCERTAIN}; sample without `exact`");
            Error::parameter("exact", format!("with {uncertain} uncertain vessels{ends}"), accepted)
        };
        let source = if params.exact {
            PatternSource::Enumerated(Enumeration::new(&keep).map_err(refused)?)
        } else {
            PatternSource::Drawn { occlusion: Occlusion::new(keep), seed: params.seed }
        };
        Ok(Self { source, vessels, against, rows })
    }

    /// How many samples a run of `asked` takes: all patterns in an enumeration.
    pub fn samples(&self, asked: u64) -> u64 {
        match &self.source {
            PatternSource::Drawn { .. } => asked,
            PatternSource::Enumerated(patterns) => patterns.patterns(),
        }
    }

    /// Fills in block `block`: bit i of word e says whether vessel e is open in sample i, and after the vessels whether a provisional condition
    /// holds. In an enumeration it fills in the `probability` of each sample too, and returns true.
    pub fn fill(&self, block: u64, masks: &mut Vec<u64>, probability: &mut [f64; BLOCK as usize]) -> bool {
        let is_enumerated = match &self.source {
            PatternSource::Drawn { occlusion, seed } => {
                occlusion.draw(*seed, block, masks);
                false
            }
            PatternSource::Enumerated(patterns) => {
                patterns.fill(block, masks, probability);
                true
            }
        };
        for rows in &self.against {
            let joined = rows.iter().fold(0, |joined, row| joined | masks[*row]);
            masks.push(!joined);
        }
        masks.drain(self.vessels..self.rows);
        is_enumerated
    }
}
