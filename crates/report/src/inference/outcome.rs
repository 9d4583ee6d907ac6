//! An inference with everything its files are made of.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::page::{ImagePlace, Segmentation};
use willis_core::decision::{Decision, ExpectedErrors, Keep, Topology};
use willis_core::flow::Boundary;
use willis_core::network::{Merged, Network, Origin, Role, merge};
use willis_core::sampling::{Likelihood, Method, SamplingOptions};
use willis_models::contacts::split::{Pairings, SuggestedCut};

/// How samples were computed, as run.json has it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SolverRecord {
    /// The solver: `lanes`, `gradients` or `reference`.
    pub flow: String,
    size: usize,
    forest: String,
    forest_joins: Option<usize>,
}

impl From<Method> for SolverRecord {
    fn from(Method { solver, solver_size, forest, forest_joins, .. }: Method) -> Self {
        Self { flow: solver.to_owned(), size: solver_size, forest: forest.to_owned(), forest_joins }
    }
}

/// The share of the samples in which blood flows below which a run is warned of.
const FEW_PERFUSED: f64 = 0.5;

/// An inference and everything its files are made of.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// The over-connected graph.
    pub network: &'a Network,
    /// The rows of its first nodes that are the input's own, which no file of a topology leaves out.
    pub own_nodes: usize,
    /// Its boundary conditions.
    pub boundary: &'a Boundary,
    /// Cuts that are suggested, the surest first.
    pub suggested_cuts: &'a [SuggestedCut],
    /// How the vessels at each opened contact may be paired.
    pub pairings: &'a [Pairings],
    /// The names of observed vessels by row, where arteries were named by their geometry.
    pub arteries: &'a [(usize, String)],
    /// What an image shows around doubtful vessels.
    pub image_places: &'a [ImagePlace],
    /// The segmentation that they were found in, where they were.
    pub segmentation: Option<&'a Segmentation>,
    /// What the samples say.
    pub result: &'a Likelihood,
    /// The rule that decided.
    pub rule: Keep,
    /// The decisions.
    pub answer: &'a Decision,
    /// Whether every decision on L is clear; `None` where the run was not to go on until it is.
    pub stable: Option<bool>,
    /// The kept graph.
    pub kept: Topology,
    /// The graph above the median.
    pub above_median: Topology,
    /// The errors that the evidence expects of the kept graph, where there is evidence.
    pub expected: Option<ExpectedErrors>,
    /// How it was sampled.
    pub sampling: &'a SamplingOptions,
    /// How the samples were computed.
    pub solver: &'a SolverRecord,
}

/// That blood flows in this share of the samples, and what raises it, where it is below one half.
pub fn few_perfused(network: &Network, boundary: &Boundary, sampling: &SamplingOptions, share: f64) -> Option<String> {
    if network.vessel_count() == 0 || share >= FEW_PERFUSED {
        return None;
    }
    let (what, so) = if share == 0.0 {
        ("in none of the samples".to_owned(), "they tell nothing of L")
    } else {
        (format!("in {:.1} % of the samples", 100.0 * share), "L rests on few")
    };
    let advice = if sampling.chance_of_an_inlet(network, boundary) < FEW_PERFUSED {
        "The inlets found lie at ends that other vessels probably join: state where blood enters, with `inlet`."
    } else if sampling.epsilon > 0.0 {
        "A smaller `epsilon` leaves more ways from inlets to outlets open."
    } else {
        "State where blood leaves, with `outlet`."
    };
    Some(format!("Blood flows {what}, so {so}. {advice}"))
}

impl Outcome<'_> {
    /// As [`few_perfused`].
    pub fn few_perfused(&self) -> Option<String> {
        few_perfused(self.network, self.boundary, self.sampling, self.result.perfused)
    }

    /// How many contacts there are: places where observed vessels may only touch.
    pub fn contacts(&self) -> usize {
        self.network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Contact).count()
    }

    /// The boundary conditions that hold in the kept topology.
    pub fn held(&self) -> Boundary {
        self.boundary.held(self.network, |row| self.answer.kept[row])
    }

    /// A topology of the vessels that are kept, with the conditions that hold there. Where only a candidate or a contact ended that is not kept,
    /// the vessel goes on: its parts are one again, but for those that were uncertain one by one.
    pub fn topology(&self, kept: &[bool]) -> Merged<'static> {
        let boundary = self.boundary.held(self.network, |row| kept[row]);
        let (graph, rows) = self.network.subgraph(|row| kept[row]);
        self.merged(&boundary, Cow::Owned(boundary.stated_in(graph)), &rows)
    }

    /// The same of the graph of the kept vessels, with their rows and the conditions that hold there; what its outlets and inner nodes state stays
    /// as it is, so that they are shared with the graph that they are of. One that is borrowed, and of which no node can go, is as it is.
    pub(super) fn merged<'g>(&self, boundary: &Boundary, graph: Cow<'g, Network>, rows: &[usize]) -> Merged<'g> {
        let mut may_go = vec![true; graph.node_count()];
        may_go[..self.own_nodes].fill(false);
        for row in rows.iter().filter(|row| self.result.uncertain[**row]) {
            self.network.ends(*row).into_iter().for_each(|node| may_go[node] = false);
        }
        let graph = match graph {
            Cow::Borrowed(_) if !may_go.contains(&true) => graph,
            graph => {
                let mut graph = graph.into_owned();
                for (row, role) in boundary.roles.iter().enumerate() {
                    let node = graph.node(row);
                    let says_nothing = node.role.is_none_or(|role| role == Role::Inner) && node.condition.is_none();
                    match role {
                        Role::Outlet if node.role != Some(Role::Inlet) => may_go[row] = false,
                        Role::Inner if says_nothing => {}
                        _ => {
                            let node = graph.node_mut(row);
                            (node.role, node.condition) = (Some(*role), boundary.condition(row));
                        }
                    }
                }
                Cow::Owned(graph)
            }
        };
        let mut merged = merge(graph, |node| may_go[node]);
        merged.parts.iter_mut().flatten().for_each(|part| *part = rows[*part]);
        merged
    }

    /// The contacts that are cut, by row.
    pub fn cuts(&self) -> impl Iterator<Item = usize> {
        let decided = self.network.vessels().zip(&self.answer.kept).enumerate();
        decided.filter(|(_, ((_, vessel), kept))| vessel.origin == Origin::Contact && !**kept).map(|(row, _)| row)
    }
}
