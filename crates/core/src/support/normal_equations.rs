//! The few equations of a least-squares fit of a curve in space.

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
