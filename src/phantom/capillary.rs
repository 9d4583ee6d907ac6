//! A block of capillaries: a random graph of degree three on a jittered lattice, fed and drained from its top.

use rand_distr::{Distribution, LogNormal, Uniform};

use super::circle::make_inlet;
use super::lattice::{Lattice, Mesh};
use super::straight_vessels::{Large, add_node};
use crate::error::{Error, Result};
use crate::network::{Condition, Network, Node, Role};
use crate::support::geometry::Point;
use crate::support::random;
use crate::support::random::stream;

/// The distance of neighbours on the lattice, m.
const SPACING: f64 = 5e-5;
/// How far a node lies from its place, in spacings: uniform along each axis.
const STRAY: f64 = 0.3;
/// The median radius of a capillary, m, and the standard deviation of its logarithm.
const CAPILLARY: (f64, f64) = (2.7e-6, 0.25);
/// The radius of a feeder at the top and at its tip, m.
const FEEDER: [f64; 2] = [8e-6, 4e-6];
/// Vessels and the feeders that go with them; between and beyond by a power law.
const FEEDERS: [(f64, f64); 3] = [(1e4, 20.0), (1e5, 40.0), (1e6, 300.0)];
/// Vessels a lattice place, at first.
const VESSELS_A_PLACE: f64 = 1.4;
/// The number of vessels may be off by this share.
const OFF: f64 = 0.005;
/// Lattices to try.
const ATTEMPTS: u64 = 40;

/// Within 2 % (mostly 0.5 %) of `edges` vessels of one connected network of degree 3 at most, feeders included.
///
/// Capillaries join neighbours on a cubic lattice of 50 µm, in random order as long as neither has three vessels yet; what does not
/// hang together with the rest is left out. Spacing and radii (log-normal, median 2.7 µm, standard deviation of the logarithm 0.25) are
/// round figures, fitted to nothing.
///
/// Feeders begin a lattice spacing above the block and run straight down to half of its depth at least, from 8 to 4 µm radius:
/// in turn inlets at 100 mmHg (penetrating arterioles) and outlets at 0 (venules); 20, 40 and 300 at 10⁴, 10⁵, 10⁶ vessels.
/// The block is about a cube, deeper than a cortex from 10⁵ vessels on. Ids are numbers from 1, vessels have no labels.
///
/// # Errors
///
/// Those of [`Large::validate`].
pub fn capillary(params: &Large) -> Result<Network> {
    params.validate()?;
    let mesh = mesh(params)
        .ok_or_else(|| Error::parameter("edges", params.edges, "no lattice of that size holds together; expected another"))?;
    let mut rng = stream(params.seed, random::ANATOMY);
    let mut network = Network::new();
    let stray = Uniform::new(-STRAY, STRAY).map_err(|_| Error::parameter("capillary", STRAY, "expected a positive share"))?;
    let radius = LogNormal::new(CAPILLARY.0.ln(), CAPILLARY.1)
        .map_err(|_| Error::parameter("capillary", CAPILLARY.1, "expected a positive deviation"))?;
    let mut row_of = vec![u32::MAX; mesh.lattice.places];
    for place in (0..mesh.lattice.places).filter(|place| mesh.kept[*place]) {
        let at = mesh.lattice.at(place).map(|x| (x as f64 + stray.sample(&mut rng)) * SPACING);
        row_of[place] = inner(&mut network, [at[0], at[1], -at[2]]) as u32;
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
        let mouth = inner(&mut network, [x, y, SPACING]);
        params.add_vessel(&mut network, [mouth, top], FEEDER[0]);
        make_inlet(&mut network, mouth);
        if number % 2 == 1 {
            let node = network.node_mut(mouth);
            (node.role, node.condition) = (Some(Role::Outlet), Some(Condition::GROUND));
        }
    }
    Ok(network)
}

fn inner(network: &mut Network, position: Point) -> usize {
    add_node(network, Node { position: Some(position), role: Some(Role::Inner), ..Node::default() })
}

/// The mesh whose number of vessels is nearest to the one asked for, of the first that come near or of all attempts.
fn mesh(params: &Large) -> Option<Mesh> {
    let feeders = feeders(params.edges);
    let mut best: Option<Mesh> = None;
    let mut places = params.edges as f64 / VESSELS_A_PLACE;
    let off = |mesh: &Mesh| mesh.vessels().abs_diff(params.edges);
    for attempt in 0..ATTEMPTS {
        let mesh = Mesh::new(Lattice::new(places.round() as usize), feeders, &mut stream(params.seed, random::lattice(attempt)));
        if mesh.vessels() > 0 {
            places *= params.edges as f64 / mesh.vessels() as f64;
        }
        if mesh.holds_feeders() && best.as_ref().is_none_or(|best| off(&mesh) < off(best)) {
            best = Some(mesh);
        }
        if best.as_ref().is_some_and(|best| off(best) as f64 <= OFF * params.edges as f64) {
            break;
        }
    }
    best
}

/// How many feeders go with so many vessels: even, half of them inlets.
fn feeders(edges: usize) -> usize {
    let row = usize::from(edges as f64 > FEEDERS[1].0);
    let [(from, few), (to, many)] = [FEEDERS[row], FEEDERS[row + 1]];
    let slope = (many / few).ln() / (to / from).ln();
    let wanted = few * (edges as f64 / from).powf(slope);
    2 * ((0.5 * wanted).round() as usize).max(1)
}
