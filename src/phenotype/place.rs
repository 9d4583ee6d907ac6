//! The node of a landmark: its nearest free end or junction.

use super::landmarks::{Landmark, sites};
use crate::error::Fault;
use crate::geometry::{Point, distance, dot, lerp, norm_squared, sub};
use crate::network::{Nearest, Network, Origin, REACH, nearest};
use crate::units::millimetres;

/// A node as near as this, m, is the one that was meant, free end or not.
const EXACT: f64 = 0.001;

/// The nearest free end (of the observed vessels, where there are any) within reach, but for those that are `taken`.
pub(super) fn free_end(network: &Network, at: Point, taken: &dyn Fn(usize) -> bool) -> Option<Nearest> {
    let observed = observed_degrees(network);
    let degree = if observed.iter().any(|degree| *degree > 0) { observed } else { network.degrees(|_| true) };
    nearest(network, at, |row| degree[row] == 1 && !taken(row)).filter(|end| end.distance <= REACH)
}

fn observed_degrees(network: &Network) -> Vec<usize> {
    network.degrees(|vessel| vessel.origin == Origin::Observed)
}

/// The nearest node: of an in- or outlet a free end (of the observed vessels, where there are any) when one is near.
pub(super) fn place(network: &Network, landmark: &Landmark) -> Result<Nearest, Fault> {
    let at = landmark.position;
    let away = distance_to_lines(network, at);
    if away > REACH {
        return Err(Fault::line(
            landmark.line,
            format!("\"{}\" lies {:.1} mm from the nearest centerline", landmark.label, millimetres(away)),
            format!("expected a position within {} mm, in the axes of the network's file", millimetres(REACH)),
        ));
    }
    let nearest = |admit: &dyn Fn(usize) -> bool| nearest(network, at, admit);
    let all = network.degrees(|_| true);
    let observed = observed_degrees(network);
    // A node between two halves of a vessel that a candidate divides is none of the anatomy.
    let is_divided = |row: usize| observed[row] == 2 && all[row] > 2;
    let any = nearest(&|row| all[row] > 0 && !is_divided(row)).or_else(|| nearest(&|row| all[row] > 0));
    let is_end = sites(&landmark.arteries).iter().any(|site| site.is_end());
    if is_end
        && any.is_some_and(|any| any.distance > EXACT)
        && let Some(end) = free_end(network, at, &|_| false)
    {
        return Ok(end);
    }
    any.ok_or_else(|| Fault::file("the nodes have no coordinates", "expected positions, or vessels with labels and no landmarks"))
}

/// The distance (m) to the nearest point of any vessel.
fn distance_to_lines(network: &Network, at: Point) -> f64 {
    let straight = |ends: [usize; 2]| ends.into_iter().filter_map(|node| network.node(node).position).collect::<Vec<_>>();
    let of = |(ends, vessel): ([usize; 2], &crate::network::Vessel)| {
        let points: Vec<Point> =
            if vessel.path.is_empty() { straight(ends) } else { vessel.path.iter().map(|p| p.position).collect() };
        points.windows(2).map(|pair| to_segment(pair[0], pair[1], at)).fold(f64::INFINITY, f64::min)
    };
    network.vessels().map(of).fold(f64::INFINITY, f64::min)
}

fn to_segment(a: Point, b: Point, at: Point) -> f64 {
    let (along, square) = (sub(b, a), norm_squared(sub(b, a)));
    let share = if square > 0.0 { (dot(sub(at, a), along) / square).clamp(0.0, 1.0) } else { 0.0 };
    distance(lerp(a, b, share), at)
}
