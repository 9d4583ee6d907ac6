//! Where each artery of the Circle of Willis lies in a network, by labels or by landmarks; on which side, and how wide.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::arteries::{Artery, ArteryVessels, BodySide, RING, Variant};
use super::labels::{LabelScheme, artery_of_label, names_no_artery};
use super::landmarks::{Landmark, Site, end_of, free_end, nearest_node_of, sites};
use super::segments_by_labels::{self, LabelMeaning};
use super::segments_by_landmarks::Points;
use willis_core::network::{NearestNode, Network, Origin, units::millimetres};
use willis_core::support::geometry::{Point, centroid, cross, distance, dot, lerp, sub, unit};
use willis_core::{error::Fault, support::distinct, support::in_order};

/// Where the arteries lie in a network.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Circle {
    location: Location,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
enum Location {
    /// The meaning of the label of each vessel.
    Vessels(Vec<LabelMeaning>),
    /// The nodes of inlets, outlets and bifurcations.
    Nodes(Box<Points>),
}

/// How a note ends that gives the node of a landmark. No other note ends so.
pub const LANDMARK_NOTE_ENDING: &str = " mm away";
impl Circle {
    /// The circle of a network whose vessels are labelled, with notes for the user.
    ///
    /// # Errors
    ///
    /// No vessel is labelled as an internal carotid, basilar or vertebral artery; a label is not a code of the scheme.
    pub fn labelled(network: &Network, scheme: LabelScheme) -> Result<(Self, Vec<String>), Fault> {
        let mut unknown = BTreeMap::new();
        let mut meanings = Vec::with_capacity(network.vessel_count());
        for (_, vessel) in network.vessels() {
            // A format that has names for its numbers, as iCafe's, has put them in their place.
            let named = || artery_of_label(&vessel.label, LabelScheme::Names).filter(|_| scheme != LabelScheme::Names);
            meanings.push(match artery_of_label(&vessel.label, scheme).or_else(named) {
                _ if names_no_artery(&vessel.label) => LabelMeaning::Free,
                Some(artery) => LabelMeaning::Artery(artery),
                None => {
                    *unknown.entry(vessel.label.trim().to_owned()).or_insert(0_usize) += 1;
                    LabelMeaning::Other
                }
            });
        }
        let number = unknown.keys().find(|label| label.parse::<u32>().is_ok());
        if let (Some(label), LabelScheme::ICafe | LabelScheme::TopCow) = (number, scheme) {
            let codes = if scheme == LabelScheme::ICafe { "1 to 22" } else { "1 to 12 and 15" };
            return Err(Fault::item(
                format!("label \"{label}\""),
                format!("none of {}", scheme.name()),
                format!("expected {codes}"),
            ));
        }
        if !meanings.iter().any(|meaning| matches!(meaning, LabelMeaning::Artery(artery) if artery.brings_blood())) {
            return Err(Fault::file(
                "no vessel is labelled as an internal carotid, basilar or vertebral artery",
                "expected labels such as L-ICA, R-ICA, BA, L-VA (`labels=icafe|topcow` for numbers), or give `landmarks=FILE`",
            ));
        }
        let mut notes = Vec::new();
        if !unknown.is_empty() {
            let names: Vec<&str> = unknown.keys().map(String::as_str).collect();
            notes.push(format!("not arteries of the circle, and so no part of it: {}", names.join(", ")));
        }
        notes.extend(side_notes(&mean_positions(network, &meanings)));
        Ok((Self { location: Location::Vessels(meanings) }, notes))
    }

    /// The circle of a network with landmarks, each at its nearest node, with notes for the user.
    ///
    /// Where two inlets or outlets have the same nearest node, the nearer one gets it and the other its next free end; without one
    /// within reach it counts as not seen.
    ///
    /// # Errors
    ///
    /// A landmark too far from every vessel; no landmark of an inlet; nodes without positions.
    pub fn at(network: &Network, landmarks: &[Landmark]) -> Result<(Self, Vec<String>), Fault> {
        if !landmarks.iter().any(|landmark| matches!(landmark.arteries[..], [single] if single.brings_blood())) {
            return Err(Fault::file(
                "no inlet among the landmarks",
                "expected one at least of L-ICA, R-ICA, BA, L-VA, R-VA: where it enters the field of view",
            ));
        }
        let mut notes = Vec::new();
        let found = landmarks.iter().enumerate().map(|(row, one)| Ok((row, one, nearest_node_of(network, one)?)));
        let mut found = found.collect::<Result<Vec<_>, Fault>>()?;
        let (mut points, mut taken) = (Points::default(), BTreeMap::new());
        while let Some((row, landmark, nearest)) = take_nearest(&mut found) {
            let sites = landmark.sites();
            let is_end = sites.iter().any(|site| site.is_end() && *site != Site::Feeder);
            if is_end && let Some(first) = taken.get(&nearest.node) {
                if let Some(next) = free_end(network, landmark.position, &|node| taken.contains_key(&node)) {
                    found.push((row, landmark, next));
                } else {
                    notes.push(format!("{} is taken as not seen: the end nearest to it is that of {first}", landmark.label));
                }
                continue;
            }
            if is_end {
                taken.insert(nearest.node, &landmark.label);
            }
            if sites.iter().any(|site| site.is_end()) {
                let (is_last, note) = end_of(network, landmark, &nearest);
                notes.extend(note);
                points.ends.extend(is_last.then_some(nearest.node));
                let is_outlet = is_last && sites.iter().any(|site| site.is_outlet());
                points.outlets.extend(is_outlet.then_some(nearest.node));
            }
            for site in sites {
                site.put(&mut points, nearest.node);
            }
            let node = &network.node(nearest.node).id;
            notes.push(format!("{} at node {node}, {:.3}{LANDMARK_NOTE_ENDING}", landmark.label, millimetres(nearest.distance)));
        }
        for s in [0, 1] {
            points.m1[s] = points.m1[s].or(points.middle[s]);
            points.a2[s] = points.a2[s].or(points.anterior[s]);
            points.p2[s] = points.p2[s].or(points.posterior[s]);
        }
        let at = landmarks.iter().filter_map(|l| if let [one] = l.arteries[..] { Some((one, l.position)) } else { None });
        notes.extend(side_notes(&at.collect()));
        Ok((Self { location: Location::Nodes(Box::new(points)) }, notes))
    }

    /// The anatomy in the vessels that `kept` selects. The network must be the one in which the circle was found, or have the same nodes
    /// and vessels in the same rows. It takes a few shortest paths, so that the time is nearly proportional to the network.
    pub fn variant(&self, network: &Network, kept: impl Fn(usize) -> bool) -> Variant {
        self.variant_between(network, &self.between(network), kept)
    }

    /// The anatomy in each of some topologies, given as the vessels that they keep with their weights; as [`Circle::variant`].
    pub fn variants(&self, network: &Network, topologies: &[(Vec<bool>, f64)]) -> Vec<Variant> {
        let between = self.between(network);
        in_order(topologies, |_, (kept, _)| self.variant_between(network, &between, |row| kept[row]))
    }

    /// The vessels that may lie between landmarks; none where labels say what vessels are.
    fn between(&self, network: &Network) -> Vec<bool> {
        match &self.location {
            Location::Vessels(_) => Vec::new(),
            Location::Nodes(points) => points.between(network),
        }
    }

    fn variant_between(&self, network: &Network, between: &[bool], kept: impl Fn(usize) -> bool) -> Variant {
        match &self.location {
            Location::Vessels(meanings) => segments_by_labels::variant(meanings, network, &kept),
            Location::Nodes(points) => points.variant(network, between, &kept),
        }
    }

    /// The network of the vessels that `kept` selects, and the vessels of each artery in it.
    pub fn arteries_in(&self, network: &Network, kept: impl Fn(usize) -> bool) -> (Network, ArteryVessels) {
        let (network, rows) = network.subgraph(kept);
        let arteries = match &self.location {
            Location::Vessels(meanings) => {
                segments_by_labels::artery_vessels(&rows.iter().map(|row| meanings[*row]).collect::<Vec<_>>(), &network)
            }
            Location::Nodes(points) => points.artery_vessels(&network),
        };
        (network, arteries)
    }

    /// Whether this may be the circle of a network, by the number of its vessels or nodes.
    pub fn fits(&self, network: &Network) -> bool {
        match &self.location {
            Location::Vessels(meanings) => meanings.len() == network.vessel_count(),
            Location::Nodes(points) => points.nodes().all(|node| node < network.node_count()),
        }
    }

    /// The same circle where each node has another row.
    pub fn follow(&mut self, node_now: &[usize]) {
        if let Location::Nodes(points) = &mut self.location {
            points.follow(node_now);
        }
    }

    /// The nodes where blood enters, by landmarks of carotid, basilar and vertebral arteries. Labels give none.
    pub fn inlets(&self) -> Vec<usize> {
        let Location::Nodes(points) = &self.location else { return Vec::new() };
        points.ica.iter().flatten().chain(&points.feeders).copied().collect()
    }

    /// The free ends where blood leaves, by landmarks of M1, A2, P2 and a third A2. Labels give none.
    pub fn outlets(&self) -> Vec<usize> {
        let Location::Nodes(points) = &self.location else { return Vec::new() };
        points.outlets.clone()
    }

    /// The nodes of landmarks that lie on one side, with the side. Labels give none.
    pub fn sided_nodes(&self) -> Vec<(BodySide, usize)> {
        let Location::Nodes(points) = &self.location else { return Vec::new() };
        let pairs = [points.ica, points.m1, points.a2, points.p2, points.middle, points.posterior];
        let of = |side: BodySide| pairs.into_iter().filter_map(move |pair| Some((side, pair[side.index()]?)));
        BodySide::BOTH.into_iter().flat_map(of).collect()
    }

    /// The nodes where blood enters by the labels of vessels: the outermost free end of each carotid and vertebral, and of the basilar artery
    /// where no vertebral is labelled. Landmarks give none.
    pub fn labelled_inlets(&self, network: &Network) -> Vec<usize> {
        let Location::Vessels(meanings) = &self.location else { return Vec::new() };
        let ends = outermost_ends(network, meanings);
        let has_vertebral = ends.keys().any(|artery| matches!(artery, Artery::Va(_)));
        let enters = |artery: &Artery| artery.brings_blood() && !(has_vertebral && *artery == Artery::Ba);
        ends.into_iter().filter(|(artery, _)| enters(artery)).map(|(_, node)| node).collect()
    }

    /// The nodes where an artery enters or leaves, so that no vessel continues there: landmarks of inlets and outlets, or for every
    /// labelled artery that enters or leaves the circle its free end farthest from the middle.
    pub fn ends(&self, network: &Network) -> Vec<usize> {
        match &self.location {
            Location::Vessels(meanings) => distinct(outermost_ends(network, meanings).into_values()),
            Location::Nodes(points) => distinct(points.ends.iter().copied()),
        }
    }
}

/// Removes the landmark that is nearest to its node; of several the first in the file.
fn take_nearest<'a>(found: &mut Vec<(usize, &'a Landmark, NearestNode)>) -> Option<(usize, &'a Landmark, NearestNode)> {
    let key = |at: &usize| (found[*at].2.distance, found[*at].0);
    let first = (0..found.len()).min_by(|a, b| key(a).0.total_cmp(&key(b).0).then(key(a).1.cmp(&key(b).1)))?;
    Some(found.swap_remove(first))
}

/// For every artery that enters or leaves the circle, its free end farthest from the mean position of all arteries.
fn outermost_ends(network: &Network, meanings: &[LabelMeaning]) -> BTreeMap<Artery, usize> {
    let centre = centroid(mean_positions(network, meanings).into_values());
    let degree = network.degrees(|vessel| vessel.origin == Origin::Observed);
    let mut found: BTreeMap<Artery, (f64, usize)> = BTreeMap::new();
    for (row, meaning) in meanings.iter().enumerate() {
        let LabelMeaning::Artery(artery) = meaning else { continue };
        if sites(&[*artery], false).is_empty() {
            continue;
        }
        for node in network.ends(row).into_iter().filter(|node| degree[*node] == 1) {
            let away = network.node(node).position.map_or(0.0, |position| distance(position, centre));
            let farthest = found.entry(*artery).or_insert((away, node));
            if away > farthest.0 {
                *farthest = (away, node);
            }
        }
    }
    found.into_iter().map(|(artery, (_, node))| (artery, node)).collect()
}

/// The mean position of the ends of the vessels of every artery, m.
fn mean_positions(network: &Network, meanings: &[LabelMeaning]) -> BTreeMap<Artery, Point> {
    let mut ends: BTreeMap<Artery, Vec<Point>> = BTreeMap::new();
    for (row, meaning) in meanings.iter().enumerate() {
        let LabelMeaning::Artery(artery) = meaning else { continue };
        let placed = network.ends(row).into_iter().filter_map(|node| network.node(node).position);
        placed.for_each(|position| ends.entry(*artery).or_default().push(position));
    }
    ends.into_iter().map(|(artery, ends)| (artery, centroid(ends))).collect()
}

/// The arteries that lie aside of the midline, so that one alone shows its side.
const ASIDE: [fn(BodySide) -> Artery; 5] = [Artery::M1, Artery::Mca, Artery::P2, Artery::Pca, Artery::PComm];
/// The others whose left one lies to the left of the right one. Two A2 may run side by side.
const PAIRED: [fn(BodySide) -> Artery; 2] = [Artery::A1, Artery::P1];
/// The right one of a pair must lie so far to the left of the left one, m.
const EXCHANGED: f64 = 0.003;
/// One alone must lie so far beyond the midline, m.
const BEYOND: f64 = 0.005;

/// The arteries that lie on the other side than the carotids of their name, or than M1, MCA or A1 where the carotids are not both known: both of a
/// pair, or one whose other is not known. And the words for what they were held against. Nothing where no such pair is known.
///
/// A mirrored file has none: its carotids lie on the other side too, which [`sides_look_exchanged`] looks at.
fn on_the_wrong_side(at: &BTreeMap<Artery, Point>) -> (Vec<Artery>, &'static str) {
    let pair = |artery: fn(BodySide) -> Artery| Some([*at.get(&artery(BodySide::Left))?, *at.get(&artery(BodySide::Right))?]);
    let carotids = (Artery::Ica as fn(BodySide) -> Artery, "the carotids");
    let references = [carotids, (Artery::M1, "both M1"), (Artery::Mca, "both MCA"), (Artery::A1, "both A1")];
    let reference = references.into_iter().find_map(|(artery, name)| Some((pair(artery)?, name)));
    let Some(([left, right], held_against)) = reference else { return (Vec::new(), "") };
    let (rightward, middle) = (unit(sub(right, left)), lerp(left, right, 0.5));
    let mut wrong = Vec::new();
    for (row, artery) in ASIDE.into_iter().chain(PAIRED).enumerate() {
        match pair(artery) {
            Some([left, right]) if dot(sub(right, left), rightward) < -EXCHANGED => wrong.extend(BodySide::BOTH.map(artery)),
            None if row < ASIDE.len() => {
                let is_beyond = |side: BodySide, p: &Point| {
                    let away = dot(sub(*p, middle), rightward);
                    if side == BodySide::Left { away > BEYOND } else { away < -BEYOND }
                };
                let one = BodySide::BOTH.into_iter().find_map(|side| Some((side, at.get(&artery(side))?)));
                wrong.extend(one.filter(|(side, p)| is_beyond(*side, p)).map(|(side, _)| artery(side)));
            }
            _ => {}
        }
    }
    (distinct(wrong), held_against)
}

const LOOKS_EXCHANGED: &str = "left and right look exchanged, unless the axes of the input are left-handed (as LAS): front, top and right do not fit together";

/// What to tell of sides that look exchanged, of all arteries or of some, given the mean positions of arteries (m).
pub(crate) fn side_notes(at: &BTreeMap<Artery, Point>) -> Vec<String> {
    let mut notes: Vec<String> =
        (sides_look_exchanged(at) == Some(true)).then(|| LOOKS_EXCHANGED.to_owned()).into_iter().collect();
    let (wrong, held_against) = on_the_wrong_side(at);
    let wrong: Vec<String> = wrong.iter().map(ToString::to_string).collect();
    if !wrong.is_empty() {
        let lies = if wrong.len() == 1 { "lies" } else { "lie" };
        notes.push(format!(
            "{} {lies} on the other side than {held_against}: left and right look exchanged there",
            wrong.join(", ")
        ));
    }
    notes
}

/// Below this product of unit vectors the arteries are too nearly in one plane for a decision.
const TOO_FLAT: f64 = 0.05;

/// Whether left and right look exchanged in right-handed axes: rightward · (forward x upward) is negative.
///
/// Rightward is from the left artery of every pair to the right one, forward from P2 or the basilar artery to A2, upward from the
/// carotid to M1 and A1. `None` where too few arteries are known.
pub(crate) fn sides_look_exchanged(at: &BTreeMap<Artery, Point>) -> Option<bool> {
    let mean = |arteries: &[Artery]| -> Option<Point> {
        let points: Vec<Point> = arteries.iter().filter_map(|artery| at.get(artery).copied()).collect();
        (!points.is_empty()).then(|| centroid(points))
    };
    let both = |artery: fn(BodySide) -> Artery| BodySide::BOTH.map(artery);
    let mut rightward = [0.0; 3];
    for artery in Artery::PAIRED {
        if let [Some(left), Some(right)] = both(*artery).map(|artery| at.get(&artery)) {
            let step = sub(*right, *left);
            rightward = [rightward[0] + step[0], rightward[1] + step[1], rightward[2] + step[2]];
        }
    }
    let front = [both(Artery::A2), both(Artery::Aca), both(Artery::A1)].into_iter().find_map(|pair| mean(&pair))?;
    let back = [both(Artery::P2), both(Artery::Pca), [Artery::Ba; 2]].into_iter().find_map(|pair| mean(&pair))?;
    let top = [both(Artery::M1), both(Artery::Mca), both(Artery::A1)].into_iter().find_map(|pair| mean(&pair))?;
    let bottom = mean(&both(Artery::Ica))?;
    let (ahead, up) = (unit(sub(front, back)), unit(sub(top, bottom)));
    let product = dot(unit(rightward), cross(ahead, up));
    (product.abs() > TOO_FLAT).then_some(product < 0.0)
}

/// The least diameter of a segment that is not hypoplastic, m, unless another is stated (Hindenes et al., PLoS ONE 15:e0241373, 2020).
pub const LEAST_DIAMETER: f64 = 1e-3;
/// Its least share of the diameter of its opposite.
const LEAST_SHARE: f64 = 0.5;

/// Which segments of [`RING`] are thin: below a diameter of `least`, m, or below half the diameter of their opposite. `diameters` in m; a segment
/// without one is not.
pub fn hypoplastic(diameters: &[Option<f64>; 7], least: f64) -> [bool; 7] {
    let of = |artery: Artery| artery.in_ring().and_then(|row| diameters[row]);
    RING.map(|artery| {
        let is_thin = |own: f64| own < least || of(artery.opposite()).is_some_and(|other| own < LEAST_SHARE * other);
        of(artery).is_some_and(is_thin)
    })
}

/// The mean diameter along the vessels of each segment of [`RING`] in the topology of the vessels `kept`, m; `None` where it has none of its
/// own, as P1 under the label of the whole posterior cerebral artery.
pub fn segment_diameters(circle: &Circle, network: &Network, kept: impl Fn(usize) -> bool) -> [Option<f64>; 7] {
    let (network, arteries) = circle.arteries_in(network, kept);
    arteries.segments.map(|rows| {
        let vessels = || rows.iter().map(|row| network.vessel(*row));
        let length: f64 = vessels().map(|vessel| vessel.length).sum();
        (length > 0.0).then(|| 2.0 * vessels().map(|vessel| vessel.radius * vessel.length).sum::<f64>() / length)
    })
}
