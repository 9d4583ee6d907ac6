//! The probability of each variant of a circle whose topology is uncertain, from the weights of sampled topologies.

use std::collections::BTreeMap;

use super::arteries::{Artery, BodySide};
use super::circle::Circle;
use super::variant::Variant;
use willis_core::decision::Topologies;
use willis_core::network::{Network, Origin};

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
    /// Of which segments too little is seen to say whether they are there: their probability is that of a table of frequencies, given the
    /// others.
    pub not_seen: [bool; 7],
    /// Which segments are absent whatever the candidates do: not even all of them together make one.
    pub impossible: [bool; 7],
}

/// What is known of the segments beside the topologies.
pub struct Informant<'a> {
    /// The probability of each segment, given the share of the topologies that have it.
    pub presence: &'a dyn Fn(&[f64; 7]) -> [f64; 7],
    /// Of which segments too little is seen to say whether they are there.
    pub not_seen: [bool; 7],
}

/// A candidate on which the most probable variant depends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecidingCandidate {
    /// The candidate's row.
    pub vessel: usize,
    /// The share of the topologies with it, by weight. It is not its P: names weigh in, and one free end continues along one candidate.
    pub share_with: f64,
    /// The share of the most probable variant among the topologies with it ...
    pub with: f64,
    /// ... and among those without it.
    pub without: f64,
}

impl DecidingCandidate {
    /// How much the variant depends on the candidate: the covariance of the two, |with - without| s (1 - s), with s its share.
    pub fn covariance(&self) -> f64 {
        (self.with - self.without).abs() * self.share_with * (1.0 - self.share_with)
    }
}

/// A candidate below this covariance is not listed.
const LEAST_COVARIANCE: f64 = 1e-3;

impl Posterior {
    /// Counts the variants of sampled topologies of `network`.
    ///
    /// Fenestrations come from the observed vessels alone: two candidates across one gap are two guesses at one vessel.
    pub fn of(circle: &Circle, network: &Network, topologies: &Topologies) -> Self {
        Self::informed(circle, network, topologies, None)
    }

    /// As [`Posterior::of`], where more is known of the segments: the variants then have the probabilities that are nearest to those of the
    /// topologies (mixed with independent segments, by iterative proportional fitting) and agree with what is known.
    pub fn informed(circle: &Circle, network: &Network, topologies: &Topologies, informant: Option<&Informant>) -> Self {
        let observed = circle.variant(network, |row| network.vessel(row).origin == Origin::Observed);
        // Two landmarks may be joined by a topology and, by a shorter way, by all candidates together otherwise.
        let all_kept = circle.variant(network, |_| true);
        let each = circle.variants(network, &topologies.weighted).into_iter();
        let each: Vec<Variant> = each.map(|variant| Variant { fenestration: observed.fenestration, ..variant }).collect();
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
        let (mut segments, mut fetal) = (segments.map(|sum| share(sum, all)), fetal.map(|sum| share(sum, all)));
        let mut not_seen = [false; 7];
        if let Some(informant) = informant {
            segments = (informant.presence)(&segments).map(|p| p.clamp(LEAST, 1.0 - LEAST));
            not_seen = informant.not_seen;
            variants = fitted(&variants, &segments);
            fetal = [0, 1].map(|side| variants.iter().filter(|(v, _)| v.fetal[side]).map(|(_, p)| p).sum::<f64>().min(1.0));
        }
        variants.sort_by(|a, b| b.1.total_cmp(&a.1));
        let deciding = variants.first().map_or_else(Vec::new, |(best, _)| deciding(network, topologies, &each, best, all));
        let best = variants.first().map(|(best, _)| *best);
        // The heaviest topology that is most like the best variant.
        let unlike = |variant: &Variant| {
            best.map_or(0, |best| {
                2 * (0..7).filter(|s| variant.present[*s] != best.present[*s]).count() + usize::from(*variant != best)
            })
        };
        let heaviest = (0..each.len()).min_by_key(|row| (unlike(&each[*row]), *row));
        let topology = heaviest.map_or_else(Vec::new, |at| topologies.weighted[at].0.clone());
        let impossible = [0, 1, 2, 3, 4, 5, 6].map(|s| !all_kept.present[s] && each.iter().all(|variant| !variant.present[s]));
        Self { variants, segments, fetal, deciding, topology, samples: topologies.samples, not_seen, impossible }
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

/// No segment is surer than this of being there or not: evidence that is missing proves nothing.
const LEAST: f64 = 0.002;
/// The share of the topologies in the variants that are fitted, the rest being independent segments.
const BY_TOPOLOGIES: f64 = 0.2;
/// Rounds of proportional fitting at the most.
const ROUNDS: usize = 200;
/// Variants below this probability are not listed.
const LEAST_VARIANT: f64 = 1e-6;

/// The variants with the given probabilities of their segments.
fn fitted(sampled: &[(Variant, f64)], segments: &[f64; 7]) -> Vec<(Variant, f64)> {
    let index = |variant: &Variant| (0..7).filter(|s| variant.present[*s]).map(|s| 1 << s).sum::<usize>();
    let mut table = vec![0.0; 1 << 7];
    for (variant, p) in sampled {
        table[index(variant)] += BY_TOPOLOGIES * p;
    }
    for (v, p) in table.iter_mut().enumerate() {
        let alone = (0..7).map(|s| if v >> s & 1 == 1 { segments[s] } else { 1.0 - segments[s] }).product::<f64>();
        *p += (1.0 - BY_TOPOLOGIES) * alone;
    }
    for _ in 0..ROUNDS {
        let mut most = 0.0_f64;
        for (s, target) in segments.iter().enumerate() {
            let there: f64 = table.iter().enumerate().filter(|(v, _)| v >> s & 1 == 1).map(|(_, p)| p).sum();
            let total: f64 = table.iter().sum();
            most = most.max((there / total - target).abs());
            for (v, p) in table.iter_mut().enumerate() {
                *p *= if v >> s & 1 == 1 { target / there } else { (1.0 - target) / (total - there) };
            }
        }
        if most < 1e-12 {
            break;
        }
    }
    let likely = sampled.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or_else(Variant::default, |(variant, _)| *variant);
    let mut out = Vec::new();
    for (v, p) in table.iter().enumerate().filter(|(_, p)| **p >= LEAST_VARIANT) {
        let own: Vec<&(Variant, f64)> = sampled.iter().filter(|(variant, _)| index(variant) == v).collect();
        let sum: f64 = own.iter().map(|(_, p)| p).sum();
        if sum > 0.0 {
            out.extend(own.iter().map(|(variant, q)| (*variant, p * q / sum)));
            continue;
        }
        let mut variant = Variant { present: std::array::from_fn(|s| v >> s & 1 == 1), ..likely };
        for side in BodySide::BOTH {
            let wider = likely.fetal[side.index()] && likely.has(Artery::P1(side));
            variant.set_fetal(side, || wider);
        }
        out.push((variant, *p));
    }
    let total: f64 = out.iter().map(|(_, p)| p).sum();
    for (_, p) in &mut out {
        *p = (*p / total).min(1.0);
    }
    out
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
        DecidingCandidate { vessel, share_with: share(there, all), with: share(both, there), without }
    };
    let candidates = (0..network.vessel_count()).filter(|row| network.vessel(*row).origin == Origin::Candidate);
    let mut deciding: Vec<DecidingCandidate> = candidates.map(of).filter(|d| d.covariance() >= LEAST_COVARIANCE).collect();
    deciding.sort_by(|a, b| b.covariance().total_cmp(&a.covariance()));
    deciding
}
