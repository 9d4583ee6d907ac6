//! The known connections of a case: where fragments belong together, as files state it, and which candidates are therefore right.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use willis_core::error::Fault;
use willis_core::network::{Network, units::metres, walks::edges_at};
use willis_core::support::geometry::{Point, distance};
use willis_models::candidates::{features::Extraction, search::point_index::PointIndex};

/// Points within so many tolerances beyond the nearest are meant too.
const AS_NEAR: f64 = 0.3;
/// A candidate may attach within so many spacings of a loose end ...
const LOOSE_SPACINGS: f64 = 2.0;
/// ... and on a standing vessel within so many spacings, diameters or gaps of the true place.
const STANDING_SPACINGS: f64 = 3.0;
const STANDING_RADII: f64 = 2.0;
const STANDING_GAPS: f64 = 0.75;

/// Which side of a connection is attached to which; the words in files are `parent` and `child`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AttachmentSide {
    /// The one that is nearer to an inlet.
    Parent,
    /// The one that is attached to it.
    Child,
}

/// Which connection a candidate makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Match {
    /// The connection.
    pub connection: usize,
    /// The pieces it joins there, by their places in it.
    pub pieces: [usize; 2],
}

/// The connections that belong in an extraction. A connection of n pieces needs n - 1 candidates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KnownConnections {
    /// Per connection the sides of its pieces.
    sides: Vec<Vec<AttachmentSide>>,
    /// Per point of the extraction the connections and pieces that a candidate to it reaches.
    sites: Vec<Vec<(usize, usize)>>,
    /// Places (m) and how far they reach (m): what is joined there is neither right nor wrong.
    pub unclear: Vec<(Point, f64)>,
}

impl KnownConnections {
    /// Connections between points of the extraction. Those near to either end are right too: 2 spacings along a loose end; on a
    /// standing vessel 3 spacings, a diameter or 3/4 of the gap. A pair so near to one before it is the same connection. What is nearer to one of
    /// the `inlets` (nodes) is the parent.
    pub fn between(extraction: &Extraction, pairs: &[[usize; 2]], inlets: &[usize]) -> Self {
        let mut this = Self { sides: Vec::new(), sites: vec![Vec::new(); extraction.position.len()], unclear: Vec::new() };
        let index = PointIndex::new(extraction.position.clone());
        let order = outwards(extraction, pairs, inlets);
        for (ends, order) in pairs.iter().zip(order) {
            let connection = this.sides.len();
            let Match { connection, pieces } = this.matching(ends[0], ends[1]).unwrap_or(Match { connection, pieces: [0, 1] });
            let gap = distance(extraction.position[ends[0]], extraction.position[ends[1]]);
            for (piece, point) in pieces.into_iter().zip(ends) {
                let (h, r) = (extraction.spacing, extraction.radius[*point]);
                let standing = (STANDING_SPACINGS * h).max(STANDING_RADII * r).max(STANDING_GAPS * gap);
                let reach = if extraction.end_at[*point].is_some() { LOOSE_SPACINGS * h } else { standing };
                for (_, near) in index.within(extraction.position[*point], reach) {
                    if extraction.fragment[near] == extraction.fragment[*point] {
                        this.sites[near].push((connection, piece));
                    }
                }
            }
            if connection == this.sides.len() {
                this.sides.push(order.to_vec());
            }
        }
        this
    }

    /// Whether a candidate between two points (m) is neither right nor wrong, unless it makes a connection.
    pub fn is_unclear(&self, ends: [Point; 2]) -> bool {
        self.unclear.iter().any(|(place, reach)| ends.iter().any(|end| distance(*end, *place) < *reach))
    }

    /// How many connections there are.
    pub fn connections(&self) -> usize {
        self.sides.len()
    }

    /// How many candidates it takes to make all connections.
    pub fn needed(&self) -> usize {
        self.sides.iter().map(|pieces| pieces.len().saturating_sub(1)).sum()
    }

    /// The first connection and piece that no point reaches.
    pub fn unreachable(&self) -> Option<(usize, usize)> {
        let mut reached: Vec<Vec<bool>> = self.sides.iter().map(|pieces| vec![false; pieces.len()]).collect();
        self.sites.iter().flatten().for_each(|(connection, piece)| reached[*connection][*piece] = true);
        reached.iter().enumerate().find_map(|(connection, pieces)| Some((connection, pieces.iter().position(|r| !r)?)))
    }

    /// The connection that a candidate between two points makes, if any; the pieces in the order of the points.
    pub fn matching(&self, from: usize, to: usize) -> Option<Match> {
        let pairs = self.sites[from].iter().flat_map(|a| self.sites[to].iter().map(move |b| (a, b)));
        let mut made = pairs.filter(|(a, b)| a.0 == b.0 && a.1 != b.1);
        made.next().map(|(a, b)| Match { connection: a.0, pieces: [a.1, b.1] })
    }

    /// Per candidate (child point, parent point; child fragment, parent fragment) whether the likelihood may take it: those that
    /// attach a child to its parent. Of several connections of a fragment the first counts; a candidate that would close a circle of
    /// fragments does not.
    pub fn allowed(&self, candidates: &[([usize; 2], [usize; 2])]) -> Vec<bool> {
        let mut connection_of: BTreeMap<usize, usize> = BTreeMap::new();
        let mut parents_of: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut may = |(points, [child, parent]): &([usize; 2], [usize; 2])| {
            let Some(Match { connection, pieces }) = self.matching(points[0], points[1]) else { return false };
            if pieces.map(|piece| self.sides[connection][piece]) != [AttachmentSide::Child, AttachmentSide::Parent] {
                return false;
            }
            if parents_of.get(child).is_some_and(|on| on.contains(parent)) {
                return connection_of[child] == connection;
            }
            if connection_of.get(child).is_some_and(|l| *l != connection) || leads(&parents_of, *parent, *child) {
                return false;
            }
            connection_of.insert(*child, connection);
            parents_of.entry(*child).or_default().push(*parent);
            true
        };
        candidates.iter().map(&mut may).collect()
    }
}

/// Whether a fragment is attached to another, directly or through others.
fn leads(parents_of: &BTreeMap<usize, Vec<usize>>, from: usize, to: usize) -> bool {
    let (mut open, mut seen) = (vec![from], BTreeSet::from([from]));
    while let Some(at) = open.pop() {
        if at == to {
            return true;
        }
        open.extend(parents_of.get(&at).into_iter().flatten().filter(|next| seen.insert(**next)));
    }
    false
}

/// Per pair of points the sides of its ends when each connected group of fragments is fed from the one with an inlet; of several, or without
/// any, from the widest, then the longest. Pairs that close a circle have no child.
fn outwards(extraction: &Extraction, pairs: &[[usize; 2]], inlets: &[usize]) -> Vec<[AttachmentSide; 2]> {
    let ends: Vec<[usize; 2]> = pairs.iter().map(|ends| ends.map(|point| extraction.fragment[point])).collect();
    let at = edges_at(extraction.fragments.len(), ends.iter().copied().enumerate());
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
    let mut sides = vec![[AttachmentSide::Parent; 2]; pairs.len()];
    let mut reached = vec![false; at.len()];
    for root in order {
        if std::mem::replace(&mut reached[root], true) {
            continue;
        }
        let mut queue = std::collections::VecDeque::from([root]);
        while let Some(parent) = queue.pop_front() {
            for pair in &at[parent] {
                let child = usize::from(ends[*pair][0] == parent);
                if !std::mem::replace(&mut reached[ends[*pair][child]], true) {
                    sides[*pair][child] = AttachmentSide::Child;
                    queue.push_back(ends[*pair][child]);
                }
            }
        }
    }
    sides
}

/// Joins the pieces of connections, match by match; `false` when the two were one already.
pub fn joiner() -> impl FnMut(&Match) -> bool {
    // Per connection the piece by which each of its pieces is known: joined pieces are known by the same.
    let mut all: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
    move |right| {
        let known = all.entry(right.connection).or_default();
        let [a, b] = right.pieces.map(|piece| *known.entry(piece).or_insert(piece));
        known.values_mut().filter(|k| **k == a).for_each(|k| *k = b);
        a != b
    }
}

/// How many of the candidates needed some right candidates are.
pub fn found(right: impl IntoIterator<Item = Match>) -> usize {
    right.into_iter().filter(joiner()).count()
}

/// The true connections as JSON: links between pieces as `gapbench` writes them, or the breaks of `willis phantom --break`.
#[derive(Deserialize)]
struct TruthFile {
    subject: Option<String>,
    voxel_mm: Option<f64>,
    /// How far a point may be from the node that it shows, where that is not a voxel.
    reach_mm: Option<f64>,
    #[serde(default)]
    nodes: Vec<Vec<f64>>,
    links: Option<Vec<Vec<LinkMember>>>,
    breaks: Option<Vec<BreakPoints>>,
    /// Places where two vessels are fused; a candidate there is neither right nor wrong.
    #[serde(default)]
    fusions: Vec<Fusion>,
    #[serde(default)]
    /// Ids from `willis phantom`; others write more than that, which is in a file of its own too.
    inlets: Vec<serde_json::Value>,
}

#[derive(Deserialize)]
struct LinkMember {
    role: AttachmentSide,
    allowed: Vec<u64>,
}

#[derive(Deserialize)]
struct Fusion {
    place: [f64; 3],
    reach_mm: f64,
    #[serde(default)]
    judged: bool,
}

#[derive(Deserialize)]
struct BreakPoints {
    ids: [u64; 2],
}

/// The true connections of an extraction of a network that blood enters at some nodes, and the subject where it is named.
///
/// # Errors
///
/// No such JSON, a node that is not there, links that no point of the extraction reaches.
pub fn read_truth(
    bytes: &[u8],
    network: &Network,
    extraction: &Extraction,
    inlets: &[usize],
) -> Result<(KnownConnections, Option<String>), Fault> {
    const ACCEPTED: &str = "expected an object with links (and nodes, voxel_mm), or with breaks";
    let file: TruthFile = serde_json::from_slice(bytes).map_err(|e| Fault::line(e.line().max(1), e.to_string(), ACCEPTED))?;
    let mut truth = match (&file.links, &file.breaks) {
        (Some(links), None) => file.of_links(links, extraction)?,
        (None, Some(breaks)) => file.of_breaks(breaks, network, extraction, inlets)?,
        (None, None) => return Err(Fault::file("neither links nor breaks", ACCEPTED)),
        (Some(_), Some(_)) => return Err(Fault::file("both links and breaks", ACCEPTED)),
    };
    let fusions = file.fusions.iter().filter(|fusion| fusion.judged);
    truth.unclear = fusions.map(|fusion| (fusion.place.map(metres), metres(fusion.reach_mm))).collect();
    Ok((truth, file.subject))
}

impl TruthFile {
    /// Groups of pieces that belong together, each with the nodes (numbered from 1) at which a candidate may attach.
    fn of_links(&self, links: &[Vec<LinkMember>], extraction: &Extraction) -> Result<KnownConnections, Fault> {
        let mut points = Vec::with_capacity(self.nodes.len());
        for (row, node) in self.nodes.iter().enumerate() {
            match node[..] {
                [x, y, z, ..] if [x, y, z].iter().all(|x| x.is_finite()) => points.push([x, y, z].map(metres)),
                _ => return Err(Fault::item(format!("node {}", row + 1), format!("{node:?}"), "expected [x, y, z, r] in mm")),
            }
        }
        let (name, reach_mm) = self.reach_mm.map_or(("voxel_mm", self.voxel_mm), |mm| ("reach_mm", Some(mm)));
        let reach = match reach_mm {
            Some(h) if h > 0.0 && h.is_finite() => metres(h),
            Some(h) => return Err(Fault::item(name, h.to_string(), "expected a positive number")),
            None => extraction.spacing,
        };
        // Per node the connections and pieces that name it.
        let mut named = vec![Vec::new(); points.len()];
        for (row, members) in links.iter().enumerate() {
            for (piece, member) in members.iter().enumerate() {
                for id in &member.allowed {
                    let there = id.checked_sub(1).and_then(|node| named.get_mut(usize::try_from(node).ok()?));
                    let accepted = || format!("expected nodes from 1 to {}", points.len());
                    let wrong = || Fault::item(format!("link {row}"), format!("node {id}"), accepted());
                    there.ok_or_else(wrong)?.push((row, piece));
                }
            }
        }
        // A point of the extraction represents the nearest node within reach, and those hardly further away.
        let index = PointIndex::new(points);
        let sites = extraction.position.iter().map(|p| {
            let nearest = index.nearest(*p, reach);
            let near = if nearest.points.is_empty() { Vec::new() } else { index.within(*p, nearest.distance + AS_NEAR * reach) };
            near.into_iter().flat_map(|(_, node)| named[node].iter().copied()).collect()
        });
        let sites = sites.collect();
        let sides = links.iter().map(|link| link.iter().map(|member| member.role).collect()).collect();
        let truth = KnownConnections { sides, sites, unclear: Vec::new() };
        match truth.unreachable() {
            Some((link, piece)) => {
                let nodes: Vec<String> = links[link][piece].allowed.iter().take(3).map(u64::to_string).collect();
                let found = format!("no point of the fragments is at its nodes {}", nodes.join(", "));
                Err(Fault::item(format!("link {link}"), found, "expected the answer to these fragments"))
            }
            None => Ok(truth),
        }
    }

    /// Missing stretches between two points by their ids.
    fn of_breaks(
        &self,
        gaps: &[BreakPoints],
        network: &Network,
        extraction: &Extraction,
        inlets: &[usize],
    ) -> Result<KnownConnections, Fault> {
        // Where each id is: a node, or a point of a vessel, which stands for the nearest that the model sees there.
        let nodes_by_id = network.nodes().enumerate().filter_map(|(row, node)| Some((node.id.parse().ok()?, row)));
        let nodes_by_id: BTreeMap<u64, usize> = nodes_by_id.collect();
        let mut along: BTreeMap<u64, (usize, Point)> = BTreeMap::new();
        for (row, (_, vessel)) in network.vessels().enumerate() {
            along.extend(vessel.path.iter().filter_map(|at| Some((at.id?, (row, at.position)))));
        }
        let point_of = |id: u64| {
            nodes_by_id.get(&id).copied().or_else(|| {
                let (row, position) = along.get(&id)?;
                let away = extraction.lines[*row].iter().map(|point| (distance(extraction.position[*point], *position), *point));
                away.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point)
            })
        };
        let find = |place: String, id: u64| {
            let accepted = "expected the id of a point of the fragments";
            point_of(id).ok_or_else(|| Fault::item(place, format!("point {id}"), accepted))
        };
        let mut pairs = Vec::new();
        for (row, gap) in gaps.iter().enumerate() {
            let [a, b] = gap.ids.map(|id| find(format!("break {row}"), id));
            pairs.push([a?, b?]);
        }
        let mut nodes = inlets.to_vec();
        for id in self.inlets.iter().filter_map(serde_json::Value::as_u64) {
            let point = find("inlets".into(), id)?;
            nodes.extend(Some(point).filter(|point| *point < network.node_count()));
        }
        Ok(KnownConnections::between(extraction, &pairs, &nodes))
    }
}
