//! The pressures of many networks that differ in their resistances alone, eight side by side where star-mesh elimination
//! serves, one by one by sparse Cholesky beyond.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use crate::error::{Error, Result};
use crate::flow::batch::star_mesh::{StarMesh, Workspace};
use crate::flow::cholesky::Cholesky;
use crate::flow::floating::{grounded, stranded};
use crate::flow::pressures::LANES_LIMIT;
use crate::flow::{Circuit, cholesky};
use crate::support::simd::{InstructionSet, Kernel, Lanes, Simd};

/// Instances solved side by side.
pub const LANES: usize = 8;

/// What all instances of a network share: which vessels are open is the same in each.
#[derive(Debug)]
pub struct Solver {
    how: How,
    instructions: InstructionSet,
    grounded: Vec<bool>,
    /// Nodes whose injected flow has nowhere to go, in every instance.
    stranded: Vec<(usize, u64)>,
}

#[derive(Debug)]
enum How {
    SideBySide(Box<StarMesh>),
    /// Beyond [`LANES_LIMIT`].
    OneByOne(Box<Cholesky>),
}

/// The memory of one worker.
pub struct Memory {
    work: Work,
    /// Pressures of every node, Pa above the circuit's level.
    above_level: Vec<Lanes<LANES>>,
}

enum Work {
    SideBySide { conductance: Vec<Lanes<LANES>>, mesh: Box<Workspace<LANES>> },
    OneByOne(Box<cholesky::Workspace>),
}

impl Solver {
    /// Prepares the instances of a circuit.
    ///
    /// # Errors
    ///
    /// The conductances of a large circuit are too far apart for the sparse factorisation.
    pub fn new(circuit: &Circuit) -> Result<Self> {
        let open = |vessel: usize| circuit.conductance[vessel] > 0.0;
        let masks: Vec<u64> = (0..circuit.vessel_count()).map(|v| if open(v) { u64::MAX } else { 0 }).collect();
        Ok(Self {
            how: match StarMesh::compile(circuit, LANES_LIMIT) {
                Some(solver) => How::SideBySide(Box::new(solver)),
                None => How::OneByOne(Box::new(Cholesky::compile(circuit).ok_or(Error::Breakdown)?)),
            },
            instructions: InstructionSet::detect(),
            grounded: grounded(circuit, open),
            stranded: stranded(circuit, &masks, LANES),
        })
    }

    /// The solver's name: `lanes` or `cholesky`.
    pub fn name(&self) -> &'static str {
        match self.how {
            How::SideBySide(_) => "lanes",
            How::OneByOne(_) => "cholesky",
        }
    }

    /// Memory for one worker.
    pub fn memory(&self) -> Memory {
        let work = match &self.how {
            How::SideBySide(solver) => Work::SideBySide { conductance: Vec::new(), mesh: Box::new(solver.workspace()) },
            How::OneByOne(_) => Work::OneByOne(Box::default()),
        };
        Memory { work, above_level: vec![Lanes::ZERO; self.grounded.len()] }
    }

    /// Solves up to [`LANES`] instances by the conductances of their vessels, m³/(Pa s).
    ///
    /// # Errors
    ///
    /// The conductances of a large circuit are too far apart for the sparse factorisation.
    pub fn solve(&self, instances: &[Vec<f64>], memory: &mut Memory) -> Result<()> {
        let Memory { work, above_level } = memory;
        match (&self.how, work) {
            (How::SideBySide(solver), Work::SideBySide { conductance, mesh }) => {
                let vessels = instances.first().map_or(0, Vec::len);
                let lanes = |vessel| Lanes(std::array::from_fn(|lane| instances.get(lane).map_or(0.0, |c| c[vessel])));
                conductance.clear();
                conductance.extend((0..vessels).map(lanes));
                self.instructions.run(SideBySide { solver, conductance, stranded: &self.stranded, work: mesh });
                above_level.iter_mut().enumerate().for_each(|(node, p)| *p = mesh.pressure[solver.slot(node)]);
            }
            (How::OneByOne(solver), Work::OneByOne(work)) => {
                for (lane, conductance) in instances.iter().enumerate() {
                    solver.solve_with(conductance, work, |node, p| above_level[node][lane] = p)?;
                }
            }
            _ => return Err(Error::Breakdown),
        }
        Ok(())
    }

    /// The pressures of an instance that has been solved, Pa above the circuit's level; `None` in floating components.
    pub fn above_level(&self, lane: usize, memory: &Memory) -> Vec<Option<f64>> {
        self.grounded.iter().zip(&memory.above_level).map(|(grounded, p)| grounded.then_some(p[lane])).collect()
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
