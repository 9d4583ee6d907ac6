//! Names the arteries of a Circle of Willis from their geometry alone, whole or broken, each name with a probability.
//!
//! An atlas holds where every 4 mm of every artery lies, how they run and how wide they are. The pose of a case in it is found from many
//! starts; then exact belief propagation over the centerlines finds the names of all nodes together. Candidates pass names as far as
//! they are believed, and what names say of a candidate comes back as a factor of its odds.

pub mod algebra;
pub mod atlas;
pub mod belief;
mod circle;
pub mod emission;
mod labelled;
pub mod model;
pub mod nodes;
pub mod pieces;
pub mod pose;
pub mod presence;

pub use circle::{CirclePrior, NamedCircle, NamedPlace, log_odds, nothing_named, topologies_say};
pub use labelled::labelled_network;
pub use model::{NamingModel, NamingScores};
pub use nodes::Nodes;

use std::path::Path;
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};

use crate::circle_of_willis::RING;
use atlas::{ArteryLabel, Atlas, LABELS, NOWHERE, OTHER, STATES, label_of, most_probable, states_of};
use belief::Beliefs;
use emission::{Pose, Search};
use nodes::is_traced;
use pieces::{PIECE_FEATURES, label_probabilities, piece_features};
use pose::{Core, Scored, core_at, find_cores};
use presence::Seen;
use willis_core::error::Result;
use willis_core::network::{Frame, Network, path_places::length_of, units::millimetres};

/// Rounds in which pieces of arteries that are taken twice settle.
const ROUNDS: usize = 3;
/// A name that fewer nodes than this are expected to have has no evidence.
const LEAST_EVIDENCE: f64 = 1e-3;
/// Frames whose log ratios differ by less than this for each node are near to each other.
const NEAR: f64 = 0.1;
/// A case has at least so much (mm) of pieces that are not false.
const LEAST_TRUE: f64 = 20.0;
/// More length (mm) than this is not named: some four million nodes.
const LONGEST: f64 = 4e6;

/// The names of the nodes of a case.
#[derive(Debug, Clone)]
pub struct Names {
    /// The nodes, in mm and RAS.
    pub nodes: Nodes,
    /// Whether the frame was found by front and back.
    pub frame_was_found: bool,
    /// How the case was found to lie, and by which model.
    pub bearings: Bearings,
    /// How well it fits there: the log ratio of all names to no artery of the circle, with the prior of the pose. NaN where the pose was known.
    pub fit: f64,
    /// Per node the probabilities of the labels.
    pub labels: Vec<[f64; LABELS]>,
    /// Per node the probabilities of the states, given that its piece is part of the circle: nodes x states.
    pub states: Vec<f64>,
    /// Per piece the probability that it is no artery of the circle.
    pub false_pieces: Vec<f64>,
    /// Whether they are of a part of the network: the circle of a whole brain.
    pub(crate) is_part: bool,
    /// What is seen of each label.
    pub seen: Seen,
    /// Per bridge of the nodes, by how much the names multiply its odds.
    pub bridge_factor: Vec<f64>,
    /// The features of the pieces in the first and in the second pass.
    pub piece_features: [Vec<[f64; PIECE_FEATURES]>; 2],
}

/// How a case was found to lie, and by which model.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Bearings {
    /// The frame of the network's file, stated or found.
    pub frame: Frame,
    /// How the case lies in the atlas.
    pub pose: Pose,
    /// The number of the model that named it, of [`NamingModels`].
    pub(crate) by: usize,
}

/// What one pass finds.
struct NamingPass {
    beliefs: Beliefs,
    /// The log likelihoods that they are of: nodes x states.
    log_likelihood: Vec<f64>,
    features: Vec<[f64; PIECE_FEATURES]>,
}

/// The names of the arteries in a network with positions: observed vessels get names, candidates and contacts are bridges. `None` for a
/// network without a vessel or without positions, and for one that is longer than any head has vessels.
pub fn name_arteries(network: &Network, model: &NamingModel) -> Option<Names> {
    let frames: &[Frame] = if network.frame.is_known() { &[network.frame] } else { &[Frame::Ras, Frame::Lps] };
    let frames: Option<Vec<_>> = frames.iter().map(|frame| Some((*frame, nodes_of(network, *frame)?))).collect();
    let mut found = find_cores(frames?, &model.atlas);
    // Pieces that are false may outweigh the others while the pose is searched: where the frames are that near to each other, the one counts
    // that fits better without such pieces.
    let score = |(_, _, poses): &(Frame, Core, Vec<Scored>)| poses.first().map_or(f64::NEG_INFINITY, |pose| pose.score);
    let best = found.iter().map(score).fold(f64::NEG_INFINITY, f64::max);
    found.retain(|one| score(one) >= best - NEAR * one.1.0.len() as f64);
    let named = found.into_iter().filter_map(|(frame, core, poses)| {
        let poses: Vec<Pose> = poses.iter().map(|scored| scored.pose).collect();
        names_at(network, model, frame, core, &poses, false)
    });
    let fit = |names: &Names| if names.fit.is_nan() { f64::NEG_INFINITY } else { names.fit };
    named.reduce(|first, second| if fit(&second) > fit(&first) { second } else { first })
}

/// The nodes of a network in a frame; `None` where there is none to name, or as many as no head has, which would fill the memory: a coordinate
/// with a wrong exponent, or a wrong unit.
fn nodes_of(network: &Network, frame: Frame) -> Option<Nodes> {
    let traced = is_traced(network);
    let along = |row: usize| length_of(&network.path_of(row));
    let length: f64 = (0..traced.len()).filter(|row| traced[*row]).map(along).sum();
    (network.has_positions() && millimetres(length) <= LONGEST)
        .then(|| Nodes::of(network, frame))
        .filter(|nodes| !nodes.is_empty())
}

/// The names of the arteries in a network that lies where `like` was found to lie: the same vessels, with other candidates.
pub fn name_again(network: &Network, model: &NamingModel, like: &Bearings) -> Option<Names> {
    let core = core_at(nodes_of(network, like.frame)?, &model.atlas, &like.pose)?;
    names_at(network, model, like.frame, core, &[like.pose], true)
}

/// The names at the best of some poses: the best first, found without knowing which pieces are false, or the one where the same vessels are
/// known to lie.
fn names_at(
    network: &Network,
    model: &NamingModel,
    frame: Frame,
    (nodes, median_of_all): Core,
    poses: &[Pose],
    is_known: bool,
) -> Option<Names> {
    let atlas = &model.atlas;
    let mut pose = *poses.first()?;
    let one = vec![1.0; nodes.len()];

    let mut median = median_of_all.unwrap_or_else(|| nodes.median_log_radius(|_| 1.0));
    let mut used = nodes.spanning_bridges(|_| true);
    let first = pass(&Search::new(&nodes, atlas, &one, &used, median), &pose);
    // Which pieces are false was learned where all that is traced is a circle; of a whole brain it would take away a quarter of its names,
    // which are right as often as the others are.
    let is_part = median_of_all.is_some();
    let nowhere = |pass: &NamingPass| {
        let each = pass.beliefs.states.chunks(STATES).zip(&nodes.piece).zip(&nodes.weight);
        let (mut sum, mut length) = (vec![0.0; nodes.pieces], vec![f64::MIN_POSITIVE; nodes.pieces]);
        for ((states, piece), weight) in each {
            sum[*piece] += weight * states[NOWHERE];
            length[*piece] += weight;
        }
        sum.iter().zip(&length).map(|(sum, length)| sum / length).collect()
    };
    let doubt: Vec<f64> =
        if is_part { nowhere(&first) } else { first.features.iter().map(|x| model.is_false(x, None)).collect() };

    let mut weight: Vec<f64> = nodes.piece.iter().map(|piece| 1.0 - doubt[*piece]).collect();
    let counted: f64 = weight.iter().zip(&nodes.weight).map(|(share, length)| share * length).sum();
    let is_enough = counted >= LEAST_TRUE;
    if is_enough {
        if !is_part {
            median = nodes.median_log_radius(|n| weight[n]);
        }
        used = nodes.spanning_bridges(|piece| doubt[piece] < 0.5);
    } else {
        weight = one;
    }
    let case = Search::new(&nodes, atlas, &weight, &used, median);
    let mut fit = f64::NAN;
    if let Some(found) = (is_enough && !is_known).then(|| case.around(poses)).and_then(|found| found.first().copied()) {
        (pose, fit) = (found.pose, found.score);
    }
    let second = pass(&case, &pose);
    let again = |(x, before): (_, &f64)| model.is_false(x, Some((before + 1e-3).ln()));
    let false_pieces: Vec<f64> = if is_part { nowhere(&second) } else { second.features.iter().zip(&doubt).map(again).collect() };

    let states = &second.beliefs.states;
    let labels = if is_part {
        states.chunks(STATES).map(|states| label_probabilities(states, atlas)).collect()
    } else {
        labels_of(&nodes, states, &false_pieces, atlas)
    };
    let bridge_factor = belief::factors(&nodes, atlas, &second.beliefs, &false_pieces);
    let evidence = evidence(&case, &second);
    let seen = Seen::of(&nodes, &labels, &false_pieces, &bridge_factor, evidence);
    Some(Names {
        is_part,
        states: second.beliefs.states,
        frame_was_found: !network.frame.is_known(),
        piece_features: [first.features, second.features],
        bearings: Bearings { frame, pose, by: 0 },
        nodes,
        fit,
        labels,
        false_pieces,
        seen,
        bridge_factor,
    })
}

/// Per node the probabilities of the labels, from those of the states and of its piece being false.
pub fn labels_of(nodes: &Nodes, states: &[f64], false_pieces: &[f64], atlas: &Atlas) -> Vec<[f64; LABELS]> {
    let each = states.chunks(STATES).zip(&nodes.piece).map(|(states, piece)| {
        let mut labels = label_probabilities(states, atlas);
        let (doubt, artery) = (false_pieces[*piece], 1.0 - labels[OTHER] + 1e-12);
        for p in &mut labels {
            *p *= (1.0 - doubt) / artery;
        }
        labels[OTHER] = doubt;
        labels
    });
    each.collect()
}

/// The names at a pose, with one of every artery, and the features of the pieces.
fn pass(case: &Search, pose: &Pose) -> NamingPass {
    let fit = case.fit(pose, &case.atlas.position);
    let (beliefs, log_likelihood) = case.settled(&case.tempered(&fit), ROUNDS);
    let features = piece_features(case, &fit, &beliefs.states);
    NamingPass { beliefs, log_likelihood, features }
}

/// For each segment of the ring minus the logarithm of the probability that no node has its name.
fn evidence(case: &Search, pass: &NamingPass) -> [f64; 7] {
    let states = RING.map(|segment| states_of(label_of(segment)));
    // What hardly any node may be says nothing: the sum of the probabilities is more than that of any.
    let is_asked = states.each_ref().map(|own| {
        let expected: f64 = pass.beliefs.states.chunks(STATES).flat_map(|row| &row[own.clone()]).sum();
        expected >= LEAST_EVIDENCE
    });
    let asked: Vec<_> = states.iter().zip(is_asked).filter(|(_, is_asked)| *is_asked).map(|(own, _)| own).collect();
    let mut found = case.forest.evidence(case.atlas, &pass.log_likelihood, &pass.beliefs, &asked).into_iter();
    is_asked.map(|is_asked| if is_asked { found.next().unwrap_or(0.0) } else { 0.0 })
}

impl Names {
    /// The expected length (mm) that is seen of a segment of [`crate::circle_of_willis::RING`].
    pub fn seen_length(&self, segment: usize) -> f64 {
        self.seen.length[label_of(RING[segment])]
    }

    /// The share of the length that is an artery of the circle.
    pub fn share_named(&self) -> f64 {
        let all: f64 = self.nodes.weight.iter().sum();
        (all - self.seen.length[OTHER]) / all.max(f64::MIN_POSITIVE)
    }

    /// The most probable label of each node.
    pub fn best(&self) -> Vec<ArteryLabel> {
        self.labels.iter().map(most_probable).collect()
    }
}

/// The models that ship: of patients, and of the drawn circle of `willis phantom`.
const SHIPPED: [(&str, &str); 2] = [("arteries.toml", include_str!("arteries.toml")), ("drawn.toml", include_str!("drawn.toml"))];
/// Where the first model names this share of the length, no other one is asked; nor of a whole brain.
const ENOUGH: f64 = 0.8;

/// Models that name arteries, the one that is asked first before the others.
#[derive(Debug, Clone)]
pub struct NamingModels(Vec<Arc<NamingModel>>);

impl NamingModels {
    /// The models that ship with willis.
    ///
    /// # Errors
    ///
    /// None in a released version: a test reads them.
    pub fn shipped() -> Result<Self> {
        // A cohort asks for every subject.
        static MODELS: OnceLock<NamingModels> = OnceLock::new();
        if let Some(models) = MODELS.get() {
            return Ok(models.clone());
        }
        let read =
            |(path, text): &(&str, &str)| NamingModel::read(text).map(Arc::new).map_err(|fault| fault.in_file(Path::new(path)));
        let models = Self(SHIPPED.iter().map(read).collect::<Result<_>>()?);
        Ok(MODELS.get_or_init(|| models).clone())
    }

    /// One model alone.
    pub fn one(model: NamingModel) -> Self {
        Self(vec![Arc::new(model)])
    }

    /// The names of a network by the model that it fits best: see [`name_arteries`].
    pub fn name(&self, network: &Network) -> Option<Names> {
        let mut best: Option<Names> = None;
        for (by, model) in self.0.iter().enumerate() {
            let Some(mut names) = name_arteries(network, model) else { continue };
            // Of a whole brain each atlas names another part, so that their fits do not compare; and drawn circles are no brains.
            if by == 0 && (names.share_named() >= ENOUGH || names.is_part) {
                return Some(names);
            }
            // A case of which a model knows next to nothing has no fit.
            let fit = |names: &Names| names.fit.max(f64::MIN);
            if best.as_ref().is_none_or(|known| fit(&names) > fit(known)) {
                names.bearings.by = by;
                best = Some(names);
            }
        }
        best
    }

    /// The names by the same model of a network that lies where `like` was found to lie: see [`name_again`].
    pub fn name_again(&self, network: &Network, like: &Bearings) -> Option<Names> {
        let mut names = name_again(network, self.0.get(like.by)?, like)?;
        names.bearings.by = like.by;
        Some(names)
    }

    /// The model that gave some names.
    pub fn of(&self, names: &Names) -> &NamingModel {
        &self.0[names.bearings.by]
    }
}
