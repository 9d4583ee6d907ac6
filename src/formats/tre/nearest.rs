//! The point of a tube nearest to another, for children that do not say where they hang.

use std::collections::HashMap;
use std::ops::Range;

use crate::geometry::{Point, distance};

/// Tubes whose points have been sorted along x.
#[derive(Default)]
pub struct Nearest {
    sorted: HashMap<usize, Vec<usize>>,
}

impl Nearest {
    /// The point of the parent and the end of the child that are nearest to one another.
    pub fn pair(&mut self, points: &[Point], parent: Range<usize>, ends: [usize; 2]) -> [usize; 2] {
        let sorted = self.sorted.entry(parent.start).or_insert_with(|| {
            let mut rows: Vec<usize> = parent.collect();
            rows.sort_by(|a, b| points[*a][0].total_cmp(&points[*b][0]));
            rows
        });
        let mut best = (f64::INFINITY, [sorted[0], ends[0]]);
        for end in ends {
            let x = points[end][0];
            let split = sorted.partition_point(|row| points[*row][0] < x);
            let (left, right) = sorted.split_at(split);
            let mut consider = |row: usize| {
                let apart = distance(points[row], points[end]);
                if apart < best.0 || (apart == best.0 && end == best.1[1] && row < best.1[0]) {
                    best = (apart, [row, end]);
                }
                (points[row][0] - x).abs() <= best.0
            };
            let _ = left.iter().rev().all(|row| consider(*row));
            let _ = right.iter().all(|row| consider(*row));
        }
        best.1
    }
}
