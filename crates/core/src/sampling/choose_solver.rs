//! Which solver, forest algorithm and group width a run uses, and why.

use super::{ForestProgram, Solver};
use crate::error::{Error, Result};
use crate::flow::{BatchSolver, Circuit};

/// Graphs of more vessels are reduced first. Smaller ones fit the nearest caches as they are.
const MOST_VESSELS_IN_FULL: usize = 4096;
/// Joins of star-mesh elimination above which a graph is reduced first and conjugate gradients are considered.
const MOST_JOINS_IN_FULL: usize = 200_000;

/// Samples of a full graph that are computed side by side.
///
/// Time of a sample at 8, 16 and 32 of them, over the least of the three, in one thread (medians of 13 interleaved rounds):
///
/// | | AVX-512: 8 | 16 | 32 | AVX2: 8 | 16 | 32 | baseline: 8 | 16 | 32 |
/// |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|
/// | broken-circle | 1.42 | 1.13 | 1 | 1.27 | 1.08 | 1 | 1.01 | 1 | 1.01 |
/// | cow-30-80 | 1.33 | 1.15 | 1 | 1.22 | 1 | 1.04 | 1.02 | 1 | 1.04 |
/// | extraction-45-165 | 1.35 | 1.10 | 1 | 1.22 | 1.01 | 1 | 1 | 1 | 1.07 |
/// | brain-206-726 | 1.19 | 1.04 | 1 | 1.16 | 1 | 1.06 | 1.01 | 1 | 1.01 |
/// | brain-206-726-13-terminals | 1.14 | 1.01 | 1 | 1.19 | 1 | 1.06 | 1.02 | 1 | 1.14 |
pub const FULL_GRAPH_LANES: usize = 32;
/// Samples of a reduced graph that are computed side by side: with more of them the memory of a large graph only lies further away.
pub const REDUCED_GRAPH_LANES: usize = 8;

/// Nanoseconds that a join of star-mesh elimination takes, a sample.
const JOIN: f64 = 0.30;
/// Steps of conjugate gradients that a mesh of vessels takes.
const STEPS: f64 = 50.0;
/// Nanoseconds that a ray of the core takes in one of these steps, a sample.
const RAY_IN_STEP: f64 = 0.5;
/// Nodes of a core above which its elimination is not even ordered: conjugate gradients are sure to be faster.
const MOST_CORE_NODES: usize = 2000;
/// Joins of a forest program, per vessel, above which Kruskal's algorithm is faster.
const MOST_FOREST_JOINS_PER_VESSEL: usize = 40;

/// How a run computed its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// The solver: `lanes`, `gradients` or `reference`.
    pub solver: &'static str,
    /// The joins of its program, or the vessels of the reference: what a sample (of `gradients`, a step) costs is in proportion.
    pub solver_size: usize,
    /// The forest algorithm: `bottleneck` or `kruskal`.
    pub forest: &'static str,
    /// The joins of the forest program.
    pub forest_joins: Option<usize>,
    /// The instruction set.
    pub instructions: &'static str,
}

impl Method {
    /// With a forest program, or Kruskal's algorithm.
    pub fn new(solver: &'static str, solver_size: usize, forest: Option<&ForestProgram>, instructions: &'static str) -> Self {
        let forest_joins = forest.map(ForestProgram::joins);
        let forest = if forest_joins.is_some() { "bottleneck" } else { "kruskal" };
        Self { solver, solver_size, forest, forest_joins, instructions }
    }
}

/// The most joins of a graph whose samples are computed vessel by vessel; `None` where it is reduced first.
pub fn most_joins_in_full(vessels: usize, solver: Solver) -> Option<usize> {
    match solver {
        _ if vessels > MOST_VESSELS_IN_FULL => None,
        Solver::Lanes => Some(usize::MAX),
        Solver::Gradients => None,
        _ => Some(MOST_JOINS_IN_FULL),
    }
}

/// The solver of a reduced graph.
///
/// # Errors
///
/// A mesh beyond what indices can count.
pub fn reduced_graph_solver(core: &Circuit, solver: Solver) -> Result<BatchSolver> {
    if solver == Solver::Lanes {
        return BatchSolver::star_mesh(core, usize::MAX).ok_or(Error::Breakdown);
    }
    let gradients = BatchSolver::gradients(core)?;
    if solver == Solver::Auto && gradients.core().is_some_and(|core| core.incomplete.program.nodes() <= MOST_CORE_NODES) {
        let nanoseconds = JOIN * gradients.joins() as f64 + STEPS * RAY_IN_STEP * gradients.rays_in_step() as f64;
        if let Some(solver) = BatchSolver::star_mesh(core, (nanoseconds / JOIN) as usize) {
            return Ok(solver);
        }
    }
    Ok(gradients)
}

/// The forest program of a graph, `None` where Kruskal's algorithm is faster. `None` among the ends is a vessel that is in no forest.
pub fn forest_program(nodes: usize, ends: &[Option<[usize; 2]>]) -> Option<ForestProgram> {
    ForestProgram::compile(nodes, ends, MOST_FOREST_JOINS_PER_VESSEL * ends.len())
}
