//! The pressures of many networks that differ in their resistances alone, eight side by side where star-mesh elimination
//! serves, one by one by sparse Cholesky beyond.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use crate::error::{Error, Result};
use crate::hemodynamics::cholesky::{self, Cholesky};
use crate::hemodynamics::floating::{grounded, stranded};
use crate::hemodynamics::star_mesh::{StarMesh, Workspace};
use crate::hemodynamics::{Circuit, steady::LANES_LIMIT};
use crate::simd::{InstructionSet, Kernel, Lanes, Simd};

/// Instances solved side by side.
pub const LANES: usize = 8;

/// What all instances of a network share: which vessels are open is the same in each.
#[derive(Debug)]
pub struct Solver {
    circuit: Circuit,
    /// `None` beyond [`LANES_LIMIT`].
    star_mesh: Option<StarMesh>,
    instructions: InstructionSet,
    grounded: Vec<bool>,
    /// Nodes whose injected flow has nowhere to go, in every instance.
    stranded: Vec<(usize, u64)>,
}

/// The memory of one worker.
pub struct Memory {
    conductance: Vec<Lanes<LANES>>,
    star_mesh: Option<Workspace<LANES>>,
    /// Pressures of every node, Pa above the level, for the sparse solver.
    above_level: Vec<Lanes<LANES>>,
}

impl Solver {
    /// Prepares the instances of a circuit.
    pub fn new(circuit: Circuit) -> Self {
        let open = |vessel: usize| circuit.conductance[vessel] > 0.0;
        let masks: Vec<u64> = (0..circuit.vessel_count()).map(|v| if open(v) { u64::MAX } else { 0 }).collect();
        Self {
            star_mesh: StarMesh::compile(&circuit, LANES_LIMIT),
            instructions: InstructionSet::detect(),
            grounded: grounded(&circuit, open),
            stranded: stranded(&circuit, &masks, LANES),
            circuit,
        }
    }

    /// The solver's name: `lanes` or `cholesky`.
    pub fn name(&self) -> &'static str {
        if self.star_mesh.is_some() { "lanes" } else { "cholesky" }
    }

    /// Memory for one worker.
    pub fn memory(&self) -> Memory {
        Memory {
            conductance: vec![Lanes::ZERO; self.circuit.vessel_count()],
            star_mesh: self.star_mesh.as_ref().map(StarMesh::workspace),
            above_level: vec![Lanes::ZERO; self.circuit.node_count()],
        }
    }

    /// Solves up to [`LANES`] instances by the conductances of their vessels, m³/(Pa s).
    ///
    /// # Errors
    ///
    /// The conductances of a large circuit are too far apart for the sparse factorisation.
    pub fn solve(&self, instances: &[Vec<f64>], memory: &mut Memory) -> Result<()> {
        if let (Some(solver), Some(work)) = (&self.star_mesh, &mut memory.star_mesh) {
            for (vessel, lanes) in memory.conductance.iter_mut().enumerate() {
                *lanes = Lanes(std::array::from_fn(|lane| instances.get(lane).map_or(0.0, |c| c[vessel])));
            }
            let (conductance, stranded) = (&memory.conductance, &self.stranded);
            self.instructions.run(SideBySide { solver, conductance, stranded, work });
            return Ok(());
        }
        for (lane, conductance) in instances.iter().enumerate() {
            let circuit = Circuit { conductance: conductance.clone(), ..self.circuit.clone() };
            let factor = Cholesky::compile(&circuit).ok_or(Error::Breakdown)?;
            let store = |node: usize, p| memory.above_level[node][lane] = p;
            factor.solve(|vessel| conductance[vessel] > 0.0, &mut cholesky::Workspace::default(), store)?;
        }
        Ok(())
    }

    /// The pressures (Pa) of an instance that has been solved; `None` in floating components.
    pub fn pressures(&self, lane: usize, memory: &Memory) -> Vec<Option<f64>> {
        let above_level = |node: usize| match (&self.star_mesh, &memory.star_mesh) {
            (Some(solver), Some(work)) => work.pressure[solver.slot(node)][lane],
            _ => memory.above_level[node][lane],
        };
        let grounded = self.grounded.iter().enumerate();
        grounded.map(|(node, grounded)| grounded.then(|| above_level(node) + self.circuit.level)).collect()
    }
}

/// A group of instances.
struct SideBySide<'a> {
    solver: &'a StarMesh,
    conductance: &'a [Lanes<LANES>],
    stranded: &'a [(usize, u64)],
    work: &'a mut Workspace<LANES>,
}

impl Kernel for SideBySide<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.solver.solve_with(simd, self.conductance, self.stranded, self.work);
    }
}
