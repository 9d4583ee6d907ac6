//! Candidates as pairs of points: both directions are one pair.

use std::collections::BTreeMap;

use super::features::Extraction;
use super::search::EndCandidate;

/// The candidates of one search as pairs of points, both directions together.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairs {
    /// Per candidate its pair.
    pub of: Vec<usize>,
    /// Per pair its points, the lower first.
    pub points: Vec<[usize; 2]>,
    /// Per pair its first candidate.
    pub first: Vec<usize>,
}

impl Pairs {
    /// The pairs, in the order of their first candidates.
    pub fn new(e: &Extraction, candidates: &[EndCandidate]) -> Self {
        let mut number = BTreeMap::new();
        let mut this = Self { of: Vec::with_capacity(candidates.len()), points: Vec::new(), first: Vec::new() };
        for (row, c) in candidates.iter().enumerate() {
            let points = unordered(c.points(e));
            let pair = *number.entry(points).or_insert_with(|| {
                this.points.push(points);
                this.first.push(row);
                this.points.len() - 1
            });
            this.of.push(pair);
        }
        this
    }

    /// Per pair the sum of a quantity over its candidates.
    pub fn sum(&self, of_candidate: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.points.len()];
        for (pair, x) in self.of.iter().zip(of_candidate) {
            sum[*pair] += x;
        }
        sum
    }

    /// Per pair the mean of a quantity over its candidates.
    pub fn mean(&self, of_candidate: &[f64]) -> Vec<f64> {
        let count = self.sum(&vec![1.0; self.of.len()]);
        self.sum(of_candidate).iter().zip(count).map(|(sum, n)| sum / n).collect()
    }
}

/// Two numbers, the lower first.
pub fn unordered([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
