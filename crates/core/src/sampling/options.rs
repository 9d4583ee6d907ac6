//! The parameters of a run; and which vessels are open in each sample, and which of the conditions found hold: drawn patterns, or every
//! possible pattern.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, require};
use crate::flow::{BLOOD_VISCOSITY, Boundary, boundary_conditions::Provisional, check_viscosity};
use crate::network::{Network, Origin, Role, Vessel};
use crate::perturbation::{Enumeration, MOST_UNCERTAIN, Occlusion};
use crate::support::random::BLOCK;

/// Which vessels are uncertain: occluded at random, and to be decided on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Uncertain {
    /// The candidates, and the contacts of observed vessels; observed vessels themselves are never occluded.
    #[default]
    Candidates,
    /// Every vessel, as in the paper.
    All,
}

impl Uncertain {
    /// Per vessel whether it is uncertain; one marked certain never is.
    pub fn vessels(self, network: &Network) -> Vec<bool> {
        network.vessels().map(|(_, v)| !v.certain && (self == Self::All || v.origin != Origin::Observed)).collect()
    }
}

/// What a vessel of the forest contributes to L.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weight {
    /// Its resilience ρ, as in the paper.
    #[default]
    Resilience,
    /// One.
    Count,
    /// The resilience ρ_G of the whole sample.
    Global,
}

impl Weight {
    /// The unit of L.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Resilience | Self::Global => "W/m\u{b3}",
            Self::Count => "samples",
        }
    }

    /// The contribution of a vessel with resilience ρ in a sample with ρ_G, W/m³ or one.
    pub fn of(self, resilience: f64, global: f64) -> f64 {
        match self {
            Self::Resilience => resilience,
            Self::Count => 1.0,
            Self::Global => global,
        }
    }
}

/// When a boundary condition that was found, and not stated, holds in a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FoundConditions {
    /// Where none of the candidates and contacts at its end is a true connection. Each is one with the probability A, occluded or not, so ε has
    /// no say. What has A = 1, is not certain and has no evidence for it is unknown, and counts for nothing.
    #[default]
    Evidence,
    /// In every sample, as what is stated and as the source and the ground of the paper.
    Fixed,
}

/// The solver of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// The fastest that the structure of the graph allows.
    #[default]
    Auto,
    /// Star-mesh elimination, many samples at a time.
    Lanes,
    /// Conjugate gradients on the core that elimination leaves, eight samples at a time.
    Gradients,
    /// The paper's loop, a sample at a time: slow, for comparison.
    Reference,
}

/// The parameters of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SamplingOptions {
    /// Occlusion probability ε in [0, 1).
    pub epsilon: f64,
    /// Samples, at least 1.
    pub samples: u64,
    /// The seed.
    pub seed: u64,
    /// Which vessels are uncertain.
    pub uncertain: Uncertain,
    /// What a vessel of the forest contributes.
    pub weight: Weight,
    /// Whether A = 1 everywhere instead of the prior of each vessel.
    pub uniform_prior: bool,
    /// When a boundary condition that was found holds.
    pub found_conditions: FoundConditions,
    /// Blood viscosity µ, Pa s, positive.
    #[serde(rename = "viscosity_Pa_s")]
    pub viscosity: f64,
    /// The solver.
    pub solver: Solver,
    /// Whether every pattern is enumerated with its probability instead of samples drawn; for 20 uncertain vessels at the
    /// most. `samples` then only scales L.
    pub exact: bool,
}

impl Default for SamplingOptions {
    fn default() -> Self {
        Self {
            epsilon: 0.5,
            samples: 1000,
            seed: 0,
            uncertain: Uncertain::default(),
            weight: Weight::default(),
            uniform_prior: false,
            found_conditions: FoundConditions::default(),
            viscosity: BLOOD_VISCOSITY,
            solver: Solver::default(),
            exact: false,
        }
    }
}

impl SamplingOptions {
    /// The chance of each vessel to be open in a sample: λA of an uncertain one, else 1.
    pub fn keep_probabilities(&self, network: &Network) -> Vec<f64> {
        let prior = |v: &Vessel| if self.uniform_prior { 1.0 } else { v.prior };
        let keep = |v: &Vessel, uncertain: bool| if uncertain { (1.0 - self.epsilon) * prior(v) } else { 1.0 };
        network.vessels().zip(self.uncertain.vessels(network)).map(|((_, v), uncertain)| keep(v, uncertain)).collect()
    }

    /// The conditions found that do not hold in every sample, each with the rows of the candidates and contacts that speak against it.
    pub fn provisional(&self, network: &Network, boundary: &Boundary) -> Provisional {
        if self.uniform_prior || self.found_conditions == FoundConditions::Fixed {
            return Provisional::new();
        }
        let speaks = |row: &usize| {
            let vessel = network.vessel(*row);
            let is_sure = vessel.evidence().is_some_and(|evidence| evidence.probability >= 1.0);
            vessel.certain || vessel.prior > 0.0 && (vessel.prior < 1.0 || is_sure)
        };
        let mut provisional = boundary.provisional(network);
        provisional.retain(|_, others| {
            others.retain(speaks);
            !others.is_empty()
        });
        provisional
    }

    /// The chance that a vessel which a sample closed is a true connection all the same, only occluded: εA/(1 - λA); zero of one that is never
    /// occluded.
    pub fn occluded_though_true(&self, network: &Network, row: usize) -> f64 {
        let vessel = network.vessel(row);
        if vessel.certain { 0.0 } else { self.epsilon * vessel.prior / (1.0 - (1.0 - self.epsilon) * vessel.prior) }
    }

    /// The probability that some inlet holds in a sample.
    pub fn chance_of_an_inlet(&self, network: &Network, boundary: &Boundary) -> f64 {
        let provisional = self.provisional(network, boundary);
        // The probability that a connection is none, whatever is occluded.
        let is_none = |vessel: &Vessel| if vessel.certain { 0.0 } else { 1.0 - vessel.prior };
        let holds = |node: usize| {
            let others = provisional.get(&node).into_iter().flatten();
            others.map(|row| is_none(network.vessel(*row))).product::<f64>()
        };
        let inlets = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Inlet);
        1.0 - inlets.map(|node| 1.0 - holds(node)).product::<f64>()
    }

    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let accepted = "expected a probability, 0 <= epsilon < 1";
        require((0.0..1.0).contains(&self.epsilon), "epsilon", self.epsilon, accepted)?;
        require((1..=1 << 50).contains(&self.samples), "samples", self.samples, "expected a number from 1 to 2^50")?;
        check_viscosity(self.viscosity)
    }
}

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
    pub fn new(network: &Network, provisional: &Provisional, params: &SamplingOptions) -> Result<Self> {
        let (mut keep, vessels) = (params.keep_probabilities(network), network.vessel_count());
        let mut against: Vec<Vec<usize>> = provisional.values().cloned().collect();
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
