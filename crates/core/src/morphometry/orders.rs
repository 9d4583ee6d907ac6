//! Which way vessels lead from the inlets, and their orders: generation, Strahler's, and Strahler's by diameter.

use super::{VesselLine, vessel_lines::vessel_lines};
use crate::network::{Network, Role, ShortestPaths, Vessel, lengths_at};
use crate::support::counted;

/// So often orders by diameter are found again at most.
const MOST_PASSES: usize = 100;

/// The vessels of a network and the ways to them from the inlets. Each vessel is reached by the shortest way; one that closes a loop leads
/// to no other.
pub struct InletWays {
    /// The vessels, each from the end that is nearer to an inlet on.
    pub lines: Vec<VesselLine>,
    /// By node, how many lines end there.
    pub degree: Vec<usize>,
    /// By node, the length of the way from the nearest inlet, m; infinite without one.
    pub from_inlet: Vec<f64>,
    /// By node, the line by which the way arrives.
    pub arrives_by: Vec<Option<usize>>,
    /// By node, the lines that ways take from it.
    leaving: Vec<Vec<usize>>,
    /// The nodes that ways reach, the nearest first.
    reached: Vec<usize>,
}

impl InletWays {
    /// Finds the ways; `role` says of each node whether blood enters or leaves there.
    pub fn of(network: &Network, role: impl Fn(usize) -> Role) -> Self {
        let nodes = network.node_count();
        let inlets: Vec<usize> = (0..nodes).filter(|node| role(*node) == Role::Inlet).collect();
        let mut lines = vessel_lines(network, |node| role(node) != Role::Inner);
        let at = lengths_at(nodes, lines.iter().enumerate().map(|(row, line)| (row, line.ends, line.length)));
        let (mut paths, mut reached) = (ShortestPaths::new(nodes), Vec::new());
        let edges = |node: usize| at[node].iter().copied();
        paths.search(&inlets, f64::INFINITY, edges, |_, node| {
            reached.push(node);
            true
        });
        let from_inlet = paths.lengths().to_vec();
        let mut arrives_by = vec![None; nodes];
        for node in &reached {
            arrives_by[*node] = paths.previous(*node).map(|(_, line)| line);
        }
        let mut leaving = vec![Vec::new(); nodes];
        for (row, line) in lines.iter_mut().enumerate() {
            let [a, b] = line.ends.map(|node| from_inlet[node]);
            if b < a {
                line.turn();
            }
            if a.is_finite() {
                leaving[line.ends[0]].push(row);
            }
        }
        let degree = counted(nodes, lines.iter().flat_map(|line| line.ends));
        Self { lines, degree, from_inlet, arrives_by, leaving, reached }
    }

    /// By line the first territory on the way to its end, from those of the vessels.
    pub fn territories(&self, of_vessel: &[Option<usize>]) -> Vec<Option<usize>> {
        let own = |line: &VesselLine| line.pieces.iter().find_map(|row| of_vessel.get(*row).copied().flatten());
        let mut marks: Vec<Option<usize>> = self.lines.iter().map(own).collect();
        for node in &self.reached {
            let before = self.arrives_by[*node].and_then(|row| marks[row]);
            for row in &self.leaving[*node] {
                marks[*row] = before.or(marks[*row]);
            }
        }
        marks
    }
}

/// By line how many bifurcations lie before it, none where no inlet leads, and the product of the probabilities of all connections on the
/// way to its end.
pub fn generations(network: &Network, ways: &InletWays) -> (Vec<Option<usize>>, Vec<f64>) {
    let mut generation: Vec<Option<usize>> = vec![None; ways.lines.len()];
    let mut probability: Vec<f64> = ways.lines.iter().map(|line| probability_within(network, line)).collect();
    for node in &ways.reached {
        let before = ways.arrives_by[*node];
        let here = before.map_or(0, |row| generation[row].unwrap_or(0) + usize::from(ways.degree[*node] > 2));
        for row in &ways.leaving[*node] {
            generation[*row] = Some(here);
            probability[*row] *= before.map_or(1.0, |row| probability[row]);
        }
    }
    (generation, probability)
}

/// By line Strahler's order, and the same by diameter; none where no inlet leads.
pub fn strahler(ways: &InletWays) -> [Vec<Option<usize>>; 2] {
    let order = raised(ways, |_, _| true);
    let by_diameter = by_diameter(ways, &order);
    [order, by_diameter]
}

/// The product of the probabilities of the connections within a line.
fn probability_within(network: &Network, line: &VesselLine) -> f64 {
    let vessels = line.pieces.iter().map(|row| network.vessel(*row)).filter(|vessel| !vessel.certain);
    vessels.filter_map(Vessel::evidence).map(|evidence| evidence.probability).product()
}

/// Strahler's orders: that of an end is 1, that of another the largest of its children, and one more where two children have it and
/// `rises` says so of the line and that order.
fn raised(ways: &InletWays, rises: impl Fn(usize, usize) -> bool) -> Vec<Option<usize>> {
    let mut order: Vec<Option<usize>> = vec![None; ways.lines.len()];
    // The farthest first.
    for row in ways.reached.iter().rev().flat_map(|node| ways.leaving[*node].iter().copied()) {
        let end = ways.lines[row].ends[1];
        let children = ways.leaving[end].iter().filter(|_| ways.arrives_by[end] == Some(row));
        let of: Vec<usize> = children.filter_map(|child| order[*child]).collect();
        let most = of.iter().copied().max();
        order[row] = Some(most.map_or(1, |most| {
            let several = of.iter().filter(|order| **order == most).count() > 1;
            most + usize::from(several && rises(row, most))
        }));
    }
    order
}

/// Orders that rise only where the vessel is wider than its children by more than chance: than halfway from the mean and one standard
/// deviation of their order to the mean less one of the next (Jiang, Kassab and Fung 1994, doi:10.1152/jappl.1994.76.2.882).
fn by_diameter(ways: &InletWays, strahler: &[Option<usize>]) -> Vec<Option<usize>> {
    let radius: Vec<f64> = ways.lines.iter().map(VesselLine::radius).collect();
    let mut order = strahler.to_vec();
    for _ in 0..MOST_PASSES {
        let spread = |of: usize| {
            let values: Vec<f64> = order.iter().zip(&radius).filter(|(order, _)| **order == Some(of)).map(|(_, r)| *r).collect();
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            (n > 0.0).then(|| [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()])
        };
        let most = order.iter().flatten().copied().max().unwrap_or(0);
        let limit = |of: usize| match (spread(of), spread(of + 1)) {
            (Some([mean, deviation]), Some([next, of_next])) => f64::midpoint(mean + deviation, next - of_next),
            (Some([mean, deviation]), None) => mean + deviation,
            (None, _) => f64::INFINITY,
        };
        let limit: Vec<f64> = (0..=most).map(limit).collect();
        let again = raised(ways, |row, of| radius[row] > limit.get(of).copied().unwrap_or(f64::INFINITY));
        if again == order {
            break;
        }
        order = again;
    }
    order
}
