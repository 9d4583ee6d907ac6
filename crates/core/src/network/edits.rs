//! What a person changes of a graph by places in mm: two places joined, vessels that meet parted, a vessel deleted; and these edits made on
//! a graph.
//!
//! Rows stay: a vessel that is divided keeps the part at its first node, the other part and all that is new come last, and what is deleted
//! is a candidate with P = 0 from then on.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};

use super::path_places::length_of;
use super::{Evidence, Frame, LengthsAt, Network, Node, Origin, PathPoint, ShortestPaths, Vessel, lengths_at, millimetres};
use crate::error::{ensure, in_few_digits};
use crate::support::{Point, distance, lerp, onto};

/// A place further from every vessel, and outside its lumen, means none, m.
const REACH: f64 = 0.002;
/// A place so near the end of a vessel is the end, m.
const AT_END: f64 = 1e-5;
/// Vessels whose distances from a place differ by no more lie on each other there, m.
const ON_EACH_OTHER: f64 = 1e-7;
/// A way so many times as long as the straight one is not what joins two places that go together.
const DETOUR: f64 = 5.0;
/// What another group needs counts so many times its length for a group that looks for its way.
const SHARED: f64 = 3.0;
/// A candidate of no less is taken to be there where groups are cut apart.
const LIKELY: f64 = 0.5;
/// A join is no shorter than this share of its radius: a resistance must not be nothing.
const SHORTEST: f64 = 0.05;

/// A vessel that is nearest to a place, and where on it: the stretch of its course, and the share of that.
type NearestVessel = (usize, (usize, f64));

/// A graph that is being edited.
pub struct GraphEditor {
    frame: Frame,
    nodes: Vec<Node>,
    vessels: Vec<([usize; 2], Vessel)>,
    ids: BTreeSet<String>,
    has_evidence: bool,
    /// Rows of the joins.
    pub joined: Vec<usize>,
    /// Per vessel that was divided its row and that of its other part, in this order.
    pub divided: Vec<[usize; 2]>,
}

/// The part of a graph that a group of places needs.
#[derive(Default)]
struct GroupPart {
    nodes: BTreeSet<usize>,
    vessels: BTreeSet<usize>,
    /// Pairs of nodes that no vessel joins yet.
    straight: Vec<[usize; 2]>,
}

impl GraphEditor {
    /// The editor of a graph.
    pub fn new(graph: Network) -> Self {
        let has_evidence = graph.vessels().any(|(_, vessel)| vessel.evidence.is_some());
        let ids = graph.nodes().map(|node| node.id.clone()).collect();
        let frame = graph.frame;
        let (nodes, vessels) = graph.into_parts();
        let (nodes, vessels) = (nodes.collect(), vessels.collect());
        Self { frame, nodes, vessels, ids, has_evidence, joined: Vec::new(), divided: Vec::new() }
    }

    /// The graph as it is now.
    pub fn finish(self) -> Network {
        let mut graph = Network::of(self.frame, self.nodes, self.vessels);
        graph.store();
        graph
    }

    /// Makes an edit.
    ///
    /// # Errors
    ///
    /// Why it cannot be: a place that no vessel is at, two places of a group that are one. Then the graph is of no more use.
    pub fn edit(&mut self, edit: &Edit) -> Result<(), String> {
        match edit {
            Edit::Join(way) => self.join(way),
            Edit::Part(groups) => self.part(groups),
            Edit::Delete(place) => {
                let (row, _) = self.nearest(*place)?[0];
                self.delete(row);
                Ok(())
            }
        }
    }

    /// Whether a vessel is there as far as anyone knows: observed, certain, or a contact that was not rejected.
    fn is_there(&self, row: usize) -> bool {
        let vessel = &self.vessels[row].1;
        vessel.is_given() || vessel.origin == Origin::Contact && vessel.prior > 0.0
    }

    fn at(&self, node: usize) -> Point {
        self.nodes[node].position.unwrap_or_default()
    }

    /// The course of a vessel: its path, or its two nodes.
    fn course(&self, row: usize) -> Vec<PathPoint> {
        let (ends, vessel) = &self.vessels[row];
        vessel.path_between(ends.map(|node| self.at(node)))
    }

    /// The vessels nearest to a place, several where they lie on each other, and where on each.
    fn nearest(&self, place: MmPoint) -> Result<Vec<NearestVessel>, String> {
        let at = place.map(|x| x * 1e-3);
        let mut found: Vec<(f64, usize, (usize, f64))> = Vec::new();
        for row in (0..self.vessels.len()).filter(|row| self.is_there(*row)) {
            let ([a, b], vessel) = &self.vessels[row];
            let mut best = (f64::INFINITY, row, (0, 0.0));
            let mut look = |stretch: usize, from: Point, to: Point| {
                let (share, away) = onto(at, from, to);
                if away < best.0 {
                    best = (away, row, (stretch, share));
                }
            };
            if vessel.path.len() > 1 {
                vessel.path.windows(2).enumerate().for_each(|(at, w)| look(at, w[0].position, w[1].position));
            } else {
                look(0, self.at(*a), self.at(*b));
            }
            found.push(best);
        }
        let least = found.iter().min_by(|a, b| a.0.total_cmp(&b.0)).copied();
        let (away, row, _) = least.ok_or("the graph has no vessel")?;
        ensure(self.nodes.iter().all(|node| node.position.is_some()), || "the nodes have no coordinates".to_owned())?;
        if away > REACH.max(self.vessels[row].1.radius) {
            let (away, reach) = (in_few_digits(format!("{:.1}", millimetres(away))), millimetres(REACH));
            let place = text_of(&[place]);
            return Err(format!("{place} is {away} mm from the nearest vessel; expected a place within {reach} mm of one"));
        }
        Ok(found.into_iter().filter(|one| one.0 <= away + ON_EACH_OTHER).map(|(_, row, on)| (row, on)).collect())
    }

    /// The nodes at the places of a group. Where vessels lie on each other, as those that an earlier edit doubled, a place is on the one
    /// that is nearest, along vessels, to the other places of its group.
    fn nodes_at(&mut self, group: &[MmPoint]) -> Result<Vec<usize>, String> {
        let several: Vec<bool> =
            group.iter().map(|place| self.nearest(*place).map(|found| found.len() > 1)).collect::<Result<_, String>>()?;
        let mut nodes = vec![None; group.len()];
        for on_several in [false, true] {
            for at in (0..group.len()).filter(|at| several[*at] == on_several) {
                let found = self.nearest(group[at])?;
                let others: Vec<usize> = nodes.iter().flatten().copied().collect();
                let row = if found.len() > 1 { self.nearest_along(&found, &others) } else { 0 };
                nodes[at] = Some(self.divide(found[row]));
            }
        }
        Ok(nodes.into_iter().flatten().collect())
    }

    /// Which of some vessels is nearest to some nodes along the vessels between.
    fn nearest_along(&self, found: &[NearestVessel], nodes: &[usize]) -> usize {
        let edges = self.edges(|row| self.is_there(row));
        let mut paths = ShortestPaths::new(self.nodes.len());
        let mut open: BTreeSet<usize> = found.iter().flat_map(|(row, _)| self.vessels[*row].0).collect();
        let next = |node: usize| edges[node].iter().copied();
        paths.search(nodes, f64::INFINITY, next, |_, node| {
            open.remove(&node);
            !open.is_empty()
        });
        let away = |row: usize| self.vessels[row].0.map(|node| paths.lengths()[node]).into_iter().fold(f64::INFINITY, f64::min);
        (0..found.len()).min_by(|a, b| away(found[*a].0).total_cmp(&away(found[*b].0))).unwrap_or(0)
    }

    /// The node at a place: an end of the nearest vessel, or a new one that divides it.
    fn node_at(&mut self, place: MmPoint) -> Result<usize, String> {
        let found = self.nearest(place)?[0];
        Ok(self.divide(found))
    }

    /// The node at a place of a vessel: one of its ends, or a new one that divides it.
    fn divide(&mut self, (row, (stretch, share)): NearestVessel) -> usize {
        let course = self.course(row);
        let (from, to) = (course[stretch], course[stretch + 1]);
        let middle = from.towards(to, share);
        let parts = [[&course[..=stretch], &[middle]].concat(), [&[middle], &course[stretch + 1..]].concat()];
        let [first, second] = [0, 1].map(|part| length_of(&parts[part]));
        let (ends, vessel) = &self.vessels[row];
        let nearer = ends[usize::from(second < first)];
        if first.min(second) <= AT_END || vessel.origin != Origin::Observed {
            return nearer;
        }
        let id = self.free_id(&self.nodes[ends[0]].id.clone());
        let node = self.nodes.len();
        self.nodes.push(Node::at(id, middle));
        let (ends, vessel) = &mut self.vessels[row];
        let share = [first, second].map(|length| length / (first + second));
        let has_path = !vessel.path.is_empty();
        let [kept, other] = parts.map(|mut path| {
            path.dedup_by(|a, b| distance(a.position, b.position) == 0.0);
            if has_path { path } else { Vec::new() }
        });
        let part = |share: f64, path: Vec<PathPoint>| {
            let resistance = vessel.resistance.map(|whole| share * whole);
            Vessel { length: share * vessel.length, resistance, path, ..vessel.clone() }
        };
        let (kept, other) = (part(share[0], kept), part(share[1], other));
        let far = std::mem::replace(&mut ends[1], node);
        *vessel = kept;
        self.divided.push([row, self.vessels.len()]);
        self.vessels.push(([node, far], other));
        node
    }

    /// An id that no node has.
    fn free_id(&mut self, like: &str) -> String {
        let mut ids = (1_u64..).map(|number| format!("{like}.{number}"));
        ids.find(|id| self.ids.insert(id.clone())).unwrap_or_default()
    }

    fn join(&mut self, way: &[MmPoint]) -> Result<(), String> {
        let ends = [self.node_at(way[0])?, self.node_at(way[way.len() - 1])?];
        ensure(ends[0] != ends[1], || "both ends are one place; expected two".to_owned())?;
        self.connect(ends, &way[1..way.len() - 1]);
        Ok(())
    }

    /// A vessel between two nodes that is there for certain, by the places between; its row.
    fn connect(&mut self, ends: [usize; 2], between: &[MmPoint]) -> usize {
        let radius = ends.map(|end| self.radius_at(end));
        let radius = f64::midpoint(radius[0], radius[1]);
        let between = between.iter().map(|place| place.map(|x| x * 1e-3));
        let course: Vec<Point> = [self.at(ends[0])].into_iter().chain(between).chain([self.at(ends[1])]).collect();
        let length = course.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>().max(SHORTEST * radius);
        let evidence = self.has_evidence.then(|| Box::new(Evidence::undirected(1.0)));
        let point = |position: &Point| PathPoint { position: *position, radius, id: None };
        let path = if course.len() > 2 { course.iter().map(point).collect() } else { Vec::new() };
        let row = self.vessels.len();
        self.joined.push(row);
        let vessel = Vessel { evidence, path, certain: true, ..Vessel::new(length, radius, Origin::Candidate) };
        self.vessels.push((ends, vessel));
        row
    }

    /// The mean radius of the vessels at a node, m.
    fn radius_at(&self, node: usize) -> f64 {
        let there = self.vessels.iter().enumerate().filter(|(row, (ends, _))| self.is_there(*row) && ends.contains(&node));
        let radii: Vec<f64> = there.map(|(_, (ends, vessel))| vessel.end_radius(ends[1] == node)).collect();
        radii.iter().sum::<f64>() / radii.len().max(1) as f64
    }

    /// Its row stays, of a candidate that is not there.
    fn delete(&mut self, row: usize) {
        let nothing = self.has_evidence.then(|| Box::new(Evidence { attached: [0.0; 2], ..Evidence::undirected(0.0) }));
        let vessel = &mut self.vessels[row].1;
        (vessel.origin, vessel.certain, vessel.prior, vessel.evidence) = (Origin::Candidate, false, 0.0, nothing);
    }

    /// It is one vessel there.
    fn keep(&mut self, row: usize) {
        let has_evidence = self.has_evidence;
        let vessel = &mut self.vessels[row].1;
        if vessel.origin != Origin::Observed {
            (vessel.certain, vessel.prior) = (true, 1.0);
            vessel.evidence = has_evidence.then(|| Box::new(Evidence::undirected(1.0)));
        }
    }

    fn part(&mut self, groups: &[Vec<MmPoint>]) -> Result<(), String> {
        let mut nodes: Vec<Vec<usize>> = Vec::new();
        for group in groups {
            nodes.push(self.nodes_at(group)?);
        }
        for (places, own) in groups.iter().zip(&nodes) {
            if let Some(second) = (1..own.len()).find(|at| own[..*at].contains(&own[*at])) {
                let second = text_of(&[places[second]]);
                let found = format!("two places of a group are at one node, the second {second}");
                return Err(format!("{found}; expected each on a vessel of its own"));
            }
        }
        let seen: BTreeSet<usize> = nodes.iter().flatten().copied().collect();
        let trees = self.trees(&nodes, &seen);
        let mut group_of: BTreeMap<usize, usize> = BTreeMap::new();
        let own = nodes.iter().enumerate().flat_map(|(group, own)| own.iter().map(move |node| (*node, group)));
        let of_trees = trees.iter().enumerate().flat_map(|(group, tree)| tree.nodes.iter().map(move |node| (*node, group)));
        for (node, group) in own.chain(of_trees) {
            group_of.entry(node).or_insert(group);
        }
        trees.iter().flat_map(|tree| &tree.vessels).for_each(|row| self.keep(*row));
        // Beyond the places of a group that has vessels between them, vessels may meet.
        let between = trees.iter().zip(&nodes).filter(|(tree, own)| tree.nodes.len() > own.len());
        let beyond: BTreeSet<usize> = between.flat_map(|(_, own)| own).copied().collect();
        self.cut(&trees, &group_of, &seen, &beyond);
        self.double(&trees, &group_of, &nodes);
        Ok(())
    }

    /// The edges at a node, of the vessels that `counts` admits.
    fn edges(&self, counts: impl Fn(usize) -> bool) -> LengthsAt {
        let counted = self.vessels.iter().enumerate().filter(|(row, _)| counts(*row));
        lengths_at(self.nodes.len(), counted.map(|(row, (ends, vessel))| (row, *ends, vessel.length)))
    }

    /// The ball around all places: its centre and its radius.
    fn ball(&self, places: &BTreeSet<usize>) -> (Point, f64) {
        let count = places.len() as f64;
        let centre = places.iter().fold([0.0; 3], |sum, node| {
            let at = self.at(*node);
            [0, 1, 2].map(|axis| sum[axis] + at[axis] / count)
        });
        (centre, places.iter().map(|node| distance(centre, self.at(*node))).fold(0.0, f64::max) * (1.0 + 1e-9))
    }

    /// What each group of nodes needs. What one has counts [`SHARED`] times for those after it, so that groups that can go apart do. Each
    /// group comes first once; of these, what is shortest, with what is shared counted so.
    fn trees(&mut self, groups: &[Vec<usize>], places: &BTreeSet<usize>) -> Vec<GroupPart> {
        let edges = self.edges(|row| self.is_there(row));
        let mut best: Option<(f64, Vec<GroupPart>)> = None;
        for first in 0..groups.len() {
            let mut order: Vec<usize> = (0..groups.len()).collect();
            order[..=first].rotate_right(1);
            let mut trees: Vec<GroupPart> = groups.iter().map(|_| GroupPart::default()).collect();
            let mut used: BTreeSet<usize> = BTreeSet::new();
            let mut total = 0.0;
            for group in order {
                let factor = |row: usize| if used.contains(&row) { SHARED } else { 1.0 };
                let tree = self.tree(&groups[group], places, &edges, factor);
                let straight = tree.straight.iter().map(|[a, b]| DETOUR * distance(self.at(*a), self.at(*b)));
                total += straight.sum::<f64>()
                    + tree.vessels.iter().map(|row| factor(*row) * self.vessels[*row].1.length).sum::<f64>();
                used.extend(&tree.vessels);
                trees[group] = tree;
            }
            if best.as_ref().is_none_or(|(least, _)| total < *least) {
                best = Some((total, trees));
            }
        }
        let mut trees = best.map(|(_, trees)| trees).unwrap_or_default();
        for tree in &mut trees {
            for ends in std::mem::take(&mut tree.straight) {
                tree.vessels.insert(self.connect(ends, &[]));
            }
        }
        trees
    }

    /// The shortest ways that join the nodes of a group, each to the nearest node of those before it, no further off than twice the ball
    /// around all places, and through places of other groups only where there is no other. Where there is none but by a [`DETOUR`], a
    /// straight vessel. A vessel counts `factor` times its length.
    fn tree(&self, own: &[usize], places: &BTreeSet<usize>, edges: &LengthsAt, factor: impl Fn(usize) -> f64) -> GroupPart {
        let (centre, ball) = self.ball(places);
        let mut tree = GroupPart { nodes: BTreeSet::from([own[0]]), ..GroupPart::default() };
        let mut paths = ShortestPaths::new(self.nodes.len());
        for (before, goal) in own.iter().enumerate().skip(1) {
            let sources: Vec<usize> = tree.nodes.iter().copied().collect();
            let away = |node: &usize| distance(self.at(*node), self.at(*goal));
            let near = own[..before].iter().copied().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(own[0]);
            let most = (DETOUR * away(&near)).max(REACH);
            let way = [false, true].into_iter().find_map(|through| {
                let open = |node: usize| {
                    own.contains(&node) || (through || !places.contains(&node)) && distance(centre, self.at(node)) <= 2.0 * ball
                };
                let next = |node: usize| {
                    let open = edges[node].iter().filter(|(_, to, _)| open(*to));
                    open.map(|(row, to, length)| (*row, *to, factor(*row) * length)).collect::<Vec<_>>()
                };
                paths.search(&sources, SHARED * most, next, |_, node| node != *goal);
                let way = paths.lengths()[*goal].is_finite().then(|| paths.path_to(*goal));
                way.filter(|way| way.edges.iter().map(|row| self.vessels[*row].1.length).sum::<f64>() <= most)
            });
            if let Some(way) = way {
                tree.nodes.extend(way.nodes);
                tree.vessels.extend(way.edges);
            } else {
                tree.straight.push([near, *goal]);
                tree.nodes.insert(*goal);
            }
        }
        tree
    }

    /// Deletes what joins two groups within the ball around the places, and between the places of each: of a way a contact, or else the
    /// vessel nearest to the centre. At the `outer` nodes vessels may meet.
    fn cut(&mut self, trees: &[GroupPart], group_of: &BTreeMap<usize, usize>, places: &BTreeSet<usize>, outer: &BTreeSet<usize>) {
        let (centre, ball) = self.ball(places);
        let inside = |node: usize| distance(centre, self.at(node)) <= ball;
        let is_core = |row: usize| trees.iter().any(|tree| tree.vessels.contains(&row));
        let within = |(ends, vessel): &([usize; 2], Vessel)| vessel.prior > 0.0 && ends.iter().all(|node| inside(*node));
        let mut open: BTreeSet<usize> =
            (0..self.vessels.len()).filter(|row| !is_core(*row) && within(&self.vessels[*row])).collect();
        let group_at = |node: usize| group_of.get(&node).filter(|_| !outer.contains(&node));
        let between = |ends: &[usize; 2]| matches!(ends.map(group_at), [Some(a), Some(b)] if a != b);
        for row in open.iter().copied().filter(|row| between(&self.vessels[*row].0)).collect::<Vec<usize>>() {
            open.remove(&row);
            self.delete(row);
        }
        open.retain(|row| self.is_there(*row) || self.vessels[*row].1.prior >= LIKELY);
        let mut paths = ShortestPaths::new(self.nodes.len());
        for group in 0..trees.len() {
            let own: Vec<usize> = group_of.keys().copied().filter(|node| group_at(*node) == Some(&group)).collect();
            loop {
                let edges = self.edges(|row| open.contains(&row));
                let mut other = None;
                let next = |node: usize| edges[node].iter().copied().filter(|(_, to, _)| !outer.contains(to));
                paths.search(&own, f64::INFINITY, next, |_, node| {
                    other = group_at(node).filter(|of| **of != group).map(|_| node);
                    other.is_none()
                });
                let Some(goal) = other else { break };
                let from_centre = |row: usize| distance(centre, self.middle_of(row));
                let rank = |row: &usize| (self.vessels[*row].1.origin != Origin::Contact, from_centre(*row));
                let way = paths.path_to(goal).edges;
                let least = way.into_iter().min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(a.cmp(b)));
                let Some(row) = least else { break };
                open.remove(&row);
                self.delete(row);
            }
        }
    }

    fn middle_of(&self, row: usize) -> Point {
        let course = self.course(row);
        let middle = course.len() / 2;
        lerp(course[middle - 1].position, course[middle].position, if course.len() == 2 { 0.5 } else { 1.0 })
    }

    /// Gives each group nodes and vessels of its own, copies of what an earlier one has; but places are where they are.
    fn double(&mut self, trees: &[GroupPart], group_of: &BTreeMap<usize, usize>, places: &[Vec<usize>]) {
        // Rows that a group has, with their nodes as they were.
        let mut taken: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
        for (group, tree) in trees.iter().enumerate() {
            let mut own: BTreeMap<usize, usize> = BTreeMap::new();
            for node in tree.nodes.iter().filter(|node| group_of[node] != group && !places[group].contains(node)) {
                let id = self.free_id(&self.nodes[*node].id.clone());
                let Node { position, radius, .. } = self.nodes[*node];
                own.insert(*node, self.nodes.len());
                self.nodes.push(Node { id, position, radius, ..Node::default() });
            }
            let here = |ends: [usize; 2]| ends.map(|node| own.get(&node).copied().unwrap_or(node));
            for row in &tree.vessels {
                let (ends, vessel) = &self.vessels[*row];
                if let Some(ends) = taken.get(row) {
                    let copy = (here(*ends), vessel.clone());
                    self.vessels.push(copy);
                } else {
                    taken.insert(*row, *ends);
                    self.vessels[*row].0 = here(*ends);
                }
            }
        }
    }
}

/// A place in mm, not m.
type MmPoint = [f64; 3];

/// A change of a graph, by places in mm; as text `join 1 2 3 + 4 5 6`, `part 1 2 3 + 4 5 6 | 7 8 9 + 10 11 12`, `delete 1 2 3`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Edit {
    /// A vessel goes from the first place to the last, straight or by the places between.
    Join(Vec<MmPoint>),
    /// The vessels at the places of a group go together, and those of different groups do not meet within the ball around all places, but
    /// beyond them. What two groups share is doubled, what joins them and is of none is deleted, candidates too, and where no vessel leads
    /// from a place to the others of its group, a straight one does. Groups of one place cut a vessel off; those that have a place in
    /// common meet there.
    Part(Vec<Vec<MmPoint>>),
    /// The vessel at the place is none.
    Delete(MmPoint),
}

impl Edit {
    /// The words of the edits.
    pub const WORDS: [&'static str; 3] = ["join", "part", "delete"];

    /// An edit by its word and its places: `+` between places, `|` between groups.
    ///
    /// # Errors
    ///
    /// Another word, or other places than it takes: what is expected.
    pub fn parse(word: &str, places: &str) -> Result<Self, &'static str> {
        const POINT: &str = "expected places of three finite numbers of mm, with + between places and | between groups";
        // The sign of a power of ten separates nothing: 1.5e+01.
        let places = places.replace("e+", "e").replace("E+", "E");
        let group = |text: &str| text.split('+').map(place).collect::<Option<Vec<MmPoint>>>();
        let groups: Vec<Vec<MmPoint>> = places.split('|').map(group).collect::<Option<_>>().ok_or(POINT)?;
        match (word, &groups[..]) {
            ("join", [way]) if way.len() > 1 => Ok(Self::Join(way.clone())),
            ("join", _) => Err("expected two places to join, or those of the way between too"),
            ("delete", [one]) if one.len() == 1 => Ok(Self::Delete(one[0])),
            ("delete", _) => Err("expected one place on the vessel to delete"),
            ("part", [_, _, ..]) => Ok(Self::Part(groups)),
            ("part", _) => Err("expected two or more groups of places, with | between them"),
            _ => Err("expected join, part or delete"),
        }
    }

    /// Its word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Join(_) => "join",
            Self::Part(_) => "part",
            Self::Delete(_) => "delete",
        }
    }

    /// Its places as text.
    pub fn places(&self) -> String {
        match self {
            Self::Join(way) => text_of(way),
            Self::Part(groups) => groups.iter().map(|group| text_of(group)).collect::<Vec<String>>().join(" | "),
            Self::Delete(place) => text_of(&[*place]),
        }
    }
}

/// Three finite numbers.
fn place(text: &str) -> Option<MmPoint> {
    let numbers: Vec<f64> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

fn text_of(places: &[MmPoint]) -> String {
    places.iter().map(|place| place.map(|x| in_few_digits(x.to_string())).join(" ")).collect::<Vec<String>>().join(" + ")
}

impl fmt::Display for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.word(), self.places())
    }
}

impl From<Edit> for String {
    fn from(edit: Edit) -> Self {
        edit.to_string()
    }
}

impl TryFrom<String> for Edit {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let (word, places) = text.split_once(' ').unwrap_or((&text, ""));
        Self::parse(word, places)
    }
}
