//! Which segments are present where vessels are labelled.
//!
//! A segment is present when a path of vessels with its own label, or with none, joins the arteries at its two ends; for A1 these are the
//! carotid or M1 of its side, and A2 or AComm. An undivided label (ACA, PCA) counts as the segment up to the communicating artery where
//! it touches the feeding artery, as in CoW_Centerline_Extraction.
//!
//! Where the carotid does not lead to M1 (because it is occluded or was not traced), A1 and PComm have no origin. They are then present
//! when the vessels of their label are connected to the arteries at their other end, from which they fill.

use petgraph::{graph::NodeIndex, visit::EdgeRef};

use super::arteries::{Artery, ArteryVessels, BodySide, FENESTRATED, RING, TERRITORIES, Variant};
use willis_core::network::{Network, paths::ShortestPaths, walks::Walk};
use willis_core::support::statistics::quantile;

/// The meaning of a vessel's label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum LabelMeaning {
    /// An artery of the circle.
    Artery(Artery),
    /// No label: the vessel may belong to any artery that it joins.
    Free,
    /// Another name: no segment runs along the vessel.
    Other,
}

/// A set of arteries, one bit each.
type Set = u64;

fn set<const N: usize>(arteries: [Artery; N]) -> Set {
    arteries.into_iter().fold(0, |set, artery| set | artery.bit())
}

fn trunk(side: BodySide) -> Set {
    set([Artery::Ica(side), Artery::M1(side), Artery::Mca(side)])
}

fn anterior(side: BodySide) -> Set {
    set([Artery::A1(side), Artery::A2(side), Artery::Aca(side)])
}

fn feeders() -> Set {
    set([Artery::Ba, Artery::Va(BodySide::Left), Artery::Va(BodySide::Right)])
}

struct LabelRules<'a, K> {
    network: &'a Network,
    meanings: &'a [LabelMeaning],
    kept: &'a K,
    /// The arteries of the kept vessels at each node.
    at_node: Vec<Set>,
    /// The arteries of all vessels, kept or not.
    known: Set,
}

/// The variant in the vessels that `kept` selects.
pub(crate) fn variant(meanings: &[LabelMeaning], network: &Network, kept: &impl Fn(usize) -> bool) -> Variant {
    let (mut at_node, mut known) = (vec![0; network.node_count()], 0);
    for (row, meaning) in meanings.iter().enumerate() {
        if let LabelMeaning::Artery(artery) = meaning {
            known |= artery.bit();
            if kept(row) {
                for node in network.ends(row) {
                    at_node[node] |= artery.bit();
                }
            }
        }
    }
    LabelRules { network, meanings, kept, at_node, known }.variant()
}

/// The vessels of each artery, by their labels. A carotid is closed where it enters, so that its branches can still fill from above.
pub(crate) fn artery_vessels(meanings: &[LabelMeaning], network: &Network) -> ArteryVessels {
    let degree = network.degrees(|_| true);
    let of = |wanted: &[Artery]| -> Vec<usize> {
        let is = |row: &usize| matches!(meanings[*row], LabelMeaning::Artery(artery) if wanted.contains(&artery));
        (0..meanings.len()).filter(is).collect()
    };
    let at_its_end = |artery: Artery| -> Vec<usize> {
        of(&[artery]).into_iter().filter(|row| network.ends(*row).into_iter().any(|node| degree[node] == 1)).collect()
    };
    let vertebrals = || BodySide::BOTH.into_iter().flat_map(|side| at_its_end(Artery::Va(side))).collect();
    let basilar = Some(of(&[Artery::Ba])).filter(|rows| !rows.is_empty()).unwrap_or_else(vertebrals);
    let [left, right] = BodySide::BOTH.map(|side| at_its_end(Artery::Ica(side)));
    let territory = |artery: Artery| of(&[artery, artery.undivided()]);
    ArteryVessels {
        feeders: [left, right, basilar],
        segments: RING.map(|artery| of(&[artery])),
        territories: TERRITORIES.map(territory),
    }
}

impl<K: Fn(usize) -> bool> LabelRules<'_, K> {
    fn nodes(&self, which: impl Fn(Set) -> bool) -> Vec<bool> {
        self.at_node.iter().map(|touch| which(*touch)).collect()
    }

    /// The kept vessels of some arteries.
    fn vessels(&self, of: Set) -> Vec<usize> {
        let is = |row: &usize| matches!(self.meanings[*row], LabelMeaning::Artery(a) if a.bit() & of != 0) && (self.kept)(*row);
        (0..self.meanings.len()).filter(is).collect()
    }

    fn has(&self, of: Set) -> bool {
        self.at_node.iter().any(|touch| touch & of != 0)
    }

    /// The shortest path over vessels of `own` or without a label, between nodes that `from` and `to` select. It does not pass through nodes
    /// of other arteries.
    fn path(&self, own: Set, from: impl Fn(Set) -> bool, to: impl Fn(Set) -> bool) -> Option<Walk> {
        let is_open = |row: usize| {
            (self.kept)(row)
                && match self.meanings[row] {
                    // A third A2 interrupts AComm where it leaves it. Where it touches another artery it is no part of the way.
                    LabelMeaning::Artery(Artery::ThirdA2) => own & Artery::ThirdA2.bit() != 0 && !self.touches(row, !own),
                    LabelMeaning::Artery(artery) => artery.bit() & own != 0,
                    LabelMeaning::Free => true,
                    LabelMeaning::Other => false,
                }
        };
        let avoid = self.nodes(|touch| touch & !own != 0);
        shortest(self.network, [&self.nodes(from), &self.nodes(to), &avoid], is_open, f64::INFINITY)
    }

    /// Whether a vessel meets some arteries.
    fn touches(&self, row: usize, of: Set) -> bool {
        self.network.ends(row).into_iter().any(|node| self.at_node[node] & of != 0)
    }

    /// Whether a segment joins `from` and `to`. An end does not matter if the network has no such artery at all.
    fn joins(&self, segment: Artery, own: Set, from: Set, to: Set, not: Set) -> bool {
        let labelled = self.known & segment.bit() != 0;
        match (self.known & from != 0, self.known & to != 0) {
            (true, true) => self.path(own, |t| t & from != 0, |t| t & to != 0 && t & not == 0).is_some(),
            // The field of view ends within the segment: its visible part must be connected to the visible end.
            (true, false) if labelled => self.path(own, |t| t & from != 0, |t| t & segment.bit() != 0).is_some(),
            (false, true) if labelled => self.path(own, |t| t & segment.bit() != 0, |t| t & to != 0).is_some(),
            _ => self.has(segment.bit()),
        }
    }

    fn variant(&self) -> Variant {
        let mut variant = Variant {
            ica: BodySide::BOTH.map(|side| self.has(Artery::Ica(side).bit())),
            ba: self.has(Artery::Ba.bit()) || (self.known & Artery::Ba.bit() == 0 && self.has(feeders())),
            third_a2: self.has(Artery::ThirdA2.bit()),
            ..Variant::default()
        };
        for side in BodySide::BOTH {
            let (a1, p1, pcomm) = (Artery::A1(side), Artery::P1(side), Artery::PComm(side));
            let (aca, pca) = (Artery::Aca(side).bit(), Artery::Pca(side).bit());
            let beyond = Artery::A2(side).bit() | aca | Artery::AComm.bit() | Artery::ThirdA2.bit();
            // Whether the carotid leads to the middle cerebral artery.
            let (ica, m1) = (Artery::Ica(side).bit(), Artery::M1(side).bit() | Artery::Mca(side).bit());
            let complete = self.path(0, |t| t & ica != 0, |t| t & m1 != 0).is_some();
            let fills_from =
                |own: Artery, on: Set| !complete && self.path(own.bit(), |t| t & own.bit() != 0, |t| t & on != 0).is_some();
            variant.set(a1, self.joins(a1, a1.bit() | aca, trunk(side), beyond, 0) || fills_from(a1, beyond));
            let beyond = Artery::P2(side).bit() | pca | pcomm.bit();
            variant.set(p1, self.joins(p1, p1.bit() | pca, feeders(), beyond, 0));
            // PComm must not reach P1 at the basilar artery, where P1 begins.
            let posterior = p1.bit() | Artery::P2(side).bit() | pca;
            variant.set(pcomm, self.joins(pcomm, pcomm.bit(), trunk(side), posterior, feeders()) || fills_from(pcomm, posterior));
        }
        variant.set(Artery::AComm, self.acomm());
        for side in BodySide::BOTH {
            variant.set_fetal(side, || self.is_fetal(side));
        }
        for (row, segment) in FENESTRATED.into_iter().enumerate() {
            variant.fenestration[row] = self.is_fenestrated(segment);
        }
        variant
    }

    /// AComm is a vessel between the two sides, or pieces of it on either side of a third A2. Arteries that only touch have none.
    fn acomm(&self) -> bool {
        let (own, trunks) = (set([Artery::AComm, Artery::ThirdA2]), trunk(BodySide::Left) | trunk(BodySide::Right));
        let only = |own: Set, other: Set| move |t: Set| t & own != 0 && t & other == 0 && t & trunks == 0;
        let (left, right) = (anterior(BodySide::Left), anterior(BodySide::Right));
        match (self.known & left != 0, self.known & right != 0) {
            (true, true) => self.path(own, only(left, right), only(right, left)).is_some(),
            _ => self.has(Artery::AComm.bit()),
        }
    }

    fn is_fetal(&self, side: BodySide) -> bool {
        let pcomm = self.vessels(Artery::PComm(side).bit());
        let mut p1 = self.vessels(Artery::P1(side).bit());
        if p1.is_empty() {
            let meets = Artery::PComm(side).bit() | trunk(side);
            let path = self.path(Artery::Pca(side).bit(), |t| t & feeders() != 0, |t| t & meets != 0);
            p1 = path.map(|path| path.edges).unwrap_or_default();
        }
        is_wider(self.network, &pcomm, &p1)
    }

    /// Whether the vessels of a segment close a cycle among themselves.
    fn is_fenestrated(&self, segment: Artery) -> bool {
        let own = self.vessels(segment.bit());
        let vessels = if own.is_empty() { self.vessels(segment.undivided().bit()) } else { own };
        let mut connected = petgraph::unionfind::UnionFind::<usize>::new(self.network.node_count());
        vessels.into_iter().any(|row| {
            let [a, b] = self.network.ends(row);
            !connected.union(a, b)
        })
    }
}

/// Above this ratio to P1, PComm counts as the wider of the two (Musio et al. 2026).
const FETAL_RATIO: f64 = 1.05;

/// Whether PComm is wider than P1 by more than the ratio; false where either has no vessels.
pub(crate) fn is_wider(network: &Network, pcomm: &[usize], p1: &[usize]) -> bool {
    match (lower_quartile(network, pcomm), lower_quartile(network, p1)) {
        (Some(pcomm), Some(p1)) => pcomm > FETAL_RATIO * p1,
        _ => false,
    }
}

/// The 25th percentile of the radii along vessels (m), by linear interpolation.
fn lower_quartile(network: &Network, vessels: &[usize]) -> Option<f64> {
    let mut radii = Vec::new();
    for vessel in vessels.iter().map(|row| network.vessel(*row)) {
        radii.extend(vessel.path.iter().map(|point| point.radius));
        radii.extend(vessel.path.is_empty().then_some(vessel.radius));
    }
    quantile(&radii, 0.25)
}

/// The shortest path by length from any node of `from` to any of `to` over the vessels that `is_open` selects, through nodes of `avoid` only
/// at its ends. A node of both sets is a path without vessels. Paths longer than `most` (m) do not count.
pub(crate) fn shortest(
    network: &Network,
    [from, to, avoid]: [&[bool]; 3],
    is_open: impl Fn(usize) -> bool,
    most: f64,
) -> Option<Walk> {
    let sources: Vec<usize> = (0..from.len()).filter(|node| from[*node]).collect();
    let vessels = |node: usize| {
        let passable = from[node] || !avoid[node];
        let edges = network.graph().edges(NodeIndex::new(node)).filter(move |_| passable);
        edges.map(|e| (e.id().index(), e.target().index(), e.weight().length.max(0.0))).filter(|(vessel, ..)| is_open(*vessel))
    };
    let mut paths = ShortestPaths::new(network.node_count());
    let mut end = None;
    paths.search(&sources, most, vessels, |_, node| {
        end = Some(node).filter(|node| to[*node]);
        end.is_none()
    });
    end.map(|end| paths.path_to(end))
}
