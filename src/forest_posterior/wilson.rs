//! Draws forests from the posterior by Wilson's algorithm: loop-erased random walks (Wilson 1996).

use rand::{Rng, RngExt};

use super::Forests;

/// The walk, ready to be sampled.
#[derive(Debug, Clone)]
pub struct Wilson {
    /// Per fragment where its choices start.
    start: Vec<usize>,
    /// Sums of weights: those of a fragment's root, then its edges.
    sum: Vec<f64>,
    /// The edge of each choice and the fragment it leads to; `None` for the root.
    choice: Vec<Option<(usize, usize)>>,
}

impl Wilson {
    /// Prepares the walk.
    pub fn new(forests: &Forests) -> Self {
        let scaled = super::marginals::Scaled::new(forests);
        let mut of = vec![Vec::new(); forests.fragments()];
        for (row, edge) in forests.edges().iter().enumerate() {
            of[edge.child].push((row, edge.parent));
        }
        let mut walk = Self { start: vec![0], sum: Vec::new(), choice: Vec::new() };
        for (fragment, own) in of.into_iter().enumerate() {
            let mut sum = scaled.root[fragment];
            walk.sum.push(sum);
            walk.choice.push(None);
            for (row, parent) in own {
                sum += scaled.edge[row];
                walk.sum.push(sum);
                walk.choice.push(Some((row, parent)));
            }
            walk.start.push(walk.sum.len());
        }
        walk
    }

    /// One forest: per fragment the edge that attaches it, `None` for a root. `None` when `limit` steps did not suffice; draws
    /// that end are then no longer fair, so a limit should be far above the mean, Σ_c P(root c) Σ(w, v)/v, which is vast where
    /// fragments strongly prefer one another to any root.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R, limit: u64) -> Option<Vec<Option<usize>>> {
        let fragments = self.start.len() - 1;
        let mut settled = vec![false; fragments];
        let mut last = vec![None; fragments];
        let mut steps = 0;
        for from in 0..fragments {
            let mut at = from;
            while !settled[at] {
                if steps == limit {
                    return None;
                }
                steps += 1;
                last[at] = self.step(at, rng);
                match last[at] {
                    Some((_, parent)) => at = parent,
                    None => break,
                }
            }
            // Only the last step from each fragment counts: loops are erased by that.
            at = from;
            while !settled[at] {
                settled[at] = true;
                match last[at] {
                    Some((_, parent)) => at = parent,
                    None => break,
                }
            }
        }
        Some(last.into_iter().map(|choice| choice.map(|(row, _)| row)).collect())
    }

    fn step<R: Rng + ?Sized>(&self, fragment: usize, rng: &mut R) -> Option<(usize, usize)> {
        let choices = self.start[fragment]..self.start[fragment + 1];
        let sums = &self.sum[choices.clone()];
        let total = sums[sums.len() - 1];
        // The product may be rounded up to the total, where only choices of no weight are left.
        let drawn = (rng.random::<f64>() * total).min(total.next_down());
        self.choice[choices.start + sums.partition_point(|sum| *sum <= drawn)]
    }
}
