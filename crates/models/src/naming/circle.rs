//! The circle of a network whose arteries were named: its landmarks, and what names and topologies together say of each segment.

use std::collections::BTreeMap;

use Artery::{A1, A2, Ica, M1, M2, P1, P2, PComm};
use serde::{Deserialize, Serialize};

use super::atlas::{
    ArteryLabel, Atlas, BA, LABELS, OTHER, STATES, artery_of, as_one_with_m1, bins_of, first_state, label_named, label_of,
    mirrored, most_probable, name_of, row, states_of,
};
use super::model::{NamingModel, TOPOLOGY_FEATURE};
use super::{Names, belief::probability_with, nodes::Nodes, presence::kind_of};
use crate::circle_of_willis::{
    Artery, BodySide, Circle, FEEDERS, LabelScheme, Posterior, RING, VariantFrequencies, artery_of_label, identify_landmarks,
};
use willis_core::decision::{KnownEnds, Topologies};
use willis_core::error::{Fault, Place, ensure};
use willis_core::network::units::{metres, millimetres};
use willis_core::network::{Frame, Network};
use willis_core::sampling::SamplingOptions;
use willis_core::support::geometry::{Point, distance, dot, lerp, sub, weighted_centroid};
use willis_core::support::{numbered::marked, statistics::sigmoid};
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
            RING.map(|artery| of[artery.opposite().in_ring().unwrap_or_default()])
        }
        let other = |name: String| label_named(&name).map_or(name, |label| name_of(mirrored(label)));
        Self {
            log_odds: exchanged(self.log_odds),
            topology_weight: exchanged(self.topology_weight),
            share: exchanged(self.share),
            is_decidable: exchanged(self.is_decidable),
            is_in_view: exchanged(self.is_in_view),
            diameters: exchanged(self.diameters),
            factors: self.factors,
            names: self.names.into_iter().map(|(row, name)| (row, other(name))).collect(),
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
    let known = marked(network.node_count(), circle.ends(&network));
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
            let is_own = |label: &ArteryLabel| artery_of(*label).and_then(Artery::side) == Some(side);
            let own = |labels: &[f64; LABELS]| (0..LABELS).filter(is_own).map(|label| labels[label]).sum::<f64>();
            weighted_centroid(self.nodes.at.iter().zip(&self.labels).map(|(at, labels)| (*at, own(labels))))
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
            let weights = || self.labels.iter().zip(&self.nodes.weight).map(|(p, length)| p[label] * length);
            let total: f64 = weights().sum();
            let sum: f64 = weights().zip(&self.nodes.log_radius).map(|(w, log_radius)| w * 2.0 * log_radius.exp()).sum();
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

    /// The middle of the closest pair of nodes of two groups of labels, with the smaller of their probabilities; `None` where they do not
    /// meet. `best` is the label of each node.
    fn meeting_place(&self, best: &[ArteryLabel], between: &[Vec<ArteryLabel>; 2]) -> Option<(Point, f64)> {
        let at = &self.nodes.at;
        let [one, other] = between.each_ref().map(|of| (0..at.len()).filter(|n| of.contains(&best[*n])).collect::<Vec<_>>());
        let pairs = one.iter().flat_map(|a| other.iter().map(|b| (distance(at[*a], at[*b]), *a, *b)));
        let (d, a, b) = pairs.reduce(|closest, next| if next.0 < closest.0 { next } else { closest })?;
        let sure = |n: usize, group: &[ArteryLabel]| group.iter().map(|label| self.labels[n][*label]).sum::<f64>();
        (d <= LIMIT).then(|| (lerp(at[a], at[b], 0.5), sure(a, &between[0]).min(sure(b, &between[1]))))
    }

    /// Where a bifurcation lies of which only one artery is seen: on that artery, nearest to where the atlas has it. `None` where neither is seen,
    /// or where the posterior communicating artery that makes it is not.
    fn expected_place(&self, best: &[ArteryLabel], atlas: &Atlas, meeting: &Meeting) -> Option<(Point, f64)> {
        let has = |label: ArteryLabel| best.contains(&label);
        let labels = || meeting.between.iter().flatten().copied();
        if labels().find(|label| matches!(artery_of(*label), Some(Artery::PComm(_)))).is_some_and(|pcomm| !has(pcomm)) {
            return None;
        }
        let (at, expected) = (&self.nodes.at, self.bearings.pose.undo(atlas.data.pieces[first_state(meeting.at)].mean));
        let near = (0..at.len()).filter(|n| labels().any(|label| label == best[*n])).map(|n| (distance(at[n], expected), n));
        let (away, n) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (away <= EXPECTED_WITHIN).then(|| (at[n], ONE_SIDED))
    }

    /// The landmarks: bifurcations where two named arteries meet, and where arteries enter or leave.
    pub fn landmarks(&self, model: &NamingModel) -> Vec<NamedPlace> {
        let best = self.best();
        let place = |meeting: Meeting| {
            let both_seen = self.meeting_place(&best, &meeting.between);
            let (at, probability) = both_seen.or_else(|| self.expected_place(&best, &model.atlas, &meeting))?;
            Some(NamedPlace { label: meeting.label, at, probability })
        };
        let mut places: Vec<NamedPlace> = meetings().into_iter().filter_map(place).collect();
        // Where PComm ends at P1 and P2, that is where they meet too.
        for side in BodySide::BOTH {
            let short = format!("{}/{}", Artery::P1(side), Artery::P2(side));
            let long = format!("{short}/{}", Artery::PComm(side));
            if places.iter().any(|place| place.label == long) {
                places.retain(|place| place.label != short);
            }
        }
        places.extend(ends(&self.nodes, &self.labels, &self.states, &model.atlas, &best));
        places
    }

    /// The circle with the sure landmarks, in a network of the same positions, with notes for the user.
    ///
    /// # Errors
    ///
    /// Too few arteries; no inlet among them.
    pub fn located(&self, network: &Network, model: &NamingModel) -> Result<(Circle, Vec<String>), Fault> {
        ensure(self.is_circle(), || nothing_named(network))?;
        let listed = self.landmarks(model);
        let mut sure: Vec<&NamedPlace> = listed.iter().filter(|place| place.probability >= SURE).collect();
        // Blood comes in somewhere: where no place is sure, at the likeliest.
        let is_inlet = |place: &&NamedPlace| artery_of_label(&place.label, LabelScheme::Names).is_some_and(Artery::brings_blood);
        let likeliest = if sure.iter().any(is_inlet) {
            None
        } else {
            let listed = listed.iter().filter(is_inlet).max_by(|a, b| a.probability.total_cmp(&b.probability));
            listed.cloned().or_else(|| likeliest_inlet(&self.nodes, &self.labels))
        };
        sure.extend(&likeliest);
        // Where the ends of all arteries at a bifurcation are seen, these say more than a bifurcation that may lie in a gap.
        let is_end = |label: &str| sure.iter().any(|place| place.label == label);
        let needed = |place: &&NamedPlace| {
            BodySide::BOTH.iter().all(|side| {
                let [ica, m1, a1, a2, p1, p2] = [Ica, M1, A1, A2, P1, P2].map(|artery| artery(*side).to_string());
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

/// That no circle of Willis could be named in a network.
pub fn nothing_named(network: &Network) -> Fault {
    let found =
        if network.has_positions() { "no arteries of a circle of Willis could be named" } else { "a node without coordinates" };
    let accepted = "expected centerlines of a head in mm, within some 30 degrees of RAS or LPS, or labels that name an internal carotid, \
                    basilar or vertebral artery, or `landmarks=FILE`";
    Fault::file(found, accepted)
}

/// Nodes of two arteries that meet are no further apart, mm.
const LIMIT: f64 = 12.0;

/// A place that has a name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPlace {
    /// `L-ICA/L-M1/L-A1` for a bifurcation, `L-ICA` for where an artery enters or leaves.
    pub label: String,
    /// Its position in mm, RAS.
    pub at: Point,
    /// How probable the names on which it rests are.
    pub probability: f64,
}

/// A bifurcation: two groups of labels that meet there, and the state of the atlas that lies there.
pub struct Meeting {
    /// Its name.
    pub label: String,
    /// The labels on the one side, and those on the other.
    pub between: [Vec<ArteryLabel>; 2],
    /// The label at whose reference end it lies.
    pub at: ArteryLabel,
}

/// Every bifurcation that has a name.
pub fn meetings() -> Vec<Meeting> {
    let mut all = Vec::new();
    for side in BodySide::BOTH {
        let mut add = |labels: &[ArteryLabel], one: &[ArteryLabel], other: &[ArteryLabel], at: ArteryLabel| {
            let label = labels.iter().map(|l| name_of(*l)).collect::<Vec<_>>().join("/");
            all.push(Meeting { label, between: [one.to_vec(), other.to_vec()], at });
        };
        let [ica, m1, m2, a1, a2, p1, p2, pcomm] = [Ica, M1, M2, A1, A2, P1, P2, PComm].map(|artery| label_of(artery(side)));
        add(&[ica, m1, a1], &[ica], &[m1, a1], ica);
        add(&[a1, a2, label_of(Artery::AComm)], &[a1], &[a2], a2);
        add(&[m1, m2], &[m1], &[m2], m2);
        add(&[ica, pcomm], &[ica], &[pcomm], pcomm);
        add(&[p1, p2, pcomm], &[pcomm], &[p1, p2], p2);
        add(&[p1, p2], &[p1], &[p2], p2);
    }
    let p1 = BodySide::BOTH.map(|side| label_of(Artery::P1(side)));
    all.push(Meeting { label: format!("BA/{}/{}", name_of(p1[0]), name_of(p1[1])), between: [vec![BA], p1.to_vec()], at: BA });
    all
}

/// How far (mm) the place that the atlas expects may be from a vessel that is there.
const EXPECTED_WITHIN: f64 = 12.0;
/// The probability of a place of which only one side is seen.
const ONE_SIDED: f64 = 0.25;

/// The ends of arteries that enter or leave the circle: of every label its free end that is farthest along it.
pub fn ends(nodes: &Nodes, labels: &[[f64; LABELS]], states: &[f64], atlas: &Atlas, best: &[ArteryLabel]) -> Vec<NamedPlace> {
    let mut found: BTreeMap<ArteryLabel, (f64, usize)> = BTreeMap::new();
    for n in (0..nodes.len()).filter(|n| nodes.degree(*n) <= 1 && best[*n] != OTHER) {
        let of_states = row(states, n);
        let label = best[n];
        let (mut along, mut sum) = (0.0, 1e-9);
        for (state, p) in of_states.iter().enumerate().filter(|(state, _)| atlas.tables.label[*state] == label) {
            along += p * atlas.tables.bin[state] as f64;
            sum += p;
        }
        let key = along / sum;
        if found.get(&label).is_none_or(|(known, _)| key > *known) {
            found.insert(label, (key, n));
        }
    }
    // An artery that goes on under another name ends there.
    let leaves = |of: ArteryLabel| match artery_of(of) {
        Some(Artery::Ba | Artery::Ica(_) | Artery::M2(_) | Artery::A2(_) | Artery::P2(_)) => true,
        Some(Artery::M1(side)) => !found.contains_key(&label_of(Artery::M2(side))),
        _ => false,
    };
    let kept = found.iter().filter(|(label, _)| leaves(**label));
    let mut places: Vec<NamedPlace> = kept
        .map(|(of, (_, n))| NamedPlace { label: name_of(as_one_with_m1(*of)), at: nodes.at[*n], probability: labels[*n][*of] })
        .collect();
    if let Some(vertebral) = vertebral_ends(nodes, labels, states, best) {
        places.retain(|place| place.label != name_of(BA));
        places.extend(vertebral);
    }
    places
}

/// The free end that is likeliest of an artery by which blood enters; `None` without a free end.
pub fn likeliest_inlet(nodes: &Nodes, labels: &[[f64; LABELS]]) -> Option<NamedPlace> {
    let ends = (0..nodes.len()).filter(|n| nodes.degree(*n) <= 1);
    let each = ends.flat_map(|n| {
        FEEDERS.map(|artery| NamedPlace { label: artery.to_string(), at: nodes.at[n], probability: labels[n][label_of(artery)] })
    });
    each.max_by(|a, b| a.probability.total_cmp(&b.probability))
}

/// Ends of the basilar artery further apart than this (mm) from left to right are those of the vertebral arteries, which the states of the
/// basilar artery hold.
const VERTEBRAL: f64 = 15.0;

/// Where the vertebral arteries enter: of the free ends that lie as far along the basilar artery as its states go, the lowest on the left
/// and on the right of their middle.
fn vertebral_ends(nodes: &Nodes, labels: &[[f64; LABELS]], states: &[f64], best: &[ArteryLabel]) -> Option<[NamedPlace; 2]> {
    let last = first_state(BA) + bins_of(BA) - 1;
    let is_end = |n: &usize| best[*n] == BA && nodes.degree(*n) <= 1 && states[n * STATES + last] > 0.5;
    let ends: Vec<usize> = (0..nodes.len()).filter(is_end).collect();
    let across = |n: usize| nodes.at[n][0];
    let (least, most) = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), n| (a.min(across(*n)), b.max(across(*n))));
    let lowest = |side: BodySide| {
        let own = ends.iter().filter(|n| (2.0 * across(**n) < least + most) == (side == BodySide::Left));
        own.min_by(|a, b| nodes.at[**a][2].total_cmp(&nodes.at[**b][2]))
    };
    let (left, right) = (lowest(BodySide::Left)?, lowest(BodySide::Right)?);
    let place = |label: &str, n: usize| NamedPlace { label: label.to_owned(), at: nodes.at[n], probability: labels[n][BA] };
    (most - least > VERTEBRAL).then(|| [place("L-VA", *left), place("R-VA", *right)])
}
