//! Centerlines as read from a file: points with radii, linked into polylines, before anything is a vessel. Coincident points of different
//! polylines are merged.
//!
//! Centerlines are contracted to vessels: maximal runs of points between points whose degree is not two. The root of a tracing is where its
//! blood comes from, if it is the widest end of one tree that gets narrower from there.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use petgraph::unionfind::UnionFind;

use super::path_places::{PathPlace, divided, length_of};
use super::walks::{Walk, edges_at, other_end, runs_by_node, vessels_at};
use super::{Frame, LengthUnit, Network, Node, Origin, PathPoint, Vessel};
use crate::error::Fault;
use crate::support::{Point, arc_lengths::arc_lengths, box_diagonal, counted, distance, statistics::median};

/// Points with radii and the links between consecutive ones. Lengths in m.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Centerlines {
    /// Which way the axes of the positions point.
    pub frame: Frame,
    /// The unit of the file's lengths, if it is the file that states one.
    pub unit: Option<LengthUnit>,
    /// Positions, m.
    pub points: Vec<Point>,
    /// Radii, m, as in the file: NaN, zero and negative values are missing radii.
    pub radii: Vec<f64>,
    /// The point's number in the file (SWC index, VTP row).
    pub ids: Vec<u64>,
    /// The tree (SWC, VTP lines that share points) or polyline to which a point belongs.
    pub strand: Vec<u32>,
    /// Pairs of linked points.
    pub links: Vec<[u32; 2]>,
    /// The radii of the links, m, where the file states those (NaN where it lacks one); points then have their mean. Else none.
    pub link_radii: Vec<f64>,
    /// The anatomical labels of the links.
    pub labels: Labels,
    /// Points that were merged with another: their numbers in the file, and the row of the other.
    pub merged: Vec<(u64, u32)>,
    /// The numbers of the points where a vessel leaves the image.
    pub at_border: BTreeSet<u64>,
    /// The numbers of the points that the file states as its source: all its lines start there.
    pub sources: BTreeSet<u64>,
    /// The number of the point that is the root of the only tree of the file.
    pub root: Option<u64>,
    /// Whether the file states which points are one, so that others in one place are apart, as where a contact was cut.
    pub states_nodes: bool,
}

impl Centerlines {
    /// Adds a point (m) of a strand and returns its row.
    pub fn add_point(&mut self, position: Point, radius: f64, id: u64, strand: u32) -> u32 {
        self.points.push(position);
        self.radii.push(radius);
        self.ids.push(id);
        self.strand.push(strand);
        self.points.len() as u32 - 1
    }

    /// Links two points, with an anatomical label unless it is empty.
    pub fn add_link(&mut self, ends: [u32; 2], label: &str) {
        self.links.push(ends);
        if !label.is_empty() {
            self.labels.set(self.links.len() - 1, label);
        }
    }
}

/// Whether a radius is usable: finite and positive.
pub fn is_radius(r: f64) -> bool {
    r.is_finite() && r > 0.0
}

/// The anatomical labels of links; most have none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    names: Vec<String>,
    row_of: BTreeMap<String, u32>,
    /// Per link the row of its label plus one; 0, or beyond the end, for none.
    of_link: Vec<u32>,
}

impl Labels {
    /// Labels a link; an empty label removes it.
    pub fn set(&mut self, link: usize, name: &str) {
        if name.is_empty() {
            if let Some(slot) = self.of_link.get_mut(link) {
                *slot = 0;
            }
            return;
        }
        let row = *self.row_of.entry(name.to_owned()).or_insert_with(|| {
            self.names.push(name.to_owned());
            self.names.len() as u32 - 1
        });
        if self.of_link.len() <= link {
            self.of_link.resize(link + 1, 0);
        }
        self.of_link[link] = row + 1;
    }

    /// Puts another text in the place of each label; an empty one removes it.
    pub fn rename(&mut self, of: impl Fn(&str) -> String) {
        self.names.iter_mut().for_each(|name| *name = of(name));
        self.row_of = self.names.iter().cloned().zip(0..).collect();
    }

    /// The label of a link; empty if it has none.
    pub fn of(&self, link: usize) -> &str {
        match self.of_link.get(link) {
            None | Some(0) => "",
            Some(row) => &self.names[*row as usize - 1],
        }
    }
}

/// Points of different polylines coincide within this fraction of the diagonal of the bounding box.
pub const WELD_TOLERANCE: f64 = 1e-6;
/// But not farther from one another than this fraction of the usual step from point to point, however far off others lie.
const WELD_STEP: f64 = 0.01;

impl Centerlines {
    /// Merges coincident points: those of different polylines, the two ends of a closed polyline's only
    /// link run, and linked points without a distance between them; only the last, where the file states its nodes. Returns how many points
    /// were removed.
    ///
    /// `tolerance` is a fraction of the diagonal of the bounding box, as [`WELD_TOLERANCE`].
    pub fn weld(&mut self, tolerance: f64) -> usize {
        let n = self.points.len();
        let steps: Vec<f64> = self.links.iter().map(|ends| self.step(*ends)).filter(|step| *step > 0.0).collect();
        let usual = median(&steps).unwrap_or(f64::INFINITY);
        let reach = (tolerance * box_diagonal(self.points.iter().copied())).min(WELD_STEP * usual);
        let degree = counted(n, self.links.iter().flatten().map(|end| *end as usize));
        let strands = &self.strand[..if self.states_nodes { 0 } else { n }];
        let mut places = DistinctPositions::of(&self.points, strands);
        places.unite_crowds(reach);
        // Besides the points, two elements for each place: one for the free ends there, which are always merged, and one for
        // its other points, once they are merged.
        let [ends, others] = [0, 1].map(|which| move |place: usize| n + 2 * place + which);
        let mut same = UnionFind::<usize>::new(n + 2 * places.at.len());
        let mut is_one = vec![false; places.at.len()];
        let mut has_end = vec![false; places.at.len()];
        for (point, place) in places.of.iter().enumerate().filter(|(point, _)| degree[*point] == 1) {
            has_end[*place] = true;
            same.union(point, ends(*place));
        }
        for link in &self.links {
            if self.step(*link) <= reach {
                same.union(link[0] as usize, link[1] as usize);
            }
        }
        let mut meet = |a: usize, b: usize| {
            if places.strand[a].is_none() || places.strand[a] != places.strand[b] {
                (is_one[a], is_one[b]) = (true, true);
                for element in [others(a), ends(b), others(b)] {
                    same.union(ends(a), element);
                }
            } else if has_end[a] && has_end[b] {
                same.union(ends(a), ends(b));
            }
        };
        (0..places.at.len()).filter(|place| places.strand[*place].is_none()).for_each(|place| meet(place, place));
        pairs_within(&places.at, reach, &mut meet);
        for (point, place) in places.of.iter().enumerate().filter(|(_, place)| is_one[**place]) {
            same.union(point, others(*place));
        }
        let mut class = same.into_labeling();
        class.truncate(n);
        self.merge(&class)
    }

    /// How far the two ends of a link lie apart, m.
    fn step(&self, [a, b]: [u32; 2]) -> f64 {
        distance(self.points[a as usize], self.points[b as usize])
    }

    /// Replaces every point by the first one of its class, with the largest radius of the class; drops links that became empty or
    /// double. Of double links the first with a label gives it.
    fn merge(&mut self, class: &[usize]) -> usize {
        let mut first_of = vec![None; class.iter().max().map_or(0, |most| most + 1)];
        let mut new_index = vec![0_u32; class.len()];
        let mut kept = Vec::new();
        for (point, label) in class.iter().enumerate() {
            new_index[point] = *first_of[*label].get_or_insert_with(|| {
                kept.push(point);
                kept.len() as u32 - 1
            });
            let first = kept[new_index[point] as usize];
            // The widest, whatever the order of the points.
            let (standing, other) = (self.radii[first], self.radii[point]);
            if is_radius(other) && (!is_radius(standing) || other > standing) {
                self.radii[first] = other;
            }
        }
        let gone = class.len() - kept.len();
        self.merged.iter_mut().for_each(|(_, row)| *row = new_index[*row as usize]);
        let is_gone = |point: &usize| kept[new_index[*point] as usize] != *point;
        self.merged.extend((0..class.len()).filter(is_gone).map(|point| (self.ids[point], new_index[point])));
        let mut row_of: HashMap<[u32; 2], usize> = HashMap::new();
        let (links, labels) = (std::mem::take(&mut self.links), std::mem::take(&mut self.labels));
        let radii = std::mem::take(&mut self.link_radii);
        for (row, link) in links.into_iter().enumerate() {
            let [a, b] = link.map(|p| new_index[p as usize]);
            if a == b {
                continue;
            }
            let first = *row_of.entry([a.min(b), a.max(b)]).or_insert(self.links.len());
            if first == self.links.len() {
                self.add_link([a, b], labels.of(row));
                self.link_radii.extend(radii.get(row));
            } else if self.labels.of(first).is_empty() {
                self.labels.set(first, labels.of(row));
            }
        }
        self.points = kept.iter().map(|p| self.points[*p]).collect();
        self.radii = kept.iter().map(|p| self.radii[*p]).collect();
        self.ids = kept.iter().map(|p| self.ids[*p]).collect();
        self.strand = kept.iter().map(|p| self.strand[*p]).collect();
        gone
    }
}

/// The distinct positions of points; any number of points may share one.
struct DistinctPositions {
    at: Vec<Point>,
    /// The strand of the points there; none if they belong to several.
    strand: Vec<Option<u32>>,
    /// The place of each point.
    of: Vec<usize>,
}

impl DistinctPositions {
    fn of(points: &[Point], strands: &[u32]) -> Self {
        let mut places = Self { at: Vec::new(), strand: Vec::new(), of: Vec::with_capacity(points.len()) };
        let mut number_of = HashMap::with_capacity(points.len());
        for (point, strand) in points.iter().zip(strands) {
            // The sum makes one zero of both.
            let place = *number_of.entry(point.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                places.at.push(*point);
                places.strand.push(Some(*strand));
                places.at.len() - 1
            });
            if places.strand[place] != Some(*strand) {
                places.strand[place] = None;
            }
            places.of.push(place);
        }
        places
    }

    /// Merges places that crowd in a cube of half the reach, where each is within reach of all others. Without
    /// that, one distant coordinate makes the reach so wide that every two points are a pair.
    fn unite_crowds(&mut self, reach: f64) {
        const CROWD: usize = 16;
        if self.at.len() <= CROWD || reach <= 0.0 {
            return;
        }
        let cell = |p: &Point| p.map(|x| (x / (0.5 * reach)).floor() as i64);
        let mut in_cell: HashMap<[i64; 3], usize> = HashMap::with_capacity(self.at.len());
        self.at.iter().for_each(|p| *in_cell.entry(cell(p)).or_default() += 1);
        in_cell.retain(|_, places| *places > CROWD);
        if in_cell.is_empty() {
            return;
        }
        let mut first_in: HashMap<[i64; 3], usize> = HashMap::new();
        let (mut at, mut strand) = (Vec::new(), Vec::new());
        let number: Vec<usize> = (0..self.at.len())
            .map(|place| {
                let p = self.at[place];
                let crowd = in_cell.contains_key(&cell(&p));
                let new = if crowd { *first_in.entry(cell(&p)).or_insert(at.len()) } else { at.len() };
                if new == at.len() {
                    at.push(p);
                    strand.push(if crowd { None } else { self.strand[place] });
                }
                new
            })
            .collect();
        self.of.iter_mut().for_each(|place| *place = number[*place]);
        (self.at, self.strand) = (at, strand);
    }
}

/// Calls `meet` for all pairs (a < b) of points at most `reach` apart.
///
/// A grid of cells several times as wide is searched: few points lie so close to a side that the next cell matters too.
pub fn pairs_within(points: &[Point], reach: f64, meet: &mut impl FnMut(usize, usize)) {
    const WIDTH: f64 = 8.0;
    const NONE: u32 = u32::MAX;
    // A little more than the reach, for coordinates that are rounded.
    let margin = 1.125 * reach;
    let cell = |x: f64| if reach > 0.0 { (x / (WIDTH * reach)).floor() as i64 } else { (x + 0.0).to_bits() as i64 };
    let mut last_in: HashMap<[i64; 3], u32> = HashMap::with_capacity(points.len());
    let mut before = vec![NONE; points.len()];
    for (b, p) in points.iter().enumerate() {
        let (low, high) = (p.map(|x| cell(x - margin)), p.map(|x| cell(x + margin)));
        for corner in 0..8 {
            let side = |axis: usize| corner >> axis & 1 == 1;
            if (0..3).any(|axis| side(axis) && low[axis] == high[axis]) {
                continue;
            }
            let mut at =
                last_in.get(&[0, 1, 2].map(|axis| if side(axis) { high[axis] } else { low[axis] })).copied().unwrap_or(NONE);
            while at != NONE {
                if distance(points[at as usize], *p) <= reach {
                    meet(at as usize, b);
                }
                at = before[at as usize];
            }
        }
        before[b] = last_in.insert(p.map(cell), b as u32).unwrap_or(NONE);
    }
}

/// Which single radius a vessel gets from the radii along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadiusRule {
    /// The mean over arc length, r = (1/l) ∫ r dz (Moriconi et al. 2019, eq. 1), by the trapezoid rule.
    #[default]
    Mean,
    /// (l / ∫ dz/r⁴)^¼: keeps the series resistance of a tapering vessel, exactly for radii linear between points.
    Effective,
}

/// A network made of centerlines, and what had to be repaired.
#[derive(Debug, Clone, Default)]
pub struct Contraction {
    /// The network; every vessel is observed.
    pub network: Network,
    /// Points whose radius was missing, zero or not finite and was interpolated.
    pub repaired_radii: usize,
    /// Vessels that had no radius at all and took the default.
    pub default_radii: usize,
    /// Vessels whose links have different labels.
    pub mixed_labels: usize,
}

impl RadiusRule {
    /// The word on the command line and in files.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["mean", "effective"][self as usize]
    }

    /// The single radius (m) of a vessel with these points.
    pub fn radius(self, path: &[PathPoint]) -> f64 {
        let (mut length, mut sum) = (0.0, 0.0);
        for pair in path.windows(2) {
            let (p, q, dz) = (pair[0].radius, pair[1].radius, distance(pair[0].position, pair[1].position));
            length += dz;
            sum += dz * if self == Self::Mean { 0.5 * (p + q) } else { (p * p + p * q + q * q) / (3.0 * (p * q).powi(3)) };
        }
        match self {
            _ if length <= 0.0 => path.first().map_or(0.0, |p| p.radius),
            Self::Mean => sum / length,
            Self::Effective => (length / sum).powf(0.25),
        }
    }
}

impl Vessel {
    /// An observed vessel along a centerline.
    pub fn along(path: Vec<PathPoint>, rule: RadiusRule) -> Self {
        let (length, radius) = (length_of(&path), rule.radius(&path));
        Self { path, ..Self::new(length, radius, Origin::Observed) }
    }

    /// The observed parts of it between places of its `course`, given in order, with their two nodes: `node` makes that of a place, by its number
    /// and the point there. A part has the radius of its own points, its share of the length and of a resistance that is stated, and the same
    /// label, prior, wall and decisions.
    pub fn parts(
        &self,
        ends: [usize; 2],
        course: &[PathPoint],
        places: impl IntoIterator<Item = PathPlace>,
        rule: RadiusRule,
        mut node: impl FnMut(usize, PathPoint) -> usize,
    ) -> Vec<([usize; 2], Self)> {
        let (whole, pieces) = (length_of(course), divided(course, places));
        let (mut from, last) = (ends[0], pieces.len() - 1);
        let part = |(number, piece): (usize, Vec<PathPoint>)| {
            let to = if number == last { ends[1] } else { node(number, piece[piece.len() - 1]) };
            let along = Self::along(piece, rule);
            let (stretched, share) = if whole > 0.0 { (self.length / whole, along.length / whole) } else { (1.0, 1.0) };
            let part = Self {
                length: along.length * stretched,
                resistance: self.resistance.map(|resistance| share * resistance),
                label: self.label.clone(),
                prior: self.prior,
                certain: self.certain,
                kept: self.kept,
                wall: self.wall,
                ..along
            };
            ([std::mem::replace(&mut from, to), to], part)
        };
        pieces.into_iter().enumerate().map(part).collect()
    }
}

/// Contracts centerlines to a network of observed vessels.
///
/// Nodes are the points of degree other than two, in point order, and the first point of every pure ring. Missing
/// radii are interpolated linearly over arc length along their vessel. A vessel has the label of its longest part.
///
/// # Errors
///
/// A vessel without any valid radius when `default_radius` (m) is `None`, or without length.
pub fn contract(lines: &Centerlines, rule: RadiusRule, default_radius: Option<f64>) -> Result<Contraction, Fault> {
    let ends = |link: usize| lines.links[link].map(|point| point as usize);
    let at = edges_at(lines.points.len(), (0..lines.links.len()).map(|link| (link, ends(link))));
    let mut is_node: Vec<bool> = at.iter().map(|links| links.len() != 2).collect();
    let runs = runs_by_node(&at, ends);
    for run in &runs {
        is_node[run.nodes[0]] = true;
    }
    let mut out = Contraction::default();
    out.network.frame = lines.frame;
    let mut row_of = vec![usize::MAX; lines.points.len()];
    for point in (0..lines.points.len()).filter(|p| is_node[*p]) {
        row_of[point] = out.network.add_node(Node {
            id: lines.ids[point].to_string(),
            position: Some(lines.points[point]),
            radius: Some(lines.radii[point]).filter(|r| is_radius(*r)),
            at_border: lines.at_border.contains(&lines.ids[point]),
            is_source: lines.sources.contains(&lines.ids[point]),
            ..Node::default()
        });
    }
    for (id, point) in &lines.merged {
        if let Some(row) = row_of.get(*point as usize).filter(|row| **row != usize::MAX) {
            let node = out.network.node_mut(*row);
            node.also.push(id.to_string());
            node.is_source |= lines.sources.contains(id);
        }
    }
    let mut interpolated = vec![false; lines.points.len()];
    for run in runs {
        let (points, ends) = (&run.nodes, run.ends().map(|point| row_of[point]));
        let name = || format!("vessel from point {} to point {}", lines.ids[points[0]], lines.ids[points[points.len() - 1]]);
        let radii = if let Some(radii) = radii_along(&run, lines) {
            points.iter().filter(|point| !is_radius(lines.radii[**point])).for_each(|point| interpolated[*point] = true);
            radii
        } else {
            out.default_radii += 1;
            let found = format!("no valid radius on any of its {} points", points.len());
            let accepted = "expected a positive radius, or give `default_radius`";
            vec![default_radius.ok_or_else(|| Fault::item(name(), found, accepted))?; points.len()]
        };
        let path = points.iter().zip(&radii);
        let path = path.map(|(p, r)| PathPoint { position: lines.points[*p], radius: *r, id: Some(lines.ids[*p]) }).collect();
        let (label, mixed) = label(lines, &run);
        out.mixed_labels += usize::from(mixed);
        let vessel = Vessel { label, ..Vessel::along(path, rule) };
        if vessel.length <= 0.0 {
            return Err(Fault::item(name(), "length 0", "expected points at different positions"));
        }
        for (end, radius) in [(ends[0], radii[0]), (ends[1], radii[radii.len() - 1])] {
            out.network.node_mut(end).radius.get_or_insert(radius);
        }
        out.network.add_vessel(ends, vessel);
    }
    let point_of = |id: u64| {
        let merged = || lines.merged.iter().find(|(other, _)| *other == id).map(|(_, point)| *point as usize);
        lines.ids.iter().position(|other| *other == id).or_else(merged)
    };
    if let Some(root) = lines.root.and_then(point_of).filter(|point| is_node[*point]).map(|point| row_of[point]) {
        out.network.node_mut(root).is_source |= falls_from(&out.network, root);
    }
    out.repaired_radii = interpolated.iter().filter(|point| **point).count();
    Ok(out)
}

/// The label of the longest part of a run, and whether there are others.
fn label(lines: &Centerlines, run: &Walk) -> (String, bool) {
    let mut lengths: Vec<(&str, f64)> = Vec::new();
    for (ends, link) in run.nodes.windows(2).zip(&run.edges) {
        let (name, length) = (lines.labels.of(*link), distance(lines.points[ends[0]], lines.points[ends[1]]));
        match lengths.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += length,
            None => lengths.push((name, length)),
        }
    }
    let longest = lengths.iter().fold(("", -1.0), |best, this| if this.1 > best.1 { *this } else { best });
    (longest.0.to_owned(), lengths.len() > 1)
}

/// The radii along the points of a run: missing ones linear over arc length between valid neighbours, round the end of a ring too, and level
/// beyond the outermost; `None` when there is no valid one. Where links have radii, a point has the mean of its links in the run, weighted by
/// length, which keeps ∫ r dz.
fn radii_along(run: &Walk, lines: &Centerlines) -> Option<Vec<f64>> {
    let points = &run.nodes;
    let arc = arc_lengths(points.iter().map(|point| lines.points[*point]));
    let mut radii: Vec<f64> = points.iter().map(|p| lines.radii[*p]).collect();
    for (i, radius) in radii.iter_mut().enumerate().filter(|_| !lines.link_radii.is_empty()) {
        let mut length = 0.0;
        for n in i.saturating_sub(1)..(i + 1).min(run.edges.len()) {
            let (step, own) = (arc[n + 1] - arc[n], lines.link_radii.get(run.edges[n]).copied().unwrap_or_default());
            if step > 0.0 && is_radius(own) {
                length += step;
                *radius = if length > step { *radius + (own - *radius) * step / length } else { own };
            }
        }
    }
    let mut valid: Vec<usize> = (0..radii.len()).filter(|i| is_radius(radii[*i])).collect();
    let (first, last, end) = (*valid.first()?, *valid.last()?, radii.len() - 1);
    let (head, tail) = (radii[first], radii[last]);
    let between = |from: f64, to: f64, along: f64, span: f64| {
        let share = if span > 0.0 { along / span } else { 0.5 };
        from + share * (to - from)
    };
    if points[0] == points[end] && first > 0 {
        let (before, behind) = (arc[end] - arc[last], arc[first]);
        radii[0] = between(tail, head, before, before + behind);
        radii[end] = radii[0];
        valid = [vec![0], valid, vec![end]].concat();
    } else {
        radii[..first].fill(head);
        radii[last..].fill(tail);
    }
    for pair in valid.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (ra, rb, span) = (radii[a], radii[b], arc[b] - arc[a]);
        for i in a + 1..b {
            radii[i] = between(ra, rb, arc[i] - arc[a], span);
        }
    }
    Some(radii)
}

/// The other free ends have at most this share of the radius of the root.
const MOST_WIDTH: f64 = 0.95;
/// No vessel is wider than this many times the narrowest one between it and the root. In a circle of arteries one comes from a carotid by
/// narrow vessels to the next carotid.
const MOST_RISE: f64 = 1.2;

/// Whether the network is one tree, `root` a free end of it and the widest of all, and vessels get narrower from there.
fn falls_from(network: &Network, root: usize) -> bool {
    if network.vessel_count() + 1 != network.node_count() {
        return false;
    }
    let vessels_at = vessels_at(network, |_| true);
    let [first] = vessels_at[root][..] else { return false };
    let end_radius = |row: usize, node: usize| network.vessel(row).end_radius(network.ends(row)[1] == node);
    let most = MOST_WIDTH * end_radius(first, root);
    // The nodes reached, each with the vessel that leads to it and the narrowest radius up to there.
    let (mut open, mut reached) = (vec![(root, first, f64::INFINITY)], 1);
    while let Some((node, from, narrowest)) = open.pop() {
        for row in vessels_at[node].iter().copied().filter(|row| node == root || *row != from) {
            let (next, vessel) = (other_end(network, row, node), network.vessel(row));
            let is_end = vessels_at[next].len() == 1;
            // A ring leads back; it leaves other nodes unreached.
            if next == node || vessel.radius > MOST_RISE * narrowest || (is_end && end_radius(row, next) > most) {
                return false;
            }
            reached += 1;
            if reached > network.node_count() {
                return false;
            }
            open.push((next, row, narrowest.min(vessel.radius)));
        }
    }
    reached == network.node_count()
}
