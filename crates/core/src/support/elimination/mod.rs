//! Elimination of the nodes of a graph, one after another, compiled to flat index lists.
//!
//! Eliminating node k joins its neighbours pairwise. What a join means is up to the user: the conductances of a star
//! become those of a mesh, or the widest path between two neighbours may now lead through k. The order (least degree or
//! least fill, whichever needs fewer joins) and the fill are worked out once.

pub mod graph;
pub mod order;

use super::{distinct, grouped, marked, placed};

pub use order::{Star, least_degree};

use order::{fewest_joins, low_degrees, reverse_cuthill_mckee};

/// More pairs than these are not compiled, so that indices can count them.
const MOST_INDEXED: usize = u32::MAX as usize / 2;

/// The place of a node that is not eliminated.
pub const NOWHERE: u32 = u32::MAX;

/// A compiled elimination: the nodes in the order in which they are eliminated, and their joins as flat lists.
///
/// The k-th node has the rays `star(k)`, each to a later one, in order. Its pairs of rays (i, j), i < j, in order, add to the rays `mesh(k)`,
/// all of later stars.
#[derive(Debug, Clone)]
pub struct Elimination {
    /// Per node its place in the order; empty where nodes are numbered in the order.
    place: Vec<u32>,
    star: Vec<u32>,
    ray_to: Vec<u32>,
    mesh_start: Vec<u32>,
    mesh: Vec<u32>,
}

impl Elimination {
    /// Orders the nodes and compiles; `None` when there are more than `limit` pairs, or more than indices can count.
    pub fn compile(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Self> {
        Some(Self::of_stars(&fewest_joins(nodes, links, limit.min(MOST_INDEXED))?, nodes))
    }

    /// Eliminates nodes of at most `most` neighbours only, as long as there are any. The rest, the core, comes after them in
    /// the order of Cuthill and McKee, with its rays but without meshes; `None` when indices cannot count the joins.
    pub fn compile_partly(nodes: usize, links: &[[usize; 2]], most: usize) -> Option<Self> {
        let (mut stars, left) = low_degrees(nodes, links, most, MOST_INDEXED)?;
        let eliminated = stars.len();
        let gone = marked(nodes, stars.iter().map(|star| star.center));
        let core = reverse_cuthill_mckee(&left, |node| !gone[node]);
        let place = placed(nodes, core.iter().copied());
        let later = |node: &usize| left[*node].iter().copied().filter(|other| place[*other] > place[*node]).collect();
        stars.extend(core.iter().map(|node| Star { center: *node, neighbours: later(node) }));
        Some(Self::of_stars(&stars, eliminated))
    }

    /// Compiles what `order` makes of the nodes that `counts` admits, by their number among these, and of the links between them. The others
    /// have no place.
    pub fn among(
        nodes: usize,
        links: &[[usize; 2]],
        counts: impl Fn(usize) -> bool,
        order: impl FnOnce(usize, &[[usize; 2]]) -> Option<Self>,
    ) -> Option<Self> {
        let admitted: Vec<usize> = (0..nodes).filter(|node| counts(*node)).collect();
        let number = placed(nodes, admitted.iter().copied());
        let between = links.iter().filter(|[a, b]| a != b && counts(*a) && counts(*b));
        let compiled = order(admitted.len(), &between.map(|ends| ends.map(|node| number[node])).collect::<Vec<_>>())?;
        let mut place = vec![NOWHERE; nodes];
        admitted.iter().zip(&compiled.place).for_each(|(node, own)| place[*node] = *own);
        Some(Self { place, ..compiled })
    }

    /// From the neighbours of each node at its elimination, all nodes in order; the first `eliminated` of them join theirs.
    pub fn of_stars(stars: &[Star], eliminated: usize) -> Self {
        let place: Vec<u32> = placed(stars.len(), stars.iter().map(|star| star.center)).into_iter().map(|at| at as u32).collect();
        let rays = stars.iter().map(|star| distinct(star.neighbours.iter().map(|node| place[*node])));
        let program = Self::of_rays(rays, eliminated);
        Self { place, ..program }
    }

    /// From the places to which the rays of each node lead, the nodes being numbered in order; the first `eliminated` nodes join theirs. A join
    /// without a ray is [`NOWHERE`].
    fn of_rays(rays: impl IntoIterator<Item = Vec<u32>>, eliminated: usize) -> Self {
        let mut program = Self { place: Vec::new(), star: vec![0], ray_to: Vec::new(), mesh_start: vec![0], mesh: Vec::new() };
        for to in rays {
            program.ray_to.extend(to);
            program.star.push(program.ray_to.len() as u32);
        }
        for k in 0..eliminated {
            let star = program.star(k);
            for i in star.clone() {
                for j in i + 1..star.end {
                    program.mesh.push(program.ray_between(program.ray_to[i], program.ray_to[j]));
                }
            }
            program.mesh_start.push(program.mesh.len() as u32);
        }
        program
    }

    /// The place of a node in the order; [`NOWHERE`] for one that does not take part.
    pub fn place(&self, node: usize) -> u32 {
        self.place[node]
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.star.len() - 1
    }

    /// How many nodes are eliminated; the places from there on are the core.
    pub fn eliminated(&self) -> usize {
        self.mesh_start.len() - 1
    }

    /// How many rays there are.
    pub fn rays(&self) -> usize {
        self.ray_to.len()
    }

    /// How many rays lie in the core.
    pub fn core_rays(&self) -> usize {
        self.rays() - self.star[self.eliminated()] as usize
    }

    /// The joins of one sample: the length of the program.
    pub fn joins(&self) -> usize {
        self.mesh.len()
    }

    /// The rays of the k-th node.
    #[inline]
    pub fn star(&self, k: usize) -> std::ops::Range<usize> {
        self.star[k] as usize..self.star[k + 1] as usize
    }

    /// The node each ray leads to.
    #[inline]
    pub fn ray_to(&self) -> &[u32] {
        &self.ray_to
    }

    /// The rays that the pairs of the k-th star add to; [`NOWHERE`] where the join is dropped.
    #[inline]
    pub fn mesh(&self, k: usize) -> &[u32] {
        &self.mesh[self.mesh_start[k] as usize..self.mesh_start[k + 1] as usize]
    }

    /// The ray between two different places that are neighbours when the earlier one is eliminated; [`NOWHERE`] for others.
    pub fn ray_between(&self, a: u32, b: u32) -> u32 {
        let star = self.star(a.min(b) as usize);
        self.ray_to[star.clone()].binary_search(&a.max(b)).map_or(NOWHERE, |at| (star.start + at) as u32)
    }

    /// Per ray the rows of the links that lie on it, in their order. A link is a row with two different places that are neighbours.
    pub fn rows_by_ray(&self, links: impl IntoIterator<Item = (u32, [u32; 2])>) -> Vec<Vec<u32>> {
        grouped(self.rays(), links.into_iter().map(|(row, [a, b])| (self.ray_between(a, b) as usize, row)))
    }
}

/// A compiled incomplete elimination of the core that is left when nodes of few neighbours are gone: a preconditioner's program. Node k is
/// the k-th of the core.
///
/// Nodes are eliminated in the order of their places. A join is kept where a ray is, or where two rays of the graph itself meet
/// (one level of fill); all others are dropped.
#[derive(Debug, Clone)]
pub struct Incomplete {
    /// The elimination, its nodes numbered in their order.
    pub program: Elimination,
    /// Per ray that of the elimination whose conductance it begins with; [`NOWHERE`] for fill.
    pub from: Vec<u32>,
}

impl Incomplete {
    /// Compiles the core of a partial elimination.
    pub fn compile(elimination: &Elimination) -> Self {
        let first = elimination.eliminated();
        let nodes = elimination.nodes() - first;
        let own = |k: usize| elimination.star(first + k).map(|ray| (elimination.ray_to()[ray] - first as u32, ray as u32));
        let mut rays: Vec<Vec<(u32, u32)>> = (0..nodes).map(|k| own(k).collect()).collect();
        for k in 0..nodes {
            let to: Vec<u32> = own(k).map(|(to, _)| to).collect();
            for (i, low) in to.iter().enumerate() {
                rays[*low as usize].extend(to[i + 1..].iter().map(|high| (*high, NOWHERE)));
            }
        }
        for rays in &mut rays {
            // Of a ray and its fill the ray comes first.
            rays.sort_unstable();
            rays.dedup_by_key(|(to, _)| *to);
        }
        let from = rays.iter().flatten().map(|(_, from)| *from).collect();
        let to = rays.into_iter().map(|rays| rays.into_iter().map(|(to, _)| to).collect());
        Self { program: Elimination::of_rays(to, nodes), from }
    }
}
