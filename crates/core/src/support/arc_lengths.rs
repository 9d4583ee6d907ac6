//! A line by the length up to each of its points, places on it, and its direction.

use super::{Point, distance};

/// The length of a line up to each of its points, which are one at least.
pub fn arc_lengths(points: impl IntoIterator<Item = Point>) -> Vec<f64> {
    let (mut before, mut length) = (None, 0.0);
    let up_to = |point| {
        length += before.replace(point).map_or(0.0, |before| distance(before, point));
        length
    };
    points.into_iter().map(up_to).collect()
}

/// A line as it is where it is `forward`, else backwards.
pub fn in_direction<T>(mut line: Vec<T>, forward: bool) -> Vec<T> {
    if !forward {
        line.reverse();
    }
    line
}

/// Where a length lies on a line of two points at least, by the length up to each of them: the last point no further along, but not its end, and the
/// share of the way from there to the next point.
pub fn place_at(arc: &[f64], length: f64) -> (usize, f64) {
    let point = arc[1..arc.len() - 1].partition_point(|at| *at <= length);
    let span = arc[point + 1] - arc[point];
    (point, if span > 0.0 { ((length - arc[point]) / span).clamp(0.0, 1.0) } else { 0.0 })
}
