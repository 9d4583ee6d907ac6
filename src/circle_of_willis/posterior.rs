//! The probability of each variant of a circle whose topology is uncertain, from the weights of sampled topologies.

use std::collections::BTreeMap;

use super::circle::Circle;
use super::variant::Variant;
use crate::decision::Topologies;
use crate::network::{Network, Origin};

/// The probabilities of a circle's variants and segments, counted over whole topologies, so that dependence between segments is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// The variants with their probability, the most probable first.
    pub variants: Vec<(Variant, f64)>,
    /// For each segment of [`super::arteries::RING`] the probability that it is present.
    pub segments: [f64; 7],
    /// For each side the probability of a posterior cerebral artery of fetal type.
    pub fetal: [f64; 2],
    /// The candidates on which the most probable variant depends, those that change its probability most first.
    pub deciding: Vec<DecidingCandidate>,
    /// The topology of largest weight with the most probable variant: for each vessel whether the topology has it.
    pub topology: Vec<bool>,
    /// How many topologies were drawn.
    pub samples: u64,
}

/// A candidate on which the most probable variant depends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecidingCandidate {
    /// The candidate's row.
    pub vessel: usize,
    /// The share of topologies with it.
    pub probability: f64,
    /// The probability of the most probable variant among the topologies with it ...
    pub with: f64,
    /// ... and among those without it.
    pub without: f64,
}

impl DecidingCandidate {
    /// How much the variant depends on the candidate: the covariance of the two, |with - without| p (1 - p).
    pub fn share(&self) -> f64 {
        (self.with - self.without).abs() * self.probability * (1.0 - self.probability)
    }
}

/// A candidate below this covariance is not listed.
const LEAST_SHARE: f64 = 1e-3;

impl Posterior {
    /// Counts the variants of sampled topologies of `network`.
    ///
    /// Fenestrations come from the observed vessels alone: two candidates across one gap are two guesses at one vessel.
    pub fn of(circle: &Circle, network: &Network, topologies: &Topologies) -> Self {
        let observed = circle.variant(network, |row| network.vessel(row).origin == Origin::Observed);
        let each: Vec<Variant> = topologies
            .weighted
            .iter()
            .map(|(kept, _)| Variant { fenestration: observed.fenestration, ..circle.variant(network, |row| kept[row]) })
            .collect();
        let mut shares: BTreeMap<Variant, f64> = BTreeMap::new();
        let (mut segments, mut fetal) = ([0.0; 7], [0.0; 2]);
        for (variant, (_, weight)) in each.iter().zip(&topologies.weighted) {
            *shares.entry(*variant).or_default() += weight;
            add(&mut segments, &variant.present, *weight);
            add(&mut fetal, &variant.fetal, *weight);
        }
        // What is added up of the weights, in the order of all, is never more than all: no probability passes 1.
        let all: f64 = topologies.weighted.iter().map(|(_, weight)| weight).sum();
        let mut variants: Vec<(Variant, f64)> = shares.into_iter().map(|(variant, sum)| (variant, share(sum, all))).collect();
        variants.sort_by(|a, b| b.1.total_cmp(&a.1));
        let deciding = variants.first().map_or_else(Vec::new, |(best, _)| deciding(network, topologies, &each, best, all));
        let best = variants.first().map(|(best, _)| *best);
        let heaviest = each.iter().position(|variant| Some(*variant) == best);
        let topology = heaviest.map_or_else(Vec::new, |at| topologies.weighted[at].0.clone());
        let (segments, fetal) = (segments.map(|sum| share(sum, all)), fetal.map(|sum| share(sum, all)));
        Self { variants, segments, fetal, deciding, topology, samples: topologies.samples }
    }

    /// The most probable variant; [`Variant::default`], which has nothing, when nothing was drawn.
    pub fn best(&self) -> Variant {
        self.variants.first().map_or_else(Variant::default, |(variant, _)| *variant)
    }

    /// The probability of the most probable variant.
    pub fn probability(&self) -> f64 {
        self.variants.first().map_or(0.0, |(_, p)| *p)
    }

    /// The probability of the most probable variant less that of the next.
    pub fn margin(&self) -> f64 {
        self.probability() - self.variants.get(1).map_or(0.0, |(_, p)| *p)
    }
}

fn add<const N: usize>(sums: &mut [f64; N], there: &[bool; N], weight: f64) {
    for (sum, _) in sums.iter_mut().zip(there).filter(|(_, there)| **there) {
        *sum += weight;
    }
}

/// The ratio of a part to the whole; 0 if the whole is 0.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// The candidates on which the `best` variant depends; `all` is the weight of all topologies.
fn deciding(network: &Network, topologies: &Topologies, each: &[Variant], best: &Variant, all: f64) -> Vec<DecidingCandidate> {
    let of_best: f64 = topologies.weighted.iter().zip(each).filter(|(_, v)| *v == best).map(|((_, w), _)| w).sum();
    let of = |vessel: usize| {
        let (mut there, mut both) = (0.0, 0.0);
        for ((kept, weight), variant) in topologies.weighted.iter().zip(each) {
            if kept[vessel] {
                there += weight;
                both += if variant == best { *weight } else { 0.0 };
            }
        }
        let without = share(of_best - both, all - there).clamp(0.0, 1.0);
        DecidingCandidate { vessel, probability: share(there, all), with: share(both, there), without }
    };
    let candidates = (0..network.vessel_count()).filter(|row| network.vessel(*row).origin == Origin::Candidate);
    let mut deciding: Vec<DecidingCandidate> = candidates.map(of).filter(|d| d.share() >= LEAST_SHARE).collect();
    deciding.sort_by(|a, b| b.share().total_cmp(&a.share()));
    deciding
}
