//! The circle of a network whose arteries were named: where its landmarks are, and what names and topologies together say of each segment.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::atlas::Atlas;
use super::joins::probability_with;
use super::model::{NamingModel, TOPOLOGY_FEATURE};
use super::presence::kind_of;
use super::states::{LABELS, OTHER, artery_of, label_named, label_of, mirrored, most_probable, name_of, states_of};
use super::{Names, landmarks::NamedPlace};
use crate::circle_of_willis::{
    Artery, BodySide, Circle, FEEDERS, LabelScheme, Posterior, RING, VariantFrequencies, artery_of_label, identify_landmarks,
};
use willis_core::decision::{KnownEnds, Topologies};
use willis_core::error::{Fault, Place};
use willis_core::network::units::{metres, millimetres};
use willis_core::network::{Frame, Network};
use willis_core::sampling::SamplingOptions;
use willis_core::support::geometry::{Point, dot, lerp, sub};
use willis_core::support::statistics::sigmoid;
use willis_io::formats::{ListedLandmark, SURE};

/// Less than this much (mm) of an artery is none of it.
const LEAST_SEEN: f64 = 3.0;
/// A network with less named length (mm) is no circle of Willis.
const LEAST_NAMED: f64 = 40.0;
/// No probability of a topology counts for more than this, nor less than one minus it.
const MOST_SURE: f64 = 0.99;

/// What names say of the segments of [`RING`], to be put together with what topologies say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedCircle {
    /// Log odds that each segment is there, but for the topologies.
    pub log_odds: [f64; 7],
    /// The weight of the log odds of the topologies.
    pub topology_weight: [f64; 7],
    /// The share of the cases with each segment among those that the model was fitted to.
    pub share: [f64; 7],
    /// Whether enough is seen around each segment to say whether it is there.
    pub is_decidable: [bool; 7],
    /// Whether anything is seen of each segment or of what lies at either end, or of what surrounds the place where it would be.
    pub is_in_view: [bool; 7],
    /// The mean diameter of each segment, m, where one is seen.
    pub diameters: [Option<f64>; 7],
    /// Candidates and contacts with the factor that names give to their odds.
    pub factors: Vec<(usize, f64)>,
    /// Vessels with the name that most of their length has.
    pub names: Vec<(usize, String)>,
}

/// What is known of people's circles before one is seen.
#[derive(Debug, Clone, PartialEq)]
pub struct CirclePrior {
    /// How frequent each variant is.
    pub frequencies: VariantFrequencies,
    /// Whether they are those of the study at hand, which then stand for the shares that the model was fitted to.
    pub is_own: bool,
    /// How often a segment that is there is out of sight, 0 to below 1.
    pub unseen: f64,
}

impl NamedCircle {
    /// The network with the odds and probabilities of candidates as names leave them.
    pub fn weighed(&self, network: &Network) -> Network {
        let mut network = network.clone();
        let count = network.vessel_count();
        for (row, factor) in self.factors.iter().filter(|(row, _)| *row < count) {
            if let Some(evidence) = &mut network.vessel_mut(*row).evidence {
                evidence.continuation_odds = evidence.continuation_odds.map(|odds| odds * factor);
                evidence.probability = probability_with(evidence.probability, *factor);
            }
        }
        network
    }

    /// The probability of each segment, given the share of plausible topologies that have it, if a segment that is there is out of sight at
    /// the rate `unseen`: with π the usual share and Λ the ratio of the likelihoods of what is seen, its odds are π/(1 - π) (h + (1 - h) Λ).
    /// Of a segment out of view it is that of the frequencies, given the others.
    pub fn presence(&self, topologies: &[f64; 7], prior: &CirclePrior) -> [f64; 7] {
        let usual = if prior.is_own { prior.frequencies.marginals() } else { self.share };
        let odds = |p: f64| p / (1.0 - p);
        let seen = std::array::from_fn(|s| {
            let p = sigmoid(self.log_odds[s] + self.topology_weight[s] * log_odds(topologies[s])).clamp(1e-3, 1.0 - 1e-3);
            let ratio = odds(p) / odds(self.share[s]);
            let odds = odds(usual[s].clamp(1e-3, 1.0 - 1e-3)) * (prior.unseen + (1.0 - prior.unseen) * ratio);
            odds / (1.0 + odds)
        });
        prior.frequencies.given(&seen, &self.is_in_view)
    }

    /// The same with left and right exchanged. The atlas is symmetric, so that this is what a mirrored network gives.
    #[must_use]
    pub fn mirrored(self) -> Self {
        fn exchanged<T: Copy>(of: [T; 7]) -> [T; 7] {
            RING.map(|artery| of[RING.iter().position(|other| *other == artery.opposite()).unwrap_or_default()])
        }
        Self {
            log_odds: exchanged(self.log_odds),
            topology_weight: exchanged(self.topology_weight),
            share: exchanged(self.share),
            is_decidable: exchanged(self.is_decidable),
            is_in_view: exchanged(self.is_in_view),
            diameters: exchanged(self.diameters),
            factors: self.factors,
            names: self
                .names
                .into_iter()
                .map(|(row, name)| (row, label_named(&name).map_or(name, |label| name_of(mirrored(label)))))
                .collect(),
        }
    }

    /// Of which segments too little is seen to say whether they are there.
    pub fn not_seen(&self) -> [bool; 7] {
        self.is_decidable.map(|is_decidable| !is_decidable)
    }
}

/// The share of the plausible topologies of a named network with each segment: its candidates have the odds that names leave them, and
/// vessels end where arteries are known to.
pub fn topologies_say(circle: &Circle, named: &NamedCircle, network: &Network, options: &SamplingOptions) -> [f64; 7] {
    let network = named.weighed(network);
    let mut known = vec![false; network.node_count()];
    for node in circle.ends(&network) {
        known[node] = true;
    }
    let ends = KnownEnds { ends: &known, inlets: &circle.inlets() };
    Posterior::of(circle, &network, &Topologies::of_free_ends(&network, ends, options)).segments
}

/// ln p/(1 - p), of a probability that is sure of nothing.
pub fn log_odds(p: f64) -> f64 {
    let p = p.clamp(1.0 - MOST_SURE, MOST_SURE);
    (p / (1.0 - p)).ln()
}

impl Names {
    /// Whether enough arteries were found to call this a circle of Willis.
    pub fn is_circle(&self) -> bool {
        let named: f64 = (0..LABELS).filter(|label| *label != OTHER).map(|label| self.seen.length[label]).sum();
        named >= LEAST_NAMED && FEEDERS.into_iter().any(|artery| self.sees(artery))
    }

    /// What the names say of the circle.
    pub fn circle(&self, model: &NamingModel) -> NamedCircle {
        let weights = |segment: usize| &model.presence[kind_of(segment)];
        NamedCircle {
            log_odds: std::array::from_fn(|s| {
                let (weights, features) = (weights(s), self.seen.features(s));
                weights[0] + weights[1..TOPOLOGY_FEATURE].iter().zip(&features).map(|(w, x)| w * x).sum::<f64>()
            }),
            topology_weight: std::array::from_fn(|s| weights(s)[TOPOLOGY_FEATURE]),
            share: std::array::from_fn(|s| model.share[kind_of(s)]),
            is_decidable: std::array::from_fn(|s| self.is_decidable(s)),
            is_in_view: std::array::from_fn(|s| self.has_surroundings(s) || self.encloses(s, &model.atlas)),
            diameters: self.diameters(),
            factors: self.nodes.bridges.iter().zip(&self.bridge_factor).map(|(b, f)| (b.vessel, *f)).collect(),
            names: self.vessels(),
        }
    }

    /// The vessels that are arteries of the circle, each with the name that most of its length has.
    fn vessels(&self) -> Vec<(usize, String)> {
        let mut sums: BTreeMap<usize, [f64; LABELS]> = BTreeMap::new();
        for ((place, weight), labels) in self.nodes.place.iter().zip(&self.nodes.weight).zip(&self.labels) {
            let sum = sums.entry(place.vessel).or_insert([0.0; LABELS]);
            sum.iter_mut().zip(labels).for_each(|(sum, p)| *sum += weight * p);
        }
        let best = sums.into_iter().map(|(row, sum)| (row, most_probable(&sum)));
        best.filter(|(_, label)| *label != OTHER).map(|(row, label)| (row, name_of(label))).collect()
    }

    /// Whether arteries lie on the other side than their names say, by `places` (m, in the axes of the network's file) whose side is known.
    pub fn is_mirrored(&self, places: &[(BodySide, Point)]) -> bool {
        let middle_of = |side: BodySide| {
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for (at, labels) in self.nodes.at.iter().zip(&self.labels) {
                let p: f64 = (0..LABELS)
                    .filter(|label| artery_of(*label).and_then(Artery::side) == Some(side))
                    .map(|label| labels[label])
                    .sum();
                sum = [0, 1, 2].map(|k| sum[k] + p * at[k]);
                total += p;
            }
            (total > 0.0).then(|| sum.map(|x| x / total))
        };
        let [Some(left), Some(right)] = BodySide::BOTH.map(middle_of) else { return false };
        let (rightward, middle) = (sub(right, left), lerp(left, right, 0.5));
        let agrees = |(side, at): &(BodySide, Point)| {
            let at = self.bearings.frame.turn(Frame::Ras, *at).map(millimetres);
            let away = dot(sub(at, middle), rightward);
            if *side == BodySide::Right { away } else { -away }
        };
        places.iter().map(agrees).sum::<f64>() < 0.0
    }

    /// Whether a segment, or what lies at both of its ends, is seen.
    fn is_decidable(&self, segment: usize) -> bool {
        self.seen.is_seen(segment) || RING[segment].joins().iter().all(|end| end.iter().any(|artery| self.sees(*artery)))
    }

    /// Whether a segment, or what lies at one of its ends, is seen.
    fn has_surroundings(&self, segment: usize) -> bool {
        let beside = if let Artery::A1(side) = RING[segment] { Some(Artery::M1(side)) } else { None };
        self.seen.is_seen(segment) || RING[segment].joins().into_iter().flatten().chain(beside).any(|artery| self.sees(artery))
    }

    fn sees(&self, artery: Artery) -> bool {
        self.seen.length[label_of(artery)] >= LEAST_SEEN
    }

    /// Whether the middle of a segment in the atlas lies within the box of all that is seen.
    fn encloses(&self, segment: usize, atlas: &Atlas) -> bool {
        let states = states_of(label_of(RING[segment]));
        let at: Vec<Point> = self.nodes.at.iter().map(|p| self.bearings.pose.apply(*p)).collect();
        (0..3).all(|k| {
            let middle = states.clone().map(|state| atlas.data.pieces[state].mean[k]).sum::<f64>() / states.len() as f64;
            at.iter().any(|p| p[k] <= middle) && at.iter().any(|p| p[k] >= middle)
        })
    }

    /// The mean diameter of each segment by the probability of its name, m, where half a millimetre of it is seen.
    fn diameters(&self) -> [Option<f64>; 7] {
        std::array::from_fn(|segment| {
            let label = label_of(RING[segment]);
            let (mut sum, mut total) = (0.0, 0.0);
            for (n, p) in self.labels.iter().enumerate() {
                let w = p[label] * self.nodes.weight[n];
                sum += w * 2.0 * self.nodes.log_radius[n].exp();
                total += w;
            }
            (total > 0.5).then(|| metres(sum / total))
        })
    }

    /// That the frame was found, not stated.
    pub fn frame_note(&self) -> Option<String> {
        let frame = self.bearings.frame.name().filter(|_| self.frame_was_found)?;
        Some(format!(
            "no frame is stated: front and back fit {frame}, and left and right follow from that; a mirrored file looks the same (see `frame`)"
        ))
    }

    /// The circle with the sure landmarks, in a network of the same positions, with notes for the user.
    ///
    /// # Errors
    ///
    /// Too few arteries; no inlet among them.
    pub fn located(&self, network: &Network, model: &NamingModel) -> Result<(Circle, Vec<String>), Fault> {
        if !self.is_circle() {
            return Err(Fault::file(
                "no arteries of a circle of Willis could be named",
                "expected centerlines of a head in mm, within some 30 degrees of RAS or LPS; or labels, or `landmarks=FILE`",
            ));
        }
        let listed = self.landmarks(model);
        let mut sure: Vec<&NamedPlace> = listed.iter().filter(|place| place.probability >= SURE).collect();
        // Blood comes in somewhere: where no place is sure, at the likeliest.
        let is_inlet = |place: &&NamedPlace| artery_of_label(&place.label, LabelScheme::Names).is_some_and(Artery::brings_blood);
        let likeliest = if sure.iter().any(is_inlet) {
            None
        } else {
            let listed = listed.iter().filter(is_inlet).max_by(|a, b| a.probability.total_cmp(&b.probability));
            listed.cloned().or_else(|| super::landmarks::likeliest_inlet(&self.nodes, &self.labels))
        };
        sure.extend(&likeliest);
        // Where the ends of all arteries at a bifurcation are seen, these say more than a bifurcation that may lie in a gap.
        let is_end = |label: &str| sure.iter().any(|place| place.label == label);
        let needed = |place: &&NamedPlace| {
            BodySide::BOTH.iter().all(|side| {
                let [ica, m1, a1, a2, p1, p2] = [Artery::Ica, Artery::M1, Artery::A1, Artery::A2, Artery::P1, Artery::P2]
                    .map(|artery| artery(*side).to_string());
                let meets = |a: &str, b: &str| [a, b].iter().all(|name| place.label.split('/').any(|part| part == *name));
                !(meets(&ica, &m1) && is_end(&ica) && is_end(&m1)
                    || meets(&a1, &a2) && is_end(&a2)
                    || meets(&p1, &p2) && is_end(&p2))
            })
        };
        let listed = sure.iter().copied().filter(needed).map(|NamedPlace { label, at, .. }| ListedLandmark {
            place: Place::File,
            label: label.clone(),
            position: Frame::Ras.turn(self.bearings.frame, *at).map(metres),
        });
        let landmarks = identify_landmarks(listed.collect())?;
        let (circle, notes) = Circle::at(network, &landmarks)?;
        let mut own: Vec<String> = self.frame_note().into_iter().collect();
        own.extend(notes);
        Ok((circle, own))
    }
}
