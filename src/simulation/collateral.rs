//! Which vessels take over when others are perturbed: gains of flow, and flow that turns round.

use super::Perturbation;
use crate::state::State;

/// Flows and gains below this share of the total inflow are rounding.
const CUT: f64 = 1e-9;

/// A vessel that is not perturbed itself but carries another flow than before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collateral {
    /// Its row.
    pub vessel: usize,
    /// Q before, m³/s.
    pub before: f64,
    /// Q after, m³/s.
    pub after: f64,
}

impl Collateral {
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
pub fn collaterals(before: &State, after: &State, perturbations: &[Perturbation]) -> Vec<Collateral> {
    let cut = CUT * before.inflow.max(after.inflow);
    let mut gains: Vec<Collateral> = untouched(before, after, perturbations).filter(|c| c.gain() > cut).collect();
    gains.sort_by(|a, b| rounded(b.gain()).total_cmp(&rounded(a.gain())).then(a.vessel.cmp(&b.vessel)));
    gains
}

/// The vessels not perturbed themselves whose flow turns round, the largest flow after it first.
pub fn reversals(before: &State, after: &State, perturbations: &[Perturbation]) -> Vec<Collateral> {
    let cut = CUT * before.inflow.max(after.inflow);
    let flows = |c: &Collateral| c.before.abs() > cut && c.after.abs() > cut;
    let mut turned: Vec<Collateral> = untouched(before, after, perturbations).filter(|c| c.is_reversed() && flows(c)).collect();
    turned.sort_by(|a, b| rounded(b.after.abs()).total_cmp(&rounded(a.after.abs())).then(a.vessel.cmp(&b.vessel)));
    turned
}

/// A figure to 24 bits, so that equal vessels stay in their order whatever the last roundings are.
fn rounded(x: f64) -> f32 {
    x as f32
}

fn untouched<'a>(
    before: &'a State,
    after: &'a State,
    perturbations: &'a [Perturbation],
) -> impl Iterator<Item = Collateral> + 'a {
    let pairs = before.vessels.iter().zip(&after.vessels).enumerate();
    pairs.filter(|(row, _)| perturbations.iter().all(|p| p.vessel != *row)).map(|(vessel, (b, a))| Collateral {
        vessel,
        before: b.flow,
        after: a.flow,
    })
}
