//! The course of a vessel as it is drawn: its radius averaged along it and its corners calmed, for display only.

/// x, y, z and radius, mm.
pub type CoursePoint = [f64; 4];

/// Radii are averaged over so many radii to either side, as on the page.
const REACH: f64 = 6.0;
/// An inner point moves at most so many radii.
const MOST: f64 = 0.3;

/// The course with the mean of its piecewise linear radius over 6 mean radii to either side of each point, by the trapezoid rule, and
/// with each inner point half way nearer to the line between its neighbours, by at most 0.3 radii. The ends stay where they are.
pub fn smoothed(course: &[CoursePoint]) -> Vec<CoursePoint> {
    let last = course.len().saturating_sub(1);
    let mut along = vec![0.0];
    let mut sum = vec![0.0];
    for pair in course.windows(2) {
        let step = distance(&pair[0], &pair[1]);
        let at = along.len() - 1;
        sum.push(sum[at] + step * f64::midpoint(pair[0][3], pair[1][3]));
        along.push(along[at] + step);
    }
    let length = along[along.len() - 1];
    if course.len() < 3 || length <= 0.0 {
        return course.to_vec();
    }
    let mean = sum[last] / length;
    // The integral of the radius from the beginning to s.
    let integral = |s: f64| {
        let low = along.partition_point(|at| *at <= s).saturating_sub(1).min(last - 1);
        let (part, whole) = (s - along[low], (along[low + 1] - along[low]).max(f64::MIN_POSITIVE));
        let radius = course[low][3] + (course[low + 1][3] - course[low][3]) * part / whole;
        sum[low] + part * f64::midpoint(course[low][3], radius)
    };
    let radius = |s: f64| {
        let [from, to] = [(s - REACH * mean).max(0.0), (s + REACH * mean).min(length)];
        if to > from { (integral(to) - integral(from)) / (to - from) } else { mean }
    };
    let point = |at: usize| {
        let ([x, y, z, _], radius) = (course[at], radius(along[at]));
        let [x, y, z] = if at == 0 || at == last { [x, y, z] } else { calmed(course, &along, at, MOST * radius) };
        [x, y, z, radius]
    };
    (0..=last).map(point).collect()
}

/// The inner point `at`, moved by at most `most`.
fn calmed(course: &[CoursePoint], along: &[f64], at: usize, most: f64) -> [f64; 3] {
    let (before, place, after) = (&course[at - 1], &course[at], &course[at + 1]);
    let share = (along[at] - along[at - 1]) / (along[at + 1] - along[at - 1]).max(f64::MIN_POSITIVE);
    let moved: [f64; 3] = std::array::from_fn(|axis| 0.5 * (before[axis] + share * (after[axis] - before[axis]) - place[axis]));
    let by = moved.iter().map(|x| x * x).sum::<f64>().sqrt();
    let part = if by > most { most / by } else { 1.0 };
    std::array::from_fn(|axis| place[axis] + part * moved[axis])
}

fn distance(a: &CoursePoint, b: &CoursePoint) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}
