//! The modulation run: fixed blocks of instances over the worker threads, each drawn from a stream of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::class::Class;
use super::instances::Instances;
use super::options::ModulationOptions;
use super::solver::{LANES, Memory, Solver};
use crate::error::{Error, Result};
use crate::flow::circuit::conductances;
use crate::flow::floating::drives_flow;
use crate::flow::state::State;
use crate::flow::{Boundary, Circuit, Factors, Tube};
use crate::network::Network;
use crate::sampling::Progress;
use crate::support::random;
use crate::support::random::{BLOCK, stream};

/// A network under modulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Modulation {
    /// The one instance without modulation.
    pub unperturbed: Instances,
    /// The instances of each class.
    pub classes: Vec<(Class, Instances)>,
    /// The flow solver: `lanes` or `gradients`.
    pub solver: &'static str,
}

/// Draws and solves the instances of every class.
///
/// Instance i of a class depends on the seed, the place of the class among the classes, and i alone; a vessel's draws do not
/// depend on which other vessels are modulated.
///
/// # Errors
///
/// A parameter or a vessel out of its range, boundary conditions that drive no flow, a breakdown of the solver, or a stop by `progress`.
pub fn modulate(
    network: &Network,
    boundary: &Boundary,
    params: &ModulationOptions,
    progress: &mut impl Progress,
) -> Result<Modulation> {
    params.validate()?;
    drives_flow(network, boundary)?;
    let tubes = Tube::at_rest(network, params.viscosity);
    let circuit = Circuit::of_tubes(network, boundary, &tubes)?;
    let mut unperturbed = Instances::default();
    let at_rest = State::solve(network, boundary, &tubes, params.viscosity)?;
    unperturbed.push(&at_rest, &tubes, &vec![Factors::ONE; tubes.len()], &circuit.ends);
    let job = Job { network, boundary, params, tubes: &tubes, circuit: &circuit, solver: Solver::new(&circuit)? };

    let blocks = params.samples.div_ceil(BLOCK);
    let total = params.samples * params.classes.len() as u64;
    let stop = AtomicBool::new(false);
    let heard = Mutex::new((0, progress));
    let one_block = |memory: &mut Memory, task: u64| -> Result<Instances> {
        if stop.load(Ordering::Relaxed) {
            return Ok(Instances::default());
        }
        let instances = job.block((task / blocks) as usize, task % blocks, memory)?;
        let (done, progress) = &mut *heard.lock().unwrap_or_else(PoisonError::into_inner);
        *done += instances.count() as u64;
        if !progress.report(*done, total) {
            stop.store(true, Ordering::Relaxed);
        }
        Ok(instances)
    };
    let tasks = 0..blocks * params.classes.len() as u64;
    let solved: Vec<Result<Instances>> = tasks.into_par_iter().map_init(|| job.solver.memory(), one_block).collect();
    let done = heard.lock().unwrap_or_else(PoisonError::into_inner).0;
    if done < total && stop.load(Ordering::Relaxed) {
        return Err(Error::Stopped { done, total });
    }
    let mut solved = solved.into_iter();
    let mut classes = Vec::with_capacity(params.classes.len());
    for class in &params.classes {
        let mut instances = Instances::default();
        for block in solved.by_ref().take(blocks as usize) {
            instances.append(block?);
        }
        classes.push((*class, instances));
    }
    Ok(Modulation { unperturbed, classes, solver: job.solver.name() })
}

/// What all blocks share.
struct Job<'a> {
    network: &'a Network,
    boundary: &'a Boundary,
    params: &'a ModulationOptions,
    tubes: &'a [Tube],
    circuit: &'a Circuit,
    solver: Solver<'a>,
}

impl Job<'_> {
    /// One block of a class, shorter when it is the last one.
    fn block(&self, class: usize, block: u64, memory: &mut Memory) -> Result<Instances> {
        let ModulationOptions { classes, samples, seed, reading, vessels, viscosity } = self.params;
        let mut rng = stream(*seed, random::modulation(class, block));
        let modulated = |row: usize| vessels.as_ref().is_none_or(|vessels| vessels[row]);
        let mut instances = Instances::default();
        let mut left = (samples - block * BLOCK).min(BLOCK) as usize;
        while left > 0 {
            let group = left.min(LANES);
            left -= group;
            let (mut factors, mut tubes, mut conductance) = (Vec::new(), Vec::new(), Vec::new());
            for _ in 0..group {
                let drawn = (0..self.tubes.len()).map(|_| reading.draw(classes[class], &mut rng)).enumerate();
                let drawn: Vec<Factors> = drawn.map(|(row, f)| if modulated(row) { f } else { Factors::ONE }).collect();
                let changed: Vec<Tube> = drawn.iter().zip(self.tubes).map(|(factors, tube)| tube.times(factors)).collect();
                conductance.push(conductances(self.network, &changed)?);
                factors.push(drawn);
                tubes.push(changed);
            }
            self.solver.solve(&conductance, memory)?;
            for (lane, (tubes, factors)) in tubes.iter().zip(&factors).enumerate() {
                let above_level = self.solver.above_level(lane, memory);
                let state = State::at_pressures(self.circuit, self.boundary, tubes, *viscosity, &above_level);
                instances.push(&state, tubes, factors, &self.circuit.ends);
            }
        }
        Ok(instances)
    }
}
