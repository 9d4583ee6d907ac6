//! Points in space and the few vector operations that centerlines need.

use super::ties::steady;

/// A position in m.
pub type Point = [f64; 3];

/// What a way on gains by being wider, against the cosine of its bend.
const WIDER: f64 = 0.3;

/// a - b.
pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + s (b - a).
pub fn lerp(a: Point, b: Point, s: f64) -> Point {
    [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])]
}

/// The inner product.
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|².
pub fn norm_squared(a: Point) -> f64 {
    dot(a, a)
}

/// |a|.
pub fn norm(a: Point) -> f64 {
    norm_squared(a).sqrt()
}

/// |a - b|.
pub fn distance(a: Point, b: Point) -> f64 {
    norm(sub(a, b))
}

/// How far along the stretch between two points the point of it lies that is nearest to a place, as a share, and how far away it is.
pub fn onto(at: Point, from: Point, to: Point) -> (f64, f64) {
    let along = sub(to, from);
    let square = norm_squared(along);
    let share = if square > 0.0 { (dot(along, sub(at, from)) / square).clamp(0.0, 1.0) } else { 0.0 };
    (share, distance(at, lerp(from, to, share)))
}

/// How far a box, by its least and its largest coordinates, is from another one, along the axis where that is most; zero where they meet.
pub fn apart([least, most]: [Point; 2], [low, high]: [Point; 2]) -> f64 {
    let gap = |k: usize| (least[k] - high[k]).max(low[k] - most[k]).max(0.0);
    (0..3).map(gap).fold(0.0, f64::max)
}

/// The mean of some points; zero for none.
pub fn centroid(points: impl IntoIterator<Item = Point>) -> Point {
    weighted_centroid(points.into_iter().map(|point| (point, 1.0))).unwrap_or_default()
}

/// The mean of some points, each with a weight; `None` where all the weights are zero.
pub fn weighted_centroid(points: impl IntoIterator<Item = (Point, f64)>) -> Option<Point> {
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for (p, weight) in points {
        sum = [0, 1, 2].map(|k| sum[k] + weight * p[k]);
        total += weight;
    }
    (total > 0.0).then(|| sum.map(|x| x / total))
}

/// a / |a|; zero stays zero.
pub fn unit(a: Point) -> Point {
    let n = norm_squared(a).sqrt();
    if n > 0.0 { [a[0] / n, a[1] / n, a[2] / n] } else { [0.0; 3] }
}

/// A line after so many rounds in which every point but the first and the last becomes a mean of itself and its neighbours, weighted (1/4, 1/2, 1/4).
pub fn smooth(points: &[Point], rounds: usize) -> Vec<Point> {
    let mut points = points.to_vec();
    for _ in 0..rounds {
        let before = points.clone();
        for (w, point) in before.windows(3).zip(points.iter_mut().skip(1)) {
            *point = [0, 1, 2].map(|k| 0.25 * w[0][k] + 0.5 * w[1][k] + 0.25 * w[2][k]);
        }
    }
    points
}

/// Of some ways on from a line that runs along a unit vector, the one that goes on the best, of equal ones the first. Each has its direction, which
/// counts by the cosine of the bend, and the ln of its radius over that of the line.
pub fn straightest<W>(along: Point, ways: impl Iterator<Item = (W, Point, f64)>) -> Option<W> {
    let mut best: Option<(f64, W)> = None;
    for (way, to, wider) in ways {
        let score = steady(dot(along, unit(to)) + WIDER * wider);
        if best.as_ref().is_none_or(|(most, _)| score > *most) {
            best = Some((score, way));
        }
    }
    best.map(|(_, way)| way)
}

/// The radius of a circle of an area, sqrt(a/π).
pub fn radius_of(area: f64) -> f64 {
    (area / std::f64::consts::PI).sqrt()
}

/// The area of a circle, πr²: of the neighbouring numbers the one from which [`radius_of`] gives the radius back.
pub fn area_of(radius: f64) -> f64 {
    let area = std::f64::consts::PI * radius * radius;
    let near = [area, area.next_up(), area.next_down(), area.next_up().next_up(), area.next_down().next_down()];
    near.into_iter().find(|a| radius_of(*a) == radius).unwrap_or(area)
}

/// The lowest and the highest corner of the box around the points; infinite and the wrong way round for none.
pub fn bounds(points: impl IntoIterator<Item = Point>) -> [Point; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    [low, high]
}

/// The diagonal of the box around the points; zero for none.
pub fn box_diagonal(points: impl IntoIterator<Item = Point>) -> f64 {
    let [low, high] = bounds(points);
    if low[0] <= high[0] { distance(low, high) } else { 0.0 }
}
