//! The forest alone, of the same samples: in lanes, by Kruskal's algorithm here, by that of petgraph.

use std::hint::black_box;

use petgraph::algo::min_spanning_tree;
use petgraph::data::Element;
use petgraph::graph::{NodeIndex, UnGraph};
use willis::internals::flow::BatchSolver;
use willis::internals::sampling::{Coins, ForestProgram, Kruskal};

use crate::Result;
use crate::case::Case;
use crate::clock::per_call;
use crate::stages;

/// Seconds for each figure.
const BUDGET: f64 = 0.3;
const SAMPLES: usize = 64;

/// Microseconds a sample of Kruskal's algorithm in the library.
pub fn kruskal(case: &Case, samples: &[Vec<u64>], budget: f64) -> f64 {
    let ends: Vec<[usize; 2]> = case.network.vessels().map(|(ends, _)| ends).collect();
    let (mut forest, coins) = (Kruskal::default(), Coins::new(ends.len(), 0));
    let time = per_call(budget, || {
        for keys in samples {
            forest.clear();
            keys.iter().filter(|k| **k > 0).for_each(|k| forest.add(*k));
            forest.grow(
                case.network.node_count(),
                &ends,
                |key| coins.vessel(key),
                |vessel| {
                    black_box(vessel);
                },
            );
        }
    });
    time / samples.len() as f64
}

/// Prints one CSV row: lanes, Kruskal, petgraph with building its graphs, petgraph with graphs that are ready.
pub fn print(case: &Case) -> Result<()> {
    let pieces = case.pieces()?;
    let solver = BatchSolver::star_mesh(&pieces.circuit, usize::MAX).ok_or("no program")?;
    let nodes = case.network.node_count();
    let program = ForestProgram::compile(nodes, &pieces.in_forest, usize::MAX).ok_or("no forest program")?;
    let keys = pieces.keys(&solver, SAMPLES);
    let ends: Vec<[usize; 2]> = case.network.vessels().map(|(ends, _)| ends).collect();

    let lanes = stages::forest(&program, &keys, BUDGET);
    let here = kruskal(case, &keys, BUDGET);
    let each = |run: &mut dyn FnMut(usize)| per_call(BUDGET, || (0..SAMPLES).for_each(&mut *run)) / SAMPLES as f64;
    let build = |keys: &[u64]| {
        let mut graph = UnGraph::<(), f64>::with_capacity(nodes, keys.len());
        (0..nodes).for_each(|_| {
            graph.add_node(());
        });
        for (key, [a, b]) in keys.iter().zip(&ends).filter(|(key, _)| **key > 0) {
            graph.add_edge(NodeIndex::new(*a), NodeIndex::new(*b), 1.0 / f64::from_bits(*key));
        }
        graph
    };
    let grow = |graph: &UnGraph<(), f64>| {
        for element in min_spanning_tree(graph) {
            if let Element::Edge { weight, .. } = element {
                black_box(weight);
            }
        }
    };
    let with_build = each(&mut |sample| grow(&build(&keys[sample])));
    let ready: Vec<UnGraph<(), f64>> = keys.iter().map(|keys| build(keys)).collect();
    let without = each(&mut |sample| grow(&ready[sample]));
    println!("{lanes:.4},{here:.4},{with_build:.4},{without:.4}");
    Ok(())
}
