//! Textbook linear algebra and graph theory, written for plainness: dense elimination, flooding, Kruskal, all forests.

use willis::internals::network::{Condition, Network};

use crate::networks::VISCOSITY;

/// Gaussian elimination with partial pivoting.
pub fn gauss(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for p in 0..n {
        let pivot = (p..n).max_by(|i, j| a[*i][p].abs().total_cmp(&a[*j][p].abs())).unwrap();
        a.swap(p, pivot);
        b.swap(p, pivot);
        let pivot_row = a[p].clone();
        for row in p + 1..n {
            let factor = a[row][p] / pivot_row[p];
            a[row].iter_mut().zip(&pivot_row).for_each(|(x, y)| *x -= factor * y);
            b[row] -= factor * b[p];
        }
    }
    for row in (0..n).rev() {
        for column in row + 1..n {
            b[row] -= a[row][column] * b[column];
        }
        b[row] /= a[row][row];
    }
    b
}

/// π r⁴ / (8 µ l).
pub fn conductance(network: &Network, row: usize) -> f64 {
    let vessel = network.vessel(row);
    std::f64::consts::PI * vessel.radius.powi(4) / (8.0 * VISCOSITY * vessel.length)
}

/// A network in one sample, with its boundary conditions.
pub struct Sample<'a> {
    pub network: &'a Network,
    pub conditions: &'a [(usize, Condition)],
    pub open: Vec<bool>,
}

impl Sample<'_> {
    fn condition(&self, node: usize) -> Option<Condition> {
        self.conditions.iter().find(|(n, _)| *n == node).map(|(_, condition)| *condition)
    }

    fn fixed(&self, node: usize) -> Option<f64> {
        if let Some(Condition::Pressure(p)) = self.condition(node) { Some(p) } else { None }
    }

    /// The open vessels at a node with the nodes at their other ends.
    fn neighbours(&self, node: usize) -> Vec<usize> {
        let open = (0..self.open.len()).filter(|row| self.open[*row]).map(|row| self.network.ends(row));
        open.filter(|[a, b]| *a == node || *b == node).map(|[a, b]| a + b - node).collect()
    }

    /// The nodes reached from `start` by open vessels; `pass` says which nodes may be entered and which left again.
    fn flood(&self, start: &[usize], enter: impl Fn(usize) -> bool, leave: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut seen = start.to_vec();
        let mut at = 0;
        while at < seen.len() {
            if leave(seen[at]) {
                for next in self.neighbours(seen[at]) {
                    if enter(next) && !seen.contains(&next) {
                        seen.push(next);
                    }
                }
            }
            at += 1;
        }
        seen
    }

    /// Whether something in the node's component fixes its pressure level.
    fn grounded(&self, node: usize) -> bool {
        let part = self.flood(&[node], |_| true, |_| true);
        part.iter().any(|n| matches!(self.condition(*n), Some(Condition::Pressure(_) | Condition::Resistance { .. })))
    }

    /// Kirchhoff's current law as a dense system; `None` where the pressure floats.
    pub fn pressures(&self) -> Vec<Option<f64>> {
        let nodes = self.network.node_count();
        let free: Vec<usize> = (0..nodes).filter(|n| self.fixed(*n).is_none() && self.grounded(*n)).collect();
        let row = |node: usize| free.iter().position(|n| *n == node);
        let (mut a, mut b) = (vec![vec![0.0; free.len()]; free.len()], vec![0.0; free.len()]);
        for (i, node) in free.iter().enumerate() {
            match self.condition(*node) {
                Some(Condition::Resistance { resistance, venous }) => {
                    a[i][i] += 1.0 / resistance;
                    b[i] += venous / resistance;
                }
                Some(Condition::Flow(q)) => b[i] += q,
                _ => {}
            }
        }
        for vessel in (0..self.open.len()).filter(|v| self.open[*v]) {
            let [p, q] = self.network.ends(vessel);
            let c = conductance(self.network, vessel);
            for (here, there) in [(p, q), (q, p)] {
                let Some(i) = row(here).filter(|_| p != q) else { continue };
                a[i][i] += c;
                match row(there) {
                    Some(j) => a[i][j] -= c,
                    None => b[i] += c * self.fixed(there).unwrap(),
                }
            }
        }
        let solution = gauss(a, b);
        (0..nodes).map(|n| self.fixed(n).or_else(|| row(n).map(|i| solution[i]))).collect()
    }

    /// Whether structure lets a vessel carry flow: its part, cut at the fixed pressures, has two different pressures or an
    /// injection beside one, and no single junction cuts the vessel off from everything that drives flow (a dead end).
    pub fn carries(&self, vessel: usize) -> bool {
        let ends = self.network.ends(vessel);
        if !self.open[vessel] || ends[0] == ends[1] {
            return false;
        }
        if let [Some(a), Some(b)] = ends.map(|n| self.fixed(n)) {
            return a != b;
        }
        let free: Vec<usize> = ends.into_iter().filter(|n| self.fixed(*n).is_none()).collect();
        let is_free = |node: usize| self.fixed(node).is_none();
        let part = self.flood(&free, |_| true, is_free);
        let (mut levels, mut injected) = (Vec::new(), false);
        for node in &part {
            match self.condition(*node) {
                Some(Condition::Pressure(p)) => levels.push(p),
                Some(Condition::Resistance { venous, .. }) => levels.push(venous),
                Some(Condition::Flow(q)) => injected |= q != 0.0,
                None => {}
            }
        }
        if levels.is_empty() || (!injected && levels.iter().all(|p| *p == levels[0])) {
            return false;
        }
        part.iter().filter(|n| is_free(**n)).all(|cut| {
            let start: Vec<usize> = ends.into_iter().filter(|n| n != cut).collect();
            self.flood(&start, |n| n != *cut, is_free).iter().any(|n| self.condition(*n).is_some())
        })
    }

    /// ρ = ΔP² r² / (8 µ l²) of every vessel that carries flow.
    pub fn resiliences(&self) -> Vec<(usize, f64)> {
        let p = self.pressures();
        let rows = (0..self.open.len()).filter(|row| self.carries(*row));
        rows.map(|row| {
            let ([a, b], vessel) = (self.network.ends(row), self.network.vessel(row));
            let gradient = (p[a].unwrap() - p[b].unwrap()) / vessel.length;
            (row, gradient * gradient * vessel.radius * vessel.radius / (8.0 * VISCOSITY))
        })
        .collect()
    }
}

/// Kruskal's maximum spanning forest, components as labels. ρ is compared to nine digits; ties, of which the networks that
/// are compared by it have none, go to the lower row.
pub fn kruskal(network: &Network, diffused: &[(usize, f64)]) -> Vec<usize> {
    let mut sorted: Vec<(f64, usize)> = diffused.iter().map(|(row, x)| (format!("{x:.8e}").parse().unwrap(), *row)).collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut label: Vec<usize> = (0..network.node_count()).collect();
    let mut forest = Vec::new();
    for (_, row) in sorted {
        let [a, b] = network.ends(row).map(|n| label[n]);
        if a != b {
            label.iter_mut().filter(|l| **l == a).for_each(|l| *l = b);
            forest.push(row);
        }
    }
    forest
}

/// How many edges a spanning forest of these vessels has: nodes touched less connected parts.
pub fn rank(network: &Network, rows: &[usize]) -> usize {
    let mut label: Vec<usize> = (0..network.node_count()).collect();
    let mut merged = 0;
    for row in rows {
        let [a, b] = network.ends(*row).map(|n| label[n]);
        if a != b {
            label.iter_mut().filter(|l| **l == a).for_each(|l| *l = b);
            merged += 1;
        }
    }
    merged
}

/// The maximum spanning forest by trying every subset of the vessels. Any rising function of ρ gives the same forest;
/// the logarithm keeps small ρ visible, and 1e-9 of the row settles ties for the lower one. Networks with ties are in `ties.rs`.
pub fn best_of_all_forests(network: &Network, diffused: &[(usize, f64)]) -> Vec<usize> {
    let all: Vec<usize> = diffused.iter().map(|(row, _)| *row).collect();
    let size = rank(network, &all);
    let (mut best, mut most) = (Vec::new(), f64::NEG_INFINITY);
    for subset in (0_u32..1 << all.len()).filter(|s| s.count_ones() as usize == size) {
        let chosen = (0..all.len()).filter(|i| subset >> i & 1 == 1);
        let weight: f64 = chosen.clone().map(|i| diffused[i].1.ln() - 1e-9 * all[i] as f64).sum();
        let rows: Vec<usize> = chosen.map(|i| all[i]).collect();
        if weight > most && rank(network, &rows) == size {
            (best, most) = (rows, weight);
        }
    }
    best
}
