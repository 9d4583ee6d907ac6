//! Blocks of samples of a large graph, reduced first to what samples can change.
//!
//! Vessels of one chain or one tree share one flow up to a factor, and so do the sums of their contributions: they are kept once, in an
//! account, and each vessel has its share of it. In a chain only the vessel of least ρ can be the one that a forest leaves out.

use super::bottleneck::Bottleneck;
use super::cost;
use super::likelihood::Sums;
use super::params::{Params, Solver, Weight};
use super::reduced_group::{Core, InLanes, LinkFlow, TreeFlow};
use super::sampler::{Block, Method};
use super::ties::Ties;
use crate::error::{Error, Result};
use crate::hemodynamics::cholesky::Cholesky;
use crate::hemodynamics::conjugate_gradients::ConjugateGradients;
use crate::hemodynamics::floating::stranded;
use crate::hemodynamics::reduction::Reduction;
use crate::hemodynamics::steady::MOST_BACKWARD;
use crate::hemodynamics::{Circuit, StarMesh};
use crate::network::Network;
use crate::resilience::resilience_per_square_flow;
use crate::simd::InstructionSet;

use std::f64::consts::PI;

pub use super::reduced_group::Workspace;

/// Everything about a reduced graph that all its samples share.
#[derive(Debug)]
pub struct Reduced {
    core: Core,
    /// Per vessel its account, and its share of it; `None` for one that never carries flow.
    shares: Vec<Option<(u32, f64)>>,
    weight: Weight,
    instructions: InstructionSet,
}

/// How pressures are found.
#[derive(Debug)]
pub enum Solve {
    Lanes(Box<StarMesh>),
    Gradients(Box<ConjugateGradients>),
    Cholesky(Box<Cholesky>),
}

impl Solve {
    fn slot(&self, node: usize) -> u32 {
        (match self {
            Self::Lanes(program) => program.slot(node),
            Self::Gradients(program) => program.slot(node),
            Self::Cholesky(_) => node,
        }) as u32
    }
}

impl Reduced {
    /// Reduces a circuit whose `certain` vessels are open in every sample, and prepares its samples.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold; a mesh beyond what indices can count.
    pub fn new(network: &Network, circuit: &Circuit, certain: &[bool], params: &Params) -> Result<Self> {
        let Reduction { circuit: core, links, trees } = Reduction::of(circuit, certain);
        // ρ of a vessel over the square of its flow.
        let of_square_flow = |row: usize| {
            let vessel = network.vessel(row);
            let factor = match vessel.resistance {
                Some(resistance) => resistance / (PI * vessel.radius * vessel.radius * vessel.length),
                None => resilience_per_square_flow(params.viscosity, vessel.radius),
            };
            if factor.is_normal() {
                return Ok(factor);
            }
            let size = format!("of length {} m and radius {} m", vessel.length, vessel.radius);
            Err(Error::parameter(network.vessel_name(row), size, "expected a resilience that a double can hold"))
        };
        let factors: Vec<Vec<f64>> =
            links.iter().map(|link| link.iter().map(|row| of_square_flow(*row)).collect()).collect::<Result<_>>()?;
        // Of equals the last is the weakest: the forest prefers the first.
        let weakest = |link: usize| (0..links[link].len()).rev().min_by(|a, b| factors[link][*a].total_cmp(&factors[link][*b]));
        let weakest: Vec<usize> = (0..links.len()).map(|link| weakest(link).unwrap_or_default()).collect();
        // Links in the order of their weakest vessels, so that theirs is the order among equals.
        let mut order: Vec<usize> = (0..links.len()).collect();
        order.sort_unstable_by_key(|link| links[*link][weakest[*link]]);
        let core = Circuit {
            ends: order.iter().map(|link| core.ends[*link]).collect(),
            conductance: order.iter().map(|link| core.conductance[*link]).collect(),
            ..core
        };

        let mut shares = vec![None; network.vessel_count()];
        let mut flows = Vec::with_capacity(links.len());
        let mut carried = links.len() + trees.len();
        for (at, link) in order.iter().enumerate() {
            let (rows, factors, weakest) = (&links[*link], &factors[*link], weakest[*link]);
            let least = factors[weakest];
            let several = (rows.len() > 1).then_some(carried as u32);
            for (member, row) in rows.iter().enumerate() {
                let account = several.filter(|_| member != weakest).unwrap_or(at as u32);
                shares[*row] = Some((account, factors[member] / least));
            }
            carried += usize::from(several.is_some());
            let own = (!certain[rows[0]]).then_some(rows[0] as u32);
            flows.push(LinkFlow {
                slots: [0; 2],
                conductance: core.conductance[at],
                factor: least,
                whole: factors.iter().map(|factor| factor / least).sum(),
                carried: several,
                mask: own,
            });
        }
        let mut hanging = Vec::with_capacity(trees.len());
        for (at, tree) in trees.iter().enumerate() {
            let mut of_square_drop = Vec::with_capacity(tree.vessels.len());
            for (row, flow) in &tree.vessels {
                of_square_drop.push(of_square_flow(*row)? * flow * flow);
            }
            let most = of_square_drop.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            for ((row, _), factor) in tree.vessels.iter().zip(&of_square_drop) {
                shares[*row] = Some(((links.len() + at) as u32, factor / most));
            }
            let whole = of_square_drop.iter().map(|factor| factor / most).sum();
            hanging.push(TreeFlow { slot: tree.node as u32, end: tree.end, factor: most, whole });
        }

        let solve = compile(&core, params.solver)?;
        for (flow, ends) in flows.iter_mut().zip(&core.ends) {
            flow.slots = ends.map(|node| solve.slot(node));
        }
        for tree in &mut hanging {
            tree.slot = solve.slot(tree.slot as usize);
        }
        let in_forest: Vec<Option<[usize; 2]>> = core.ends.iter().map(|ends| Some(*ends)).collect();
        let bottleneck = match solve {
            Solve::Lanes(_) => Bottleneck::compile(core.node_count(), &in_forest, cost::forest_limit(links.len())),
            Solve::Gradients(_) | Solve::Cholesky(_) => None,
        };
        let ties = Ties::new(&core, &flows.iter().map(|flow| flow.factor).collect::<Vec<_>>());
        Ok(Self {
            core: Core { bottleneck, ties, accounts: carried, links: flows, trees: hanging, solve, circuit: core },
            shares,
            weight: params.weight,
            instructions: InstructionSet::detect(),
        })
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        let (solver, size) = match &self.core.solve {
            Solve::Lanes(program) => ("lanes", program.updates()),
            Solve::Gradients(program) => ("gradients", program.joins()),
            Solve::Cholesky(factor) => ("cholesky", factor.factor_entries()),
        };
        Method {
            solver,
            solver_size: size,
            forest: if self.core.bottleneck.is_some() { "bottleneck" } else { "kruskal" },
            forest_joins: self.core.bottleneck.as_ref().map(Bottleneck::joins),
            instructions: self.instructions.name(),
        }
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> Workspace {
        Workspace::new(&self.core)
    }

    /// Replaces `sums` by those of a block.
    ///
    /// # Errors
    ///
    /// Pressures that do not meet Kirchhoff's law.
    pub fn block(&self, block: Block<'_>, work: &mut Workspace, sums: &mut Sums) -> Result<()> {
        work.gather(&self.core, block.masks);
        let stranded = stranded(&self.core.circuit, &work.masks, block.samples);
        let residual =
            self.instructions.run(InLanes { core: &self.core, block, stranded: &stranded, weight: self.weight, work, sums })?;
        sums.residual = residual.relative;
        if residual.backward > MOST_BACKWARD {
            return Err(Error::Breakdown);
        }
        let accounts = &work.accounts;
        for (row, share) in self.shares.iter().enumerate() {
            let (account, share) = share.map_or((None, 0.0), |(account, share)| (Some(account as usize), share));
            let of = |values: &[f64], share: f64| account.map_or(0.0, |account| share * values[account]);
            let share = if self.weight == Weight::Resilience { share } else { 1.0 };
            sums.likelihood[row] = of(&accounts.likelihood, share);
            sums.square[row] = of(&accounts.square, share * share);
            sums.count[row] = of(&accounts.count, 1.0);
        }
        Ok(())
    }
}

/// Compiles a core for the solver asked for, or for the one that is predicted to be the fastest.
fn compile(core: &Circuit, solver: Solver) -> Result<Solve> {
    match solver {
        Solver::Lanes => {
            return StarMesh::compile(core, usize::MAX).map(|program| Solve::Lanes(Box::new(program))).ok_or(Error::Breakdown);
        }
        Solver::Cholesky => return Cholesky::compile(core).map(|f| Solve::Cholesky(Box::new(f))).ok_or(Error::Breakdown),
        Solver::Gradients | Solver::Auto => {}
    }
    let gradients = ConjugateGradients::compile(core).ok_or(Error::Breakdown)?;
    let lanes = match solver {
        Solver::Auto if gradients.core() <= cost::SMALL_CORE => StarMesh::compile(core, cost::lanes_limit(&gradients)),
        _ => None,
    };
    Ok(match lanes {
        Some(program) => Solve::Lanes(Box::new(program)),
        None => Solve::Gradients(Box::new(gradients)),
    })
}
