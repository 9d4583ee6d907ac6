//! The point of a tube nearest to another, for children that do not say where they hang.

use std::collections::HashMap;
use std::ops::Range;

use crate::geometry::{Point, distance};

/// Tubes whose points have been sorted along their longest axis.
#[derive(Default)]
pub struct Nearest {
    sorted: HashMap<usize, (usize, Vec<usize>)>,
}

impl Nearest {
    /// The point of the parent and the end of the child that are nearest to one another.
    pub fn pair(&mut self, points: &[Point], parent: Range<usize>, ends: [usize; 2]) -> [usize; 2] {
        let (axis, sorted) = self.sorted.entry(parent.start).or_insert_with(|| sort(points, parent));
        let x = |row: usize| points[row][*axis];
        let mut best = (f64::INFINITY, [sorted[0], ends[0]]);
        for end in ends {
            let (left, right) = sorted.split_at(sorted.partition_point(|row| x(*row) < x(end)));
            let mut consider = |row: &usize| {
                let apart = distance(points[*row], points[end]);
                if apart < best.0 || (apart == best.0 && end == best.1[1] && *row < best.1[0]) {
                    best = (apart, [*row, end]);
                }
                (x(*row) - x(end)).abs() <= best.0
            };
            let _ = left.iter().rev().all(&mut consider);
            let _ = right.iter().all(consider);
        }
        best.1
    }
}

/// The axis along which points extend the most, and their rows in its order.
fn sort(points: &[Point], range: Range<usize>) -> (usize, Vec<usize>) {
    let extent = |axis: usize| {
        let x = || points[range.clone()].iter().map(|p| p[axis]);
        x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
    };
    let axis = (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(0);
    let mut rows: Vec<usize> = range.collect();
    rows.sort_by(|a, b| points[*a][axis].total_cmp(&points[*b][axis]));
    (axis, rows)
}
