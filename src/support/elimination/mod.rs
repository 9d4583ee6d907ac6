//! Elimination of the nodes of a graph, one after another, compiled to flat index lists.
//!
//! Eliminating node k joins its neighbours pairwise. What a join means is up to the user: the conductances of a star
//! become those of a mesh, or the widest path between two neighbours may now lead through k. The order (least degree or
//! least fill, whichever needs fewer joins) and the fill are worked out once.

mod graph;
mod incomplete;
mod order;
mod program;

pub use incomplete::Incomplete;
pub use order::{Star, least_degree};

use order::{least_fill, low_degrees, reverse_cuthill_mckee};
use program::Program;

/// The place of a node that is not eliminated.
pub const NOWHERE: u32 = u32::MAX;

/// A compiled elimination.
///
/// Node k in elimination order has the rays `star(k)`, each to a later node; ray r leads to place `ray_to[r]`. Its pairs of
/// rays (i, j), i < j, in order, add to the rays `mesh(k)`, all of later stars.
#[derive(Debug, Clone)]
pub struct Elimination {
    /// Per node its place in the order.
    place: Vec<u32>,
    program: Program,
    /// How many nodes are eliminated; the others are the core.
    eliminated: usize,
}

impl Elimination {
    /// Orders and compiles; `None` when there are more than `limit` pairs, or more than indices can count.
    pub fn compile(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Self> {
        let stars = least_degree(nodes, links, limit.min(u32::MAX as usize / 2))?;
        let pairs = stars.iter().map(Star::pairs).sum();
        let filled = least_fill(nodes, links, pairs);
        Some(Self::flatten(nodes, &filled.unwrap_or(stars), nodes))
    }

    /// Eliminates nodes of at most `most` neighbours only, as long as there are any. The core that is left stands behind them in
    /// the order of Cuthill and McKee, with its rays but without meshes; `None` when indices cannot count the joins.
    pub fn compile_partly(nodes: usize, links: &[[usize; 2]], most: usize) -> Option<Self> {
        let (mut stars, left) = low_degrees(nodes, links, most);
        let eliminated = stars.len();
        let mut gone = vec![false; nodes];
        for star in &stars {
            gone[star.center] = true;
        }
        let core = reverse_cuthill_mckee(&left, |node| !gone[node]);
        let mut place = vec![0; nodes];
        core.iter().enumerate().for_each(|(at, node)| place[*node] = at);
        let later = |node: &usize| left[*node].iter().copied().filter(|other| place[*other] > place[*node]).collect();
        stars.extend(core.iter().map(|node| Star { center: *node, neighbours: later(node) }));
        let pairs: usize = stars[..eliminated].iter().map(Star::pairs).sum();
        (pairs <= u32::MAX as usize / 2).then(|| Self::flatten(nodes, &stars, eliminated))
    }

    fn flatten(nodes: usize, stars: &[Star], eliminated: usize) -> Self {
        let mut place = vec![NOWHERE; nodes];
        for (at, star) in stars.iter().enumerate() {
            place[star.center] = at as u32;
        }
        let rays = stars.iter().map(|star| {
            let mut to: Vec<u32> = star.neighbours.iter().map(|node| place[*node]).collect();
            to.sort_unstable();
            to
        });
        let program = Program::new(rays, eliminated);
        Self { place, program, eliminated }
    }

    /// The place of a node in the order.
    pub fn place(&self, node: usize) -> u32 {
        self.place[node]
    }

    /// How many nodes have a place.
    pub fn nodes(&self) -> usize {
        self.program.nodes()
    }

    /// How many nodes are eliminated; the places from there on are the core.
    pub fn eliminated(&self) -> usize {
        self.eliminated
    }

    /// How many rays there are in all.
    pub fn rays(&self) -> usize {
        self.program.ray_to().len()
    }

    /// How many of them lie in the core.
    pub fn core_rays(&self) -> usize {
        (self.eliminated..self.nodes()).map(|k| self.star(k).len()).sum()
    }

    /// The joins of one sample: the length of the program.
    pub fn joins(&self) -> usize {
        self.program.joins()
    }

    /// The ray between two different places that are neighbours when the earlier one is eliminated; [`NOWHERE`] for others.
    pub fn ray(&self, a: u32, b: u32) -> u32 {
        self.program.ray(a.min(b), a.max(b)).unwrap_or(NOWHERE)
    }

    /// The rays of the k-th node.
    #[inline]
    pub fn star(&self, k: usize) -> std::ops::Range<usize> {
        self.program.star(k)
    }

    /// The place each ray leads to.
    #[inline]
    pub fn ray_to(&self) -> &[u32] {
        self.program.ray_to()
    }

    /// The rays that the pairs of the k-th star add to.
    #[inline]
    pub fn mesh(&self, k: usize) -> &[u32] {
        self.program.mesh(k)
    }
}
