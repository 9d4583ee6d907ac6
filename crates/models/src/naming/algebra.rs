//! Matrices of three rows: rotations, and symmetric ones as xx, yy, zz, xy, xz, yz.

#![expect(clippy::inline_always, reason = "a kernel is compiled as a whole for each instruction set")]

use willis_core::support::geometry::Point;
use willis_core::support::simd::{Kernel, Simd};

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

/// Divides by the sum, and returns it.
pub fn normalise(row: &mut [f64]) -> f64 {
    let sum: f64 = row.iter().sum();
    for p in row {
        *p /= sum;
    }
    sum
}

/// A table, by rows, times a vector.
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
    fn with_simd<S: Simd>(self, _: S) {
        for (row, out) in self.table.chunks_exact(self.by.len()).zip(self.out) {
            *out = dot(row, self.by);
        }
    }
}
