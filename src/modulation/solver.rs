//! The pressures of many networks that differ in their resistances alone, eight side by side.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use crate::error::{Error, Result};
use crate::flow::batch::solver::Workspace;
use crate::flow::floating::{grounded, stranded};
use crate::flow::pressures::MOST_BACKWARD;
use crate::flow::residual::Check;
use crate::flow::{BatchSolver, Circuit};
use crate::support::simd::{InstructionSet, Kernel, Lanes, Simd};

/// Instances solved side by side.
pub const LANES: usize = 8;

/// What all instances of a network share: which vessels are open is the same in each.
#[derive(Debug)]
pub struct Solver<'a> {
    circuit: &'a Circuit,
    batch: BatchSolver,
    instructions: InstructionSet,
    grounded: Vec<bool>,
    /// Nodes whose injected flow has nowhere to go, in every instance.
    stranded: Vec<(usize, u64)>,
}

/// The memory of one worker.
pub struct Memory {
    conductance: Vec<Lanes<LANES>>,
    work: Workspace<LANES>,
}

impl<'a> Solver<'a> {
    /// Prepares the instances of a circuit.
    ///
    /// # Errors
    ///
    /// More vessels than indices can count.
    pub fn new(circuit: &'a Circuit) -> Result<Self> {
        let open = |vessel: usize| circuit.conductance[vessel] > 0.0;
        let masks: Vec<u64> = (0..circuit.vessel_count()).map(|v| if open(v) { u64::MAX } else { 0 }).collect();
        Ok(Self {
            circuit,
            batch: BatchSolver::for_few(circuit)?,
            instructions: InstructionSet::detect(),
            grounded: grounded(circuit, open),
            stranded: stranded(circuit, &masks, LANES),
        })
    }

    /// The solver's name: `lanes` or `gradients`.
    pub fn name(&self) -> &'static str {
        self.batch.name()
    }

    /// Memory for one worker.
    pub fn memory(&self) -> Memory {
        Memory { conductance: Vec::new(), work: self.batch.workspace(0) }
    }

    /// Solves up to [`LANES`] instances by the conductances of their vessels, m³/(Pa s).
    ///
    /// # Errors
    ///
    /// Conjugate gradients that do not converge on a large circuit.
    pub fn solve(&self, instances: &[Vec<f64>], memory: &mut Memory) -> Result<()> {
        let Memory { conductance, work } = memory;
        let vessels = instances.first().map_or(0, Vec::len);
        let lanes = |vessel| Lanes(std::array::from_fn(|lane| instances.get(lane).map_or(0.0, |c| c[vessel])));
        conductance.clear();
        conductance.extend((0..vessels).map(lanes));
        self.instructions.run(SideBySide { solver: &self.batch, conductance, stranded: &self.stranded, work });
        if matches!(self.batch, BatchSolver::Gradients(_)) {
            for (lane, own) in instances.iter().enumerate() {
                let pressure = |node: usize| work.pressure()[self.batch.slot(node)][lane];
                let residual = Check::default().residual(self.circuit, |vessel| own[vessel], &self.stranded, pressure);
                if residual.backward > MOST_BACKWARD {
                    return Err(Error::Breakdown);
                }
            }
        }
        Ok(())
    }

    /// The pressures of an instance that has been solved, Pa above the circuit's level; `None` in floating components.
    pub fn above_level(&self, lane: usize, memory: &Memory) -> Vec<Option<f64>> {
        let pressure = |node: usize| memory.work.pressure()[self.batch.slot(node)][lane];
        self.grounded.iter().enumerate().map(|(node, grounded)| grounded.then(|| pressure(node))).collect()
    }
}

/// A group of instances.
struct SideBySide<'a> {
    solver: &'a BatchSolver,
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
