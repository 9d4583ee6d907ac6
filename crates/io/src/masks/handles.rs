//! Handles of a mask that are noise: loops around a hole that is narrower than the vessels around it, as a segmenter leaves them within
//! one lumen or between two that touch.
//!
//! A loop lives, in the distance to the wall, from the depth of its weakest neck inside down to the width of its hole outside: the
//! persistence of Edelsbrunner, Letscher and Zomorodian, "Topological persistence and simplification" (2002). Where the hole is narrower
//! than the vessels, the loop is opened at its weakest neck.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::skeleton::{Branch, Skeleton};
use willis_core::support::geometry::{Point, distance, lerp};

/// Loops longer than so many of their own radii are not looked at: what they go around is no hole of one vessel.
const LONGEST: f64 = 60.0;
/// A loop is not looked for beyond so many nodes: in a sponge it would be looked for all over.
const MOST_NODES: usize = 1000;
/// Places along the way from a loop to its middle where its hole is looked for.
const STEPS: usize = 4;

/// What is known of a branch.
pub struct Course {
    /// The points from end to end, mm.
    pub points: Vec<Point>,
    /// The distance of each to the wall, mm.
    pub depths: Vec<f64>,
    length: f64,
}

impl Course {
    /// A branch through points with their depths.
    pub fn new(points: Vec<Point>, depths: Vec<f64>) -> Self {
        let length = points.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
        Self { points, depths, length }
    }

    /// The depth of its narrowest place between the ends.
    fn neck(&self) -> f64 {
        self.depths.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Outward direction at an end.
    fn direction(&self, is_last: bool) -> Point {
        let n = self.points.len();
        let (tip, step): (usize, isize) = if is_last { (n - 1, -1) } else { (0, 1) };
        let far = 1.5 * self.depths[tip] + 1.0;
        let mut at = tip;
        while distance(self.points[at], self.points[tip]) < far {
            let Some(next) = at.checked_add_signed(step).filter(|next| *next < n) else { break };
            at = next;
        }
        willis_core::support::geometry::unit(willis_core::support::geometry::sub(self.points[at], self.points[tip]))
    }

    /// Its length outside of the lumens at its ends.
    fn free_length(&self) -> f64 {
        self.length - self.depths.first().copied().unwrap_or(0.0) - self.depths.last().copied().unwrap_or(0.0)
    }
}

/// Opens the narrow loops of a skeleton, and returns how many there were. `course` tells the course of a branch, `is_clear` whether no
/// voxel of a vessel lies within a distance (mm) of a place.
pub fn open_narrow_loops(
    graph: &mut Skeleton,
    course: impl Fn(&Skeleton, &Branch) -> Course,
    is_clear: impl Fn(Point, f64) -> bool,
    resolution: f64,
) -> usize {
    let mut opened = 0;
    loop {
        let courses: Vec<Course> = graph.branches.iter().map(|branch| course(graph, branch)).collect();
        let mut at: Vec<Vec<usize>> = vec![Vec::new(); graph.nodes.len()];
        for (row, branch) in graph.branches.iter().enumerate() {
            branch.ends.iter().for_each(|end| at[*end].push(row));
        }
        let mut gone = vec![false; courses.len()];
        for row in 0..courses.len() {
            if gone[row] {
                continue;
            }
            let Some(cycle) = shortest_loop(graph, &courses, &at, &gone, row) else { continue };
            let mut depths: Vec<f64> = cycle.iter().flat_map(|row| courses[*row].depths.iter().copied()).collect();
            depths.sort_unstable_by(f64::total_cmp);
            let alpha: f64 = std::env::var("WILLIS_HA").ok().and_then(|v| v.parse().ok()).unwrap_or(1.0);
            let radius = alpha * depths[depths.len() / 2].max(resolution);
            if is_narrow(&cycle, &courses, radius, &is_clear) {
                let rule: u32 = std::env::var("WILLIS_HV").ok().and_then(|v| v.parse().ok()).unwrap_or(0);
                let weakest = |row: &&usize| {
                    let course = &courses[**row];
                    let ends = graph.branches[**row].ends;
                    let straight = || {
                        let of = |is_last: bool| {
                            let node = ends[usize::from(is_last)];
                            let own = course.direction(is_last);
                            let mut best: f64 = -1.0;
                            for other in at[node].iter().filter(|other| !gone[**other] && **other != **row) {
                                let e = graph.branches[*other].ends;
                                for last in [false, true] {
                                    if e[usize::from(last)] == node {
                                        best =
                                            best.max(-willis_core::support::geometry::dot(own, courses[*other].direction(last)));
                                    }
                                }
                            }
                            best
                        };
                        (of(false), of(true))
                    };
                    let d = (course.depths[0]).min(course.depths[course.depths.len() - 1]).max(1e-9);
                    match rule {
                        0 => (course.neck(), course.free_length()),
                        1 => (course.free_length(), 0.0),
                        2 => (course.neck() / d, course.free_length()),
                        3 => {
                            let (a, b) = straight();
                            (a + b, 0.0)
                        }
                        4 => {
                            let (a, b) = straight();
                            (a.max(b), 0.0)
                        }
                        5 => {
                            let (a, b) = straight();
                            (a + b + 2.0 * course.neck() / d, 0.0)
                        }
                        6 => {
                            let (a, b) = straight();
                            (a.min(b), 0.0)
                        }
                        7 => {
                            let (a, b) = straight();
                            (a + b + course.free_length().max(0.0) / radius / 3.0, 0.0)
                        }
                        8 => (course.neck() + 0.3 * course.free_length().max(0.0), 0.0),
                        _ => {
                            let (a, b) = straight();
                            (a + b + course.neck() / radius + course.free_length().max(0.0) / radius / 6.0, 0.0)
                        }
                    }
                };
                let weakest =
                    cycle.iter().min_by(|a, b| weakest(a).partial_cmp(&weakest(b)).unwrap_or(std::cmp::Ordering::Equal));
                let env = |name: &str, usual: f64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(usual);
                let chosen = *weakest.unwrap_or(&row);
                let length: f64 = cycle.iter().map(|row| courses[*row].length).sum();
                let is_pinhole = length < env("WILLIS_HL", 1e9) * radius;
                let straightest = {
                    let ends = graph.branches[chosen].ends;
                    let mut most: f64 = -1.0;
                    for last in [false, true] {
                        let node = ends[usize::from(last)];
                        let own = courses[chosen].direction(last);
                        for other in at[node].iter().filter(|other| !gone[**other] && **other != chosen) {
                            let e = graph.branches[*other].ends;
                            for l in [false, true] {
                                if e[usize::from(l)] == node {
                                    most = most.max(-willis_core::support::geometry::dot(own, courses[*other].direction(l)));
                                }
                            }
                        }
                    }
                    most
                };
                let is_rung =
                    straightest < env("WILLIS_HT", 2.0) && courses[chosen].free_length() < env("WILLIS_HF", 1e9) * radius;
                if is_pinhole || is_rung {
                    gone[chosen] = true;
                    opened += 1;
                }
            }
        }
        if !gone.contains(&true) {
            return opened;
        }
        graph.remove(&gone);
    }
}

/// Whether the hole of a loop is nowhere as wide as a radius: at no place on the ways from the loop to its middle.
fn is_narrow(cycle: &[usize], courses: &[Course], radius: f64, is_clear: &impl Fn(Point, f64) -> bool) -> bool {
    let points = || cycle.iter().flat_map(|row| courses[*row].points.iter().copied());
    let length: f64 = cycle.iter().map(|row| courses[*row].length).sum();
    if length > LONGEST * radius {
        return false;
    }
    let (sum, count) = points().fold(([0.0; 3], 0.0), |(sum, n), p| ([0, 1, 2].map(|k| sum[k] + p[k]), n + 1.0));
    let middle = sum.map(|x| x / count);
    !points().any(|point| (0..STEPS).any(|step| is_clear(lerp(middle, point, step as f64 / STEPS as f64), radius)))
}

/// The shortest loop through a branch, as rows of branches.
fn shortest_loop(graph: &Skeleton, courses: &[Course], at: &[Vec<usize>], gone: &[bool], row: usize) -> Option<Vec<usize>> {
    let [from, to] = graph.branches[row].ends;
    if from == to {
        return Some(vec![row]);
    }
    // Lengths are not negative, so that their bits are in their order.
    let mut best: BTreeMap<usize, (f64, usize)> = BTreeMap::from([(from, (0.0, usize::MAX))]);
    let mut open = BinaryHeap::from([Reverse((0_u64, from))]);
    while let Some(Reverse((bits, node))) = open.pop() {
        let so_far = f64::from_bits(bits);
        if node == to {
            let (mut cycle, mut node) = (vec![row], to);
            while let Some((_, by)) = best.get(&node).filter(|(_, by)| *by != usize::MAX) {
                cycle.push(*by);
                let [a, b] = graph.branches[*by].ends;
                node = if a == node { b } else { a };
            }
            return Some(cycle);
        }
        if best.get(&node).is_some_and(|(length, _)| *length < so_far) {
            continue;
        }
        if best.len() > MOST_NODES {
            return None;
        }
        for by in at[node].iter().copied().filter(|by| *by != row && !gone[*by]) {
            let [a, b] = graph.branches[by].ends;
            let next = if a == node { b } else { a };
            let length = so_far + courses[by].length;
            if best.get(&next).is_none_or(|(known, _)| length < *known) {
                best.insert(next, (length, by));
                open.push(Reverse((length.to_bits(), next)));
            }
        }
    }
    None
}
