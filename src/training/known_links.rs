//! The answer to a case: where fragments belong together, and which bridges that makes right.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::candidates::features::Extraction;
use crate::candidates::search::neighbours::PointIndex;
use crate::support::geometry::{Point, distance};

/// Points within so many tolerances beyond the nearest are meant as well as it.
const AS_NEAR: f64 = 0.3;
/// A bridge may attach within so many spacings of a loose end ...
const LOOSE_SPACINGS: f64 = 2.0;
/// ... and on a standing vessel within so many spacings, diameters or gaps of the true place.
const STANDING_SPACINGS: f64 = 3.0;
const STANDING_RADII: f64 = 2.0;
const STANDING_GAPS: f64 = 0.75;

/// Which side of a link hangs on which; the words in files are `parent` and `child`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LinkSide {
    /// The one that is nearer to an inlet.
    Parent,
    /// The one that hangs on it.
    Child,
}

/// A place where pieces belong together: per piece its side and the rows of the points at which a bridge may attach.
pub type Link = Vec<(LinkSide, Vec<usize>)>;

/// A right bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Right {
    /// The link it makes.
    pub link: usize,
    /// The pieces it joins there, by their places in it.
    pub pieces: [usize; 2],
}

/// The links that belong in an extraction. A link of n pieces needs n - 1 bridges.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct KnownLinks {
    /// Per link the sides of its pieces.
    sides: Vec<Vec<LinkSide>>,
    /// Per point of the extraction the links and pieces that a bridge to it reaches.
    sites: Vec<Vec<(usize, usize)>>,
}

impl KnownLinks {
    /// Links that name points of their own (m): a point of the extraction stands for the nearest within `tolerance` (m), and for
    /// those hardly further away.
    pub fn snapped(extraction: &Extraction, points: &[Point], tolerance: f64, links: &[Link]) -> Self {
        let mut named = vec![Vec::new(); points.len()];
        for (link, pieces) in links.iter().enumerate() {
            for (piece, (_, rows)) in pieces.iter().enumerate() {
                for row in rows {
                    named[*row].push((link, piece));
                }
            }
        }
        let index = PointIndex::new(points.to_vec());
        let sites = extraction.position.iter().map(|p| {
            let nearest = index.nearest(*p, tolerance);
            let reach = nearest.distance + AS_NEAR * tolerance;
            let near = if nearest.points.is_empty() { Vec::new() } else { index.within(*p, reach) };
            near.into_iter().flat_map(|(_, row)| named[row].iter().copied()).collect()
        });
        Self { sites: sites.collect(), sides: links.iter().map(|l| l.iter().map(|(side, _)| *side).collect()).collect() }
    }

    /// Right bridges between points of the extraction. Those near to either end are right too: 2 spacings along a loose end; on a
    /// standing vessel 3 spacings, a diameter or 3/4 of the gap. What is nearer to one of the `inlets` (nodes) is the parent.
    pub fn bridging(extraction: &Extraction, bridges: &[[usize; 2]], inlets: &[usize]) -> Self {
        let mut answer = Self { sides: Vec::new(), sites: vec![Vec::new(); extraction.position.len()] };
        let index = PointIndex::new(extraction.position.clone());
        let order = outwards(extraction, bridges, inlets);
        for (link, (ends, order)) in bridges.iter().zip(order).enumerate() {
            let gap = distance(extraction.position[ends[0]], extraction.position[ends[1]]);
            for (piece, point) in ends.iter().enumerate() {
                let (h, r) = (extraction.spacing, extraction.radius[*point]);
                let standing = (STANDING_SPACINGS * h).max(STANDING_RADII * r).max(STANDING_GAPS * gap);
                let reach = if extraction.end_at[*point].is_some() { LOOSE_SPACINGS * h } else { standing };
                for (_, near) in index.within(extraction.position[*point], reach) {
                    if extraction.fragment[near] == extraction.fragment[*point] {
                        answer.sites[near].push((link, piece));
                    }
                }
            }
            answer.sides.push(order.to_vec());
        }
        answer
    }

    /// How many links there are.
    pub fn links(&self) -> usize {
        self.sides.len()
    }

    /// How many bridges it takes to make all links.
    pub fn needed(&self) -> usize {
        self.sides.iter().map(|pieces| pieces.len().saturating_sub(1)).sum()
    }

    /// The first link and piece that no point reaches.
    pub fn unreachable(&self) -> Option<(usize, usize)> {
        let mut reached: Vec<Vec<bool>> = self.sides.iter().map(|pieces| vec![false; pieces.len()]).collect();
        self.sites.iter().flatten().for_each(|(link, piece)| reached[*link][*piece] = true);
        reached.iter().enumerate().find_map(|(link, pieces)| Some((link, pieces.iter().position(|r| !r)?)))
    }

    /// The link that a bridge between two points makes, if any; the pieces in the order of the points.
    pub fn right(&self, from: usize, to: usize) -> Option<Right> {
        let pairs = self.sites[from].iter().flat_map(|a| self.sites[to].iter().map(move |b| (a, b)));
        let mut made = pairs.filter(|(a, b)| a.0 == b.0 && a.1 != b.1);
        made.next().map(|(a, b)| Right { link: a.0, pieces: [a.1, b.1] })
    }

    /// Per bridge (child point, parent point; child fragment, parent fragment) whether the likelihood may take it: those by which
    /// a piece hangs as it should. Of several links of a fragment the first counts; a bridge that would let fragments hang on one another in
    /// a circle does not.
    pub fn allowed(&self, bridges: &[([usize; 2], [usize; 2])]) -> Vec<bool> {
        let mut link_of: BTreeMap<usize, usize> = BTreeMap::new();
        let mut hangs_on: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut may = |(points, [child, parent]): &([usize; 2], [usize; 2])| {
            let Some(Right { link, pieces }) = self.right(points[0], points[1]) else { return false };
            if pieces.map(|piece| self.sides[link][piece]) != [LinkSide::Child, LinkSide::Parent] {
                return false;
            }
            if hangs_on.get(child).is_some_and(|on| on.contains(parent)) {
                return link_of[child] == link;
            }
            if link_of.get(child).is_some_and(|l| *l != link) || leads(&hangs_on, *parent, *child) {
                return false;
            }
            link_of.insert(*child, link);
            hangs_on.entry(*child).or_default().push(*parent);
            true
        };
        bridges.iter().map(&mut may).collect()
    }
}

/// Whether a fragment hangs on another, directly or by others in between.
fn leads(hangs_on: &BTreeMap<usize, Vec<usize>>, from: usize, to: usize) -> bool {
    let (mut open, mut seen) = (vec![from], vec![from]);
    while let Some(at) = open.pop() {
        if at == to {
            return true;
        }
        for next in hangs_on.get(&at).into_iter().flatten() {
            if !seen.contains(next) {
                seen.push(*next);
                open.push(*next);
            }
        }
    }
    false
}

/// Per bridge the sides of its ends when each connected group of fragments hangs on the one with an inlet, of several, or without
/// any, on the widest, then the longest. Bridges that close a circle have no child.
fn outwards(extraction: &Extraction, bridges: &[[usize; 2]], inlets: &[usize]) -> Vec<[LinkSide; 2]> {
    let ends: Vec<[usize; 2]> = bridges.iter().map(|ends| ends.map(|point| extraction.fragment[point])).collect();
    let mut at = vec![Vec::new(); extraction.fragments.len()];
    for (bridge, fragments) in ends.iter().enumerate() {
        for fragment in fragments {
            at[*fragment].push(bridge);
        }
    }
    let fed: Vec<usize> = inlets.iter().map(|node| extraction.fragment[*node]).collect();
    let rank = |f: usize| {
        let fragment = &extraction.fragments[f];
        (fed.contains(&f), fragment.widest_end.unwrap_or(0.0), fragment.length)
    };
    let mut order: Vec<usize> = (0..at.len()).collect();
    order.sort_by(|a, b| {
        let (a, b) = (rank(*a), rank(*b));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1)).then(b.2.total_cmp(&a.2))
    });
    let mut sides = vec![[LinkSide::Parent; 2]; bridges.len()];
    let mut reached = vec![false; at.len()];
    for root in order {
        if std::mem::replace(&mut reached[root], true) {
            continue;
        }
        let mut queue = std::collections::VecDeque::from([root]);
        while let Some(parent) = queue.pop_front() {
            for bridge in &at[parent] {
                let child = usize::from(ends[*bridge][0] == parent);
                if !std::mem::replace(&mut reached[ends[*bridge][child]], true) {
                    sides[*bridge][child] = LinkSide::Child;
                    queue.push_back(ends[*bridge][child]);
                }
            }
        }
    }
    sides
}
