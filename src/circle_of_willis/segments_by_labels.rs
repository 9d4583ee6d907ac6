//! The rules of presence where vessels are labelled.
//!
//! A segment is there when a way over vessels of its own label, or of none, joins what lies at its two ends: A1 the carotid or
//! M1 of its side and A2 or AComm. Of what is labelled undivided (ACA, PCA) the part up to the communicating artery is there when
//! it touches the artery that feeds it, as in CoW_Centerline_Extraction.
//!
//! Where the carotid itself does not lead to M1 (it is occluded, or was not traced), A1 and PComm have nothing to come from: they are
//! there when what is traced under their name hangs on the arteries at their other end, from which they fill.

use super::arteries::{Artery, FENESTRATED, RING, Side};
use super::collaterals::{Courses, TERRITORIES};
use super::shortest_path::{Marks, Way, shortest};
use super::variant::Variant;
use crate::network::Network;
use crate::support::statistics::quantile;

/// What a label makes of a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Named {
    /// A vessel of an artery.
    Artery(Artery),
    /// A vessel without a label: a part of whatever it joins.
    Free,
    /// A vessel of another name, over which no segment runs.
    Other,
}

/// A set of arteries, one bit each.
type Set = u32;

fn set<const N: usize>(arteries: [Artery; N]) -> Set {
    arteries.into_iter().fold(0, |set, artery| set | bit(artery))
}

fn bit(artery: Artery) -> Set {
    let kind = match artery {
        Artery::Ica(_) => 0,
        Artery::M1(_) => 1,
        Artery::Mca(_) => 2,
        Artery::A1(_) => 3,
        Artery::A2(_) => 4,
        Artery::Aca(_) => 5,
        Artery::P1(_) => 6,
        Artery::P2(_) => 7,
        Artery::Pca(_) => 8,
        Artery::PComm(_) => 9,
        Artery::Va(_) => 10,
        Artery::AComm => 11,
        Artery::Ba => 12,
        Artery::ThirdA2 => 13,
    };
    1 << (2 * kind + artery.side().map_or(0, Side::row))
}

fn trunk(side: Side) -> Set {
    set([Artery::Ica(side), Artery::M1(side), Artery::Mca(side)])
}

fn anterior(side: Side) -> Set {
    set([Artery::A1(side), Artery::A2(side), Artery::Aca(side)])
}

fn feeders() -> Set {
    set([Artery::Ba, Artery::Va(Side::Left), Artery::Va(Side::Right)])
}

struct Solver<'a, K> {
    network: &'a Network,
    places: &'a [Named],
    kept: &'a K,
    /// Per node the arteries of the kept vessels that touch it.
    touch: Vec<Set>,
    /// The arteries of all vessels, kept or not.
    known: Set,
}

/// The variant over the vessels that `kept` admits.
pub(crate) fn variant(places: &[Named], network: &Network, kept: &impl Fn(usize) -> bool) -> Variant {
    let (mut touch, mut known) = (vec![0; network.node_count()], 0);
    for (row, place) in places.iter().enumerate() {
        if let Named::Artery(artery) = place {
            known |= bit(*artery);
            if kept(row) {
                for node in network.ends(row) {
                    touch[node] |= bit(*artery);
                }
            }
        }
    }
    Solver { network, places, kept, touch, known }.variant()
}

/// Which vessels the arteries are, by their labels. A carotid is closed where it comes in, so that what leaves it higher up can be fed from
/// above.
pub(crate) fn courses(places: &[Named], network: &Network) -> Courses {
    let degree = network.degrees(|_| true);
    let of = |wanted: &[Artery]| -> Vec<usize> {
        let is = |row: &usize| matches!(places[*row], Named::Artery(artery) if wanted.contains(&artery));
        (0..places.len()).filter(is).collect()
    };
    let at_its_end = |artery: Artery| -> Vec<usize> {
        of(&[artery]).into_iter().filter(|row| network.ends(*row).into_iter().any(|node| degree[node] == 1)).collect()
    };
    let vertebrals = || Side::BOTH.into_iter().flat_map(|side| at_its_end(Artery::Va(side))).collect();
    let basilar = Some(of(&[Artery::Ba])).filter(|rows| !rows.is_empty()).unwrap_or_else(vertebrals);
    let [left, right] = Side::BOTH.map(|side| at_its_end(Artery::Ica(side)));
    let territory = |artery: Artery| of(&[artery, artery.whole()]);
    Courses {
        feeders: [left, right, basilar],
        segments: RING.map(|artery| of(&[artery])),
        territories: TERRITORIES.map(territory),
    }
}

impl<K: Fn(usize) -> bool> Solver<'_, K> {
    fn nodes(&self, which: impl Fn(Set) -> bool) -> Marks {
        self.touch.iter().map(|touch| which(*touch)).collect()
    }

    /// The kept vessels of some arteries.
    fn vessels(&self, of: Set) -> Vec<usize> {
        let is = |row: &usize| matches!(self.places[*row], Named::Artery(a) if bit(a) & of != 0) && (self.kept)(*row);
        (0..self.places.len()).filter(is).collect()
    }

    fn has(&self, of: Set) -> bool {
        self.touch.iter().any(|touch| touch & of != 0)
    }

    /// The way over vessels of `own`, or without a label, between nodes that `from` and `to` admit, past all other arteries.
    fn way(&self, own: Set, from: impl Fn(Set) -> bool, to: impl Fn(Set) -> bool) -> Option<Way> {
        let may = |row: usize| {
            (self.kept)(row)
                && match self.places[row] {
                    Named::Artery(artery) => bit(artery) & own != 0,
                    Named::Free => true,
                    Named::Other => false,
                }
        };
        let avoid = self.nodes(|touch| touch & !own != 0);
        shortest(self.network, [&self.nodes(from), &self.nodes(to), &avoid], may, f64::INFINITY)
    }

    /// Whether a segment joins `from` and `to`, each only as far as the network knows such an artery at all.
    fn joins(&self, segment: Artery, own: Set, from: Set, to: Set, not: Set) -> bool {
        let apart = self.known & bit(segment) != 0;
        match (self.known & from != 0, self.known & to != 0) {
            (true, true) => self.way(own, |t| t & from != 0, |t| t & to != 0 && t & not == 0).is_some(),
            // The field of view ends within the segment: what is seen of it must hang on the end that is seen.
            (true, false) if apart => self.way(own, |t| t & from != 0, |t| t & bit(segment) != 0).is_some(),
            (false, true) if apart => self.way(own, |t| t & bit(segment) != 0, |t| t & to != 0).is_some(),
            _ => self.has(bit(segment)),
        }
    }

    fn variant(&self) -> Variant {
        let mut variant = Variant {
            ica: Side::BOTH.map(|side| self.has(bit(Artery::Ica(side)))),
            ba: self.has(bit(Artery::Ba)) || (self.known & bit(Artery::Ba) == 0 && self.has(feeders())),
            third_a2: self.has(bit(Artery::ThirdA2)),
            ..Variant::default()
        };
        for side in Side::BOTH {
            let (a1, p1, pcomm) = (Artery::A1(side), Artery::P1(side), Artery::PComm(side));
            let (aca, pca) = (bit(Artery::Aca(side)), bit(Artery::Pca(side)));
            let beyond = bit(Artery::A2(side)) | aca | bit(Artery::AComm) | bit(Artery::ThirdA2);
            let whole = self.is_whole(side);
            let hangs = |own: Artery, on: Set| !whole && self.way(bit(own), |t| t & bit(own) != 0, |t| t & on != 0).is_some();
            variant.set(a1, self.joins(a1, bit(a1) | aca, trunk(side), beyond, 0) || hangs(a1, beyond));
            let beyond = bit(Artery::P2(side)) | pca | bit(pcomm);
            variant.set(p1, self.joins(p1, bit(p1) | pca, feeders(), beyond, 0));
            // P1 begins at the basilar artery, where PComm has no business.
            let posterior = bit(p1) | bit(Artery::P2(side)) | pca;
            variant.set(pcomm, self.joins(pcomm, bit(pcomm), trunk(side), posterior, feeders()) || hangs(pcomm, posterior));
        }
        variant.set(Artery::AComm, self.acomm());
        for side in Side::BOTH {
            variant.set_fetal(side, || self.is_fetal(side));
        }
        for (row, segment) in FENESTRATED.into_iter().enumerate() {
            variant.fenestration[row] = self.is_fenestrated(segment);
        }
        variant
    }

    /// Whether the carotid leads to the middle cerebral artery.
    fn is_whole(&self, side: Side) -> bool {
        let (ica, m1) = (bit(Artery::Ica(side)), bit(Artery::M1(side)) | bit(Artery::Mca(side)));
        self.way(0, |t| t & ica != 0, |t| t & m1 != 0).is_some()
    }

    /// AComm is a vessel between the two sides; two arteries that merely touch have none.
    fn acomm(&self) -> bool {
        let trunks = trunk(Side::Left) | trunk(Side::Right);
        let only = |own: Set, other: Set| move |t: Set| t & own != 0 && t & other == 0 && t & trunks == 0;
        let (left, right) = (anterior(Side::Left), anterior(Side::Right));
        match (self.known & left != 0, self.known & right != 0) {
            (true, true) => self.way(bit(Artery::AComm), only(left, right), only(right, left)).is_some(),
            _ => self.has(bit(Artery::AComm)),
        }
    }

    fn is_fetal(&self, side: Side) -> bool {
        let pcomm = self.vessels(bit(Artery::PComm(side)));
        let mut p1 = self.vessels(bit(Artery::P1(side)));
        if p1.is_empty() {
            let meets = bit(Artery::PComm(side)) | trunk(side);
            let way = self.way(bit(Artery::Pca(side)), |t| t & feeders() != 0, |t| t & meets != 0);
            p1 = way.map(|way| way.vessels).unwrap_or_default();
        }
        is_wider(self.network, &pcomm, &p1)
    }

    /// Whether the vessels of a segment close a cycle among themselves.
    fn is_fenestrated(&self, segment: Artery) -> bool {
        let own = self.vessels(bit(segment));
        let vessels = if own.is_empty() { self.vessels(bit(segment.whole())) } else { own };
        let mut parts = petgraph::unionfind::UnionFind::<usize>::new(self.network.node_count());
        vessels.into_iter().any(|row| {
            let [a, b] = self.network.ends(row);
            !parts.union(a, b)
        })
    }
}

/// PComm is the wider one of the two above this ratio to P1 (Musio et al. 2026).
const FETAL_RATIO: f64 = 1.05;

/// Whether the first vessels are wider than the second ones by more than the ratio; false where either is nothing.
pub(crate) fn is_wider(network: &Network, pcomm: &[usize], p1: &[usize]) -> bool {
    match (lower_quartile(network, pcomm), lower_quartile(network, p1)) {
        (Some(pcomm), Some(p1)) => pcomm > FETAL_RATIO * p1,
        _ => false,
    }
}

/// The 25th percentile (m), linear between the two radii around it; a vessel without points has its own radius.
fn lower_quartile(network: &Network, vessels: &[usize]) -> Option<f64> {
    let mut radii = Vec::new();
    for vessel in vessels.iter().map(|row| network.vessel(*row)) {
        radii.extend(vessel.path.iter().map(|point| point.radius));
        if vessel.path.is_empty() {
            radii.push(vessel.radius);
        }
    }
    quantile(&radii, 0.25)
}
