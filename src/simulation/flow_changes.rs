//! Which vessels take over when others are perturbed: gains of flow, and flow that turns round.

use super::Perturbation;
use crate::flow::state::State;

/// Flows and gains up to this share of the total inflow are rounding.
const ROUNDING: f64 = 1e-9;

/// The flow, m³/s, up to which flows and gains between two states are rounding.
pub fn rounding(before: &State, after: &State) -> f64 {
    ROUNDING * before.inflow.max(after.inflow)
}

/// A vessel that is not perturbed itself but carries another flow than before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowChange {
    /// Its row.
    pub vessel: usize,
    /// Q before, m³/s.
    pub before: f64,
    /// Q after, m³/s.
    pub after: f64,
}

impl FlowChange {
    /// The gain of flow whatever its direction, |Q after| - |Q before|, m³/s.
    pub fn gain(&self) -> f64 {
        self.after.abs() - self.before.abs()
    }

    /// Whether blood runs the other way than before.
    pub fn is_reversed(&self) -> bool {
        self.before * self.after < 0.0
    }
}

/// The vessels not perturbed themselves that gain flow, |Q after| > |Q before|, the largest gain first.
pub fn gains(before: &State, after: &State, perturbations: &[Perturbation]) -> Vec<FlowChange> {
    let cut = rounding(before, after);
    largest_first(untouched(before, after, perturbations).filter(|c| c.gain() > cut), FlowChange::gain)
}

/// The vessels not perturbed themselves whose flow turns round, the largest flow after it first.
pub fn reversals(before: &State, after: &State, perturbations: &[Perturbation]) -> Vec<FlowChange> {
    let cut = rounding(before, after);
    let turned = |c: &FlowChange| c.is_reversed() && c.before.abs() > cut && c.after.abs() > cut;
    largest_first(untouched(before, after, perturbations).filter(turned), |c| c.after.abs())
}

/// The largest figure first, to 24 bits, so that equal vessels stay in their order whatever the last roundings are.
fn largest_first(changes: impl Iterator<Item = FlowChange>, figure: impl Fn(&FlowChange) -> f64) -> Vec<FlowChange> {
    let mut changes: Vec<FlowChange> = changes.collect();
    changes.sort_by(|a, b| (figure(b) as f32).total_cmp(&(figure(a) as f32)));
    changes
}

fn untouched<'a>(
    before: &'a State,
    after: &'a State,
    perturbations: &'a [Perturbation],
) -> impl Iterator<Item = FlowChange> + 'a {
    let pairs = before.vessels.iter().zip(&after.vessels).enumerate();
    pairs.filter(|(row, _)| perturbations.iter().all(|p| p.vessel != *row)).map(|(vessel, (b, a))| FlowChange {
        vessel,
        before: b.flow,
        after: a.flow,
    })
}
