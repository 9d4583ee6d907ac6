//! Places along a path, between its points too, and paths at even steps.

use super::PathPoint;
use crate::support::{
    arc_lengths::{arc_lengths, place_at},
    distance,
};

/// A place on a path: a share of the way from one of its points to the next.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct PathPlace {
    /// The point before it.
    pub point: usize,
    /// The share of the way to the next point, in [0, 1).
    pub share: f64,
}

impl PathPlace {
    /// Position (m) and radius (m) there; the number is that of the point, if it is one.
    pub fn on(self, path: &[PathPoint]) -> PathPoint {
        let from = path[self.point];
        match path.get(self.point + 1) {
            Some(to) if self.share > 0.0 => from.towards(*to, self.share),
            _ => from,
        }
    }
}

/// The pieces of a path between places on it, given in order: each ends with a point at a place, with which the next one begins.
pub fn divided(path: &[PathPoint], places: impl IntoIterator<Item = PathPlace>) -> Vec<Vec<PathPoint>> {
    let (mut pieces, mut piece, mut next) = (Vec::new(), Vec::new(), 0);
    for place in places {
        piece.extend_from_slice(&path[next..next.max(place.point + usize::from(place.share > 0.0))]);
        let at = place.on(path);
        piece.push(at);
        pieces.push(std::mem::replace(&mut piece, vec![at]));
        next = place.point + 1;
    }
    piece.extend_from_slice(&path[next..]);
    pieces.push(piece);
    pieces
}

/// The length of a path, m.
pub fn length_of(path: &[PathPoint]) -> f64 {
    path.windows(2).map(|w| distance(w[0].position, w[1].position)).sum()
}

/// The ends of so many equally long stretches of a path of at least two points, the first and the last point among them.
pub fn at_even_steps(path: &[PathPoint], steps: usize) -> Vec<PathPlace> {
    let arc = arc_lengths(path.iter().map(|point| point.position));
    let length = arc[arc.len() - 1];
    let place = |number: usize| {
        if number == steps {
            return PathPlace { point: path.len() - 1, share: 0.0 };
        }
        let (point, share) = place_at(&arc, length * number as f64 / steps as f64);
        PathPlace { point, share }
    };
    (0..=steps).map(place).collect()
}
