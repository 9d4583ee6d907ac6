//! The joins of an elimination as flat lists.

use super::NOWHERE;

/// Node k has the rays `star(k)`, each to a later node, in order. Its pairs of rays (i, j), i < j, in order, add to the rays `mesh(k)`,
/// all of later stars.
#[derive(Debug, Clone)]
pub struct Program {
    star: Vec<u32>,
    ray_to: Vec<u32>,
    mesh_start: Vec<u32>,
    mesh: Vec<u32>,
}

impl Program {
    /// From the rays of each node, in order; the first `eliminated` nodes join theirs. A join without a ray is [`NOWHERE`].
    pub fn new(stars: impl IntoIterator<Item = Vec<u32>>, eliminated: usize) -> Self {
        let mut program = Self { star: vec![0], ray_to: Vec::new(), mesh_start: vec![0], mesh: Vec::new() };
        for to in stars {
            program.ray_to.extend(to);
            program.star.push(program.ray_to.len() as u32);
        }
        for k in 0..eliminated {
            let to = program.star(k);
            for i in to.clone() {
                for j in i + 1..to.end {
                    let target = program.ray(program.ray_to[i], program.ray_to[j]);
                    program.mesh.push(target.unwrap_or(NOWHERE));
                }
            }
            program.mesh_start.push(program.mesh.len() as u32);
        }
        program
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.star.len() - 1
    }

    /// The joins of one sample.
    pub fn joins(&self) -> usize {
        self.mesh.len()
    }

    /// The ray from a node to a later one.
    pub fn ray(&self, from: u32, to: u32) -> Option<u32> {
        let star = self.star(from as usize);
        self.ray_to[star.clone()].binary_search(&to).ok().map(|at| (star.start + at) as u32)
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
}
