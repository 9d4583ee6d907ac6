//! A block of capillaries: a random graph of degree three on a jittered cubic lattice, fed and drained from the top.

use rand::seq::{SliceRandom, index};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, LogNormal, Uniform};

use super::{Large, add_node, state};
use willis_core::error::{Error, Result};
use willis_core::network::{Condition, Fragments, Network, Role};
use willis_core::support::{counted, random, random::stream};

/// The distance between neighbours on the lattice, m.
const SPACING: f64 = 5e-5;
/// How far a node lies from its place, in spacings: uniform along each axis.
const JITTER: f64 = 0.3;
/// The median radius of a capillary, m, and the standard deviation of its logarithm.
const CAPILLARY: (f64, f64) = (2.7e-6, 0.25);
/// The radius of a feeder at its top and at its tip, m.
const FEEDER: [f64; 2] = [8e-6, 4e-6];
/// Numbers of vessels and of the feeders that they get; a power law gives the values between and beyond.
const FEEDERS: [(f64, f64); 3] = [(1e4, 20.0), (1e5, 40.0), (1e6, 300.0)];
/// Vessels per place of the lattice, as a first guess.
const VESSELS_A_PLACE: f64 = 1.4;
/// The share by which the number of vessels may differ from the one requested.
const TOLERANCE: f64 = 0.005;
/// How many lattices to try.
const ATTEMPTS: u64 = 40;

/// One connected network of degree 3 at most. Its number of vessels, with the feeders, is within 2 % (mostly 0.5 %) of `edges`.
///
/// Capillaries join neighbours on a cubic lattice of 50 µm. They are added in random order, unless one of the two places has three
/// vessels already; what is not connected to the rest is left out. Spacing and radii (log-normal, median 2.7 µm, standard deviation of
/// the logarithm 0.25) are round figures, fitted to no data.
///
/// Feeders begin one lattice spacing above the block and run straight down to at least half of its depth, from 8 to 4 µm radius.
/// They are alternately inlets at 100 mmHg (penetrating arterioles) and outlets at 0 (venules): 20, 40 and 300 at 10⁴, 10⁵, 10⁶ vessels.
/// The block is about a cube, deeper than a cortex from 10⁵ vessels on. Ids are numbers from 1, vessels have no labels.
///
/// # Errors
///
/// A number of vessels for which no lattice holds together.
pub fn capillary(params: &Large) -> Result<Network> {
    let mesh = mesh(params)
        .ok_or_else(|| Error::parameter("edges", params.edges, "no lattice of that size holds together; expected another"))?;
    let mut rng = stream(params.seed, random::ANATOMY);
    let mut network = Network::new();
    let jitter = Uniform::new(-JITTER, JITTER).map_err(|_| Error::parameter("capillary", JITTER, "expected a positive share"))?;
    let radius = LogNormal::new(CAPILLARY.0.ln(), CAPILLARY.1)
        .map_err(|_| Error::parameter("capillary", CAPILLARY.1, "expected a positive deviation"))?;
    let mut row_of = vec![u32::MAX; mesh.lattice.places];
    for place in (0..mesh.lattice.places).filter(|place| mesh.kept[*place]) {
        let at = mesh.lattice.at(place).map(|x| (x as f64 + jitter.sample(&mut rng)) * SPACING);
        row_of[place] = add_node(&mut network, [at[0], at[1], -at[2]], None) as u32;
    }
    for link in &mesh.links {
        let ends = mesh.lattice.ends(*link).map(|place| row_of[place] as usize);
        let radius =
            mesh.feeder_share(*link).map_or_else(|| radius.sample(&mut rng), |share| FEEDER[0] + share * (FEEDER[1] - FEEDER[0]));
        params.add_vessel(&mut network, ends, radius);
    }
    for (number, (column, _)) in mesh.feeders.iter().enumerate() {
        let top = row_of[*column] as usize;
        let [x, y, _] = network.node(top).position.unwrap_or_default();
        let mouth = add_node(&mut network, [x, y, SPACING], None);
        params.add_vessel(&mut network, [mouth, top], FEEDER[0]);
        let ends = [(Role::Inlet, Condition::INLET), (Role::Outlet, Condition::GROUND)];
        let (role, condition) = ends[number % 2];
        state(&mut network, mouth, role, condition);
    }
    Ok(network)
}

/// The mesh whose number of vessels is nearest to the requested one; the search ends when that is near enough.
fn mesh(params: &Large) -> Option<Mesh> {
    let feeders = feeders(params.edges);
    let mut best: Option<Mesh> = None;
    let mut places = params.edges as f64 / VESSELS_A_PLACE;
    let difference = |mesh: &Mesh| mesh.vessels().abs_diff(params.edges);
    for attempt in 0..ATTEMPTS {
        let mesh = Mesh::new(Lattice::new(places.round() as usize), feeders, &mut stream(params.seed, random::lattice(attempt)));
        if mesh.vessels() > 0 {
            places *= params.edges as f64 / mesh.vessels() as f64;
        }
        // Every feeder is connected to the rest.
        let holds_feeders = mesh.feeders.iter().all(|(top, _)| mesh.kept[*top]);
        if holds_feeders && best.as_ref().is_none_or(|best| difference(&mesh) < difference(best)) {
            best = Some(mesh);
        }
        if best.as_ref().is_some_and(|best| difference(best) as f64 <= TOLERANCE * params.edges as f64) {
            break;
        }
    }
    best
}

/// The number of feeders for a number of vessels: even, half of them inlets.
fn feeders(edges: usize) -> usize {
    let row = usize::from(edges as f64 > FEEDERS[1].0);
    let [(from, few), (to, many)] = [FEEDERS[row], FEEDERS[row + 1]];
    let slope = (many / few).ln() / (to / from).ln();
    let wanted = few * (edges as f64 / from).powf(slope);
    2 * ((0.5 * wanted).round() as usize).max(1)
}

/// The largest number of vessels at a place of the lattice.
const DEGREE: u8 = 3;

/// A cubic lattice. Its places are numbered row by row and layer by layer from the top; the last layer may be incomplete.
#[derive(Debug, Clone, Copy)]
struct Lattice {
    /// How many places.
    places: usize,
    /// How many places along each side of a layer.
    side: usize,
}

impl Lattice {
    /// A lattice that is nearly a cube.
    fn new(places: usize) -> Self {
        Self { places, side: ((places as f64).cbrt().round() as usize).max(2) }
    }

    /// The coordinates of a place: along the row, across, and down.
    fn at(self, place: usize) -> [usize; 3] {
        [place % self.side, place / self.side % self.side, place / (self.side * self.side)]
    }

    /// The two places of a link. A link leads from a place to the next along an axis, and is numbered by both.
    fn ends(self, link: u32) -> [usize; 2] {
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

/// The largest connected part of a random maximal subgraph of degree three, with feeders.
struct Mesh {
    lattice: Lattice,
    /// For each place whether the mesh has it.
    kept: Vec<bool>,
    /// The links in order, with those of the feeders.
    links: Vec<u32>,
    /// The place of each feeder in the top layer and the number of its links downwards, in the order of the places.
    feeders: Vec<(usize, usize)>,
}

impl Mesh {
    /// Puts the feeders into random columns, down to at least half of the depth. Then adds every other link, in random order, unless one
    /// of its places has three vessels already. The top of a feeder has one vessel more, from above the lattice.
    fn new(lattice: Lattice, feeders: usize, rng: &mut impl Rng) -> Self {
        let columns = lattice.side * lattice.side;
        let down = (lattice.places / columns).saturating_sub(1).max(1);
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

    /// How many vessels, with the one above every feeder.
    fn vessels(&self) -> usize {
        self.links.len() + self.feeders.len()
    }

    /// How far down its feeder a link is, 0 to 1; `None` for a capillary.
    fn feeder_share(&self, link: u32) -> Option<f64> {
        let [first, _] = self.lattice.ends(link);
        let columns = self.lattice.side * self.lattice.side;
        let feeder = self.feeders.binary_search_by_key(&(first % columns), |(top, _)| *top).ok();
        let (_, steps) = self.feeders[feeder.filter(|_| link % 3 == 2)?];
        let step = first / columns;
        (step < steps).then(|| (step + 1) as f64 / steps as f64)
    }
}

/// The connected part with the most places, and its links.
fn largest_part(lattice: Lattice, taken: &[bool]) -> (Vec<bool>, Vec<u32>) {
    let links = || (0..taken.len() as u32).filter(|link| taken[*link as usize]);
    let Fragments { of_node, count } = Fragments::over(lattice.places, links().map(|link| lattice.ends(link)));
    let size = counted(count, of_node.iter().copied());
    let largest = (0..count).fold(0, |largest, part| if size[part] > size[largest] { part } else { largest });
    let kept: Vec<bool> = of_node.into_iter().map(|part| part == largest).collect();
    let links = links().filter(|link| kept[lattice.ends(*link)[0]]).collect();
    (kept, links)
}
