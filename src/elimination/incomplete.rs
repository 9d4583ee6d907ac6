//! Incomplete elimination of the core that is left when nodes of few neighbours are gone: a preconditioner's program.
//!
//! Nodes are eliminated in the order of their places. A join is kept where a ray is, or where two rays of the graph itself meet
//! (one level of fill); all others are dropped.

use super::{Elimination, NOWHERE};

/// A compiled incomplete elimination; node k is the k-th of the core.
#[derive(Debug, Clone)]
pub struct Incomplete {
    star: Vec<u32>,
    ray_to: Vec<u32>,
    /// Per ray that of the elimination whose conductance it begins with; [`NOWHERE`] for fill.
    from: Vec<u32>,
    mesh_start: Vec<u32>,
    mesh: Vec<u32>,
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
        let mut program = Self { star: vec![0], ray_to: Vec::new(), from: Vec::new(), mesh_start: vec![0], mesh: Vec::new() };
        for rays in &mut rays {
            // Of a ray and its fill the ray comes first.
            rays.sort_unstable();
            rays.dedup_by_key(|(to, _)| *to);
            program.ray_to.extend(rays.iter().map(|(to, _)| to));
            program.from.extend(rays.iter().map(|(_, from)| from));
            program.star.push(program.ray_to.len() as u32);
        }
        for k in 0..nodes {
            let to = program.star(k);
            for i in to.clone() {
                let low = program.star(program.ray_to[i] as usize);
                let targets = &program.ray_to[low.clone()];
                for high in &program.ray_to[i + 1..to.end] {
                    program.mesh.push(targets.binary_search(high).map_or(NOWHERE, |at| (low.start + at) as u32));
                }
            }
            program.mesh_start.push(program.mesh.len() as u32);
        }
        program
    }

    /// How many nodes the core has.
    pub fn nodes(&self) -> usize {
        self.star.len() - 1
    }

    /// The joins of one sample.
    pub fn joins(&self) -> usize {
        self.mesh.len()
    }

    /// The rays of the k-th node.
    #[inline]
    pub fn star(&self, k: usize) -> std::ops::Range<usize> {
        self.star[k] as usize..self.star[k + 1] as usize
    }

    /// The node each ray leads to, later than its own.
    #[inline]
    pub fn ray_to(&self) -> &[u32] {
        &self.ray_to
    }

    /// Per ray that of the elimination whose conductance it begins with; [`NOWHERE`] for fill.
    #[inline]
    pub fn from(&self) -> &[u32] {
        &self.from
    }

    /// The rays that the pairs of the k-th star add to; [`NOWHERE`] where the join is dropped.
    #[inline]
    pub fn mesh(&self, k: usize) -> &[u32] {
        &self.mesh[self.mesh_start[k] as usize..self.mesh_start[k + 1] as usize]
    }
}
