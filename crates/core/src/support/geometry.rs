//! Points in space and the few vector operations that centerlines need.

/// A position in m.
pub type Point = [f64; 3];

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

/// a / |a|; zero stays zero.
pub fn unit(a: Point) -> Point {
    let n = norm_squared(a).sqrt();
    if n > 0.0 { [a[0] / n, a[1] / n, a[2] / n] } else { [0.0; 3] }
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

/// The diagonal of the box around the points; zero for none.
pub fn box_diagonal(points: impl IntoIterator<Item = Point>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    if low[0] <= high[0] { distance(low, high) } else { 0.0 }
}
