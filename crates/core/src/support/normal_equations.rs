//! The few equations of a least-squares fit of a curve in space.

/// Solves a symmetric positive definite system of the first `terms` equations, for each of three right sides, by Gaussian elimination.
pub fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [[f64; 3]; N], terms: usize) -> [[f64; 3]; N] {
    for i in 0..terms {
        for j in i + 1..terms {
            let f = a[j][i] / a[i][i];
            for k in 0..terms {
                a[j][k] -= f * a[i][k];
            }
            for k in 0..3 {
                b[j][k] -= f * b[i][k];
            }
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
