//! The modulation run: the worker threads share fixed blocks of instances, and each block has its own stream of random numbers. Of each
//! instance of a class the pressures, flows and other figures are kept.
//!
//! The options of a resistance modulation: its classes, and what a modulation by u does to a vessel.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::{f64::consts::PI, fmt};

use rand::{Rng, RngExt};
use rayon::prelude::*;

use crate::error::{Error, Result, ensure, require};
use crate::flow::pressures::{Check, MOST_BACKWARD};
use crate::flow::{
    BLOOD_VISCOSITY, BatchSolver, Boundary, Circuit, Factors, Tube, Unfed, check_viscosity, drives_flow, grounded, stranded,
};
use crate::flow::{batch::solver::BatchWorkspace, circuit::conductances, state::State};
use crate::support::random::{BLOCK, stream};
use crate::support::simd::{InstructionSet, Kernel, Lanes, Simd};
use crate::support::{Distribution, limits, random};
use crate::{network::Network, sampling::Progress};

/// Instances solved side by side.
const LANES: usize = 8;

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
/// Instance i of a class depends only on the seed, on the position of the class among the classes, and on i. What a vessel draws
/// does not depend on which other vessels are modulated.
///
/// # Errors
///
/// An option out of its range, boundary conditions that drive no flow, a breakdown of the solver, or a stop by `progress`.
pub fn modulate(
    network: &Network,
    boundary: &Boundary,
    params: &ModulationOptions,
    progress: &mut (impl Progress + ?Sized),
) -> Result<Modulation> {
    params.validate()?;
    check_memory(network, params)?;
    drives_flow(network, boundary)?;
    let tubes = Tube::at_rest(network, params.viscosity);
    let circuit = Circuit::new(network, boundary, params.viscosity)?;
    let mut unperturbed = Instances::default();
    let at_rest = State::solve(network, boundary, &tubes, params.viscosity)?;
    unperturbed.push(&at_rest, &tubes, &vec![Factors::ONE; tubes.len()], &circuit.ends);
    let open = |vessel: usize| circuit.conductance[vessel] > 0.0;
    let masks: Vec<u64> = (0..tubes.len()).map(|v| if open(v) { u64::MAX } else { 0 }).collect();
    let (solver, instructions) = (BatchSolver::for_few(&circuit)?, InstructionSet::detect());
    let (grounded, stranded) = (grounded(&circuit, open), stranded(&circuit, &masks, LANES));
    let job = Job { network, boundary, params, tubes: &tubes, circuit: &circuit, solver, instructions, grounded, stranded };

    let blocks = params.samples.div_ceil(BLOCK);
    let total = params.samples * params.classes.len() as u64;
    let stop = AtomicBool::new(false);
    let listener = Mutex::new((0, progress));
    let solve_block = |work: &mut BatchWorkspace<LANES>, task: u64| -> Result<Instances> {
        if stop.load(Ordering::Relaxed) {
            return Ok(Instances::default());
        }
        let instances = job.block((task / blocks) as usize, task % blocks, work)?;
        let (done, progress) = &mut *listener.lock().unwrap_or_else(PoisonError::into_inner);
        *done += instances.count() as u64;
        if !progress.report(*done, total) {
            stop.store(true, Ordering::Relaxed);
        }
        Ok(instances)
    };
    let tasks = 0..blocks * params.classes.len() as u64;
    let solved: Vec<Result<Instances>> = tasks.into_par_iter().map_init(|| job.solver.workspace(), solve_block).collect();
    let done = listener.lock().unwrap_or_else(PoisonError::into_inner).0;
    ensure(done >= total || !stop.load(Ordering::Relaxed), || Error::Stopped { done, total })?;
    let mut classes: Vec<(Class, Instances)> = params.classes.iter().map(|class| (*class, Instances::default())).collect();
    for (task, block) in solved.into_iter().enumerate() {
        classes[task / blocks as usize].1.append(block?);
    }
    let solver = job.solver.name();
    Ok(Modulation { unperturbed, classes, solver })
}

/// What all blocks share.
struct Job<'a> {
    network: &'a Network,
    boundary: &'a Boundary,
    params: &'a ModulationOptions,
    tubes: &'a [Tube],
    circuit: &'a Circuit,
    solver: BatchSolver,
    instructions: InstructionSet,
    /// For each node whether it is connected to a boundary condition. Modulation opens and closes no vessel, so this and the next hold
    /// for all instances.
    grounded: Vec<bool>,
    /// The nodes whose injected flow cannot leave.
    stranded: Vec<(usize, u64)>,
}

impl Job<'_> {
    /// One block of a class; the last one may be shorter.
    fn block(&self, class: usize, block: u64, work: &mut BatchWorkspace<LANES>) -> Result<Instances> {
        let ModulationOptions { classes, samples, seed, reading, vessels, .. } = self.params;
        let mut rng = stream(*seed, random::modulation(class, block));
        let is_modulated = |row: usize| vessels.as_ref().is_none_or(|vessels| vessels[row]);
        let mut instances = Instances::default();
        let mut left = (samples - block * BLOCK).min(BLOCK) as usize;
        while left > 0 {
            let group = left.min(LANES);
            left -= group;
            let (mut factors, mut tubes) = (Vec::new(), Vec::new());
            for _ in 0..group {
                let drawn = (0..self.tubes.len()).map(|_| reading.draw(classes[class], &mut rng)).enumerate();
                let drawn: Vec<Factors> = drawn.map(|(row, f)| if is_modulated(row) { f } else { Factors::ONE }).collect();
                tubes.push(drawn.iter().zip(self.tubes).map(|(factors, tube)| tube.times(factors)).collect::<Vec<Tube>>());
                factors.push(drawn);
            }
            let states = self.states(&tubes, work)?;
            for ((state, tubes), factors) in states.iter().zip(&tubes).zip(&factors) {
                instances.push(state, tubes, factors, &self.circuit.ends);
            }
        }
        Ok(instances)
    }

    /// Solves up to [`LANES`] instances.
    fn states(&self, instances: &[Vec<Tube>], work: &mut BatchWorkspace<LANES>) -> Result<Vec<State>> {
        let each: Vec<Vec<f64>> = instances.iter().map(|tubes| conductances(self.network, tubes)).collect::<Result<_>>()?;
        let lanes = |vessel| Lanes(std::array::from_fn(|lane| each.get(lane).map_or(0.0, |conductance| conductance[vessel])));
        let rows: Vec<Lanes<LANES>> = (0..self.tubes.len()).map(lanes).collect();
        self.instructions.run(SideBySide { job: self, rows: &rows, work });
        let pressure = |node: usize, lane: usize| work.pressure()[self.solver.slot(node)][lane];
        if self.solver.core().is_some() {
            for (lane, own) in each.iter().enumerate() {
                let at = |node| pressure(node, lane);
                if Check::default().residual(self.circuit, |vessel| own[vessel], &self.stranded, at).backward > MOST_BACKWARD {
                    return Err(Error::Breakdown);
                }
            }
        }
        let above_level = |node: usize, lane: usize| self.grounded[node].then(|| pressure(node, lane));
        let state = |(lane, tubes): (usize, &Vec<Tube>)| {
            let above_level: Vec<_> = (0..self.grounded.len()).map(|node| above_level(node, lane)).collect();
            State::at_pressures(self.circuit, self.boundary, tubes, self.params.viscosity, &above_level, Some(&self.solver))
        };
        Ok(instances.iter().enumerate().map(state).collect())
    }
}

/// Refuses a run whose figures do not fit into memory: 8 bytes for each pressure of a node, for seven figures of a vessel and two of the network,
/// in blocks and then in tables.
fn check_memory(network: &Network, params: &ModulationOptions) -> Result<()> {
    /// Blocks and tables, and the copies that tables and histograms are sorted in.
    const TIMES: f64 = 2.5;
    let figures = (network.node_count() + 7 * network.vessel_count() + 2) as f64;
    let each = 8.0 * TIMES * figures * params.classes.len() as f64;
    limits::fits_memory("samples", params.samples, each * params.samples as f64, |left| left / each)
}

/// A group of instances for the vector kernel.
struct SideBySide<'a> {
    job: &'a Job<'a>,
    rows: &'a Vec<Lanes<LANES>>,
    work: &'a mut BatchWorkspace<LANES>,
}

impl Kernel for SideBySide<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.job.solver.solve(simd, self.rows, 0, &self.job.stranded, self.work);
    }
}

/// The figures of the instances of a class. A table has one row per instance; a row has one figure per node or vessel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Instances {
    /// By node, Pa; NaN in floating components.
    pub pressure: Vec<f64>,
    /// Pressure drop by vessel, Pa, positive from its first node to its second.
    pub drop: Vec<f64>,
    /// Flow by vessel, m³/s, with the sign of the drop.
    pub flow: Vec<f64>,
    /// Resilience by vessel, W/m³.
    pub resilience: Vec<f64>,
    /// Hypertension force by vessel, Pa/m²; NaN in floating components.
    pub force: Vec<f64>,
    /// The factor that multiplied the resistance, by vessel.
    pub resistance_factor: Vec<f64>,
    /// The factor that multiplied the radius, by vessel.
    pub radius_factor: Vec<f64>,
    /// The factor that multiplied the length, by vessel.
    pub length_factor: Vec<f64>,
    /// ρ_G by instance, W/m³.
    pub network_resilience: Vec<f64>,
    /// The total inflow through the nodes with a boundary condition, by instance, m³/s.
    pub inflow: Vec<f64>,
}

impl Instances {
    /// Adds an instance.
    pub fn push(&mut self, state: &State, tubes: &[Tube], factors: &[Factors], ends: &[[usize; 2]]) {
        self.pressure.extend(state.pressure.iter().map(|p| p.unwrap_or(f64::NAN)));
        self.drop.extend(state.vessels.iter().map(|v| v.drop));
        self.flow.extend(state.vessels.iter().map(|v| v.flow));
        self.resilience.extend(state.vessels.iter().map(|v| v.resilience));
        self.force
            .extend(tubes.iter().zip(ends).map(|(tube, ends)| hypertension_force(ends.map(|n| state.pressure[n]), tube.radius)));
        self.resistance_factor.extend(factors.iter().map(|f| f.resistance));
        self.radius_factor.extend(factors.iter().map(|f| f.radius));
        self.length_factor.extend(factors.iter().map(|f| f.length));
        self.network_resilience.push(state.network_resilience);
        self.inflow.push(state.inflow);
    }

    /// Adds the instances of a later block.
    pub fn append(&mut self, mut later: Self) {
        for (table, later) in self.tables().into_iter().zip(later.tables()) {
            table.append(later);
        }
    }

    fn tables(&mut self) -> [&mut Vec<f64>; 10] {
        let Self { pressure, drop, flow, resilience, force, .. } = self;
        let Self { resistance_factor, radius_factor, length_factor, network_resilience, inflow, .. } = self;
        [pressure, drop, flow, resilience, force, resistance_factor, radius_factor, length_factor, network_resilience, inflow]
    }

    /// How many instances there are.
    pub fn count(&self) -> usize {
        self.inflow.len()
    }

    /// The distribution of one column of a table with `width` figures per instance, over the instances; `unit` converts each figure.
    pub fn column(table: &[f64], width: usize, at: usize, unit: impl Fn(f64) -> f64) -> Distribution {
        Distribution::of(table.iter().skip(at).step_by(width).map(|x| unit(*x)).collect())
    }

    /// For each instance of a table with `width` figures per instance, the mean of `figure` over the columns that `counts` selects;
    /// NaN figures are left out.
    pub fn means(table: &[f64], width: usize, counts: &[bool], figure: impl Fn(f64) -> f64) -> Vec<f64> {
        let mean = |row: &[f64]| mean_of(row.iter().zip(counts).filter(|(_, counts)| **counts).map(|(x, _)| figure(*x)));
        table.chunks_exact(width).map(mean).collect()
    }
}

/// The hypertension force of a vessel, Pa/m²: the mean of the pressures (Pa) at its two ends divided by its cross-section π r², with
/// the radius r (m) where it is narrowest. The paper calls it a force; it is large in a thin vessel. NaN without pressures.
pub fn hypertension_force(ends: [Option<f64>; 2], radius: f64) -> f64 {
    match ends {
        [Some(a), Some(b)] => f64::midpoint(a, b) / (PI * radius * radius),
        _ => f64::NAN,
    }
}

/// The mean without NaN figures; NaN when all are.
fn mean_of(figures: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = figures.filter(|x| !x.is_nan()).fold((0.0, 0.0), |(sum, n), x| (sum + x, n + 1.0));
    sum / n
}

/// The largest number of classes.
const MOST_CLASSES: usize = 12;
/// The largest number of instances of a class: memory holds the figures of all of them.
const MOST_SAMPLES: u64 = 1 << 24;

/// A class of modulation: u is drawn uniformly in [low, high).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// At least 0.
    pub low: f64,
    /// Above `low` and below 1.
    pub high: f64,
}

/// What a modulation by u means. The paper names the classes and leaves this open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reading {
    /// The resistance grows: R (1 + u).
    #[default]
    Increment,
    /// The conductance shrinks: R / (1 - u).
    Conductance,
    /// The resistance shrinks: R (1 - u).
    Literal,
    /// The lumen shrinks and the vessel grows longer, by two independent draws: radius r (1 - u1), length l (1 + u2), so
    /// that the resistance is R (1 + u2)/(1 - u1)⁴ and the volume V (1 - u1)² (1 + u2).
    Geometry,
}

/// How resistances are modulated.
#[derive(Debug, Clone, PartialEq)]
pub struct ModulationOptions {
    /// The classes: 1 to 12 of them, no two alike.
    pub classes: Vec<Class>,
    /// Instances of each class, 1 to 2²⁴.
    pub samples: u64,
    /// The seed.
    pub seed: u64,
    /// What a modulation means.
    pub reading: Reading,
    /// For each vessel whether it is modulated; `None` modulates all.
    pub vessels: Option<Vec<bool>>,
    /// Blood viscosity µ, Pa s, positive.
    pub viscosity: f64,
    /// What becomes of vessels that no inlet feeds, where an input is modulated.
    pub unfed: Unfed,
}

impl Class {
    /// The classes of the paper.
    pub const PAPER: [Self; 3] = [Self { low: 0.0, high: 0.2 }, Self { low: 0.2, high: 0.3 }, Self { low: 0.3, high: 0.5 }];
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.low, self.high)
    }
}

impl Reading {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["increment", "conductance", "literal", "geometry"][self as usize]
    }

    /// Draws the modulation of one vessel.
    pub fn draw(self, class: Class, rng: &mut impl Rng) -> Factors {
        let mut draw = || rng.random_range(class.low..class.high);
        let u = draw();
        let of_resistance = |resistance| Factors { resistance, ..Factors::ONE };
        match self {
            Self::Increment => of_resistance(1.0 + u),
            Self::Conductance => of_resistance(1.0 / (1.0 - u)),
            Self::Literal => of_resistance(1.0 - u),
            Self::Geometry => {
                let (radius, length) = (1.0 - u, 1.0 + draw());
                Factors { resistance: length / radius.powi(4), volume: radius * radius * length, radius, length }
            }
        }
    }
}

impl Default for ModulationOptions {
    fn default() -> Self {
        Self {
            classes: Class::PAPER.to_vec(),
            samples: 1000,
            seed: 0,
            reading: Reading::default(),
            vessels: None,
            viscosity: BLOOD_VISCOSITY,
            unfed: Unfed::Keep,
        }
    }
}

impl ModulationOptions {
    /// Checks every field but `vessels`.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let count = self.classes.len();
        let accepted = format!("expected 1 to {MOST_CLASSES} classes");
        require((1..=MOST_CLASSES).contains(&count), "classes", format!("of {count}"), accepted)?;
        for (at, class) in self.classes.iter().enumerate() {
            let refused = |why: &str| Error::parameter("classes", class, why);
            if class.low >= class.high {
                return Err(refused("the class ends before it begins; expected LOW:HIGH with 0 <= low < high < 1"));
            }
            ensure(class.low >= 0.0 && class.high < 1.0, || refused("expected LOW:HIGH with 0 <= low < high < 1"))?;
            ensure(!self.classes[..at].contains(class), || refused("given twice; expected each class once"))?;
        }
        require((1..=MOST_SAMPLES).contains(&self.samples), "samples", self.samples, "expected a number from 1 to 2^24")?;
        check_viscosity(self.viscosity)
    }
}
