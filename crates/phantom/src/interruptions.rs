//! Where a mask interrupts vessels: stretches of centerlines that lie in no voxel of a vessel.

use std::collections::BTreeSet;

use super::mask_truth::MaskBreak;
use super::truth::BreakKind;
use super::tube::{DrawnTube, VoxelGrid};
use willis_core::support::geometry::{Point, distance};
use willis_core::support::numbered::grouped;
use willis_io::masks::Mask;

/// Which stations the mask shows.
pub(super) struct ShownStations<'a> {
    tubes: &'a [DrawnTube],
    grid: &'a VoxelGrid,
    mask: &'a Mask,
    arcs: Vec<Vec<f64>>,
    /// For each station whether its voxel is a vessel in the mask.
    seen: Vec<Vec<bool>>,
    /// For each node the vessels that end there, with the end.
    at_node: Vec<Vec<(usize, usize)>>,
}

impl<'a> ShownStations<'a> {
    pub fn new(tubes: &'a [DrawnTube], nodes: usize, grid: &'a VoxelGrid, mask: &'a Mask) -> Self {
        let known = tubes.iter().enumerate().filter_map(|(row, tube)| Some((row, tube.nodes?)));
        let at_node = grouped(nodes, known.flat_map(|(row, ends)| [(ends[0], (row, 0)), (ends[1], (row, 1))]));
        let is_shown = |tube: &DrawnTube| tube.stations.iter().map(|at| mask.classes[grid.row(*at)] > 0).collect();
        let seen = tubes.iter().map(is_shown).collect();
        Self { tubes, grid, mask, arcs: tubes.iter().map(DrawnTube::arc).collect(), seen, at_node }
    }

    /// How far from an end a vessel runs in the lumen of the others there, mm.
    fn within_others(&self, row: usize, end: usize) -> f64 {
        let Some(nodes) = self.tubes[row].nodes else { return 0.0 };
        let others = self.at_node[nodes[end]].iter().filter(|other| **other != (row, end));
        let radius = |(row, end): &(usize, usize)| {
            let radii = &self.tubes[*row].radii;
            radii[[0, radii.len() - 1][*end]]
        };
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
    fn breaks_at_missing_node(&self, at: &[(usize, usize)], found: &mut Vec<MaskBreak>) {
        let end_of = |(row, end): (usize, usize)| [0, self.arcs[row].len() - 1][end];
        if at.iter().any(|vessel| self.seen[vessel.0][end_of(*vessel)]) {
            return;
        }
        let nearest = |(row, end): (usize, usize)| {
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
    fn are_joined(&self, ends: [(usize, usize); 2], stretches: &[(usize, [usize; 2])]) -> bool {
        let places: Vec<(Point, f64)> = stretches
            .iter()
            .flat_map(|(row, [a, b])| {
                (*a.min(b)..=*a.max(b)).map(|at| (self.tubes[*row].stations[at], self.tubes[*row].radii[at]))
            })
            .collect();
        let is_near = |row: usize| {
            let at = self.grid.position(self.grid.voxel(row));
            places.iter().any(|(place, radius)| distance(at, *place) <= radius + 2.0 * self.grid.spacing)
        };
        let [start, goal] = ends.map(|(row, station)| self.grid.row(self.tubes[row].stations[station]));
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
}
