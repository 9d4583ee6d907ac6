//! The courses of branches: lines at even steps, with places and directions along them.

use willis_core::network::PathPoint;
use willis_core::network::path_places::{at_even_steps, length_of};
use willis_core::support::geometry::{Point, lerp, sub, unit};

/// A course has no fewer and no more steps.
const LEAST_STEPS: usize = 2;
const MOST_STEPS: usize = 20_000;

/// A line with the length along it.
#[derive(Debug, Clone, Default)]
pub struct Course {
    /// Length from the beginning to each point, m, not falling.
    pub arc: Vec<f64>,
    /// The points.
    pub points: Vec<Point>,
    /// Their radii, m.
    pub radii: Vec<f64>,
}

impl Course {
    /// The whole length, m.
    pub fn length(&self) -> f64 {
        self.arc.last().copied().unwrap_or(0.0)
    }

    /// The place at a length from the beginning, no further than the line goes.
    pub fn at(&self, arc: f64) -> Point {
        let after = self.arc.partition_point(|s| *s < arc);
        if after == 0 || after >= self.arc.len() {
            return self.points.get(after.min(self.points.len().saturating_sub(1))).copied().unwrap_or_default();
        }
        let (from, to) = (self.arc[after - 1], self.arc[after]);
        lerp(self.points[after - 1], self.points[after], (arc - from) / (to - from).max(f64::MIN_POSITIVE))
    }

    /// The direction from one length along it to another; zero where they are one place.
    pub fn direction(&self, from: f64, to: f64) -> Point {
        unit(sub(self.at(to), self.at(from)))
    }

    /// Radii of the points between two lengths, in order of the points.
    pub fn radii_between(&self, from: f64, to: f64) -> Vec<f64> {
        self.arc.iter().zip(&self.radii).filter(|(s, _)| (from..=to).contains(*s)).map(|(_, r)| *r).collect()
    }

    /// The same from its other end.
    pub(super) fn reversed(&self) -> Self {
        let length = self.length();
        Self {
            arc: self.arc.iter().rev().map(|s| length - s).collect(),
            points: self.points.iter().rev().copied().collect(),
            radii: self.radii.iter().rev().copied().collect(),
        }
    }

    /// Goes on along another line.
    pub(super) fn extend(&mut self, other: &Self) {
        let length = self.length();
        self.arc.extend(other.arc.iter().map(|s| s + length));
        self.points.extend_from_slice(&other.points);
        self.radii.extend_from_slice(&other.radii);
    }
}

/// A line through points at even steps of about `step`.
pub fn even_course(path: &[PathPoint], step: f64) -> Course {
    let length = length_of(path);
    let steps = ((length / step).ceil() as usize).clamp(LEAST_STEPS, MOST_STEPS);
    let mut course = Course::default();
    for (n, place) in at_even_steps(path, steps).into_iter().enumerate() {
        let point = place.on(path);
        course.arc.push(length * n as f64 / steps as f64);
        course.points.push(point.position);
        course.radii.push(point.radius);
    }
    course
}
