//! The exact expectation of a run: all 2^E subgraphs of a small network, each with its probability.

use willis::internals::network::{Condition, Network, Origin};
use willis::internals::perturbation::Enumeration;
use willis::internals::sampling::{Uncertain, Weight};

use crate::textbook::{Sample, best_of_all_forests};

/// Mean and variance of one sample's contribution, per vessel.
#[derive(Clone, Default)]
pub struct Moments {
    pub mean: Vec<f64>,
    pub variance: Vec<f64>,
}

/// What infinitely many samples would say.
pub struct Exact {
    moments: [Moments; 3],
    pub frequency: Vec<f64>,
    /// Mean and variance of ρ_G.
    pub network_resilience: [f64; 2],
}

impl Exact {
    pub fn moments(&self, weight: Weight) -> &Moments {
        &self.moments[index(weight)]
    }
}

fn index(weight: Weight) -> usize {
    match weight {
        Weight::Resilience => 0,
        Weight::Count => 1,
        Weight::Global => 2,
    }
}

/// λA of every vessel uncertain, one for the others.
pub fn keep(network: &Network, epsilon: f64, uncertain: Uncertain) -> Vec<f64> {
    let keep = network.vessels().map(|(_, v)| {
        let is_uncertain = !v.certain && (uncertain == Uncertain::All || v.origin == Origin::Candidate);
        if is_uncertain { (1.0 - epsilon) * v.prior } else { 1.0 }
    });
    keep.collect()
}

/// Enumerates the subgraphs.
pub fn enumerate(network: &Network, conditions: &[(usize, Condition)], keep: &[f64]) -> Exact {
    let vessels = keep.len();
    let zero = Moments { mean: vec![0.0; vessels], variance: vec![0.0; vessels] };
    let mut exact =
        Exact { moments: [zero.clone(), zero.clone(), zero], frequency: vec![0.0; vessels], network_resilience: [0.0; 2] };
    for mask in 0_u32..1 << vessels {
        let open: Vec<bool> = (0..vessels).map(|row| mask >> row & 1 == 1).collect();
        let probability: f64 = open.iter().zip(keep).map(|(open, k)| if *open { *k } else { 1.0 - k }).product();
        if probability == 0.0 {
            continue;
        }
        let present = mask.count_ones();
        let diffused = Sample { network, conditions, open }.resiliences();
        let total: f64 = diffused.iter().map(|(_, x)| x).sum();
        let global = if present > 0 { total / f64::from(present) } else { 0.0 };
        exact.network_resilience[0] += probability * global;
        exact.network_resilience[1] += probability * global * global;
        for row in best_of_all_forests(network, &diffused) {
            let own = diffused.iter().find(|(r, _)| *r == row).unwrap().1;
            exact.frequency[row] += probability;
            for (moments, x) in exact.moments.iter_mut().zip([own, 1.0, global]) {
                moments.mean[row] += probability * x;
                moments.variance[row] += probability * x * x;
            }
        }
    }
    for moments in &mut exact.moments {
        moments.variance.iter_mut().zip(&moments.mean).for_each(|(v, m)| *v -= m * m);
    }
    exact.network_resilience[1] -= exact.network_resilience[0].powi(2);
    exact
}

#[test]
fn every_pattern_comes_once_with_its_probability() {
    let keep = [0.5, 1.0, 0.25, 0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7];
    let all = Enumeration::new(&keep).expect("eight uncertain vessels");
    assert_eq!(all.patterns(), 256);
    let (mut masks, mut probability) = (Vec::new(), [0.0; 64]);
    let mut seen = std::collections::BTreeMap::new();
    for block in 0..4 {
        all.fill(block, &mut masks, &mut probability);
        for (i, p) in probability.iter().enumerate() {
            let pattern: Vec<bool> = masks.iter().map(|m| m >> i & 1 == 1).collect();
            assert!(pattern[1] && !pattern[3]);
            let product: f64 = keep.iter().zip(&pattern).map(|(k, open)| if *open { *k } else { 1.0 - k }).product();
            assert!((p - product).abs() < 1e-15);
            assert!(seen.insert(pattern, *p).is_none());
        }
    }
    assert_eq!(seen.len(), 256);
    assert!((seen.values().sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(Enumeration::new(&[0.5; 21]), Err(21));
}
