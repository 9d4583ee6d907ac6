//! Features of a bridge from a posterior: what is probable of the other bridges speaks for or against this one.
//!
//! The posterior of [`FEATURES`](super::FEATURES) alone says where blood probably enters each fragment; from there follow the
//! way it runs at every point, which meeting points are taken, and which fragments are fed. A second posterior uses that.

mod claims;
mod entries;

use ndarray::Array2;

use super::extraction::Extraction;
use super::search::FoundBridge;
use super::steady::steady;
use crate::geometry::{dot, sub, unit};
use crate::posterior::{Forests, Marginals, rooted_in};
use claims::Claims;
use entries::Entries;

/// The features of a bridge from a posterior, by the names that weights have in a file. P is the probability of a bridge.
///
/// - `with_flow`: -F t·u where the parent is met on its way, else 0: t its tangent, u across the gap from the child, F the entries
///   of blood to expect behind the point less those ahead. A branch goes on with the flow.
/// - `step_with_flow`: F ln r₁/r₂ where the parent is met on its way, else 0: r₁ the parent's radius behind, r₂ ahead. A vessel is thinner
///   after a branch.
/// - `entered_there`: Σ P of the bridges by which the parent hangs elsewhere by the free end that is met; 0 on its way. An end has one
///   neighbour.
/// - `claims_on_end`: Σ P of the bridges by which other fragments than the parent hang on the child's end.
/// - `fed_otherwise`: the probability that the parent is fed, by an inlet, without the child's help. No bridge goes round.
/// - `claims_nearby`: Σ P, at most 2, of the bridges of other fragments that meet the parent near the same point on its way.
pub const FEEDBACK_FEATURES: &[&str] =
    &["with_flow", "step_with_flow", "entered_there", "claims_on_end", "fed_otherwise", "claims_nearby"];

/// Claims on a point beyond so many are all alike.
const MOST_CLAIMS: f64 = 2.0;

/// What of the feedback does not change from one posterior to the next.
pub struct Feedback<'a> {
    extraction: &'a Extraction,
    bridges: Vec<FoundBridge>,
    entries: Entries,
    claims: Claims,
    /// Per fragment whether it is taken to be fed.
    fed: Vec<bool>,
}

impl<'a> Feedback<'a> {
    /// The feedback on bridges between fragments. Where no inlet is known the longest fragment is taken to be fed.
    ///
    /// # Panics
    ///
    /// When a bridge is within a fragment.
    pub fn new(extraction: &'a Extraction, bridges: &[FoundBridge]) -> Self {
        assert!(bridges.iter().all(|bridge| !bridge.inside), "bridges between fragments");
        let fragments = &extraction.fragments;
        let longest = fragments.iter().map(|f| f.length).fold(0.0, f64::max);
        let given = fragments.iter().any(|f| f.fed);
        let fed = |length: f64| longest > 0.0 && steady(length / longest) >= 1.0;
        Self {
            extraction,
            bridges: bridges.to_vec(),
            entries: Entries::new(extraction),
            claims: Claims::new(extraction, bridges),
            fed: fragments.iter().map(|f| if given { f.fed } else { fed(f.length) }).collect(),
        }
    }

    /// The features of every bridge, shape (bridges, [`FEEDBACK_FEATURES`]).
    ///
    /// # Panics
    ///
    /// When the forests are not those of the bridges, in their order, or the marginals are of others.
    pub fn features(&self, forests: &Forests, marginals: &Marginals) -> Array2<f64> {
        assert_eq!(forests.bridges().len(), self.bridges.len(), "the forests of the same bridges");
        assert_eq!(forests.fragments(), self.fed.len(), "the forests of the same fragments");
        assert_eq!(marginals.bridges.len(), self.bridges.len(), "the marginals of the same forests");
        let e = self.extraction;
        let balance = self.entries.balance(e, &self.bridges, marginals);
        let fed = rooted_in(forests, &self.fed);
        let mut out = Array2::zeros((self.bridges.len(), FEEDBACK_FEATURES.len()));
        for (row, (bridge, mut out)) in self.bridges.iter().zip(out.rows_mut()).enumerate() {
            let sum = |rows: &[usize]| rows.iter().map(|row| marginals.bridges[*row]).sum::<f64>();
            let course = &e.course[bridge.point];
            let across = unit(sub(e.position[bridge.point], e.position[e.ends[bridge.end].point]));
            // At nodes the course is zero, and nothing is said.
            let balance = balance[e.branch[bridge.point]];
            let values = [
                -balance * dot(course.tangent, across),
                balance * course.narrowing,
                sum(&self.claims.elsewhere[row]),
                sum(&self.claims.on_child[row]),
                fed_without(forests, marginals, &fed, row),
                sum(&self.claims.beside[row]).min(MOST_CLAIMS),
            ];
            out.iter_mut().zip(values).for_each(|(out, value)| *out = value);
        }
        out
    }
}

/// The probability that a walk from the parent dies in a fed fragment before it meets the child: f_p - f_c G_pc/G_cc with f the
/// probability that a fragment's tree is rooted in a fed one, G_pc/G_cc = 1 - P_e v_c/(w_e P(root c)).
fn fed_without(forests: &Forests, marginals: &Marginals, fed: &[f64], row: usize) -> f64 {
    let bridge = &forests.bridges()[row];
    let (child, parent) = (bridge.child, bridge.parent);
    if bridge.log_weight == f64::NEG_INFINITY {
        return fed[parent];
    }
    let odds = (forests.log_roots()[child] - bridge.log_weight).exp();
    let apart = (marginals.bridges[row] / marginals.roots[child] * odds).min(1.0);
    (fed[parent] - (1.0 - apart) * fed[child]).clamp(0.0, 1.0)
}
