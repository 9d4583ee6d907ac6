//! Bifurcations: angles, asymmetry, and Murray's exponent.

use super::{VesselLine, orders::InletWays};
use crate::network::Network;
use crate::support::{Point, cross, dot, grouped, norm_squared, sub, unit};

/// The direction and the width of a vessel are those between so many and so many radii of the widest vessel there.
const STRETCH: [f64; 2] = [2.0, 6.0];
/// Murray's exponent is looked for up to here.
const MOST_EXPONENT: f64 = 1e3;

/// A node where three or more vessels meet. Figures are missing where nobody knows them: directions without positions.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredBifurcation {
    /// The row of its node.
    pub node: usize,
    /// How many vessel ends meet.
    pub degree: usize,
    /// The vessel by which blood comes from the nearest inlet; without an inlet the widest.
    pub parent: usize,
    /// The other vessels, the widest first.
    pub children: Vec<usize>,
    /// Of the parent and the two widest children, m.
    pub radii: [f64; 3],
    /// Between the two widest children, rad.
    pub angle: f64,
    /// From the direction of the parent to that of each of them, rad; zero goes straight on.
    pub bends: [f64; 2],
    /// The narrower of the two by the wider.
    pub asymmetry: f64,
    /// The sum of the children's cross-sections over the parent's.
    pub area_ratio: f64,
    /// k in r^k = Σ r_child^k; none where a child is as wide as the parent, since no k fulfils it then.
    pub murray: Option<f64>,
    /// Between the direction of the parent and the plane of the two children, rad; zero is flat.
    pub elevation: f64,
}

/// A vessel end at a bifurcation.
struct Leg {
    line: usize,
    radius: f64,
    direction: Option<Point>,
}

/// The bifurcations of a network, by node.
pub fn bifurcations(network: &Network, ways: &InletWays) -> Vec<MeasuredBifurcation> {
    let lines = &ways.lines;
    let ends = lines.iter().enumerate().flat_map(|(row, line)| [(line.ends[0], (row, false)), (line.ends[1], (row, true))]);
    let ends = grouped(network.node_count(), ends);
    let measured = |node: usize| {
        let widest = ends[node].iter().map(|(line, _)| lines[*line].radius()).fold(0.0, f64::max);
        let position = network.node(node).position;
        let legs = ends[node].iter().map(|(line, last)| leg(&lines[*line], *line, *last, widest, position)).collect();
        bifurcation(node, legs, ways.arrives_by[node])
    };
    (0..network.node_count()).filter(|node| ways.degree[*node] > 2).map(measured).collect()
}

fn bifurcation(node: usize, mut legs: Vec<Leg>, arrives_by: Option<usize>) -> MeasuredBifurcation {
    let degree = legs.len();
    legs.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let first = arrives_by.and_then(|row| legs.iter().position(|leg| leg.line == row)).unwrap_or(0);
    let parent = legs.remove(first);
    let ratios: Vec<f64> = legs.iter().map(|leg| leg.radius / parent.radius).collect();
    let angle = |a: Option<Point>, b: Option<Point>| a.zip(b).map_or(f64::NAN, |(a, b)| dot(a, b).clamp(-1.0, 1.0).acos());
    let onwards = parent.direction.map(|d| d.map(|x| -x));
    let flat = legs[0].direction.zip(legs[1].direction).map(|(a, b)| cross(a, b)).filter(|n| norm_squared(*n) > 1e-12);
    MeasuredBifurcation {
        node,
        degree,
        parent: parent.line,
        radii: [parent.radius, legs[0].radius, legs[1].radius],
        angle: angle(legs[0].direction, legs[1].direction),
        bends: [0, 1].map(|child| angle(onwards, legs[child].direction)),
        asymmetry: legs[1].radius / legs[0].radius,
        area_ratio: ratios.iter().map(|ratio| ratio * ratio).sum(),
        murray: murray(&ratios),
        elevation: flat.zip(onwards).map_or(f64::NAN, |(n, d)| dot(unit(n), d).abs().min(1.0).asin()),
        children: legs.into_iter().map(|leg| leg.line).collect(),
    }
}

fn leg(line: &VesselLine, row: usize, last: bool, widest: f64, position: Option<Point>) -> Leg {
    let [near, far] = STRETCH.map(|radii| (radii * widest).min(line.length));
    // A short vessel has the direction and the width of all of it.
    let near = if far - near > 0.25 * (STRETCH[1] - STRETCH[0]) * widest { near } else { 0.0 };
    let radius = if last { line.radius_between(line.length - far, line.length - near) } else { line.radius_between(near, far) };
    let from = if near > 0.0 { line.place(near, last) } else { position };
    let direction = from.zip(line.place(far, last)).map(|(a, b)| sub(b, a)).filter(|d| norm_squared(*d) > 0.0).map(unit);
    Leg { line: row, radius, direction }
}

/// The k > 0 at which the k-th powers of the ratios add up to 1, by bisection. Their sum falls with k if every ratio is below 1, from more than
/// 1 to 0, so there is just one; else there is none.
fn murray(ratios: &[f64]) -> Option<f64> {
    if ratios.iter().any(|ratio| !(*ratio > 0.0 && *ratio < 1.0)) {
        return None;
    }
    let sum = |k: f64| ratios.iter().map(|ratio| ratio.powf(k)).sum::<f64>();
    let [mut low, mut high] = [0.0, MOST_EXPONENT];
    if sum(high) > 1.0 {
        return None;
    }
    while high - low > 1e-12 * high {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if sum(middle) > 1.0 { low = middle } else { high = middle }
    }
    Some(high)
}
