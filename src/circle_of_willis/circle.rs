//! Where each artery of the Circle of Willis is in a network, by labels or by landmarks.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::arteries::Artery;
use super::collaterals::Courses;
use super::labels::{Scheme, artery, is_none};
use super::landmarks::{Landmark, Site, are_exchanged, free_end, place, sites};
use super::segments_by_labels;
use super::segments_by_labels::Named;
use super::segments_by_landmarks::Points;
use super::variant::Variant;
use crate::error::Fault;
use crate::network::units::millimetres;
use crate::network::{Nearest, Network, Origin};
use crate::support::geometry::{Point, distance};

/// Where the arteries are.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Circle {
    place: Where,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
enum Where {
    /// Per vessel what its label makes of it.
    Vessels(Vec<Named>),
    /// Nodes of in- and outlets and bifurcations.
    Nodes(Box<Points>),
}

/// How a note ends that says where a landmark was found; no other note ends so.
pub const MM_AWAY: &str = " mm away";
const EXCHANGED: &str = "left and right look exchanged, unless the axes of the input are left-handed (as LAS): front, top and right do not fit together";

impl Circle {
    /// The circle of a network whose vessels are labelled, and what a person should know.
    ///
    /// # Errors
    ///
    /// No vessel is labelled as an internal carotid, basilar or vertebral artery; a label is no code of the scheme.
    pub fn labelled(network: &Network, scheme: Scheme) -> Result<(Self, Vec<String>), Fault> {
        let mut strange = BTreeMap::new();
        let mut places = Vec::with_capacity(network.vessel_count());
        for (_, vessel) in network.vessels() {
            places.push(match artery(&vessel.label, scheme) {
                _ if is_none(&vessel.label) => Named::Free,
                Some(artery) => Named::Artery(artery),
                None => {
                    *strange.entry(vessel.label.trim().to_owned()).or_insert(0_usize) += 1;
                    Named::Other
                }
            });
        }
        if let (Some(label), Scheme::ICafe | Scheme::TopCow) = (strange.keys().next(), scheme) {
            let codes = if scheme == Scheme::ICafe { "1 to 22" } else { "1 to 12 and 15" };
            return Err(Fault::item(
                format!("label \"{label}\""),
                format!("none of {}", scheme.name()),
                format!("expected {codes}"),
            ));
        }
        if !places.iter().any(|place| matches!(place, Named::Artery(artery) if is_inlet(*artery))) {
            return Err(Fault::file(
                "no vessel is labelled as an internal carotid, basilar or vertebral artery",
                "expected labels such as L-ICA, R-ICA, BA, L-VA (--labels icafe|topcow for numbers), or give --landmarks FILE",
            ));
        }
        let mut notes = Vec::new();
        if !strange.is_empty() {
            let names: Vec<&str> = strange.keys().map(String::as_str).collect();
            notes.push(format!("not arteries of the circle, and so no part of it: {}", names.join(", ")));
        }
        if are_exchanged(&middles(network, &places)) == Some(true) {
            notes.push(EXCHANGED.to_owned());
        }
        Ok((Self { place: Where::Vessels(places) }, notes))
    }

    /// The circle of a network with landmarks, each at its nearest node, and what a person should know.
    ///
    /// Where two in- or outlets have the same nearest node, the nearer one is there and the other at its next free end; without one
    /// within reach it was not seen.
    ///
    /// # Errors
    ///
    /// A landmark too far from every vessel; no inlet of a carotid or basilar artery among them; nodes without positions.
    pub fn at(network: &Network, landmarks: &[Landmark]) -> Result<(Self, Vec<String>), Fault> {
        if !landmarks.iter().any(|landmark| matches!(landmark.arteries[..], [single] if is_inlet(single))) {
            return Err(Fault::file(
                "no inlet among the landmarks",
                "expected one at least of L-ICA, R-ICA, BA, L-VA, R-VA: where it enters the field of view",
            ));
        }
        let mut notes = Vec::new();
        let mut found = Vec::new();
        for landmark in landmarks {
            found.push((landmark, place(network, landmark)?));
        }
        let (mut points, mut taken) = (Points::default(), BTreeMap::new());
        while let Some((landmark, placed)) = nearest_of(&mut found) {
            let sites = sites(&landmark.arteries);
            let is_end = sites.iter().any(|site| site.is_end() && *site != Site::Feeder);
            if is_end && let Some(first) = taken.get(&placed.node) {
                if let Some(next) = free_end(network, landmark.position, &|node| taken.contains_key(&node)) {
                    found.push((landmark, next));
                } else {
                    notes.push(format!("{} is taken as not seen: the end nearest to it is that of {first}", landmark.label));
                }
                continue;
            }
            if is_end {
                taken.insert(placed.node, &landmark.label);
            }
            for site in sites {
                site.put(&mut points, placed.node);
            }
            let node = &network.node(placed.node).id;
            notes.push(format!("{} at node {node}, {:.3}{MM_AWAY}", landmark.label, millimetres(placed.distance)));
        }
        for s in [0, 1] {
            points.a2[s] = points.a2[s].or(points.anterior[s]);
            points.p2[s] = points.p2[s].or(points.posterior[s]);
        }
        let at = landmarks.iter().filter_map(|l| if let [one] = l.arteries[..] { Some((one, l.position)) } else { None });
        if are_exchanged(&at.collect()) == Some(true) {
            notes.push(EXCHANGED.to_owned());
        }
        Ok((Self { place: Where::Nodes(Box::new(points)) }, notes))
    }

    /// The anatomy over the vessels of the network that `kept` admits; the network must be the one that the circle was found in, or
    /// have its nodes and vessels in the same rows.
    ///
    /// Nothing but shortest ways: the time is in proportion to the network, but for a logarithm.
    pub fn variant(&self, network: &Network, kept: impl Fn(usize) -> bool) -> Variant {
        match &self.place {
            Where::Vessels(places) => segments_by_labels::variant(places, network, &kept),
            Where::Nodes(points) => points.variant(network, &kept),
        }
    }

    /// The circle in a network of the same nodes with some of the vessels, whose rows were `rows`.
    #[must_use]
    pub fn in_part(&self, rows: &[usize]) -> Self {
        let place = match &self.place {
            Where::Vessels(places) => Where::Vessels(rows.iter().map(|row| places[*row]).collect()),
            Where::Nodes(points) => Where::Nodes(points.clone()),
        };
        Self { place }
    }

    /// Which vessels the arteries are, all vessels of the network counted.
    pub fn courses(&self, network: &Network) -> Courses {
        match &self.place {
            Where::Vessels(places) => segments_by_labels::courses(places, network),
            Where::Nodes(points) => points.courses(network),
        }
    }

    /// Whether this may be the circle of a network: of as many vessels, or with no node beyond its own.
    pub fn fits(&self, network: &Network) -> bool {
        match &self.place {
            Where::Vessels(places) => places.len() == network.vessel_count(),
            Where::Nodes(_) => self.ends(network).iter().all(|node| *node < network.node_count()),
        }
    }

    /// The nodes where blood is known to come in: landmarks of carotid, basilar and vertebral arteries; none where labels say where
    /// the arteries are.
    pub fn inlets(&self) -> Vec<usize> {
        let Where::Nodes(points) = &self.place else { return Vec::new() };
        points.ica.iter().flatten().chain(&points.feeders).copied().collect()
    }

    /// The nodes where an artery is known to enter or leave, so that no vessel continues from there: landmarks, or of the vessels
    /// labelled as one that enters or leaves the circle the free end that is farthest from its middle.
    pub fn ends(&self, network: &Network) -> Vec<usize> {
        let mut nodes: Vec<usize> = match &self.place {
            Where::Vessels(places) => outermost(network, places),
            Where::Nodes(points) => {
                let pairs = [points.ica, points.m1, points.a2, points.p2, points.posterior, points.anterior];
                let pairs = pairs.into_iter().flatten().flatten();
                pairs
                    .chain(
                        points.carotid.iter().flatten().chain(&points.feeders).chain(&points.tip).chain(&points.third).copied(),
                    )
                    .collect()
            }
        };
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

/// Takes out the landmark that is nearest to its place, the first in the file of several.
fn nearest_of<'a>(found: &mut Vec<(&'a Landmark, Nearest)>) -> Option<(&'a Landmark, Nearest)> {
    let order =
        |a: &(&Landmark, Nearest), b: &(&Landmark, Nearest)| a.1.distance.total_cmp(&b.1.distance).then(a.0.line.cmp(&b.0.line));
    let first = (0..found.len()).min_by(|a, b| order(&found[*a], &found[*b]))?;
    Some(found.swap_remove(first))
}

/// Of every artery that enters or leaves the circle, its free end farthest from the mean of all ends of labelled vessels.
fn outermost(network: &Network, places: &[Named]) -> Vec<usize> {
    let middles = middles(network, places);
    let count = middles.len().max(1) as f64;
    let centre: Point = std::array::from_fn(|axis| middles.values().map(|p| p[axis]).sum::<f64>() / count);
    let degree = network.degrees(|vessel| vessel.origin == Origin::Observed);
    let mut found: BTreeMap<Artery, (f64, usize)> = BTreeMap::new();
    for (row, place) in places.iter().enumerate() {
        let Named::Artery(artery) = place else { continue };
        if matches!(artery, Artery::A1(_) | Artery::P1(_) | Artery::PComm(_) | Artery::AComm) {
            continue;
        }
        for node in network.ends(row).into_iter().filter(|node| degree[*node] == 1) {
            let Some(position) = network.node(node).position else { continue };
            let away = distance(position, centre);
            let farthest = found.entry(*artery).or_insert((away, node));
            if away > farthest.0 {
                *farthest = (away, node);
            }
        }
    }
    found.into_values().map(|(_, node)| node).collect()
}

fn is_inlet(artery: Artery) -> bool {
    matches!(artery, Artery::Ica(_) | Artery::Ba | Artery::Va(_))
}

/// The mean position of the ends of every artery's vessels, m.
fn middles(network: &Network, places: &[Named]) -> BTreeMap<Artery, Point> {
    let mut sums: BTreeMap<Artery, (Point, f64)> = BTreeMap::new();
    for (row, place) in places.iter().enumerate() {
        let Named::Artery(artery) = place else { continue };
        for p in network.ends(row).into_iter().filter_map(|node| network.node(node).position) {
            let (sum, count) = sums.entry(*artery).or_default();
            (*sum, *count) = ([sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]], *count + 1.0);
        }
    }
    sums.into_iter().map(|(artery, (sum, count))| (artery, sum.map(|x| x / count))).collect()
}
