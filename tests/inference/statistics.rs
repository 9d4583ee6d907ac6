//! Sampled figures against their theoretical spread: occlusion against the binomial, standard errors and L over 1000 seeds
//! against enumeration.

use crate::draw::Draw;
use crate::exact::{enumerate, keep};
use crate::networks::{radii, random_conditions, random_network, run};
use willis::internals::decision::{Keep, all_decided, decide};
use willis::internals::network::{Condition, Network, Node, Origin, Vessel};
use willis::internals::perturbation::Occlusion;
use willis::internals::sampling::{SamplingOptions, Uncertain, Weight};
use willis::internals::support::Distribution;
use willis::internals::support::statistics::{median, otsu, quantile};

const EDGES: usize = 40;
const BLOCKS: u64 = 2500;
const SEEDS: u64 = 1000;

/// A mean of `n` independent figures of deviation `deviation`, five standard errors wide: one in two million is outside.
fn within(got: f64, expected: f64, deviation: f64, n: f64, what: &str) {
    let z = (got - expected) / (deviation / n.sqrt());
    assert!(z.abs() < 5.0, "{what}: {got} for {expected}, z = {z}");
}

/// The masks of many blocks, [block][edge].
fn draw(p: f64, seed: u64) -> Vec<Vec<u64>> {
    let occlusion = Occlusion::new([p; EDGES]);
    let masks = (0..BLOCKS).map(|block| {
        let mut masks = Vec::new();
        occlusion.draw(seed, block, &mut masks);
        masks
    });
    masks.collect()
}

const RATES: [f64; 6] = [0.5, 0.1, 0.9, 1.0 / 3.0, 0.999, 1e-3];

/// Over all, per edge and per place in the block. 6.4 million bits fix a rate to 2e-4 of the deviation.
#[test]
fn vessels_are_open_at_their_rate() {
    for p in RATES {
        let masks = draw(p, 0);
        let deviation = (p * (1.0 - p)).sqrt();
        let mut place = [0_u32; 64];
        let mut edge = [0_u32; EDGES];
        for (e, mask) in masks.iter().flat_map(|masks| masks.iter().enumerate()) {
            edge[e] += mask.count_ones();
            (0..64).for_each(|i| place[i] += (mask >> i & 1) as u32);
        }
        let n = BLOCKS as f64;
        within(f64::from(edge.iter().sum::<u32>()) / (64.0 * n * EDGES as f64), p, deviation, 64.0 * n * EDGES as f64, "all");
        for (e, count) in edge.iter().enumerate() {
            within(f64::from(*count) / (64.0 * n), p, deviation, 64.0 * n, &format!("p = {p}, edge {e}"));
        }
        for (i, count) in place.iter().enumerate() {
            within(f64::from(*count) / (EDGES as f64 * n), p, deviation, EDGES as f64 * n, &format!("p = {p}, place {i}"));
        }
    }
}

/// Neighbouring edges, samples, blocks and seeds agree as often as independent ones: both open p².
#[test]
fn neighbours_are_independent() {
    for p in RATES {
        let (masks, other_seed) = (draw(p, 1), draw(p, 2));
        let both = p * p;
        let deviation = (both * (1.0 - both)).sqrt();
        let check = |what: &str, pairs: &mut dyn Iterator<Item = (u64, u64)>, places: f64| {
            let (mut joint, mut n) = (0_u64, 0.0);
            for (a, b) in pairs {
                joint += u64::from((a & b).count_ones());
                n += places;
            }
            // Chains of pairs share members; that makes their mean spread up to sqrt(1 + 2p) times as far.
            within(joint as f64 / n, both, deviation * (1.0 + 2.0 * p).sqrt(), n, &format!("p = {p}, {what}"));
        };
        check("edges", &mut masks.iter().flat_map(|m| m.windows(2).map(|w| (w[0], w[1]))), 64.0);
        let inner = u64::MAX >> 1;
        check("samples", &mut masks.iter().flatten().map(|m| (m & inner, m >> 1)), 63.0);
        let blocks = masks.windows(2).flat_map(|w| w[0].iter().copied().zip(w[1].iter().copied()));
        check("blocks", &mut { blocks }, 64.0);
        let diagonal = masks.windows(2).flat_map(|w| w[0][1..].iter().copied().zip(w[1].iter().copied()));
        check("next edge of the block before", &mut { diagonal }, 64.0);
        check("seeds", &mut masks.iter().flatten().copied().zip(other_seed.iter().flatten().copied()), 64.0);
    }
}

/// Certain vessels and impossible ones draw nothing: the others keep their bits.
#[test]
fn zero_and_one_are_exact() {
    let of = |keep: &[f64]| {
        let mut masks = Vec::new();
        Occlusion::new(keep.iter().copied()).draw(4, 9, &mut masks);
        masks
    };
    let masks = of(&[0.5, 0.0, 0.3, 1.0, 0.7]);
    assert_eq!((masks[1], masks[3]), (0, u64::MAX));
    assert_eq!([masks[0], masks[2], masks[4]], of(&[0.5, 0.3, 0.7])[..]);
}

/// Blocks cover a thin tail too: the number of open bits per mask has the variance of the binomial.
#[test]
fn masks_spread_as_the_binomial() {
    for p in RATES {
        let counts: Vec<f64> = draw(p, 3).into_iter().flatten().map(|m| f64::from(m.count_ones())).collect();
        let (n, mean) = (counts.len() as f64, 64.0 * p);
        let variance = 64.0 * p * (1.0 - p);
        let second = counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / n;
        // The fourth central moment of the binomial is 3 V² + V (1 - 6 p (1 - p)).
        let fourth = 3.0 * variance.powi(2) + variance * (1.0 - 6.0 * p * (1.0 - p));
        within(second, variance, (fourth - variance.powi(2)).sqrt(), n, &format!("p = {p}"));
    }
}

/// L of 1000 seeds on two graphs: its spread against the standard errors that the runs state, and its z-scores against the
/// standard normal.
///
/// The variance over 1000 seeds is off by sqrt(2/1000) = 4.5 % of itself; 5 of these, and 5 % for the vessel that is in few
/// forests. Pooled over the vessels the z-scores have mean square 1, and the shares beyond 1 and 2 are near 31.7 % and
/// 4.6 %; vessels share samples, so these count as if two vessels in three said nothing new.
#[test]
fn standard_errors_and_z_scores_over_seeds() {
    for (graph, weight) in [(1, Weight::Resilience), (2, Weight::Resilience), (2, Weight::Global)] {
        let mut draw = Draw::new(40 + graph);
        let network = random_network(&mut draw, 7, 11, radii(0.5, 1.5));
        let conditions = random_conditions(&mut draw, 7);
        let params = |seed| SamplingOptions {
            epsilon: 0.3,
            samples: 3200,
            seed,
            uncertain: Uncertain::All,
            weight,
            ..SamplingOptions::default()
        };
        let exact = enumerate(&network, &conditions, &keep(&network, 0.3, Uncertain::All));
        let runs: Vec<_> = (0..SEEDS).map(|seed| run(&network, &conditions, &params(seed))).collect();
        let mut pooled = Vec::new();
        let rows = (0..11).filter(|row| (0.03..0.97).contains(&exact.frequency[*row]));
        for row in rows {
            let expected = 3200.0 * exact.moments(weight).mean[row];
            let z: Vec<f64> = runs.iter().map(|r| (r.likelihood[row] - expected) / r.std_error[row]).collect();
            let n = SEEDS as f64;
            let mean_square = |f: &dyn Fn(usize) -> f64| (0..runs.len()).map(|i| f(i).powi(2)).sum::<f64>() / n;
            let spread = mean_square(&|i| runs[i].likelihood[row] - expected);
            let stated = mean_square(&|i| runs[i].std_error[row]);
            let what = format!("graph {graph}, {weight:?}, vessel {row}");
            assert!((spread / stated - 1.0).abs() < 5.0 * (2.0 / n).sqrt() + 0.05, "{what}: {spread} for {stated}");
            within(z.iter().sum::<f64>() / n, 0.0, 1.0, n, &what);
            pooled.extend(z);
        }
        assert!(pooled.len() >= 5 * SEEDS as usize);
        let share = |beyond: f64| pooled.iter().filter(|z| z.abs() > beyond).count() as f64 / pooled.len() as f64;
        let independent = pooled.len() as f64 / 3.0;
        let square = pooled.iter().map(|z| z * z).sum::<f64>() / pooled.len() as f64;
        within(square, 1.0, 2_f64.sqrt(), independent, "mean square");
        within(share(1.0), 0.3173, (0.3173_f64 * 0.6827).sqrt(), independent, "beyond 1");
        within(share(2.0), 0.0455, (0.0455_f64 * 0.9545).sqrt(), independent, "beyond 2");
        let positive = pooled.iter().filter(|z| **z > 0.0).count() as f64 / pooled.len() as f64;
        within(positive, 0.5, 0.5, independent, "above zero");
    }
}

/// One sample has no standard error to speak of, and equal contributions have none.
#[test]
fn no_spread_no_error() {
    let mut draw = Draw::new(50);
    let network = random_network(&mut draw, 7, 11, radii(0.5, 1.5));
    let conditions = random_conditions(&mut draw, 7);
    let of = |samples, epsilon| run(&network, &conditions, &SamplingOptions { samples, epsilon, ..SamplingOptions::default() });
    assert!(of(1, 0.3).std_error.iter().all(|error| error.is_nan()));
    let open = run(&network, &conditions, &SamplingOptions { epsilon: 0.0, uniform_prior: true, ..SamplingOptions::default() });
    // What no sample saw may be seen three times in as many samples, 95 % of 1.96 errors, by the rule of three.
    let n = open.samples as f64;
    let heaviest = open.likelihood.iter().fold(0.0, |most: f64, l| most.max(l / n));
    for row in 0..11 {
        let expected = if open.frequency[row] > 0.0 { 0.0 } else { 3.0 / 1.96 * heaviest };
        assert!((open.std_error[row] - expected).abs() <= 1e-12 * heaviest, "{row}: {}", open.std_error[row]);
    }
    // Nothing is uncertain: no sample differs from another.
    let mut certain = network.clone();
    for row in 0..11 {
        certain.vessel_mut(row).origin = Origin::Observed;
    }
    let candidates = SamplingOptions { uncertain: Uncertain::Candidates, ..SamplingOptions::default() };
    assert_eq!(run(&certain, &conditions, &candidates).std_error, [0.0; 11]);
}

/// Three vessels in series, each open in one sample of a thousand: blood flows in one of 10⁹, so 64 samples tell nothing of L, which the
/// enumeration has above zero. An error of 0 would say that L is 0, exactly; and nothing is decided.
#[test]
fn where_blood_flowed_in_no_sample_the_error_is_unknown() {
    let mut network = Network::new();
    let nodes: Vec<usize> = (0..4).map(|id| network.add_node(Node { id: id.to_string(), ..Node::default() })).collect();
    for pair in nodes.windows(2) {
        network.add_vessel([pair[0], pair[1]], Vessel::new(0.01, 0.001, Origin::Candidate));
    }
    let conditions = [(nodes[0], Condition::Pressure(1e4)), (nodes[3], Condition::Pressure(0.0))];
    let options = SamplingOptions { epsilon: 0.999, samples: 64, uniform_prior: true, ..SamplingOptions::default() };
    let result = run(&network, &conditions, &options);
    assert_eq!(result.likelihood, [0.0; 3]);
    assert!(result.std_error.iter().all(|error| error.is_nan()), "{:?}", result.std_error);
    let decided = decide(Keep::Median, &network, &result).unwrap();
    assert_eq!((decided.undecided, decided.threshold), (vec![0, 1, 2], None));
    assert!(!all_decided(Keep::Median, &network, &result).unwrap());
    // Where it flows in every sample, all is as it was.
    let open = run(&network, &conditions, &SamplingOptions { epsilon: 0.0, ..options });
    assert!(open.likelihood.iter().all(|l| *l > 0.0));
    assert_eq!(open.std_error, [0.0; 3]);
    assert_eq!(decide(Keep::Value(0.0), &network, &open).unwrap().undecided, [0; 0]);
}

/// L of a vessel that few samples saw, or none, lies within 1.96 of its error in 95 % of runs at least; the truth is the enumeration. Vessels that
/// more samples saw are those of [`standard_errors_and_z_scores_over_seeds`].
#[test]
fn errors_hold_for_vessels_that_few_samples_saw() {
    // By how many samples saw the vessel: none, fewer than 5, fewer than 20.
    let (mut held, mut all) = ([0.0; 3], [0.0; 3]);
    for graph in 0..8 {
        let mut draw = Draw::new(60 + graph);
        let network = random_network(&mut draw, 7, 11, radii(0.5, 1.5));
        let conditions = random_conditions(&mut draw, 7);
        let exact =
            enumerate(&network, &conditions, &keep(&network, 0.05, Uncertain::All)).moments(Weight::Resilience).mean.clone();
        for (seed, samples) in (0..50).flat_map(|seed| [(seed, 64), (seed, 640)]) {
            let params =
                SamplingOptions { epsilon: 0.05, samples, seed, uncertain: Uncertain::All, ..SamplingOptions::default() };
            let result = run(&network, &conditions, &params);
            for row in (0..11).filter(|row| exact[*row] > 0.0) {
                let error = result.std_error[row];
                let times = (result.frequency[row] * samples as f64).round() as u64;
                assert!(error > 0.0 || times == samples, "{graph} {seed} {row}");
                let group = [1, 5, 20].iter().filter(|least| times >= **least).count();
                if group < 3 {
                    let off = (result.likelihood[row] - samples as f64 * exact[row]).abs();
                    held[group] += f64::from(off <= 1.96 * error);
                    all[group] += 1.0;
                }
            }
        }
    }
    for (held, all) in held.into_iter().zip(all) {
        // Two points of a hundred for the shares themselves, of which some hundred independent ones are counted.
        assert!(all > 100.0 && held / all > 0.93, "{held} of {all}");
    }
}

#[test]
fn the_figures_are_those_of_numpy() {
    // numpy: mean, std(ddof=1), quantile of [3, 1, 4, 1, 5]
    let d = Distribution::of(vec![3.0, 1.0, 4.0, 1.0, 5.0]);
    assert!((d.mean - 2.8).abs() < 1e-15 && (d.std - 1.788_854_381_999_831_6).abs() < 1e-15);
    assert_eq!(d.quantiles, [1.0, 1.0, 3.0, 4.0, 4.8]);
    assert!(Distribution::of(vec![1.0, f64::NAN]).quantiles[0].is_nan());
    assert!(Distribution::of(Vec::new()).mean.is_nan());
}

#[test]
fn quantiles_are_those_of_numpy() {
    // numpy.quantile([3, 1, 4, 1, 5, 9, 2, 6], [0.5, 0.1, 0.9])
    let v = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0];
    assert_eq!(median(&v), Some(3.5));
    assert_eq!(quantile(&v, 0.1), Some(1.0));
    assert!((quantile(&v, 0.9).unwrap_or(0.0) - 6.9).abs() < 1e-12);
    assert_eq!(median(&[]), None);
}

#[test]
fn otsu_cuts_between_two_clusters() {
    assert_eq!(otsu(&[1.0, 2.0, 10.0, 11.0], 0.0), Some(6.0));
    assert_eq!(otsu(&[2.0, 2.0], 0.0), None);
    assert_eq!(otsu(&[2.0, 2.0 + 1e-15, 2.0 - 1e-15], 1e-9), None);
}
