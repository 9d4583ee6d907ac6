//! What a format cannot hold of a network.

use super::super::skeleton::is_straight;
use super::super::sniff::Format;
use super::consists_of_lines;
use super::lines::has_no_course;
use crate::geometry::distance;
use crate::network::{Network, Node, Origin, RadiusRule, Vessel, cycles};

/// Lengths and radii that differ by less than this share are one.
const SAME: f64 = 1e-9;

/// What a format has a place for.
struct Holds {
    /// The names of vessels.
    labels: bool,
    /// The centerline of a vessel between its nodes.
    paths: bool,
    /// A length and a radius of a vessel that are not those of its centerline.
    figures: bool,
    /// Ids of nodes.
    ids: bool,
    /// Nodes on no vessel.
    lone_nodes: bool,
    /// What vessels state beyond geometry: origins, priors, resistances.
    statements: bool,
    /// What nodes state beyond geometry: labels, conditions.
    conditions: bool,
    /// Radii of nodes.
    radii: bool,
}

/// Polylines of points with radii and a name.
const LINES: Holds = Holds {
    labels: true,
    paths: true,
    figures: false,
    ids: false,
    lone_nodes: false,
    statements: false,
    conditions: false,
    radii: true,
};
const EVERYTHING: Holds = Holds { figures: true, ids: true, lone_nodes: true, statements: true, conditions: true, ..LINES };

fn holds(format: Format, network: &Network) -> Holds {
    let straight = is_straight(network);
    match format {
        Format::GraphMl | Format::Csv => EVERYTHING,
        Format::Vtp | Format::Vtk => Holds { figures: true, statements: true, ..LINES },
        Format::Swc | Format::ICafe => Holds { lone_nodes: true, ..LINES },
        Format::Npz | Format::VesselVio => Holds { lone_nodes: true, figures: straight, radii: !straight, ..LINES },
        Format::Voreen => Holds { paths: false, figures: true, ids: whole_ids(network), lone_nodes: true, radii: false, ..LINES },
        Format::Points | Format::Markups | Format::Tre | Format::VTrails => LINES,
    }
}

/// Whether all ids are whole numbers.
fn whole_ids(network: &Network) -> bool {
    network.nodes().all(|n| n.id.parse::<u64>().is_ok_and(|id| id.to_string() == n.id))
}

/// What gets lost when the network is written in a format, in words, one thing each.
pub fn losses(network: &Network, format: Format) -> Vec<String> {
    let holds = holds(format, network);
    let mut lost = Vec::new();
    let mut lose = |held: bool, count: usize, what: &str| {
        if !held && count > 0 {
            lost.push(what.replace("{}", &count.to_string()));
        }
    };
    let vessels = |of: &dyn Fn(&Vessel) -> bool| network.vessels().filter(|(_, v)| of(v)).count();
    lose(holds.labels, vessels(&|v| !v.label.is_empty()), "the labels of {} vessels");
    lose(holds.paths, vessels(&|v| v.path.len() > 2), "the points between the nodes of {} vessels");
    if !holds.figures {
        let differing = |of: &dyn Fn(&Vessel, [usize; 2]) -> Option<f64>, stated: fn(&Vessel) -> f64| {
            let differs = |(ends, v): &([usize; 2], &Vessel)| {
                of(v, *ends).is_some_and(|drawn| (drawn - stated(v)).abs() > SAME * stated(v).abs())
            };
            network.vessels().filter(differs).count()
        };
        lose(
            false,
            differing(&|v, ends| drawn_length(network, v, ends), |v| v.length),
            "the lengths of {} vessels that are not those of their lines",
        );
        lose(
            false,
            differing(&|v, _| drawn_radius(v), |v| v.radius),
            "the radii of {} vessels that are not the mean over their points",
        );
    }
    let ids = network.nodes().enumerate().filter(|(row, node)| node.id != row.to_string()).count();
    lose(holds.ids, ids, "the ids of {} nodes");
    let degree = network.degrees(|_| true);
    lose(holds.lone_nodes, degree.iter().filter(|d| **d == 0).count(), "{} nodes without a vessel");
    let nodes = |of: &dyn Fn(&Node) -> bool| network.nodes().filter(|n| of(n)).count();
    lose(holds.radii, nodes(&|n| n.radius.is_some()), "the radii of {} nodes");
    lose(holds.conditions, nodes(&|n| !n.label.is_empty()), "the labels of {} nodes");
    lose(holds.conditions, nodes(&|n| n.condition.is_some()), "the boundary conditions of {} nodes");
    lose(holds.statements, vessels(&|v| v.origin == Origin::Candidate), "that {} vessels are candidates");
    lose(holds.statements, vessels(&|v| v.prior != 1.0), "the priors of {} vessels");
    lose(holds.statements, vessels(&|v| v.certain), "that {} vessels are certain");
    lose(holds.statements, vessels(&|v| v.resistance.is_some()), "the resistances that {} vessels state");
    if consists_of_lines(format, network) {
        let lone = (0..network.vessel_count()).filter(|row| has_no_course(network, *row)).count();
        lose(false, lone, "{} vessels from a node to itself, which have no course");
    }
    if format == Format::Swc && cycles(network) > 0 {
        lost.push(format!("{} links that close loops, which go into a file beside it for --loops", cycles(network)));
    }
    lost
}

/// The length (m) of a vessel as a line; none where it has no place.
fn drawn_length(network: &Network, vessel: &Vessel, ends: [usize; 2]) -> Option<f64> {
    if vessel.path.is_empty() {
        let [a, b] = ends.map(|end| network.node(end).position);
        return Some(distance(a?, b?));
    }
    Some(vessel.path.windows(2).map(|p| distance(p[0].position, p[1].position)).sum())
}

/// The mean radius (m) over a vessel's points; none where it has none, since points are then made that keep it.
fn drawn_radius(vessel: &Vessel) -> Option<f64> {
    (!vessel.path.is_empty()).then(|| RadiusRule::Mean.radius(&vessel.path))
}
