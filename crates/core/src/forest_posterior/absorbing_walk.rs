//! A random walk on a few fragments that may die, as a dense matrix of odds, and the elimination of fragments from it.
//!
//! The probability that a walk dies before it meets a given node, for every start and every node to be met.
//!
//! For one node c to be met: eliminate all others, then go back through them. The halves of the nodes share that work:
//! eliminate one half, solve the other as a problem of its own, go back through the first; then the other way round. About
//! 1.3 n³ multiplications in all, and not one subtraction.

/// Odds of the next step from every node.
///
/// What a node steps to itself with is never read: it only delays the walk.
#[derive(Debug, Clone, PartialEq)]
pub struct AbsorbingWalk {
    /// How many nodes there are.
    pub nodes: usize,
    /// Odds of a step from row to column, row by row.
    step: Vec<f64>,
    /// Odds of dying, per node.
    pub death: Vec<f64>,
}

impl AbsorbingWalk {
    /// A walk without any odds yet.
    pub fn new(nodes: usize) -> Self {
        Self { nodes, step: vec![0.0; nodes * nodes], death: vec![0.0; nodes] }
    }

    /// The odds of stepping from a node to each.
    pub fn row(&self, node: usize) -> &[f64] {
        &self.step[node * self.nodes..(node + 1) * self.nodes]
    }

    /// Adds to the odds of a step.
    pub fn add(&mut self, from: usize, to: usize, odds: f64) {
        self.step[from * self.nodes + to] += odds;
    }

    /// Adds the odds of another walk, whose i-th node is the `at[i]`-th here.
    pub fn add_all(&mut self, other: &Self, at: &[usize]) {
        for (row, from) in at.iter().enumerate() {
            self.death[*from] += other.death[row];
            let target = &mut self.step[from * self.nodes..(from + 1) * self.nodes];
            for (odds, to) in other.row(row).iter().zip(at) {
                target[*to] += odds;
            }
        }
    }

    /// The walk on these nodes alone, in this order; other steps are left out.
    #[must_use]
    pub fn part(&self, nodes: &[usize]) -> Self {
        let step = nodes.iter().flat_map(|from| nodes.iter().map(|to| self.row(*from)[*to])).collect();
        Self { nodes: nodes.len(), step, death: nodes.iter().map(|node| self.death[*node]).collect() }
    }

    /// Eliminates the first `count` nodes one after another: a step to one of them becomes the step that the walk takes on
    /// from there. The rows of those nodes become probabilities over later nodes and death. Returns Σ ln S, S the odds of all
    /// steps away from the node at its turn.
    pub fn eliminate(&mut self, count: usize) -> f64 {
        let n = self.nodes;
        let mut log_sum = 0.0;
        for i in 0..n {
            let (above, below) = self.step.split_at_mut(i * n);
            let row = &mut below[..n];
            let mut death = self.death[i];
            let pivots = i.min(count);
            let mut k = 0;
            while k < pivots {
                let together = if k + TOGETHER <= pivots { TOGETHER } else { 1 };
                let end = k + together;
                // The odds of stepping to one of these take in what leads there by way of those before it.
                for first in k..end {
                    let odds = row[first];
                    add_multiple(&mut row[first + 1..end], odds, &above[first * n + first + 1..first * n + end]);
                    death += odds * self.death[first];
                }
                let (odds, rest) = row.split_at_mut(end);
                let of = |pivot: usize| &above[(k + pivot) * n + end..(k + pivot + 1) * n];
                if together == TOGETHER {
                    add_multiples(rest, [0, 1, 2, 3].map(|pivot| odds[k + pivot]), [0, 1, 2, 3].map(of));
                } else {
                    add_multiple(rest, odds[k], of(0));
                }
                k = end;
            }
            if i < count {
                let sum = death + row[i + 1..].iter().sum::<f64>();
                row[i + 1..].iter_mut().for_each(|odds| *odds /= sum);
                death /= sum;
                log_sum += sum.ln();
            }
            self.death[i] = death;
        }
        log_sum
    }
}

/// Rows that are read together, so that the row they are added to is read and written a quarter as often.
const TOGETHER: usize = 4;

/// y += Σ a x; nothing is touched when every a is zero.
fn add_multiples(y: &mut [f64], a: [f64; TOGETHER], x: [&[f64]; TOGETHER]) {
    if a == [0.0; TOGETHER] {
        return;
    }
    let [x0, x1, x2, x3] = x.map(|x| &x[..y.len()]);
    for (i, y) in y.iter_mut().enumerate() {
        *y += (a[0] * x0[i] + a[1] * x1[i]) + (a[2] * x2[i] + a[3] * x3[i]);
    }
}

/// y += a x.
fn add_multiple(y: &mut [f64], a: f64, x: &[f64]) {
    if a == 0.0 {
        return;
    }
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Probabilities of dying before a meeting: row = start, column = the node to be met; 0 where they are one.
#[derive(Debug, Clone, PartialEq)]
pub struct Escapes {
    nodes: usize,
    q: Vec<f64>,
}

impl Escapes {
    /// The probability for one start and one node to be met.
    pub fn get(&self, start: usize, met: usize) -> f64 {
        self.q[start * self.nodes + met]
    }
}

/// All escapes of a walk, and ln det L.
pub fn escapes(walk: &AbsorbingWalk) -> (Escapes, f64) {
    let n = walk.nodes;
    let mut out = Escapes { nodes: n, q: vec![0.0; n * n] };
    if n < 2 {
        let sum = if n == 1 { walk.death[0].ln() } else { 0.0 };
        return (out, sum);
    }
    let (first, second): (Vec<usize>, Vec<usize>) = (0..n).partition(|node| *node < n / 2);
    let log_det = half(walk, &first, &second, &mut out);
    half(walk, &second, &first, &mut out);
    (out, log_det)
}

/// The columns of `kept`, by elimination of the others; returns ln det L.
fn half(walk: &AbsorbingWalk, gone: &[usize], kept: &[usize], out: &mut Escapes) -> f64 {
    let order: Vec<usize> = gone.iter().chain(kept).copied().collect();
    let mut reduced = walk.part(&order);
    let log_sum = reduced.eliminate(gone.len());
    let places: Vec<usize> = (gone.len()..order.len()).collect();
    let (inner, log_det) = escapes(&reduced.part(&places));
    let (above, width) = (gone.len(), kept.len());
    // Rows in the order of `order`, columns in that of `kept`.
    let mut q = vec![0.0; above * width];
    q.extend_from_slice(&inner.q);
    for k in (0..above).rev() {
        let (row, later) = q[k * width..].split_at_mut(width);
        row.fill(reduced.death[k]);
        let (odds, ends) = reduced.row(k)[k + 1..].as_chunks::<TOGETHER>();
        let blocks = later.chunks_exact(TOGETHER * width);
        for (odds, x) in ends.iter().zip(later[odds.len() * TOGETHER * width..].chunks_exact(width)) {
            add_multiple(row, *odds, x);
        }
        for (odds, block) in odds.iter().zip(blocks) {
            add_multiples(row, *odds, [0, 1, 2, 3].map(|at| &block[at * width..(at + 1) * width]));
        }
    }
    for (row, start) in q.chunks_exact(width).zip(&order) {
        for (q, met) in row.iter().zip(kept) {
            out.q[start * out.nodes + met] = *q;
        }
    }
    log_sum + log_det
}
