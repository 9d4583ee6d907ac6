//! What is measured of a network of vessels: each vessel between two junctions, each bifurcation, each end, and the whole.
//!
//! Nodes at which only two vessels meet divide nothing: the pieces are one vessel, unless their labels differ. So a figure does not
//! depend on how a file divides its lines.

pub mod columns;
mod figures;
mod orders;
mod vessel_lines;

pub use figures::{MeasureContext, NetworkFigures, Region, VesselTotals};
pub use orders::MeasuredBifurcation;
pub use vessel_lines::{SMOOTHING, Smoothing, VesselLine, VesselShape};

use crate::network::{Network, Role};
use figures::figures_of;
use orders::{InletWays, bifurcations, generations, strahler};

/// A vessel between two junctions or ends.
#[derive(Debug, Clone)]
pub struct MeasuredVessel {
    /// Its line, from the node that is nearer to an inlet to the other.
    pub line: VesselLine,
    /// Lengths, widths and bends.
    pub shape: VesselShape,
    /// How many vessels begin or end at its two nodes, itself included.
    pub degree: [usize; 2],
    /// How many bifurcations lie between the nearest inlet and it; none where no inlet leads to it.
    pub generation: Option<usize>,
    /// Its order after Strahler; none where no inlet leads to it.
    pub strahler: Option<usize>,
    /// Its order after Strahler where an order rises only with the diameter (Jiang, Kassab and Fung 1994).
    pub diameter_strahler: Option<usize>,
    /// The length of the way from the nearest inlet to where it begins, m; infinite where none leads there.
    pub from_inlet: f64,
    /// The product of the probabilities of all connections on that way and within it; not a number where there is none.
    pub probability: f64,
    /// The territory that the way to it or beyond it enters first.
    pub territory: Option<usize>,
}

/// An end at which no other vessel begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredEnd {
    /// The row of its node.
    pub node: usize,
    /// The row of its vessel.
    pub vessel: usize,
    /// The radius of the vessel over its last stretch, m.
    pub radius: f64,
    /// The length of the way from the nearest inlet, m; infinite where none leads there.
    pub from_inlet: f64,
}

/// All that is measured of a network.
#[derive(Debug, Clone)]
pub struct Morphometry {
    /// Vessel by vessel.
    pub vessels: Vec<MeasuredVessel>,
    /// By node, those where at least three vessels meet.
    pub bifurcations: Vec<MeasuredBifurcation>,
    /// By node.
    pub ends: Vec<MeasuredEnd>,
    /// The whole.
    pub network: NetworkFigures,
}

impl Morphometry {
    /// Measures a network; `role` says of each node whether blood enters or leaves there.
    pub fn of(network: &Network, role: impl Fn(usize) -> Role, smoothing: Smoothing, around: MeasureContext<'_>) -> Self {
        let ways = InletWays::of(network, role);
        let (bifurcations, territory) = (bifurcations(network, &ways), ways.territories(around.territory));
        let figures = figures_of(&ways, &bifurcations, &territory, around.region);
        let ((generation, probability), [strahler, diameter_strahler]) = (generations(network, &ways), strahler(&ways));
        let InletWays { lines, degree, from_inlet, .. } = ways;
        let mut ends: Vec<MeasuredEnd> = Vec::new();
        for (vessel, line) in lines.iter().enumerate() {
            for (node, last) in line.ends.into_iter().zip([false, true]).filter(|(node, _)| degree[*node] == 1) {
                ends.push(MeasuredEnd { node, vessel, radius: line.end_radius(last), from_inlet: from_inlet[node] });
            }
        }
        ends.sort_by_key(|end| end.node);
        let measured = |(row, line): (usize, VesselLine)| MeasuredVessel {
            shape: VesselShape::of(&line, smoothing),
            degree: line.ends.map(|node| degree[node]),
            generation: generation[row],
            strahler: strahler[row],
            diameter_strahler: diameter_strahler[row],
            from_inlet: from_inlet[line.ends[0]],
            probability: probability[row],
            territory: territory[row],
            line,
        };
        Self { vessels: lines.into_iter().enumerate().map(measured).collect(), bifurcations, ends, network: figures }
    }
}

/// What is measured of a network as a whole; `role` says of each node whether blood enters or leaves there.
pub fn network_figures(network: &Network, role: impl Fn(usize) -> Role, around: MeasureContext<'_>) -> NetworkFigures {
    let ways = InletWays::of(network, role);
    figures_of(&ways, &bifurcations(network, &ways), &ways.territories(around.territory), around.region)
}
