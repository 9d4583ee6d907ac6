//! Matrices of three rows: rotations, and symmetric ones as xx, yy, zz, xy, xz, yz.

#![expect(clippy::inline_always, reason = "a kernel is compiled as a whole for each instruction set")]

use std::slice::ChunksExact;

use willis_core::support::geometry::Point;
use willis_core::support::simd::{Kernel, Lanes, Simd};

/// A matrix by rows.
pub type Matrix3 = [[f64; 3]; 3];
/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub type Symmetric = [f64; 6];

/// The unit matrix.
pub const UNIT: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A v.
pub fn times(a: &Matrix3, v: Point) -> Point {
    [0, 1, 2].map(|i| a[i][0] * v[0] + a[i][1] * v[1] + a[i][2] * v[2])
}

/// A B.
pub fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j]))
}

/// Aᵀ.
pub fn transposed(a: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[j][i]))
}

/// v vᵀ.
pub fn outer(v: Point) -> Symmetric {
    [v[0] * v[0], v[1] * v[1], v[2] * v[2], v[0] * v[1], v[0] * v[2], v[1] * v[2]]
}

/// The full matrix of a symmetric one.
pub fn full(s: &Symmetric) -> Matrix3 {
    [[s[0], s[3], s[4]], [s[3], s[1], s[5]], [s[4], s[5], s[2]]]
}

/// S v.
pub fn symmetric_times(s: &Symmetric, v: Point) -> Point {
    times(&full(s), v)
}

/// R S Rᵀ.
pub fn turned(r: &Matrix3, s: &Symmetric) -> Symmetric {
    let m = product(&product(r, &full(s)), &transposed(r));
    [m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]]
}

/// The trace of the product of two symmetric matrices.
pub fn trace_of_product(a: &Symmetric, b: &Symmetric) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// The inverse of a positive definite matrix and the logarithm of its determinant.
pub fn inverse(s: &Symmetric) -> (Symmetric, f64) {
    let [a, b, c, d, e, f] = *s;
    let minors = [b * c - f * f, a * c - e * e, a * b - d * d, e * f - d * c, d * f - e * b, d * e - a * f];
    let determinant = a * minors[0] + d * minors[3] + e * minors[4];
    (minors.map(|m| m / determinant), determinant.ln())
}

/// The rotation by a vector: its axis, and its length as the angle in radians.
pub fn rotation(v: Point) -> Matrix3 {
    let angle = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if angle < 1e-12 {
        return UNIT;
    }
    let k = v.map(|x| x / angle);
    let cross = [[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]];
    let square = product(&cross, &cross);
    let (sine, rest) = (angle.sin(), 1.0 - angle.cos());
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| UNIT[i][j] + sine * cross[i][j] + rest * square[i][j]))
}

/// The vector of a rotation, by way of its quaternion.
pub fn rotation_vector(r: &Matrix3) -> Point {
    let trace = r[0][0] + r[1][1] + r[2][2];
    // The largest of the four squares first, so that nothing is divided by a small number.
    let squares = [1.0 + trace, 1.0 + 2.0 * r[0][0] - trace, 1.0 + 2.0 * r[1][1] - trace, 1.0 + 2.0 * r[2][2] - trace];
    let largest = (0..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    let s = squares[largest].max(0.0).sqrt();
    let [w, x, y, z] = match largest {
        0 => [s * s, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]],
        1 => [r[2][1] - r[1][2], s * s, r[0][1] + r[1][0], r[0][2] + r[2][0]],
        2 => [r[0][2] - r[2][0], r[0][1] + r[1][0], s * s, r[1][2] + r[2][1]],
        _ => [r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], s * s],
    }
    .map(|q| 0.5 * q / s);
    let sine = (x * x + y * y + z * z).sqrt();
    if sine < 1e-12 {
        return [0.0; 3];
    }
    let angle = 2.0 * sine.atan2(w.abs()) * if w < 0.0 { -1.0 } else { 1.0 };
    [x, y, z].map(|q| q / sine * angle)
}

/// The sum of products.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight sums side by side, which vector instructions add up.
    let mut sums = [0.0; 8];
    let (chunks_a, chunks_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = chunks_a.remainder().iter().zip(chunks_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in chunks_a.zip(chunks_b) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// The largest of some numbers: eight side by side, so that none waits for another.
pub fn largest(row: &[f64]) -> f64 {
    let mut most = [f64::NEG_INFINITY; 8];
    for chunk in row.chunks(8) {
        most.iter_mut().zip(chunk).for_each(|(most, x)| *most = if x > most { *x } else { *most });
    }
    most.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// Divides by the sum, and returns it.
pub fn normalise(row: &mut [f64]) -> f64 {
    let sum: f64 = row.iter().sum();
    for p in row {
        *p /= sum;
    }
    sum
}

/// Rows of a table that are multiplied side by side, so that none waits for its own sums.
const ROWS: usize = 4;

/// A table, by rows, times a vector: [`dot`] of each row.
pub struct TableTimes<'a> {
    /// The rows, each as long as the vector.
    pub table: &'a [f64],
    /// The vector.
    pub by: &'a [f64],
    /// A figure for each row.
    pub out: &'a mut [f64],
}

impl Kernel for TableTimes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.by.len();
        let whole = n - n % 8;
        let mut rows = self.table.chunks_exact(ROWS * n);
        let mut outs = self.out.chunks_exact_mut(ROWS);
        for (rows, outs) in rows.by_ref().zip(outs.by_ref()) {
            let rows = [0, 1, 2, 3].map(|row| &rows[row * n..][..n]);
            // The eight sums of [`dot`] for each row.
            let mut sums = [[simd.splat_f64s(0.0); 8]; ROWS];
            let [a, b, c, d] = rows.map(|row| eights::<S>(&row[..whole]));
            for ((((x, a), b), c), d) in eights::<S>(&self.by[..whole]).zip(a).zip(b).zip(c).zip(d) {
                for (sums, row) in sums.iter_mut().zip([a, b, c, d]) {
                    for ((sum, x), y) in sums.iter_mut().zip(x).zip(row) {
                        *sum = simd.add_f64s(*sum, simd.mul_f64s(*y, *x));
                    }
                }
            }
            for ((out, row), sums) in outs.iter_mut().zip(rows).zip(sums) {
                let mut eight = Lanes::<8>::ZERO;
                eight.vectors_mut::<S>().iter_mut().zip(sums).for_each(|(to, sum)| *to = sum);
                let rest: f64 = row[whole..].iter().zip(&self.by[whole..]).map(|(x, y)| x * y).sum();
                *out = eight.iter().sum::<f64>() + rest;
            }
        }
        for (row, out) in rows.remainder().chunks_exact(n).zip(outs.into_remainder()) {
            *out = dot(row, self.by);
        }
    }
}

/// Eight numbers at a time, as vectors.
#[inline(always)]
fn eights<S: Simd>(numbers: &[f64]) -> ChunksExact<'_, S::f64s> {
    S::as_simd_f64s(numbers).0.chunks_exact(8 / S::F64_LANES)
}

/// A sum of the rows of a table, each with a weight, added to a vector row by row; rows without weight are left out.
pub struct AddRows<'a> {
    /// The rows, each as long as the vector.
    pub table: &'a [f64],
    /// A weight for each row.
    pub weights: &'a [f64],
    /// The vector.
    pub out: &'a mut [f64],
}

impl Kernel for AddRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (row, weight) in self.table.chunks_exact(self.out.len()).zip(self.weights).filter(|(_, weight)| **weight > 0.0) {
            self.out.iter_mut().zip(row).for_each(|(out, x)| *out += weight * x);
        }
    }
}
