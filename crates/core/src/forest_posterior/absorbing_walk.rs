//! A random walk on a few fragments that may die, as a dense matrix of odds, and the elimination of fragments from it.

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
pub const TOGETHER: usize = 4;

/// y += Σ a x; nothing is touched when every a is zero.
pub fn add_multiples(y: &mut [f64], a: [f64; TOGETHER], x: [&[f64]; TOGETHER]) {
    if a == [0.0; TOGETHER] {
        return;
    }
    let [x0, x1, x2, x3] = x.map(|x| &x[..y.len()]);
    for (i, y) in y.iter_mut().enumerate() {
        *y += (a[0] * x0[i] + a[1] * x1[i]) + (a[2] * x2[i] + a[3] * x3[i]);
    }
}

/// y += a x.
pub fn add_multiple(y: &mut [f64], a: f64, x: &[f64]) {
    if a == 0.0 {
        return;
    }
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}
