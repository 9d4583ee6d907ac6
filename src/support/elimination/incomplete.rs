//! Incomplete elimination of the core that is left when nodes of few neighbours are gone: a preconditioner's program.
//!
//! Nodes are eliminated in the order of their places. A join is kept where a ray is, or where two rays of the graph itself meet
//! (one level of fill); all others are dropped.

use super::program::Program;
use super::{Elimination, NOWHERE};

/// A compiled incomplete elimination; node k is the k-th of the core.
#[derive(Debug, Clone)]
pub struct Incomplete {
    program: Program,
    /// Per ray that of the elimination whose conductance it begins with; [`NOWHERE`] for fill.
    from: Vec<u32>,
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
        Self { program: Program::new(to, nodes), from }
    }

    /// Its joins.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Per ray that of the elimination whose conductance it begins with; [`NOWHERE`] for fill.
    #[inline]
    pub fn from(&self) -> &[u32] {
        &self.from
    }
}
