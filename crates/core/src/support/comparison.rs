//! Two groups compared: Cliff's delta, its interval, and a permutation test, over several imputations of values that are not sure.
//!
//! δ = P(a > b) - P(a < b) for a value a of the first group and b of the second (Cliff 1993, doi:10.1037/0033-2909.114.3.494). It is in [-1, 1], does
//! not depend on the unit, and knows no distribution. It is 2U/(n m) - 1 of the U of Mann and Whitney.

use rand::RngExt;

use super::{marked, quantile, random::stream, ties::TIE};

/// Half of the width of a normal interval of 95 %, in standard deviations.
pub(super) const Z: f64 = 1.959_963_984_540_054;
/// So many ways to divide subjects into groups are drawn, or all are taken, where there are no more.
pub const PERMUTATIONS: usize = 9999;
/// The least values of a group.
const LEAST: usize = 2;
/// Deltas this near are one.
const EQUAL: f64 = 1e-12;

/// How two groups differ in a measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupDifference {
    /// Cliff's delta, the mean over imputations.
    pub delta: f64,
    /// Its interval of 95 %.
    pub interval: [f64; 2],
    /// The share of its variance that comes from the imputations.
    pub doubt: f64,
    /// Of the permutation test of |δ|, two-sided.
    pub p: f64,
}

/// The number of values of a sample that are known, and their quartiles.
pub fn quartiles(values: impl Iterator<Item = f64>) -> (usize, [f64; 3]) {
    let known: Vec<f64> = values.filter(|x| x.is_finite()).collect();
    (known.len(), [0.25, 0.5, 0.75].map(|q| quantile(&known, q).unwrap_or(f64::NAN)))
}

/// Compares two groups in a measure. `imputations` has the values of all subjects, once for each imputation; one that is not a number is
/// missing. `first` says which subjects are of the first group. `None` where a group has fewer than two values in some imputation, or all values are
/// equal in each. Values equal but for [rounding](TIE) are one.
pub fn compare(imputations: &[Vec<f64>], first: &[bool], seed: u64) -> Option<GroupDifference> {
    // Values that are sure are the same in all.
    let same = imputations.windows(2).all(|pair| pair[0].iter().map(|x| x.to_bits()).eq(pair[1].iter().map(|x| x.to_bits())));
    let imputations = if same { &imputations[..1] } else { imputations };
    // Who never has the measure is not divided.
    let known: Vec<usize> = (0..first.len()).filter(|row| imputations.iter().any(|values| values[*row].is_finite())).collect();
    let first = &*known.iter().map(|row| first[*row]).collect::<Vec<bool>>();
    let imputations = imputations.iter().map(|values| tied(known.iter().map(|row| values[*row]).collect()));
    let imputations: Vec<Vec<f64>> = imputations.collect();
    let ranked: Vec<Ranks> = imputations.iter().map(|values| Ranks::of(values)).collect();
    if ranked.iter().all(|ranks| ranks.is_constant) {
        return None;
    }
    let deltas: Vec<[f64; 3]> = imputations.iter().map(|values| delta_and_variance(values, first)).collect::<Option<_>>()?;
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| deltas.iter().map(of).sum::<f64>() / deltas.len() as f64;
    let (delta, within) = (mean(&|d| d[0]), mean(&|d| d[1]));
    // The rules of Rubin (1987, Multiple Imputation for Nonresponse in Surveys, section 3.3).
    let count = deltas.len() as f64;
    let between = if count > 1.0 { mean(&|d| (d[0] - delta).powi(2)) * count / (count - 1.0) } else { 0.0 };
    let extra = (1.0 + 1.0 / count) * between;
    let total = within + extra;
    let doubt = if total > 0.0 { extra / total } else { 0.0 };
    let width = if extra > 0.0 { student((count - 1.0) / (doubt * doubt)) } else { Z };
    let interval = interval(delta, total.sqrt(), width, deltas.iter().map(|d| d[2]).fold(f64::INFINITY, f64::min));
    Some(GroupDifference { delta, interval, doubt, p: permutation_test(&ranked, first, delta, seed) })
}

/// So many draws among things by their weights, those that `number` of a seed draws; none where there is no weight.
pub fn drawn_by_weight(weights: &[f64], draws: usize, seed: u64, number: u64) -> Vec<usize> {
    let total: f64 = weights.iter().sum();
    let Some(last) = weights.len().checked_sub(1) else { return Vec::new() };
    // Stream 0 is that of permutations.
    let mut rng = stream(seed, number + 1);
    let mut draw = || {
        let mut left = rng.random_range(0.0..1.0) * total;
        let reached = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        reached.unwrap_or(last)
    };
    (0..draws).map(|_| draw()).collect()
}

/// The same values, where one that is larger than another by rounding alone is that.
fn tied(mut values: Vec<f64>) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).filter(|at| values[*at].is_finite()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let rounding = TIE * order.iter().map(|at| values[*at].abs()).fold(0.0, f64::max);
    for pair in order.windows(2) {
        if values[pair[1]] - values[pair[0]] <= rounding {
            values[pair[1]] = values[pair[0]];
        }
    }
    values
}

/// δ, its variance, unbiased but for the least that it may be (Cliff 1993, eq. 7), and the size of the smaller group.
fn delta_and_variance(values: &[f64], first: &[bool]) -> Option<[f64; 3]> {
    let group = |of: bool| values.iter().zip(first).filter(move |(x, is)| x.is_finite() && **is == of).map(|(x, _)| *x);
    let (a, b): (Vec<f64>, Vec<f64>) = (group(true).collect(), group(false).collect());
    if a.len().min(b.len()) < LEAST {
        return None;
    }
    let (n, m) = (a.len() as f64, b.len() as f64);
    let sign = |x: f64, y: f64| f64::from(i8::from(x > y) - i8::from(x < y));
    let of_a: Vec<f64> = a.iter().map(|x| b.iter().map(|y| sign(*x, *y)).sum::<f64>() / m).collect();
    let of_b: Vec<f64> = b.iter().map(|y| a.iter().map(|x| sign(*x, *y)).sum::<f64>() / n).collect();
    let delta = of_a.iter().sum::<f64>() / n;
    let squares = |of: &[f64]| of.iter().map(|d| (d - delta).powi(2)).sum::<f64>();
    let all: f64 = a.iter().flat_map(|x| b.iter().map(move |y| (sign(*x, *y) - delta).powi(2))).sum();
    let variance = (m * m * squares(&of_a) + n * n * squares(&of_b) - all) / (n * m * (n - 1.0) * (m - 1.0));
    Some([delta, variance.max((1.0 - delta * delta) / (n * m - 1.0)), n.min(m)])
}

/// The interval of δ, which lies nearer to zero than to ±1 (Feng and Cliff 2004, doi:10.22237/jmasm/1099267500); `width` in standard errors, `least` is
/// the size of the smaller group.
fn interval(delta: f64, error: f64, width: f64, least: f64) -> [f64; 2] {
    let square = width * width;
    if 1.0 - delta.abs() < EQUAL {
        let near = (least - square) / (least + square);
        return if delta > 0.0 { [near, 1.0] } else { [-1.0, -near] };
    }
    let (rest, spread) = (1.0 - delta * delta, square * error * error);
    let half = width * error * (rest * rest + spread).sqrt();
    let end = |sign: f64| ((delta - delta.powi(3) + sign * half) / (rest + spread)).clamp(-1.0, 1.0);
    [end(-1.0), end(1.0)]
}

/// The 0.975-quantile of Student's t of so many degrees of freedom, to 0.1 % from ten on (Abramowitz and Stegun, 26.7.5).
fn student(freedom: f64) -> f64 {
    let z = |power: i32| Z.powi(power);
    let terms = [
        (z(3) + z(1)) / 4.0,
        (5.0 * z(5) + 16.0 * z(3) + 3.0 * z(1)) / 96.0,
        (3.0 * z(7) + 19.0 * z(5) + 17.0 * z(3) - 15.0 * z(1)) / 384.0,
    ];
    Z + terms.iter().enumerate().map(|(k, term)| term / freedom.powi(k as i32 + 1)).sum::<f64>()
}

/// The middle rank of each value, from 1; none of one that is missing.
struct Ranks {
    of: Vec<Option<f64>>,
    known: usize,
    is_constant: bool,
}

impl Ranks {
    fn of(values: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..values.len()).filter(|row| values[*row].is_finite()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let mut of = vec![None; values.len()];
        let (mut groups, mut before) = (0, 0);
        for tied in order.chunk_by(|a, b| values[*a] == values[*b]) {
            groups += 1;
            for row in tied {
                of[*row] = Some(before as f64 + 0.5 * (tied.len() + 1) as f64);
            }
            before += tied.len();
        }
        Self { of, known: order.len(), is_constant: groups < 2 }
    }

    /// δ of the subjects of the first group against all others; zero where one has none.
    fn delta(&self, first: &[bool]) -> f64 {
        let (mut sum, mut n) = (0.0, 0.0);
        for rank in self.of.iter().zip(first).filter(|(_, is)| **is).filter_map(|(rank, _)| *rank) {
            sum += rank;
            n += 1.0;
        }
        let m = self.known as f64 - n;
        if n * m > 0.0 { 2.0 * (sum - 0.5 * n * (n + 1.0)) / (n * m) - 1.0 } else { 0.0 }
    }
}

/// How likely |δ| is as large or larger where groups mean nothing: the share of the ways to divide the subjects. All of them, if they are few, else so
/// many that are drawn, with the groups as they are as one more (Phipson and Smyth 2010, doi:10.2202/1544-6115.1585). The same division goes for all
/// imputations, none of which knows the groups.
fn permutation_test(imputations: &[Ranks], first: &[bool], delta: f64, seed: u64) -> f64 {
    let size = first.iter().filter(|is| **is).count();
    let reaches = |first: &[bool]| {
        let mean = imputations.iter().map(|ranks| ranks.delta(first)).sum::<f64>() / imputations.len() as f64;
        mean.abs() >= delta.abs() - EQUAL
    };
    if let Some(total) = ways(first.len(), size) {
        let mut chosen: Vec<usize> = (0..size).collect();
        let mut reached = 0;
        loop {
            reached += usize::from(reaches(&marked(first.len(), chosen.iter().copied())));
            // The next combination in lexical order.
            let Some(at) = (0..size).rev().find(|at| chosen[*at] < first.len() - size + at) else { break };
            chosen[at] += 1;
            for next in at + 1..size {
                chosen[next] = chosen[next - 1] + 1;
            }
        }
        return reached as f64 / total as f64;
    }
    let (mut rng, mut divided) = (stream(seed, 0), first.to_vec());
    let mut reached = 1;
    for _ in 0..PERMUTATIONS {
        for last in (1..divided.len()).rev() {
            divided.swap(last, rng.random_range(0..=last));
        }
        reached += usize::from(reaches(&divided));
    }
    reached as f64 / (PERMUTATIONS + 1) as f64
}

/// In how many ways so many of a number can be chosen, where these are no more than are drawn.
fn ways(of: usize, chosen: usize) -> Option<usize> {
    let mut ways = 1_usize;
    for k in 0..chosen.min(of - chosen) {
        ways = ways.checked_mul(of - k)? / (k + 1);
        if ways > PERMUTATIONS {
            return None;
        }
    }
    Some(ways)
}

/// Values of p corrected for their number by Holm's method (1979, Scandinavian Journal of Statistics 6:65), which holds however measures depend
/// on one another.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let (mut corrected, mut most) = (vec![f64::NAN; p.len()], 0.0_f64);
    for (at, row) in order.iter().enumerate() {
        most = most.max(p[*row] * (p.len() - at) as f64).min(1.0);
        corrected[*row] = most;
    }
    corrected
}
