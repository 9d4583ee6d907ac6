//! Where a mask interrupts vessels: stretches of centerlines that lie in no voxel of a vessel. And where it joins vessels that are apart:
//! voxels of two that touch.

use std::collections::BTreeSet;

use super::truth::{BreakKind, Contact, MaskBreak};
use super::tube::{DrawnTube, VoxelGrid};
use willis_core::network::ShortestPaths;
use willis_core::support::{Point, centroid, distance, grouped};
use willis_io::masks::Mask;

/// A station: the row of its vessel, and its number along it.
type Station = (usize, usize);

/// An end of a vessel: its row, and which (0 the first, 1 the last).
type VesselEnd = (usize, usize);

/// Vessels are apart where the way along them is longer than so many sums of their radii, and so many voxels more.
const APART: [f64; 2] = [3.0, 3.0];
/// How far beyond its radius a voxel of the mask still belongs to a vessel, in voxels.
const AROUND: f64 = 3.0;

/// Two voxels that touch, of vessels that are apart.
struct Touch {
    /// The vessels, the lower row first.
    vessels: [usize; 2],
    /// The stations that the voxels lie nearest to.
    stations: [Station; 2],
    /// Between the voxels, mm.
    place: Point,
}

/// The stations of vessels, and which of them the mask shows.
pub(super) struct Stations<'a> {
    tubes: &'a [DrawnTube],
    grid: &'a VoxelGrid,
    mask: &'a Mask,
    arcs: Vec<Vec<f64>>,
    /// For each station whether its voxel is a vessel in the mask.
    seen: Vec<Vec<bool>>,
    /// For each node the vessels that end there, with the end.
    at_node: Vec<Vec<VesselEnd>>,
    /// The number of the first station of each vessel, where all are numbered through.
    first: Vec<usize>,
}

impl<'a> Stations<'a> {
    pub fn new(tubes: &'a [DrawnTube], nodes: usize, grid: &'a VoxelGrid, mask: &'a Mask) -> Self {
        let known = tubes.iter().enumerate().filter_map(|(row, tube)| Some((row, tube.nodes?)));
        let at_node = grouped(nodes, known.flat_map(|(row, ends)| [(ends[0], (row, 0)), (ends[1], (row, 1))]));
        let is_shown = |tube: &DrawnTube| tube.stations.iter().map(|at| mask.classes[grid.row(*at)] > 0).collect();
        let seen = tubes.iter().map(is_shown).collect();
        let first = tubes.iter().scan(0, |next, tube| {
            *next += tube.stations.len();
            Some(*next - tube.stations.len())
        });
        let (first, arcs) = (first.collect(), tubes.iter().map(DrawnTube::arc).collect());
        Self { tubes, grid, mask, arcs, seen, at_node, first }
    }

    fn place(&self, (row, station): Station) -> Point {
        self.tubes[row].stations[station]
    }

    fn radius(&self, (row, station): Station) -> f64 {
        self.tubes[row].radii[station]
    }

    /// The last station of a vessel towards an end.
    fn at_end(&self, row: usize, end: usize) -> Station {
        (row, [0, self.arcs[row].len() - 1][end])
    }

    /// How far from an end a vessel runs in the lumen of the others there, mm.
    fn within_others(&self, row: usize, end: usize) -> f64 {
        let Some(nodes) = self.tubes[row].nodes else { return 0.0 };
        let others = self.at_node[nodes[end]].iter().filter(|other| **other != (row, end));
        let radius = |(row, end): &VesselEnd| self.radius(self.at_end(*row, *end));
        others.map(radius).fold(0.0, f64::max) + if self.at_node[nodes[end]].len() > 1 { self.grid.spacing } else { 0.0 }
    }

    /// The station's distance along its vessel from an end, mm.
    fn away_from_end(&self, row: usize, end: usize, station: usize) -> f64 {
        let arc = &self.arcs[row];
        if end == 0 { arc[station] } else { arc[arc.len() - 1] - arc[station] }
    }

    /// Whether the mask shows nothing of a vessel outside the lumen of others; of one that lies within these all along, nothing at all.
    pub fn is_lost(&self, row: usize) -> bool {
        let within = [0, 1].map(|end| self.within_others(row, end));
        let is_own = |station: &usize| (0..2).all(|end| self.away_from_end(row, end, *station) >= within[end]);
        let own: Vec<usize> = (0..self.arcs[row].len()).filter(is_own).collect();
        if own.is_empty() {
            return !self.seen[row].contains(&true);
        }
        !own.iter().any(|station| self.seen[row][*station])
    }

    /// The missing stretches between two shown places that the mask does not join around them.
    pub fn breaks(&self) -> Vec<MaskBreak> {
        let mut found = Vec::new();
        for row in (0..self.tubes.len()).filter(|row| !self.is_lost(*row)) {
            let shown: Vec<usize> = (0..self.arcs[row].len()).filter(|station| self.seen[row][*station]).collect();
            for pair in shown.windows(2).filter(|pair| pair[1] > pair[0] + 1) {
                if !self.are_joined([(row, pair[0]), (row, pair[1])], &[(row, [pair[0], pair[1]])]) {
                    found.push(self.gap(row, [pair[0], pair[1]], None));
                }
            }
        }
        for at in self.at_node.iter().filter(|at| at.len() > 1) {
            self.breaks_at_missing_node(at, &mut found);
        }
        found.sort_by(|a, b| a.vessel.cmp(&b.vessel).then(a.from_mm.total_cmp(&b.from_mm)));
        found
    }

    /// Where the mask does not show a junction at all, every vessel there but the widest is to be joined to the widest.
    fn breaks_at_missing_node(&self, at: &[VesselEnd], found: &mut Vec<MaskBreak>) {
        let end_of = |(row, end): VesselEnd| self.at_end(row, end).1;
        if at.iter().any(|vessel| self.seen[vessel.0][end_of(*vessel)]) {
            return;
        }
        let nearest = |(row, end): VesselEnd| {
            let mut stations = (0..self.arcs[row].len()).filter(|station| self.seen[row][*station]);
            let station = if end == 0 { stations.next() } else { stations.next_back() };
            station.filter(|_| !self.is_lost(row)).map(|station| (row, end, station))
        };
        let mut pieces: Vec<(usize, usize, usize)> = at.iter().copied().filter_map(nearest).collect();
        pieces.sort_by(|a, b| self.tubes[b.0].radii[b.2].total_cmp(&self.tubes[a.0].radii[a.2]).then(a.cmp(b)));
        let Some((&(widest, its_end, its_station), others)) = pieces.split_first() else { return };
        for (row, end, station) in others {
            let way = [(widest, [its_station, end_of((widest, its_end))]), (*row, [*station, end_of((*row, *end))])];
            if !self.are_joined([(widest, its_station), (*row, *station)], &way) {
                let node = end_of((*row, *end));
                let stretch = [node.min(*station), node.max(*station)];
                found.push(self.gap(*row, stretch, Some((*end, self.tubes[widest].stations[its_station]))));
            }
        }
    }

    /// A missing stretch; `other` says at which of its ends the place is that of another vessel.
    fn gap(&self, row: usize, stretch: [usize; 2], other: Option<(usize, Point)>) -> MaskBreak {
        let tube = &self.tubes[row];
        let mut ends_mm = stretch.map(|station| tube.stations[station]);
        if let Some((end, place)) = other {
            ends_mm[end] = place;
        }
        let [from_mm, to_mm] = stretch.map(|station| self.arcs[row][station]);
        let is_near = |end: usize| self.away_from_end(row, end, stretch[end]) <= self.within_others(row, end);
        let at_junction = other.is_some()
            || tube.nodes.is_some_and(|nodes| (0..2).any(|end| self.at_node[nodes[end]].len() > 1 && is_near(end)));
        let kind = if at_junction { BreakKind::Junction } else { BreakKind::Vessel };
        MaskBreak { ends_mm, kind, vessel: row, label: tube.label.clone(), from_mm, to_mm, gap_mm: to_mm - from_mm }
    }

    /// Whether voxels of the mask near some stretches join two stations.
    fn are_joined(&self, ends: [Station; 2], stretches: &[(usize, [usize; 2])]) -> bool {
        let places: Vec<(Point, f64)> = stretches
            .iter()
            .flat_map(|(row, [a, b])| (*a.min(b)..=*a.max(b)).map(|at| (self.place((*row, at)), self.radius((*row, at)))))
            .collect();
        let is_near = |row: usize| {
            let at = self.grid.position(self.grid.voxel(row));
            places.iter().any(|(place, radius)| distance(at, *place) <= radius + 2.0 * self.grid.spacing)
        };
        let [start, goal] = ends.map(|station| self.grid.row(self.place(station)));
        let (mut reached, mut open) = (BTreeSet::from([start]), vec![start]);
        while let Some(at) = open.pop() {
            if at == goal {
                return true;
            }
            let around = self.grid.neighbours(at).filter(|to| self.mask.classes[*to] > 0 && is_near(*to));
            open.extend(around.filter(|to| reached.insert(*to)));
        }
        false
    }

    /// The number of a station, where all are numbered through.
    fn number(&self, (row, station): Station) -> usize {
        self.first[row] + station
    }

    /// The stations next to one along the vessels, with their distance, by their numbers.
    fn next_to(&self, number: usize) -> Vec<(usize, usize, f64)> {
        let row = self.first.partition_point(|first| *first <= number) - 1;
        let here = (row, number - self.first[row]);
        let mut found = Vec::new();
        let mut add = |to: Station| found.push((0, self.number(to), distance(self.place(here), self.place(to))));
        if here != self.at_end(row, 0) {
            add((row, here.1 - 1));
        }
        if here != self.at_end(row, 1) {
            add((row, here.1 + 1));
        }
        for end in (0..2).filter(|end| here == self.at_end(row, *end)) {
            let node = self.tubes[row].nodes.map(|nodes| nodes[end]);
            let others = node.iter().flat_map(|node| &self.at_node[*node]).filter(|other| **other != (row, end));
            others.for_each(|(row, end)| add(self.at_end(*row, *end)));
        }
        found
    }

    /// The station of the vessel in whose lumen each voxel of the mask lies deepest, by the rows of these voxels; none far from all.
    fn owners(&self, rows: &[usize]) -> Vec<Option<Station>> {
        let mut owners = vec![None; rows.len()];
        let mut depths = vec![f64::INFINITY; rows.len()];
        for (tube_row, tube) in self.tubes.iter().enumerate() {
            self.grid.near(tube, AROUND * self.grid.spacing, [0, self.grid.shape[2]], |near| {
                let depth = near.away - near.radius;
                if self.mask.classes[near.row] > 0
                    && let Ok(at) = rows.binary_search(&near.row)
                    && depth < depths[at]
                {
                    (owners[at], depths[at]) = (Some((tube_row, near.station)), depth);
                }
            });
        }
        owners
    }

    /// The pairs of voxels that touch and belong to vessels that are apart.
    fn touches(&self) -> Vec<Touch> {
        let classes = &self.mask.classes;
        let rows: Vec<usize> = (0..classes.len()).filter(|row| classes[*row] > 0).collect();
        let owners = self.owners(&rows);
        let mut pairs = Vec::new();
        for (row, a) in rows.iter().zip(&owners).filter_map(|(row, owner)| Some((*row, (*owner)?))) {
            let later = self.grid.neighbours(row).filter(|to| *to > row);
            for (to, b) in later.filter_map(|to| Some((to, owners[rows.binary_search(&to).ok()?]?))) {
                if a.0 != b.0 {
                    pairs.push(([a.min(b), a.max(b)], [row, to]));
                }
            }
        }
        pairs.sort_unstable();
        let widest = self.tubes.iter().map(DrawnTube::widest).fold(0.0, f64::max);
        let mut ways = ShortestPaths::new(self.arcs.iter().map(Vec::len).sum());
        let mut searched = None;
        let mut found = Vec::new();
        for ([a, b], voxels) in pairs {
            let apart = |radii: f64| APART[0] * radii + APART[1] * self.grid.spacing;
            if searched.replace(a) != Some(a) {
                ways.search(&[self.number(a)], apart(self.radius(a) + widest), |at| self.next_to(at), |_, _| true);
            }
            if ways.lengths()[self.number(b)] > apart(self.radius(a) + self.radius(b)) {
                let [p, q] = voxels.map(|row| self.grid.position(self.grid.voxel(row)));
                let place = [0, 1, 2].map(|axis| f64::midpoint(p[axis], q[axis]));
                found.push(Touch { vessels: [a.0, b.0], stations: [a, b], place });
            }
        }
        found
    }

    /// Where voxels touch that belong to vessels which are apart. A voxel belongs to the vessel in whose lumen it lies deepest; what two
    /// vessels have in common along one stretch is one contact.
    pub fn contacts(&self) -> Vec<Contact> {
        let mut touches = self.touches();
        touches.sort_by_key(|touch| (touch.vessels, touch.stations));
        let is_one = |a: &Touch, b: &Touch| {
            let between = distance(self.place(a.stations[0]), self.place(b.stations[0]));
            let both = self.radius(b.stations[0]) + self.radius(b.stations[1]);
            a.vessels == b.vessels && between <= both + APART[1] * self.grid.spacing
        };
        let contact = |touches: &[Touch]| {
            let vessels = touches[0].vessels;
            let position_mm = centroid(touches.iter().map(|touch| touch.place));
            Contact { vessels, labels: vessels.map(|row| self.tubes[row].label.clone()), position_mm }
        };
        touches.chunk_by(is_one).map(contact).collect()
    }
}
