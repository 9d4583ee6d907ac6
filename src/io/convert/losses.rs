//! What a format cannot hold of a network.

use super::consists_of_lines;
use super::straight_lines::has_no_course;
use crate::io::format::Format;
use crate::io::skeleton::is_straight;
use crate::io::vendors::voreen::has_whole_ids;
use crate::network::{Network, Node, Origin, RadiusRule, Vessel};
use crate::support::geometry::distance;

/// Lengths and radii that differ by less than this share are one.
const SAME: f64 = 1e-9;

/// What a format may have no place for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Thing {
    /// The centerline of a vessel between its nodes.
    Paths,
    /// A length and a radius of a vessel that are not those of its centerline.
    Figures,
    /// Ids of nodes.
    Ids,
    /// Nodes on no vessel.
    LoneNodes,
    /// What vessels state beyond geometry: origins, priors, resistances.
    Statements,
    /// What nodes state beyond geometry: labels, conditions.
    Conditions,
    /// Radii of nodes.
    Radii,
}

/// What a format has no place for in a network.
fn lacks(format: Format, network: &Network) -> Vec<Thing> {
    use Thing::{Conditions, Figures, Ids, LoneNodes, Paths, Radii, Statements};
    match format {
        Format::GraphMl | Format::Csv => vec![],
        Format::Vtp | Format::Vtk => vec![Ids, LoneNodes, Conditions],
        Format::Npz | Format::VesselVio if is_straight(network) => vec![Ids, Statements, Conditions, Radii],
        Format::Swc | Format::Npz | Format::VesselVio => vec![Figures, Ids, Statements, Conditions],
        Format::Voreen if has_whole_ids(network) => vec![Paths, Statements, Conditions, Radii],
        Format::Voreen => vec![Paths, Ids, Statements, Conditions, Radii],
        Format::Points | Format::Markups | Format::Tre | Format::ICafe | Format::VTrails => {
            vec![Figures, Ids, LoneNodes, Statements, Conditions]
        }
    }
}

/// What gets lost when the network is written in a format, in words, one thing each.
pub fn losses(network: &Network, format: Format) -> Vec<String> {
    use Thing::{Conditions, Figures, Ids, LoneNodes, Paths, Radii, Statements};
    let lacks = lacks(format, network);
    let vessels = |of: &dyn Fn([usize; 2], &Vessel) -> bool| network.vessels().filter(|(ends, v)| of(*ends, v)).count();
    let nodes = |of: &dyn Fn(&Node) -> bool| network.nodes().filter(|n| of(n)).count();
    let differs = |drawn: Option<f64>, stated: f64| drawn.is_some_and(|drawn| (drawn - stated).abs() > SAME * stated.abs());
    let degree = network.degrees(|_| true);
    let counts = [
        (Paths, vessels(&|_, v| v.path.len() > 2), "the points between the nodes of {} vessels"),
        (
            Figures,
            vessels(&|ends, v| differs(drawn_length(network, v, ends), v.length)),
            "the lengths of {} vessels that are not those of their lines",
        ),
        (
            Figures,
            vessels(&|_, v| differs(drawn_radius(v), v.radius)),
            "the radii of {} vessels that are not the mean over their points",
        ),
        (Ids, network.nodes().enumerate().filter(|(row, node)| node.id != row.to_string()).count(), "the ids of {} nodes"),
        (LoneNodes, degree.iter().filter(|d| **d == 0).count(), "{} nodes without a vessel"),
        (Radii, nodes(&|n| n.radius.is_some()), "the radii of {} nodes"),
        (Conditions, nodes(&|n| !n.label.is_empty()), "the labels of {} nodes"),
        (Conditions, nodes(&|n| n.condition.is_some()), "the boundary conditions of {} nodes"),
        (Statements, vessels(&|_, v| v.origin == Origin::Candidate), "that {} vessels are candidates"),
        (Statements, vessels(&|_, v| v.prior != 1.0), "the priors of {} vessels"),
        (Statements, vessels(&|_, v| v.evidence.is_some()), "the probabilities of {} vessels"),
        (Statements, vessels(&|_, v| v.certain), "that {} vessels are certain"),
        (Statements, vessels(&|_, v| v.resistance.is_some()), "the resistances that {} vessels state"),
    ];
    let mut lost: Vec<String> = counts
        .into_iter()
        .filter(|(thing, count, _)| *count > 0 && lacks.contains(thing))
        .map(|(_, count, what)| what.replace("{}", &count.to_string()))
        .collect();
    let joints = degree.iter().filter(|d| **d == 2).count();
    if consists_of_lines(format, network) && joints > 0 {
        lost.push(format!("{joints} nodes that join two vessels, which are read again as one"));
    }
    let without_course = (0..network.vessel_count()).filter(|row| has_no_course(network, *row)).count();
    if consists_of_lines(format, network) && without_course > 0 {
        lost.push(format!("{without_course} vessels from a node to itself, which have no course"));
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
