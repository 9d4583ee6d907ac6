//! The truth of contacts as `skelbench` writes it: which place of the true vessels every point of a skeleton shows.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use willis_core::error::{Fault, ensure};
use willis_core::network::{Network, Origin, PathPoint, units::metres};
use willis_core::support::arc_lengths::{arc_lengths, in_direction};
use willis_core::support::geometry::{Point, distance, dot, sub, unit};
use willis_core::support::numbered::{grouped, marked};
use willis_models::candidates::search::point_index::PointIndex;
use willis_models::contacts::branches::{BranchEnd, Branches, Cluster, even_course, runs};

/// Neighbours on a skeleton that are further apart along the true vessels than so many radii of both and voxels are fused.
const FUSED_RADII: f64 = 3.0;
const FUSED_VOXELS: f64 = 3.0;
/// Two ends are one vessel no further apart along it than so many times the way over the skeleton, radii of both and voxels.
const WAY: f64 = 1.2;
const SLACK: f64 = 0.7;
/// A point of a skeleton shows the nearest node of the case's own within so many voxels.
const REACH: f64 = 2.0;
/// What the sides of a contact show is looked for between these distances from it, and as far as `NEAR` from where vessels meet again.
/// They are one vessel if no more than this is missing on the way, m.
const NEAR: f64 = 1e-3;
const FAR: f64 = 5e-3;
const TOLERANCE: f64 = 1.5e-3;

#[derive(Deserialize)]
struct ContactTruthFile {
    subject: Option<String>,
    voxel_mm: f64,
    nodes: Vec<Vec<f64>>,
    stations: Vec<Vec<f64>>,
    station_nodes: Vec<Vec<usize>>,
    adjacent: Vec<(usize, usize, f64, String, [f64; 3], f64)>,
}

/// Stations along the true vessels, which of them each node of a skeleton shows, and which are neighbours.
#[derive(Debug, Clone)]
pub struct ContactTruth {
    /// Whom it shows, where that is named.
    pub subject: Option<String>,
    voxel: f64,
    nodes: Vec<Point>,
    shown: Vec<Option<TruePlace>>,
    radius: Vec<f64>,
    next: Vec<Vec<(usize, f64)>>,
}

/// A place on the true vessels: on the way from a station to one of its neighbours.
#[derive(Debug, Clone, Copy)]
struct TruePlace {
    station: usize,
    /// How far from it, m; towards the neighbour, and how far from that, m.
    off: f64,
    towards: Option<(usize, f64)>,
}

impl TruePlace {
    fn new(node: Point, station: usize, stations: &[Point], next: &[(usize, f64)]) -> Self {
        let from = sub(node, stations[station]);
        let mut best = Self { station, off: 0.0, towards: None };
        for (other, length) in next {
            let along = dot(from, unit(sub(stations[*other], stations[station]))).min(0.5 * length);
            if along > best.off {
                best = Self { station, off: along, towards: Some((*other, length - along)) };
            }
        }
        best
    }

    /// The stations at both sides, with the way to each, m.
    fn sides(&self) -> impl Iterator<Item = (usize, f64)> {
        [Some((self.station, self.off)), self.towards].into_iter().flatten()
    }
}

/// The place that an end shows, and how far (m) beyond the cluster.
type ShownPlace = (Option<TruePlace>, f64);

/// What the truth says of a branch.
struct Identity {
    /// What either end shows.
    ends: [ShownPlace; 2],
    /// The same of the stretch at either end, where the branch leads from one vessel to another.
    near: [ShownPlace; 2],
    /// Whether it leads from one vessel to another, and is no longer than these are wide.
    is_short_and_mixed: bool,
}

impl ContactTruth {
    /// Reads the truth of a case.
    ///
    /// # Errors
    ///
    /// No such JSON, a node or station that is not there, a negative length, a voxel without a size.
    pub fn read(bytes: &[u8]) -> Result<Self, Fault> {
        const ACCEPTED: &str = "expected the truth of a skeleton, with nodes, stations, station_nodes and adjacent";
        let file: ContactTruthFile =
            serde_json::from_slice(bytes).map_err(|e| Fault::line(e.line().max(1), e.to_string(), ACCEPTED))?;
        let wrong = || Fault::item("voxel_mm", file.voxel_mm.to_string(), "expected a positive number");
        ensure(file.voxel_mm > 0.0, wrong)?;
        let place = |what: &str, row: usize, at: &[f64]| match at {
            [x, y, z, ..] => Ok([*x, *y, *z].map(metres)),
            _ => Err(Fault::item(format!("{what} {row}"), format!("{at:?}"), "expected x, y, z in mm")),
        };
        let nodes = file.nodes.iter().enumerate().map(|(row, at)| place("node", row + 1, at)).collect::<Result<Vec<_>, _>>()?;
        let mut station_of = vec![None; nodes.len()];
        for (station, shown) in file.station_nodes.iter().enumerate() {
            for id in shown {
                let accepted = || format!("expected nodes from 1 to {}", nodes.len());
                let there = id.checked_sub(1).and_then(|row| station_of.get_mut(row));
                *there.ok_or_else(|| Fault::item(format!("station {station}"), format!("node {id}"), accepted()))? =
                    Some(station);
            }
        }
        let stations =
            file.stations.iter().enumerate().map(|(row, at)| place("station", row, at)).collect::<Result<Vec<_>, _>>()?;
        let (found, listed) = (stations.len(), file.station_nodes.len());
        let few = || Fault::item("station_nodes", format!("{found} stations"), format!("expected {listed}"));
        ensure(found >= listed, few)?;
        let radius: Vec<f64> = file.stations.iter().map(|s| metres(s.get(3).copied().unwrap_or(0.0))).collect();
        let mut next = vec![Vec::new(); radius.len()];
        for (row, (a, b, mm, ..)) in file.adjacent.iter().enumerate() {
            let fault = |found: String, accepted: String| Fault::item(format!("adjacent {row}"), found, accepted);
            let accepted = || format!("expected stations from 0 to {}", next.len().saturating_sub(1));
            ensure(*a.max(b) < next.len(), || fault(a.max(b).to_string(), accepted()))?;
            ensure(*mm >= 0.0, || fault(format!("{mm} mm"), "expected a length from 0 on".to_owned()))?;
            next[*a].push((*b, metres(*mm)));
            next[*b].push((*a, metres(*mm)));
        }
        let shown = nodes.iter().zip(station_of);
        let shown = shown.map(|(node, station)| station.map(|station| TruePlace::new(*node, station, &stations, &next[station])));
        Ok(Self { subject: file.subject, voxel: metres(file.voxel_mm), shown: shown.collect(), nodes, radius, next })
    }

    /// Per cluster the vessel of each end: ends of one number are one vessel; a number of its own for an end that is no vessel's; `None`
    /// where nothing is known.
    pub fn classes(&self, branches: &Branches) -> Vec<Vec<Option<usize>>> {
        let index = PointIndex::new(self.nodes.clone());
        let mut identities: Vec<Identity> =
            (0..branches.branches.len()).map(|row| self.identity(branches, &index, row)).collect();
        // A short branch from one vessel to another is nobody's only where both of its ends pass by without it.
        let passed = |row: usize, side: usize, identities: &[Identity]| {
            let Some(cluster) = branches.branches[row].clusters[side] else { return true };
            let own = identities[row].near[side];
            let others = branches.clusters[cluster].ends.iter().filter(|end| end.branch != row);
            let same = |end: &&BranchEnd| self.same(branches, cluster, own, identities[end.branch].near[usize::from(end.last)]);
            others.filter(same).count() >= 2
        };
        for row in 0..identities.len() {
            let is_nobodys = identities[row].is_short_and_mixed && (0..2).all(|side| passed(row, side, &identities));
            identities[row].is_short_and_mixed = is_nobodys;
        }
        let of_cluster = |(row, cluster): (usize, &Cluster)| {
            let mut class: Vec<usize> = (0..cluster.ends.len()).collect();
            let known = |end: &BranchEnd| identities[end.branch].ends[usize::from(end.last)];
            let nobody = |end: &BranchEnd| identities[end.branch].is_short_and_mixed;
            for i in 0..class.len() {
                for j in 0..i {
                    let (a, b) = (&cluster.ends[i], &cluster.ends[j]);
                    if !nobody(a) && !nobody(b) && self.same(branches, row, known(a), known(b)) {
                        let (from, to) = (class[i], class[j]);
                        class.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
                    }
                }
            }
            let found = class.into_iter().zip(&cluster.ends);
            found.map(|(class, end)| (known(end).0.is_some() || nobody(end)).then_some(class)).collect()
        };
        branches.clusters.iter().enumerate().map(of_cluster).collect()
    }

    /// Per contact of an opened network, in their order, whether its two sides are one vessel: the way along the true vessels from a place
    /// that one side shows to a place that the other shows is no longer than the way through the contact, up to 1.5 mm. `None` where a side
    /// shows no place.
    ///
    /// A side shows what the points of its lines do, 1 to 5 mm from the contact. Nearer, a point lies in the lumen of both, and so does one
    /// where the line meets others again: it counts only on a line that has no other. Nothing is looked for between two points, since these
    /// may be of two vessels. It is the rule of `contact_truth` in `proofread.py` of skelbench, but for the last millimetre of lines, and
    /// for candidates, which do not end a line here.
    pub fn contacts(&self, graph: &Network) -> Vec<Option<bool>> {
        let index = PointIndex::new(self.nodes.clone());
        let contacts = || graph.vessels().filter(|(_, vessel)| vessel.origin == Origin::Contact);
        let has_contact = marked(graph.node_count(), contacts().flat_map(|(ends, _)| ends));
        let lines = runs(graph, |node| has_contact[node]);
        // Per node the lines that end there, each with whether by its last point.
        let ends = lines.iter().flat_map(|line| [(line.ends[0], (line, false)), (line.ends[1], (line, true))]);
        let at = grouped(graph.node_count(), ends);
        // Per station that the lines at a node show, how far from it (m).
        let places = |node: usize| {
            let mut seen = BTreeMap::new();
            for (line, last) in &at[node] {
                let far = line.ends[usize::from(!last)];
                let length = if has_contact[far] || at[far].len() > 1 { line.length } else { f64::INFINITY };
                let shown =
                    ways(&line.points, *last).filter(|(_, arc)| (NEAR..=FAR).contains(arc)).filter_map(|(position, arc)| {
                        let nearest = index.nearest(position, REACH * self.voxel).points.first().copied()?;
                        Some((self.shown[nearest]?.station, arc))
                    });
                let shown: Vec<(usize, f64)> = shown.collect();
                let is_clear = |(_, arc): &&(usize, f64)| length - arc >= NEAR;
                let any = shown.iter().any(|place| is_clear(&place));
                for (station, arc) in shown.iter().filter(|place| !any || is_clear(place)) {
                    let nearest = seen.entry(*station).or_insert(*arc);
                    *nearest = arc.min(*nearest);
                }
            }
            seen
        };
        let is_one = |[a, b]: [usize; 2]| {
            let [a, b] = [a, b].map(places);
            let furthest = b.values().copied().reduce(f64::max)?;
            let meets = |(station, off): (&usize, &f64)| {
                let from = TruePlace { station: *station, off: 0.0, towards: None };
                let found = self.within(from, off + furthest + TOLERANCE);
                b.iter().any(|(other, beyond)| found.get(other).is_some_and(|d| *d <= off + beyond + TOLERANCE))
            };
            (!a.is_empty()).then(|| a.iter().any(meets))
        };
        contacts().map(|(ends, _)| is_one(ends)).collect()
    }

    fn same(&self, branches: &Branches, cluster: usize, (p, a): ShownPlace, (q, b): ShownPlace) -> bool {
        let (Some(p), Some(q)) = (p, q) else { return false };
        let core = &branches.clusters[cluster].core;
        let size = core.iter().map(|x| distance(core[0].position, x.position)).fold(0.0, f64::max);
        let reach = WAY * (a + b + size) + SLACK * (self.radius[p.station] + self.radius[q.station] + self.voxel);
        self.are_within(p, q, reach)
    }

    /// Whether two places are within a distance (m) along the vessels.
    fn are_within(&self, p: TruePlace, q: TruePlace, reach: f64) -> bool {
        if p.station == q.station && p.towards.map(|(to, _)| to) == q.towards.map(|(to, _)| to) {
            return (p.off - q.off).abs() <= reach;
        }
        let found = self.within(p, reach);
        q.sides().any(|(station, off)| found.get(&station).is_some_and(|d| d + off <= reach))
    }

    /// The stations within a distance (m) along the vessels.
    fn within(&self, from: TruePlace, reach: f64) -> BTreeMap<usize, f64> {
        let mut best: BTreeMap<usize, f64> = from.sides().collect();
        let mut open: BTreeSet<(u64, usize)> = from.sides().map(|(station, d)| (d.to_bits(), station)).collect();
        while let Some((bits, at)) = open.pop_first() {
            // Lengths are not negative, so that their bits are in their order.
            let d = f64::from_bits(bits);
            if d > best[&at] {
                continue;
            }
            for (next, step) in &self.next[at] {
                if d + step <= reach && best.get(next).is_none_or(|known| d + step < *known) {
                    best.insert(*next, d + step);
                    open.insert(((d + step).to_bits(), *next));
                }
            }
        }
        best
    }

    fn identity(&self, branches: &Branches, index: &PointIndex, row: usize) -> Identity {
        let branch = &branches.branches[row];
        // Stations along the branch, every half voxel.
        let (mut shown, mut arc) = (Vec::new(), Vec::new());
        let course = even_course(&branch.points, 0.5 * self.voxel);
        for (at, place) in course.arc.into_iter().zip(course.points) {
            let near = index.nearest(place, REACH * self.voxel);
            if let Some(place) = near.points.first().and_then(|node| self.shown[*node]) {
                shown.push(place);
                arc.push(at);
            }
        }
        let are_fused = |p: TruePlace, q: TruePlace| {
            let apart = FUSED_RADII * (self.radius[p.station] + self.radius[q.station]) + FUSED_VOXELS * self.voxel;
            !self.are_within(p, q, apart)
        };
        let cuts: Vec<usize> = (1..shown.len()).filter(|n| are_fused(shown[n - 1], shown[*n])).collect();
        let bounds = [&[0][..], &cuts, &[shown.len()]].concat();
        let sections: Vec<[usize; 2]> = bounds.windows(2).map(|w| [w[0], w[1]]).collect();
        let length = |s: &[usize; 2]| if s[1] > s[0] { arc[s[1] - 1] - arc[s[0]] } else { 0.0 };
        let longest = sections.iter().copied().reduce(|a, b| if length(&b) > length(&a) { b } else { a }).unwrap_or([0, 0]);
        let long: Vec<[usize; 2]> =
            sections.iter().copied().filter(|s| length(s) > 2.0 * (2.0 * branch.radius + self.voxel)).collect();
        // A long branch of two vessels is each on its own side.
        let of_end = match long[..] {
            [first, .., last] => [first, last],
            _ => [longest; 2],
        };
        let is_short_and_mixed = cuts.first().is_some_and(|cut| {
            let wide = self.radius[shown[cut - 1].station] + self.radius[shown[*cut].station];
            branch.length <= 1.5 * wide + 2.0 * self.voxel
        });
        let anchor = |side: usize, [from, to]: [usize; 2]| {
            if to == from {
                return (None, 0.0);
            }
            let (first, last) = (arc[from], arc[to - 1]);
            let wanted = branch.clusters[side].map_or(0.0, |cluster| 2.0 * branches.clusters[cluster].radius + self.voxel);
            let off = wanted.min(0.5 * (last - first));
            let at = if side == 0 { first + off } else { last - off };
            let nearest = (from..to).min_by(|a, b| (arc[*a] - at).abs().total_cmp(&(arc[*b] - at).abs())).unwrap_or(from);
            (Some(shown[nearest]), if side == 0 { arc[nearest] } else { branch.length - arc[nearest] })
        };
        let near = [sections[0], sections[sections.len() - 1]];
        Identity {
            ends: [anchor(0, of_end[0]), anchor(1, of_end[1])],
            near: [anchor(0, near[0]), anchor(1, near[1])],
            is_short_and_mixed,
        }
    }
}

/// Points from the first or last one on, each with its way from there, m.
fn ways(points: &[PathPoint], from_last: bool) -> impl Iterator<Item = (Point, f64)> {
    let line = in_direction(points.iter().map(|point| point.position).collect(), !from_last);
    let arc = arc_lengths(line.iter().copied());
    line.into_iter().zip(arc)
}
