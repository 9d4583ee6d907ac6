//! Radii and positions averaged along the branches, against the jitter of single points.

use willis_core::support::geometry::Point;

/// Rounds of averaging: a kernel of so many points to either side.
const RADIUS_ROUNDS: usize = 3;
const POSITION_ROUNDS: usize = 2;

/// Averaged points.
pub struct SmoothPoints {
    /// Geometric means over three neighbours to either side, through junctions, m.
    pub radius: Vec<f64>,
    /// Means over two neighbours to either side; junctions and ends stay, m.
    pub position: Vec<Point>,
}

/// Averages points with their neighbours: x ← x/2 + (mean over the neighbours)/2, round by round.
pub fn smooth(lines: &[Vec<usize>], degree: &[usize], position: &[Point], radius: &[f64]) -> SmoothPoints {
    let logs: Vec<[f64; 1]> = radius.iter().map(|r| [r.ln()]).collect();
    let logs = averaged(lines, degree, logs, RADIUS_ROUNDS, |degree| degree > 0);
    SmoothPoints {
        radius: logs.into_iter().map(|[x]| x.exp()).collect(),
        position: averaged(lines, degree, position.to_vec(), POSITION_ROUNDS, |degree| degree == 2),
    }
}

fn averaged<const D: usize>(
    lines: &[Vec<usize>],
    degree: &[usize],
    mut x: Vec<[f64; D]>,
    rounds: usize,
    moves: impl Fn(usize) -> bool,
) -> Vec<[f64; D]> {
    for _ in 0..rounds {
        let mut sum = vec![[0.0; D]; x.len()];
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            for (to, from) in [(pair[0], pair[1]), (pair[1], pair[0])] {
                for axis in 0..D {
                    sum[to][axis] += x[from][axis];
                }
            }
        }
        for point in (0..x.len()).filter(|p| moves(degree[*p])) {
            for axis in 0..D {
                x[point][axis] = 0.5 * x[point][axis] + 0.5 * sum[point][axis] / degree[point] as f64;
            }
        }
    }
    x
}
