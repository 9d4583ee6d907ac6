//! Where a mask joins vessels that are apart: voxels of two that touch.

use super::mask_truth::Contact;
use super::tube::{DrawnTube, VoxelGrid};
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, centroid, distance};
use willis_io::masks::Mask;

/// Vessels are apart where the way along them is longer than so many sums of their radii, and so many voxels more.
const APART: [f64; 2] = [3.0, 3.0];
/// How far beyond its radius a voxel of the mask still belongs to a vessel, in voxels.
const AROUND: f64 = 3.0;

/// The stations of all vessels, numbered through.
struct Stations<'a> {
    tubes: &'a [DrawnTube],
    /// The number of the first station of each vessel.
    first: Vec<usize>,
    /// The vessel of each station.
    tube: Vec<usize>,
    /// For each node the stations that lie there.
    at_node: Vec<Vec<usize>>,
}

/// Two voxels that touch, of vessels that are apart.
struct Touch {
    /// The vessels, the lower row first.
    tubes: [usize; 2],
    /// The stations that the voxels lie nearest to.
    stations: [usize; 2],
    /// Between the voxels, mm.
    place: Point,
}

impl<'a> Stations<'a> {
    fn new(tubes: &'a [DrawnTube]) -> Self {
        let nodes = tubes.iter().filter_map(|tube| tube.nodes).flatten().max().map_or(0, |last| last + 1);
        let mut all = Self { tubes, first: Vec::new(), tube: Vec::new(), at_node: vec![Vec::new(); nodes] };
        for (row, tube) in tubes.iter().enumerate() {
            let first = all.tube.len();
            all.first.push(first);
            all.tube.resize(first + tube.stations.len(), row);
            for (end, node) in tube.nodes.iter().flatten().enumerate() {
                all.at_node[*node].push([first, all.tube.len() - 1][end]);
            }
        }
        all
    }

    fn place(&self, station: usize) -> Point {
        let tube = self.tube[station];
        self.tubes[tube].stations[station - self.first[tube]]
    }

    fn radius(&self, station: usize) -> f64 {
        let tube = self.tube[station];
        self.tubes[tube].radii[station - self.first[tube]]
    }

    /// The stations next to one along the vessels, with their distance.
    fn next_to(&self, station: usize) -> Vec<(usize, usize, f64)> {
        let tube = &self.tubes[self.tube[station]];
        let first = self.first[self.tube[station]];
        let last = first + tube.stations.len() - 1;
        let mut found = Vec::new();
        let mut add = |to: usize| found.push((0, to, distance(self.place(station), self.place(to))));
        if station > first {
            add(station - 1);
        }
        if station < last {
            add(station + 1);
        }
        for (end, at) in [first, last].into_iter().enumerate().filter(|(_, at)| *at == station) {
            let node = tube.nodes.map(|nodes| nodes[end]);
            node.iter().flat_map(|node| &self.at_node[*node]).filter(|to| **to != at).for_each(|to| add(*to));
        }
        found
    }

    /// The station of the vessel in whose lumen each voxel of the mask lies deepest, by the rows of these voxels; none far from all.
    fn owners(&self, grid: &VoxelGrid, mask: &Mask, rows: &[usize]) -> Vec<Option<usize>> {
        let mut owners = vec![None; rows.len()];
        let mut depths = vec![f64::INFINITY; rows.len()];
        for (tube, first) in self.tubes.iter().zip(&self.first) {
            grid.near(tube, AROUND * grid.spacing, [0, grid.shape[2]], |near| {
                let depth = near.away - near.radius;
                if mask.classes[near.row] > 0
                    && let Ok(at) = rows.binary_search(&near.row)
                    && depth < depths[at]
                {
                    (owners[at], depths[at]) = (Some(first + near.station), depth);
                }
            });
        }
        owners
    }

    /// The pairs of voxels that touch and belong to vessels that are apart, in order of vessels and stations.
    fn touches(&self, grid: &VoxelGrid, mask: &Mask) -> Vec<Touch> {
        let rows: Vec<usize> = (0..mask.classes.len()).filter(|row| mask.classes[*row] > 0).collect();
        let owners = self.owners(grid, mask, &rows);
        let mut pairs = Vec::new();
        for (row, a) in rows.iter().zip(&owners).filter_map(|(row, owner)| Some((*row, (*owner)?))) {
            let later = grid.neighbours(row).filter(|to| *to > row);
            for (to, b) in later.filter_map(|to| Some((to, owners[rows.binary_search(&to).ok()?]?))) {
                if self.tube[a] != self.tube[b] {
                    pairs.push(([a.min(b), a.max(b)], [row, to]));
                }
            }
        }
        pairs.sort_unstable();
        let widest = self.tubes.iter().map(DrawnTube::widest).fold(0.0, f64::max);
        let mut ways = ShortestPaths::new(self.tube.len());
        let mut searched = None;
        let mut found = Vec::new();
        for ([a, b], voxels) in pairs {
            let apart = |radii: f64| APART[0] * radii + APART[1] * grid.spacing;
            if searched.replace(a) != Some(a) {
                ways.search(&[a], apart(self.radius(a) + widest), |at| self.next_to(at), |_, _| true);
            }
            if ways.lengths()[b] > apart(self.radius(a) + self.radius(b)) {
                let [p, q] = voxels.map(|row| grid.position(grid.voxel(row)));
                let place = [0, 1, 2].map(|axis| f64::midpoint(p[axis], q[axis]));
                found.push(Touch { tubes: [a, b].map(|station| self.tube[station]), stations: [a, b], place });
            }
        }
        found
    }
}

/// Where voxels touch that belong to vessels which are apart. A voxel belongs to the vessel in whose lumen it lies deepest; what two
/// vessels have in common along one stretch is one contact.
pub(super) fn contacts(tubes: &[DrawnTube], grid: &VoxelGrid, mask: &Mask) -> Vec<Contact> {
    let stations = Stations::new(tubes);
    let mut touches = stations.touches(grid, mask);
    touches.sort_by_key(|touch| (touch.tubes, touch.stations));
    let is_one = |a: &Touch, b: &Touch| {
        let between = distance(stations.place(a.stations[0]), stations.place(b.stations[0]));
        let both = stations.radius(b.stations[0]) + stations.radius(b.stations[1]);
        a.tubes == b.tubes && between <= both + APART[1] * grid.spacing
    };
    let contact = |touches: &[Touch]| {
        let vessels = touches[0].tubes;
        let position_mm = centroid(touches.iter().map(|touch| touch.place));
        Contact { vessels, labels: vessels.map(|row| tubes[row].label.clone()), position_mm }
    };
    touches.chunk_by(is_one).map(contact).collect()
}
