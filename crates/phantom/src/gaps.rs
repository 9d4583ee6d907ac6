//! Gaps as the only damage: the middle of some vessels is missing, everything else is complete and exact.

use rand::seq::index;

use super::damage::{Breaks, SampledVessel};
use super::extraction::extract;
use super::truth::{Break, BreakKind, Truth};
use super::{add_node, check_positions, check_range};
use willis_core::error::{Error, Result};
use willis_core::network::centerlines::Centerlines;
use willis_core::network::{Network, Origin, PathPoint, Role, Vessel, fragments};
use willis_core::support::random::{self, stream};
use willis_models::candidates::search::join_nearest;

/// How many vessels are interrupted, and the distance of centerline points.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaps {
    /// The share of the vessels that lose about their middle third, 0 to 1. Their number is exact, to rounding.
    pub share: f64,
    /// The seed; it may equal that of the anatomy.
    pub seed: u64,
    /// Distance between centerline points, m, positive; `None` gives a vessel two points, an interrupted one four.
    pub spacing: Option<f64>,
}

impl Gaps {
    /// The rows of the interrupted vessels, in order.
    ///
    /// # Errors
    ///
    /// A share out of its range, a node without position.
    fn choose(&self, network: &Network) -> Result<Vec<usize>> {
        check_range("share", self.share, 0.0, 1.0)?;
        check_positions(network)?;
        let count = (self.share * network.vessel_count() as f64).round() as usize;
        let mut rows = index::sample(&mut stream(self.seed, random::GAPS), network.vessel_count(), count).into_vec();
        rows.sort_unstable();
        Ok(rows)
    }

    /// A vessel at equal steps, without its middle third where it is interrupted.
    fn sampled(&self, network: &Network, row: usize, interrupted: bool) -> SampledVessel {
        let steps = |length: f64| self.spacing.map_or(1.0, |spacing| (length / spacing).round()).max(1.0) as usize;
        let mut vessel = SampledVessel::at(network, row, |length| steps(length).max(if interrupted { 3 } else { 1 }));
        if interrupted {
            let (last, third) = (vessel.last(), (vessel.last() as f64 / 3.0).round() as usize);
            vessel.pieces = vec![[0, third], [last - third, last]];
        }
        vessel
    }
}

/// The centerlines of a network with gaps, and the true answer. Points are numbered as by [`super::extraction::break_up`].
///
/// # Errors
///
/// A share out of its range, a node without position.
pub fn with_gaps(network: &Network, gaps: &Gaps) -> Result<(Centerlines, Truth)> {
    let mut interrupted = gaps.choose(network)?.into_iter().peekable();
    let sampled = |row: usize| gaps.sampled(network, row, interrupted.next_if_eq(&row).is_some());
    let vessels: Vec<SampledVessel> = (0..network.vessel_count()).map(sampled).collect();
    let params = Breaks { jitter: 0.0, radius_noise: 0.0, radius_bias: 0.0, spurious: 0.0, ..Breaks::default() };
    // The random order of fragments and points uses a later part of the stream than the gaps.
    let mut rng = stream(gaps.seed, random::GAPS);
    rng.set_word_pos(1 << 40);
    Ok(extract(network, &vessels, &params, &mut rng))
}

/// The same gaps in a graph that is over-connected: candidates join both loose ends of every gap to their `k` nearest nodes.
///
/// The nodes keep their rows, ids and conditions. The loose ends follow, two per gap, with the next numbers as ids. Two vessels replace
/// an interrupted one. Candidates come last ([`join_nearest`]). The ids in the answer are those of the nodes, which must be the numbers
/// from 1 in order, as in the large phantoms.
///
/// # Errors
///
/// A share out of its range, a node without position or with another id.
pub fn over_connected(network: Network, gaps: &Gaps, k: usize) -> Result<(Network, Truth)> {
    let chosen = gaps.choose(&network)?;
    if let Some((row, node)) = network.nodes().enumerate().find(|(row, node)| node.id.parse() != Ok(row + 1)) {
        return Err(Error::parameter("node", &node.id, format!("expected {} as its id", row + 1)));
    }
    let mut truth = Truth {
        vessels: network.vessels().map(|(_, vessel)| vessel.label.clone()).collect(),
        inlets: (1..).zip(network.nodes()).filter(|(_, n)| n.role == Some(Role::Inlet)).map(|(id, _)| id).collect(),
        points: widest_vessels(&network),
        ..Truth::default()
    };
    let (complete, mut graph) = (network.node_count(), Network::new());
    let sampled: Vec<SampledVessel> = chosen.iter().map(|row| gaps.sampled(&network, *row, true)).collect();
    let (nodes, vessels) = network.into_parts();
    for node in nodes {
        graph.add_node(node);
    }
    let mut interrupted = chosen.into_iter().zip(sampled).peekable();
    for (row, (ends, vessel)) in vessels.enumerate() {
        let Some((_, sampled)) = interrupted.next_if(|(next, _)| *next == row) else {
            graph.add_vessel(ends, vessel);
            continue;
        };
        let [near, far] = [sampled.pieces[0], sampled.pieces[1]];
        let loose = [near[1], far[0]].map(|at| {
            let (position, radius) = sampled.points[at];
            truth.points.push(Some(row));
            add_node(&mut graph, position, Some(radius))
        });
        let label = vessel.label;
        for (ends, piece) in [([ends[0], loose[0]], near), ([loose[1], ends[1]], far)] {
            let points = || sampled.points[piece[0]..=piece[1]].iter();
            let path = points().map(|(position, radius)| PathPoint { position: *position, radius: *radius, id: None });
            let path = if vessel.path.is_empty() { Vec::new() } else { path.collect() };
            let length = sampled.step * (piece[1] - piece[0]) as f64;
            graph.add_vessel(ends, Vessel { label: label.clone(), path, ..Vessel::new(length, vessel.radius, Origin::Observed) });
        }
        let stretch = [near[1], far[0]].map(|at| at as f64 * sampled.step);
        let ids = loose.map(|node| node as u64 + 1);
        truth.breaks.push(Break { ids, kind: BreakKind::Vessel, vessel: row, label, stretch });
    }
    truth.spurious = vec![false; fragments(&graph, |_, _| true).count];
    let ends: Vec<usize> = (complete..graph.node_count()).collect();
    join_nearest(&mut graph, &ends, k);
    Ok((graph, truth))
}

/// For each node the row of its widest vessel.
fn widest_vessels(network: &Network) -> Vec<Option<usize>> {
    let mut widest: Vec<Option<usize>> = vec![None; network.node_count()];
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        for end in ends {
            if widest[end].is_none_or(|widest| vessel.radius > network.vessel(widest).radius) {
                widest[end] = Some(row);
            }
        }
    }
    widest
}
