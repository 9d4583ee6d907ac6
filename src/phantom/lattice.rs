//! Random maximal subgraphs of degree three of a cubic lattice, with straight feeders from its top.

use petgraph::unionfind::UnionFind;
use rand::seq::{SliceRandom, index};
use rand::{Rng, RngExt};

/// The most vessels at a place.
const DEGREE: u8 = 3;

/// Places in rows of rows, layer by layer from the top; the last layer may be in part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lattice {
    /// How many places.
    pub places: usize,
    /// Places along each side of a layer.
    side: usize,
}

impl Lattice {
    /// About a cube.
    pub fn new(places: usize) -> Self {
        Self { places, side: ((places as f64).cbrt().round() as usize).max(2) }
    }

    /// Along the row, across, and down.
    pub fn at(self, place: usize) -> [usize; 3] {
        [place % self.side, place / self.side % self.side, place / (self.side * self.side)]
    }

    /// Whole layers.
    fn layers(self) -> usize {
        self.places / (self.side * self.side)
    }

    /// From a place to the next along an axis: links are numbered by their first place and their axis.
    pub fn ends(self, link: u32) -> [usize; 2] {
        let first = link as usize / 3;
        [first, first + [1, self.side, self.side * self.side][link as usize % 3]]
    }

    /// All links, in order.
    fn links(self) -> impl Iterator<Item = u32> {
        (0..3 * self.places as u32).filter(move |link| {
            let [first, second] = self.ends(*link);
            let axis = *link as usize % 3;
            second < self.places && (axis == 2 || self.at(first)[axis] + 1 < self.side)
        })
    }
}

/// The largest connected part of a random maximal subgraph.
pub(crate) struct Mesh {
    pub lattice: Lattice,
    /// Whether each place is in it.
    pub kept: Vec<bool>,
    /// Its links, in order, those of the feeders too.
    pub links: Vec<u32>,
    /// Per feeder its place in the top layer and how many links it runs down, in the order of the places.
    pub feeders: Vec<(usize, usize)>,
}

impl Mesh {
    /// Lays the feeders down random columns, half of the depth or more, then every other link in random order where neither of its
    /// places has three vessels yet. The top of a feeder has one vessel more, which is none of the lattice's.
    pub fn new(lattice: Lattice, feeders: usize, rng: &mut impl Rng) -> Self {
        let columns = lattice.side * lattice.side;
        let down = lattice.layers().saturating_sub(1).max(1);
        let mut tops = index::sample(rng, columns, feeders.min(columns)).into_vec();
        tops.sort_unstable();
        let feeders: Vec<_> = tops.into_iter().map(|top| (top, rng.random_range(down.div_ceil(2)..=down))).collect();

        let mut degree = vec![0_u8; lattice.places];
        let mut taken = vec![false; 3 * lattice.places];
        for (top, steps) in &feeders {
            degree[*top] += 1;
            for step in 0..*steps {
                let link = 3 * (top + step * columns) + 2;
                taken[link] = true;
                for place in lattice.ends(link as u32) {
                    degree[place] += 1;
                }
            }
        }
        let mut order: Vec<u32> = lattice.links().filter(|link| !taken[*link as usize]).collect();
        order.shuffle(rng);
        for link in order {
            let ends = lattice.ends(link);
            if ends.iter().all(|place| degree[*place] < DEGREE) {
                taken[link as usize] = true;
                for place in ends {
                    degree[place] += 1;
                }
            }
        }
        let (kept, links) = largest_part(lattice, &taken);
        Self { lattice, kept, links, feeders }
    }

    /// How many vessels, one above every feeder included.
    pub fn vessels(&self) -> usize {
        self.links.len() + self.feeders.len()
    }

    /// Whether every feeder hangs together with the rest.
    pub fn holds_feeders(&self) -> bool {
        self.feeders.iter().all(|(top, _)| self.kept[*top])
    }

    /// How far down its feeder a link is, 0 to 1; none for a capillary.
    pub fn feeder_share(&self, link: u32) -> Option<f64> {
        let [first, _] = self.lattice.ends(link);
        let columns = self.lattice.side * self.lattice.side;
        let feeder = self.feeders.binary_search_by_key(&(first % columns), |(top, _)| *top).ok();
        let (_, steps) = self.feeders[feeder.filter(|_| link % 3 == 2)?];
        let step = first / columns;
        (step < steps).then(|| (step + 1) as f64 / steps as f64)
    }
}

/// The part with the most places, and its links.
fn largest_part(lattice: Lattice, taken: &[bool]) -> (Vec<bool>, Vec<u32>) {
    let mut parts = UnionFind::<u32>::new(lattice.places);
    let links = || (0..taken.len() as u32).filter(|link| taken[*link as usize]);
    for link in links() {
        let [a, b] = lattice.ends(link);
        parts.union(a as u32, b as u32);
    }
    let part = parts.into_labeling();
    let mut size = vec![0_usize; lattice.places];
    for label in &part {
        size[*label as usize] += 1;
    }
    let largest = (0..size.len()).fold(0, |largest, label| if size[label] > size[largest] { label } else { largest });
    let kept: Vec<bool> = part.iter().map(|label| *label as usize == largest).collect();
    let links = links().filter(|link| kept[lattice.ends(*link)[0]]).collect();
    (kept, links)
}
