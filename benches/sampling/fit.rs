//! Least squares of relative errors.

/// The coefficients x of `terms` x ≈ `measured` with the least Σ (terms x / measured - 1)², and the largest ratio, either
/// way, between fit and measurement.
pub fn relative<const N: usize>(rows: &[([f64; N], f64)]) -> ([f64; N], f64) {
    let (mut normal, mut right) = ([[0.0; N]; N], [0.0; N]);
    for (terms, measured) in rows {
        let scaled = terms.map(|t| t / measured);
        for i in 0..N {
            right[i] += scaled[i];
            for j in 0..N {
                normal[i][j] += scaled[i] * scaled[j];
            }
        }
    }
    for k in 0..N {
        for i in k + 1..N {
            let factor = normal[i][k] / normal[k][k];
            let (above, below) = normal.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).for_each(|(b, a)| *b -= factor * a);
            right[i] -= factor * right[k];
        }
    }
    let mut x = [0.0; N];
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| normal[k][j] * x[j]).sum();
        x[k] = (right[k] - known) / normal[k][k];
    }
    let ratio = |(terms, measured): &([f64; N], f64)| {
        let fitted: f64 = terms.iter().zip(&x).map(|(t, x)| t * x).sum();
        (fitted / measured).max(measured / fitted)
    };
    (x, rows.iter().map(ratio).fold(1.0, f64::max))
}
