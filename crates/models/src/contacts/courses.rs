//! The courses of branches from the clusters they leave: smooth lines at even steps, and directions over a reach of the cluster's own size.

use super::branches::{BranchEnd, Branches, ObservedBranch};
use willis_core::network::PathPoint;
use willis_core::network::path_places::{at_even_steps, length_of};
use willis_core::support::geometry::{Point, lerp, smooth, straightest, sub, unit};

/// Points of a course are a quarter of the branch's radius apart, ...
const STEP_RADII: f64 = 0.25;
const LEAST_STEPS: usize = 2;
/// ... no more than this many, and smoothed in so many rounds of (1/4, 1/2, 1/4).
const MOST_STEPS: usize = 20_000;
const ROUNDS: usize = 8;
/// A walk passes no more than this many branches, and goes on in the direction of so many last points.
const HOPS: usize = 4;
const TAIL: usize = 8;

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

    fn reversed(&self) -> Self {
        let length = self.length();
        Self {
            arc: self.arc.iter().rev().map(|s| length - s).collect(),
            points: self.points.iter().rev().copied().collect(),
            radii: self.radii.iter().rev().copied().collect(),
        }
    }

    fn extend(&mut self, other: &Self) {
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

/// The courses of all branches.
pub struct Courses {
    of_branch: Vec<Course>,
}

impl Courses {
    /// Courses of the branches.
    pub fn new(branches: &Branches) -> Self {
        let course = |b: &ObservedBranch| {
            let course = even_course(&b.points, STEP_RADII * b.radius);
            Course { points: smooth(&course.points, ROUNDS), ..course }
        };
        Self { of_branch: branches.branches.iter().map(course).collect() }
    }

    /// The course of a branch, from its first point on.
    pub fn of(&self, branch: usize) -> &Course {
        &self.of_branch[branch]
    }

    /// The course of a branch from one of its ends.
    pub fn from(&self, end: BranchEnd) -> Course {
        if end.last { self.of_branch[end.branch].reversed() } else { self.of_branch[end.branch].clone() }
    }

    /// The course from an end of a branch at least as far as `reach`, beyond far clusters along the branch that goes on the straightest.
    pub fn walk(&self, branches: &Branches, from: BranchEnd, reach: f64) -> Course {
        let (mut course, mut end, mut seen) = (Course::default(), from, vec![from.branch]);
        loop {
            let piece = self.from(end);
            course.extend(&piece);
            let Some(cluster) = branches.cluster(end.other()) else { break };
            if course.length() >= reach || seen.len() >= HOPS {
                break;
            }
            let tail = &piece.points[piece.points.len().saturating_sub(TAIL)..];
            let along = unit(sub(tail[tail.len() - 1], tail[0]));
            let own = branches.branches[end.branch].radius;
            let others = branches.clusters[cluster].ends.iter().filter(|next| !seen.contains(&next.branch));
            let ways = others.map(|next| {
                let line = &self.of_branch[next.branch].points;
                let n = TAIL.min(line.len()) - 1;
                let [first, on] = if next.last { [line.len() - 1, line.len() - 1 - n] } else { [0, n] };
                (*next, sub(line[on], line[first]), (branches.branches[next.branch].radius / own).ln())
            });
            let Some(next) = straightest(along, ways, |score| score) else { break };
            end = next;
            seen.push(end.branch);
        }
        course
    }
}
