//! The bridges between fragments with their features, and the weights that a pass gives them.

use std::collections::BTreeMap;

use ndarray::{Array1, Array2, ArrayView1, Axis};

use super::weights::Pass;
use crate::candidates::features::extraction::Extraction;
use crate::candidates::features::features;
use crate::candidates::features::root_features::root_features;
use crate::candidates::search::by_evidence::FoundBridge;
use crate::error::Result;
use crate::forest_posterior;
use crate::forest_posterior::Forests;

/// Log weights are cut at ±25: an odd feature cannot settle a question for good.
const MOST_LOG_WEIGHT: f64 = 25.0;

/// The bridges between fragments.
pub struct Rows {
    /// The bridges, in the order of the search.
    pub bridges: Vec<FoundBridge>,
    /// The bridges within a fragment.
    pub inside: Vec<FoundBridge>,
    /// Their features, shape (bridges within a fragment, features).
    pub inside_features: Array2<f64>,
    /// Child and parent fragment of each.
    pub fragments: Vec<[usize; 2]>,
    /// The number of its link: the two directions between a pair of points share one.
    pub link: Vec<usize>,
    /// How many links there are.
    pub links: usize,
    /// Features, shape (bridges, features).
    pub bridge: Array2<f64>,
    /// Features of the fragments as roots, shape (fragments, features).
    pub root: Array2<f64>,
}

impl Rows {
    /// Measures the bridges of a search; those within a fragment count among the rivals of the others and stand apart then.
    pub fn new(extraction: &Extraction, found: &[FoundBridge]) -> Self {
        let (inside, between): (Vec<usize>, Vec<usize>) = (0..found.len()).partition(|row| found[*row].inside);
        let all = features(extraction, found);
        let [bridge, inside_features] = [&between, &inside].map(|rows| all.select(Axis(0), rows));
        let inside = inside.into_iter().map(|row| found[row]).collect();
        let bridges: Vec<FoundBridge> = between.into_iter().map(|row| found[row]).collect();
        let mut links = BTreeMap::new();
        let mut link = Vec::with_capacity(bridges.len());
        let mut fragments = Vec::with_capacity(bridges.len());
        for bridge in &bridges {
            let points = [extraction.ends[bridge.end].point, bridge.point];
            let next = links.len();
            link.push(*links.entry([points[0].min(points[1]), points[0].max(points[1])]).or_insert(next));
            fragments.push(points.map(|point| extraction.fragment[point]));
        }
        Self { bridges, inside, inside_features, fragments, link, links: links.len(), bridge, root: root_features(extraction) }
    }

    /// The features of the bridges with more columns beside them.
    pub fn beside(&self, more: &Array2<f64>) -> Array2<f64> {
        let (rows, own) = self.bridge.dim();
        Array2::from_shape_fn((rows, own + more.ncols()), |(row, column)| {
            if column < own { self.bridge[[row, column]] } else { more[[row, column - own]] }
        })
    }

    /// Per link the sum of a quantity of its directions, at most 1.
    pub fn summed(&self, of_bridge: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.links];
        for (link, x) in self.link.iter().zip(of_bridge) {
            sum[*link] += x;
        }
        sum.into_iter().map(|x: f64| x.min(1.0)).collect()
    }

    /// The forests that the weights of a pass make of the features of its bridges.
    ///
    /// # Errors
    ///
    /// A feature or weight that is no number.
    pub fn forests(&self, pass: &Pass, bridge: &Array2<f64>) -> Result<Forests> {
        weighed(&self.fragments, (bridge, ArrayView1::from(&pass.bridge)), (&self.root, ArrayView1::from(&pass.root)))
    }
}

/// Whether a log weight stands at its limit, where the weights of features no longer move it.
pub fn is_cut(log_weight: f64) -> bool {
    log_weight.abs() >= MOST_LOG_WEIGHT
}

/// The forests of bridges between fragments (child, parent), by features and weights of bridges and roots.
pub fn weighed(
    fragments: &[[usize; 2]],
    (bridge, beta): (&Array2<f64>, ArrayView1<f64>),
    (root, gamma): (&Array2<f64>, ArrayView1<f64>),
) -> Result<Forests> {
    let log_weights: Array1<f64> = bridge.dot(&beta);
    let cut = |x: &f64| x.clamp(-MOST_LOG_WEIGHT, MOST_LOG_WEIGHT);
    let bridges = fragments.iter().zip(&log_weights);
    let bridges = bridges
        .map(|([child, parent], w)| forest_posterior::Bridge { child: *child, parent: *parent, log_weight: cut(w) })
        .collect();
    Forests::new(root.dot(&gamma).iter().map(cut).collect(), bridges)
}
