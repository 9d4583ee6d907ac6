//! A graph whose samples are solved for masks of any origin: the step of `willis infer` with its mask as an argument.

use willis::error::Result;
use willis::internals::flow::batch::{conductances::MaskedRows, solver::BatchWorkspace};
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::floating_components::stranded;
use willis::internals::flow::poiseuille::BLOOD_VISCOSITY;
use willis::internals::flow::resilience::{is_diffused, resilience_per_square_drop};
use willis::internals::flow::{BatchSolver, Boundary, Circuit, FoundOutlets};
use willis::internals::network::Network;
use willis::internals::perturbation::Occlusion;
use willis::internals::sampling::{Coins, Kruskal, SamplingOptions, Uncertain, infer};
use willis::internals::support::simd::Scalar;

/// Samples solved side by side.
const LANES: usize = 8;
/// The seed of the block by which a model is compared with the library.
const SEED: u64 = 3;

pub struct Model {
    pub name: String,
    /// The keep probability of each vessel.
    pub keep: Vec<f64>,
    /// The vessels that share a node with each vessel.
    pub neighbours: Vec<Vec<usize>>,
    circuit: Circuit,
    program: BatchSolver,
    per_square_drop: Vec<f64>,
    /// What decides between vessels of equal resilience.
    coins: Coins,
}

/// The memory of one worker.
#[derive(Default)]
pub struct Work {
    pub masks: Vec<u64>,
    solver: Option<BatchWorkspace<LANES>>,
    resilience: Vec<[f64; LANES]>,
    forest: Kruskal,
}

impl Model {
    /// A graph with the conditions that its nodes state, every vessel uncertain, the priors of the file.
    pub fn new(name: &str, network: &Network, epsilon: f64) -> Result<Self> {
        let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground)?;
        let circuit = Circuit::new(network, &boundary, BLOOD_VISCOSITY)?;
        let program = BatchSolver::star_mesh(&circuit, usize::MAX).ok_or(willis::error::Error::Breakdown)?;
        let uncertain = Uncertain::All.vessels(network);
        let vessels = || network.vessels().map(|(_, v)| v).zip(&circuit.conductance);
        let touch = |a: [usize; 2], b: [usize; 2]| a.iter().any(|node| b.contains(node));
        let rows = 0..network.vessel_count();
        let neighbours = circuit
            .ends
            .iter()
            .enumerate()
            .map(|(row, here)| rows.clone().filter(|other| *other != row && touch(*here, circuit.ends[*other])).collect());
        let model = Self {
            name: name.to_owned(),
            keep: vessels().zip(uncertain).map(|((v, _), u)| if u { (1.0 - epsilon) * v.prior } else { 1.0 }).collect(),
            neighbours: neighbours.collect(),
            per_square_drop: vessels().map(|(v, c)| resilience_per_square_drop(*c, v.volume())).collect(),
            circuit: circuit.clone(),
            program,
            coins: Coins::new(network.vessel_count(), SEED),
        };
        model.check_against_library(network, &boundary, epsilon)?;
        Ok(model)
    }

    pub fn vessels(&self) -> usize {
        self.keep.len()
    }

    /// Solves the 64 samples of `work.masks`; calls `take` with sample, vessel and contribution for the vessels of each
    /// sample's forest.
    pub fn solve(&self, work: &mut Work, mut take: impl FnMut(usize, usize, f64)) {
        let stranded = stranded(&self.circuit, &work.masks, 64);
        let coin = self.coins.of_block(0);
        let solver = work.solver.get_or_insert_with(|| self.program.workspace());
        for first in (0..64).step_by(LANES) {
            let rows = MaskedRows { conductance: &self.circuit.conductance, masks: &work.masks, first };
            self.program.solve(Scalar::new(), &rows, first, &stranded, solver);
            let level = self.circuit.level;
            work.resilience.clear();
            let vessels = self.circuit.ends.iter().zip(&self.per_square_drop).zip(&work.masks);
            work.resilience.extend(vessels.map(|((ends, per_square_drop), mask)| {
                let [a, b] = ends.map(|node| solver.pressure()[self.program.slot(node)]);
                std::array::from_fn(|lane| {
                    let drop = a[lane] - b[lane];
                    let flows = mask >> (first + lane) & 1 == 1 && is_diffused(drop, a[lane] + level, b[lane] + level);
                    if flows { drop * drop * per_square_drop } else { 0.0 }
                })
            }));
            for lane in 0..LANES {
                work.forest.clear();
                for (vessel, resilience) in work.resilience.iter().enumerate().filter(|(_, r)| r[lane] > 0.0) {
                    work.forest.add(self.coins.key(resilience[lane], vessel, coin[first + lane]));
                }
                let resilience = &work.resilience;
                let row = |key| self.coins.vessel(key);
                work.forest.grow(self.circuit.node_count(), &self.circuit.ends, row, |vessel| {
                    take(first + lane, vessel, resilience[vessel][lane]);
                });
            }
        }
    }

    /// One block here is one block there, but for the order of the sums: the experiment measures what the program does.
    fn check_against_library(&self, network: &Network, boundary: &Boundary, epsilon: f64) -> Result<()> {
        let params =
            SamplingOptions { epsilon, samples: 64, seed: SEED, uncertain: Uncertain::All, ..SamplingOptions::default() };
        let (there, _) = infer(network, boundary, &params, &mut |_: u64, _: u64| true)?;
        let (mut work, mut here) = (Work::default(), vec![(0.0, 0.0); self.vessels()]);
        Occlusion::new(self.keep.iter().copied()).draw(SEED, 0, &mut work.masks);
        self.solve(&mut work, |_, vessel, contribution| {
            here[vessel].0 += contribution;
            here[vessel].1 += 1.0 / 64.0;
        });
        for (row, (likelihood, frequency)) in here.into_iter().enumerate() {
            assert_eq!(frequency, there.frequency[row], "{}: the step differs from the library's", self.name);
            assert!((likelihood - there.likelihood[row]).abs() <= 1e-12 * likelihood, "{}: vessel {row}", self.name);
        }
        Ok(())
    }
}
