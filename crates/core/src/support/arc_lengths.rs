//! A line by the length up to each of its points, walks along it, and its direction.

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

/// A walk along a line of two points at least, by the length up to each of them.
pub struct ArcWalk<'a> {
    arc: &'a [f64],
    point: usize,
}

impl<'a> ArcWalk<'a> {
    /// At the beginning.
    pub fn new(arc: &'a [f64]) -> Self {
        Self { arc, point: 0 }
    }

    /// The last point no further along the line than a length, but not its end, and the share of the way from there to the next point. No length
    /// is shorter than the one before.
    pub fn to(&mut self, length: f64) -> (usize, f64) {
        while self.point + 2 < self.arc.len() && self.arc[self.point + 1] <= length {
            self.point += 1;
        }
        let span = self.arc[self.point + 1] - self.arc[self.point];
        (self.point, if span > 0.0 { ((length - self.arc[self.point]) / span).clamp(0.0, 1.0) } else { 0.0 })
    }
}
