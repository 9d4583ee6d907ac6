//! The course of a vessel from a free end inwards, past junctions, and where it points at several scales.

use crate::candidates::features::extraction::Extraction;
use willis_core::support::arc_lengths::{arc_lengths, in_direction};
use willis_core::support::geometry::{Point, distance, norm_squared, straightest, sub, unit};
use willis_core::support::normal_equations::solve;
use willis_core::support::ties::steady;

/// Directions are fitted over so many spacings and a third of that in radii.
pub const SCALES: [f64; 4] = [3.0, 6.0, 12.0, 24.0];
/// A course is followed over the largest scale, so many spacings and so many radii more.
const MORE_SPACINGS: f64 = 2.0;
const MORE_RADII: f64 = 8.0;
/// Past a junction it follows the branch that runs on straightest, by the direction over so many points.
const LOOK: usize = 5;
/// Thinning bends the last stretch of a line, over so many radii; only the smallest scale sees it.
const BENT_RADII: f64 = 0.7;
/// The curvature is fitted over so many spacings and radii, with this ridge.
const CURVED_SPACINGS: f64 = 16.0;
const CURVED_RADII: f64 = 6.0;
const RIDGE: f64 = 0.02;

/// What is measured along the course of a free end. Lengths in m.
#[derive(Default)]
pub struct EndCourse {
    /// Unit vectors out of the vessel, by [`SCALES`].
    pub directions: [Point; 4],
    /// The unit vector out of the vessel at its end, by a parabola.
    pub tip_direction: Point,
    /// Half the second derivative of that parabola, 1/m.
    pub curvature: Point,
    /// Length to the first junction, or of the course.
    pub first_run: f64,
    /// Radius at the first junction, or at the end.
    pub junction_radius: f64,
    /// Mean radius of the last two points.
    pub tip_radius: f64,
    /// Geometric mean radius from the fourth to the sixteenth point.
    pub far_radius: f64,
    /// Length of the course.
    pub length: f64,
    /// Distance of the points from the line at the third scale, root mean square, in spacings.
    pub wiggle: f64,
}

impl EndCourse {
    /// The course of a free end of an extraction, by its row.
    pub fn new(extraction: &Extraction, row: usize) -> Self {
        let end = &extraction.ends[row];
        let h = extraction.spacing;
        let limit = (SCALES[3] + MORE_SPACINGS) * h + MORE_RADII * end.radius;
        let (points, junction) = inwards(extraction, end.point, end.branch, limit);
        let position: Vec<Point> = points.iter().map(|p| extraction.position[*p]).collect();
        let arc = arc_lengths(position.iter().copied());
        let smooth = if position.len() > 3 { slightly_smooth(&position) } else { position };
        let mut course = Self {
            first_run: junction.map_or(arc[arc.len() - 1], |at| arc[at]),
            junction_radius: junction.map_or(extraction.radius[end.point], |at| extraction.smooth.radius[points[at]]),
            tip_radius: points.iter().take(2).map(|p| extraction.radius[*p]).sum::<f64>() / points.len().min(2) as f64,
            far_radius: if points.len() > 4 { log_mean(extraction, &points[3..points.len().min(16)]) } else { end.radius },
            length: arc[arc.len() - 1],
            ..Self::default()
        };
        for (scale, windows) in SCALES.iter().enumerate() {
            let upto = arc.iter().take_while(|s| **s <= windows * h + windows / 3.0 * end.radius).count();
            let from = arc.iter().take_while(|s| **s < BENT_RADII * end.radius).count();
            let from = if scale > 0 && upto > 8 && upto - from >= 2 { from } else { 0 };
            let upto = upto.max(2).min(smooth.len());
            let (direction, spread) = line(&smooth[from..upto], &arc[from..upto]);
            course.directions[scale] = direction;
            if scale == 2 {
                course.wiggle = spread / h;
            }
        }
        let upto = arc.iter().take_while(|s| **s <= CURVED_SPACINGS * h + CURVED_RADII * end.radius).count();
        course.tip_direction = course.directions[1];
        if upto >= 6 {
            let (slope, curvature) = parabola(&smooth[..upto], &arc[..upto]);
            course.tip_direction = unit(slope.map(|x| -x));
            course.curvature = curvature;
        }
        course
    }
}

fn log_mean(extraction: &Extraction, points: &[usize]) -> f64 {
    (points.iter().map(|p| extraction.radius[*p].ln()).sum::<f64>() / points.len() as f64).exp()
}

/// The points from a free end inwards, at most so long, and the place of the first junction among them.
fn inwards(e: &Extraction, from: usize, branch: usize, limit: f64) -> (Vec<usize>, Option<usize>) {
    let (mut way, mut length, mut junction) = (vec![from], 0.0, None);
    let mut branch = branch;
    let mut seen = vec![branch];
    loop {
        let line = &e.lines[branch];
        for point in in_direction(line.clone(), line[0] == way[way.len() - 1]).into_iter().skip(1) {
            length += distance(e.position[way[way.len() - 1]], e.position[point]);
            way.push(point);
            if length >= limit {
                return (way, junction);
            }
        }
        let node = way[way.len() - 1];
        if e.degree[node] < 2 {
            return (way, junction);
        }
        if e.degree[node] > 2 && junction.is_none() {
            junction = Some(way.len() - 1);
        }
        let smooth = |p: usize| e.smooth.position[p];
        let back = unit(sub(smooth(node), smooth(way[way.len().saturating_sub(LOOK + 1)])));
        let headings = e.graph.headings(&e.lines, node).into_iter().filter(|heading| !seen.contains(&heading.branch));
        let ways = headings.map(|heading| {
            let wider = (e.smooth.radius[heading.walk(1)] / e.smooth.radius[node]).ln();
            (heading.branch, sub(smooth(heading.walk(LOOK)), smooth(node)), wider)
        });
        let Some(next) = straightest(back, ways, steady) else { return (way, junction) };
        branch = next;
        seen.push(branch);
    }
}

/// The Gaussian average (1.5 points) of positions; those beyond the ends are the ends.
fn slightly_smooth(position: &[Point]) -> Vec<Point> {
    const SIGMA: f64 = 1.5;
    let last = position.len() as isize - 1;
    let weight: Vec<f64> = (-6..=6).map(|o: i32| (-0.5 * (f64::from(o) / SIGMA).powi(2)).exp()).collect();
    let total: f64 = weight.iter().sum();
    let at = |i: isize| {
        let mut sum = [0.0; 3];
        for (o, w) in (-6..=6).zip(&weight) {
            let p = position[(i + o).clamp(0, last) as usize];
            (0..3).for_each(|k| sum[k] += w * p[k]);
        }
        sum.map(|x| x / total)
    };
    (0..position.len() as isize).map(at).collect()
}

/// The direction of the least-squares line against the arc length, towards its beginning, and the root mean square distance from it.
fn line(points: &[Point], arc: &[f64]) -> (Point, f64) {
    let n = points.len() as f64;
    let middle = arc.iter().sum::<f64>() / n;
    let mean = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / n);
    let mut v = [0.0; 3];
    for (p, s) in points.iter().zip(arc) {
        (0..3).for_each(|k| v[k] -= (s - middle) * (p[k] - mean[k]));
    }
    let direction = unit(v);
    let square: f64 = arc.iter().map(|s| (s - middle).powi(2)).sum::<f64>().max(f64::MIN_POSITIVE);
    let off = |(p, s): (&Point, &f64)| norm_squared([0, 1, 2].map(|k| p[k] - mean[k] + (s - middle) * v[k] / square));
    (direction, (points.iter().zip(arc).map(off).sum::<f64>() / n).sqrt())
}

/// Slope at the beginning and half the second derivative of the parabola through points, by ridge regression.
fn parabola(points: &[Point], arc: &[f64]) -> (Point, Point) {
    let most = arc[arc.len() - 1].max(f64::MIN_POSITIVE);
    let rows: Vec<[f64; 3]> = arc.iter().map(|s| [1.0, s / most, (s / most).powi(2)]).collect();
    let mut a = [[0.0; 3]; 3];
    let mut b = [[0.0; 3]; 3];
    for (row, p) in rows.iter().zip(points) {
        for i in 0..3 {
            for j in 0..3 {
                a[i][j] += row[i] * row[j];
                b[i][j] += row[i] * (p[j] - points[0][j]);
            }
        }
    }
    a[2][2] += RIDGE * points.len() as f64;
    let x = solve(a, b, 3);
    (x[1].map(|x| x / most), x[2].map(|x| x / (most * most)))
}
