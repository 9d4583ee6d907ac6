//! The few equations of a least-squares fit of a curve in space.

use super::Point;

/// The equations of a fit to points, each with its weight, its terms and its place.
pub fn normal_equations<const N: usize>(rows: impl Iterator<Item = (f64, [f64; N], Point)>) -> ([[f64; N]; N], [[f64; 3]; N]) {
    let (mut a, mut b) = ([[0.0; N]; N], [[0.0; 3]; N]);
    for (weight, terms, at) in rows {
        for ((row, side), term) in a.iter_mut().zip(&mut b).zip(terms) {
            row.iter_mut().zip(terms).for_each(|(cell, other)| *cell += weight * term * other);
            side.iter_mut().zip(at).for_each(|(cell, x)| *cell += weight * term * x);
        }
    }
    (a, b)
}

/// Solves a symmetric positive definite system of the first `terms` equations, for each of three right sides, by Gaussian elimination.
pub fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [[f64; 3]; N], terms: usize) -> [[f64; 3]; N] {
    for i in 0..terms {
        let (head, side) = (a[i], b[i]);
        for j in i + 1..terms {
            let f = a[j][i] / head[i];
            a[j].iter_mut().zip(head).for_each(|(cell, above)| *cell -= f * above);
            b[j].iter_mut().zip(side).for_each(|(cell, above)| *cell -= f * above);
        }
    }
    let mut x = [[0.0; 3]; N];
    for i in (0..terms).rev() {
        for k in 0..3 {
            let known: f64 = (i + 1..terms).map(|j| a[i][j] * x[j][k]).sum();
            x[i][k] = (b[i][k] - known) / a[i][i];
        }
    }
    x
}
