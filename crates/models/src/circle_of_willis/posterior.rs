//! The probability of each variant of a circle whose topology is uncertain, from sampled topologies, and how frequent variants are.

use std::{collections::BTreeMap, path::Path};

use serde::{Deserialize, Serialize};

use super::arteries::{Artery, BodySide, RING, Variant};
use super::circle::Circle;
use super::labels::{LabelScheme, artery_of_label};
use willis_core::decision::Topologies;
use willis_core::error::{Fault, Result, ensure};
use willis_core::network::{Network, Origin};
use willis_io::formats::tables::reader::TableReader;

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

/// What is known of the segments beside the topologies: the probability of each, given the share of the topologies that have it; and of which
/// of them too little is seen to say whether they are there.
pub type Informant<'a> = (&'a dyn Fn(&[f64; 7]) -> [f64; 7], [bool; 7]);

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
    pub fn informed(circle: &Circle, network: &Network, topologies: &Topologies, informant: Option<Informant>) -> Self {
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
        let not_seen = informant.map_or([false; 7], |(_, not_seen)| not_seen);
        if let Some((presence, _)) = informant {
            segments = presence(&segments).map(|p| p.clamp(LEAST, 1.0 - LEAST));
            variants = fitted(&variants, &segments);
            fetal = [0, 1].map(|side| variants.iter().filter(|(v, _)| v.fetal[side]).map(|(_, p)| p).sum::<f64>().min(1.0));
        }
        variants.sort_by(|a, b| b.1.total_cmp(&a.1));
        let deciding = variants.first().map_or_else(Vec::new, |(best, _)| deciding(network, topologies, &each, best, all));
        let best = variants.first().map(|(best, _)| *best);
        // The heaviest topology that is most like the best variant.
        let unlike =
            |a: &Variant, b: &Variant| 2 * (0..7).filter(|s| a.present[*s] != b.present[*s]).count() + usize::from(a != b);
        let heaviest = (0..each.len()).min_by_key(|row| (best.map_or(0, |best| unlike(&each[*row], &best)), *row));
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

/// Whether a variant has a segment, both by their numbers: bit s of that of a variant says that it has segment s of [`RING`].
fn has(variant: usize, segment: usize) -> bool {
    variant >> segment & 1 == 1
}

/// The sum of a table over the variants that have a segment.
fn sum_with(table: &[f64], segment: usize) -> f64 {
    table.iter().enumerate().filter(|(variant, _)| has(*variant, segment)).map(|(_, x)| x).sum()
}

/// The variants with the given probabilities of their segments.
fn fitted(sampled: &[(Variant, f64)], segments: &[f64; 7]) -> Vec<(Variant, f64)> {
    let index = |variant: &Variant| (0..7).filter(|s| variant.present[*s]).map(|s| 1 << s).sum::<usize>();
    let mut table = vec![0.0; 1 << 7];
    for (variant, p) in sampled {
        table[index(variant)] += BY_TOPOLOGIES * p;
    }
    for (v, p) in table.iter_mut().enumerate() {
        let alone = (0..7).map(|s| if has(v, s) { segments[s] } else { 1.0 - segments[s] }).product::<f64>();
        *p += (1.0 - BY_TOPOLOGIES) * alone;
    }
    for _ in 0..ROUNDS {
        let mut most = 0.0_f64;
        for (s, target) in segments.iter().enumerate() {
            let there = sum_with(&table, s);
            let total: f64 = table.iter().sum();
            most = most.max((there / total - target).abs());
            for (v, p) in table.iter_mut().enumerate() {
                *p *= if has(v, s) { target / there } else { (1.0 - target) / (total - there) };
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
        let mut variant = Variant { present: std::array::from_fn(|s| has(v, s)), ..likely };
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

/// The table that ships. Its frame is that of 1,864 people of the Tromsø study (Hindenes et al., PLoS ONE 15(11):e0241373, 2020, doi
/// 10.1371/journal.pone.0241373; 3 T time-of-flight, segments below 1 mm count as missing): the complete circle in 11.9 %, only both PComm
/// missing in 27.8 %. The abstract gives no share for each of the other 45 variants; how the rest is dealt out here (PComm most often, then
/// AComm, P1 with the PComm of the other side, A1) is an assumption, which a table of one's own replaces.
const PUBLISHED: &str = include_str!("frequencies.csv");
/// The share of all variants that a table does not name, spread over them evenly.
const UNNAMED: f64 = 0.02;

/// How frequent each variant is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariantFrequencies {
    /// The share of each of the 128 variants; bit s of the index says that segment s of [`RING`] is there.
    pub share: Vec<f64>,
}

impl VariantFrequencies {
    /// The table that ships.
    ///
    /// # Errors
    ///
    /// None in a released version: a test reads it.
    pub fn published() -> Result<Self> {
        Self::read(PUBLISHED.as_bytes()).map_err(|fault| fault.in_file(Path::new("frequencies.csv")))
    }

    /// Reads a table of `missing,share`: the missing segments (`L-A1, R-PComm`, or `complete`), and how many in 1 (or per cent, or a count) have the
    /// variant.
    ///
    /// # Errors
    ///
    /// A missing column, a segment that is none of the ring, a share that is no number from 0 on, none above 0, or a sum that is no number.
    pub fn read(bytes: &[u8]) -> Result<Self, Fault> {
        let mut rows = TableReader::ragged(bytes)?;
        let line = rows.header_line;
        let column = |name: &str| {
            rows.find(&[name]).ok_or_else(|| Fault::line(line, format!("no column {name}"), "expected missing,share"))
        };
        let (missing, share) = (column("missing")?, column("share")?);
        let mut table = vec![0.0; 1 << RING.len()];
        while let Some(row) = rows.row()? {
            let (text, value) = (row.text(missing).to_owned(), row.real(share)?);
            let wrong = || Fault::line(row.line, format!("share {value}"), "expected a number from 0 on");
            ensure(value >= 0.0 && value.is_finite(), wrong)?;
            let index =
                index_of(&text).map_err(|part| Fault::line(row.line, format!("missing \"{part}\""), segments_accepted()))?;
            table[index] += value;
        }
        let total: f64 = table.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            let found = if total > 0.0 { "shares of more than 1e308 together" } else { "no variant with a share" };
            return Err(Fault::line(line, found, "expected missing,share with a share above 0"));
        }
        let unnamed = table.iter().filter(|share| **share == 0.0).count().max(1) as f64;
        let spread = if table.contains(&0.0) { UNNAMED } else { 0.0 };
        for share in &mut table {
            *share = if *share > 0.0 { (1.0 - spread) * *share / total } else { spread / unnamed };
        }
        Ok(Self { share: table })
    }

    /// As [`VariantFrequencies::read`], from a file.
    ///
    /// # Errors
    ///
    /// As there, or a file that cannot be read.
    pub fn of_file(path: &Path) -> Result<Self> {
        let bytes = willis_io::formats::bytes_of(path)?;
        Self::read(&bytes).map_err(|fault| fault.in_file(path))
    }

    /// The share of people who have each segment.
    pub fn marginals(&self) -> [f64; 7] {
        std::array::from_fn(|s| sum_with(&self.share, s))
    }

    /// The probability of each segment that is not `decidable`, given the probabilities of the others; these stay.
    pub fn given(&self, presence: &[f64; 7], decidable: &[bool; 7]) -> [f64; 7] {
        let marginals = self.marginals();
        let weight = |variant: usize| -> f64 {
            let fits = (0..7).filter(|s| decidable[*s]).map(|s| {
                // What is seen, over what the table alone says of it.
                let (p, usual) = (presence[s], marginals[s]);
                if has(variant, s) { p / usual } else { (1.0 - p) / (1.0 - usual) }
            });
            self.share[variant] * fits.product::<f64>()
        };
        let weights: Vec<f64> = (0..self.share.len()).map(weight).collect();
        let total: f64 = weights.iter().sum();
        std::array::from_fn(|s| {
            if decidable[s] || total <= 0.0 {
                return if decidable[s] { presence[s] } else { marginals[s] };
            }
            sum_with(&weights, s) / total
        })
    }
}

/// Which segments of [`RING`] are there where those of a text are missing (`L-A1, R-PComm`, or `complete`).
///
/// # Errors
///
/// The accepted form.
pub fn present_segments(missing: &str) -> Result<[bool; 7], String> {
    let index = index_of(missing).map_err(|_| segments_accepted())?;
    Ok(std::array::from_fn(|s| has(index, s)))
}

fn segments_accepted() -> String {
    let ring: Vec<String> = RING.iter().map(ToString::to_string).collect();
    format!("expected complete, or segments of {}", ring.join(", "))
}

/// The index of the variant that misses the segments of a text; the part that is no segment otherwise.
fn index_of(text: &str) -> Result<usize, String> {
    let all = (1 << RING.len()) - 1;
    if text.trim() == "complete" {
        return Ok(all);
    }
    let mut index = all;
    for part in text.split([',', ';']).map(str::trim) {
        let artery = artery_of_label(part, LabelScheme::Names);
        let segment = artery.and_then(Artery::in_ring).ok_or_else(|| part.to_owned())?;
        index &= !(1 << segment);
    }
    Ok(index)
}
