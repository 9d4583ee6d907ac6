//! Whole topologies and their weights: against independent products for the free ends, against enumeration for the samples' votes.

use std::collections::BTreeMap;

use crate::draw::Draw as Random;
use crate::exact;
use crate::networks::{boundary, radii, random_conditions, random_network, run};
use crate::textbook::{Sample, best_of_all_forests};
use crate::vessels::{network, tube};
use willis::internals::decision::{Keep, KnownEnds, Topologies, TopologySource, decide};
use willis::internals::network::{Condition, Evidence, Network, Node, Origin, Vessel};
use willis::internals::perturbation::Occlusion;
use willis::internals::sampling::{SamplingOptions, Uncertain, Weight};

fn candidate(continuation_odds: [f64; 2]) -> Vessel {
    let evidence = Some(Box::new(Evidence { continuation_odds, ..Evidence::undirected(0.5) }));
    Vessel { origin: Origin::Candidate, prior: 0.5, evidence, ..tube(1.0, 1.0) }
}

/// Two fragments 0 - 1 and 2 - 3; candidates from the free ends 1 and 2 to one another and past it.
fn broken() -> Network {
    network(
        4,
        [
            ([0, 1], tube(10.0, 1.0)),
            ([2, 3], tube(10.0, 1.0)),
            ([1, 2], candidate([3.0, 1.0])),
            ([1, 3], candidate([2.0, 0.0])),
            ([0, 2], candidate([9.0, 5.0])),
        ],
    )
}

fn shares(topologies: &Topologies) -> BTreeMap<Vec<bool>, f64> {
    topologies.weighted.iter().cloned().collect()
}

/// End 1 takes candidate 2 with 3/6, 3 with 2/6, none with 1/6; end 2 takes 2 with 1/7, 4 with 5/7, none with 1/7. Ends 0 and 3 are
/// known. Where 0 is known for an inlet, the topology that leaves 3 without blood, the one without any candidate, weighs e⁻² of that.
fn assert_shares(inlets: &[usize], weight_unfed: f64) {
    let network = broken();
    let known = [true, false, false, true];
    let params = SamplingOptions { samples: 70_000, seed: 3, ..SamplingOptions::default() };
    let draw = TopologySource::FreeEnds(KnownEnds { ends: &known, inlets });
    let drawn = Topologies::draw(&network, &boundary(&network, &[]), &params, draw).unwrap();
    assert_eq!(drawn.samples, 70_000);
    let one = [(Some(2), 3.0 / 6.0), (Some(3), 2.0 / 6.0), (None, 1.0 / 6.0)];
    let two = [(Some(2), 1.0 / 7.0), (Some(4), 5.0 / 7.0), (None, 1.0 / 7.0)];
    let mut expected: BTreeMap<Vec<bool>, f64> = BTreeMap::new();
    for (a, p) in one {
        for (b, q) in two {
            let kept = (0..5).map(|row| row < 2 || a == Some(row) || b == Some(row)).collect();
            let weight = if a.or(b).is_none() { weight_unfed } else { 1.0 };
            *expected.entry(kept).or_default() += weight * p * q;
        }
    }
    let all: f64 = expected.values().sum();
    for p in expected.values_mut() {
        *p /= all;
    }
    let drawn = shares(&drawn);
    assert_eq!(drawn.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (kept, p) in &expected {
        let error = (p * (1.0 - p) / 70_000.0).sqrt();
        assert!((drawn[kept] - p).abs() < 4.5 * error, "{kept:?}: {} for {p}", drawn[kept]);
    }
}

#[test]
fn free_ends_continue_by_their_odds_whatever_the_others_do() {
    assert_shares(&[], 1.0);
}

#[test]
fn a_topology_weighs_less_for_every_outlet_that_it_leaves_without_blood() {
    assert_shares(&[0], (-2.0_f64).exp());
}

/// A candidate that is certain is there and closes its ends; a vessel at a known outlet goes nowhere.
#[test]
fn what_is_known_stays_as_it_is() {
    let mut network = broken();
    network.vessel_mut(2).certain = true;
    let all = |known: [bool; 4]| {
        let drawn = Topologies::draw(
            &network,
            &boundary(&network, &[]),
            &SamplingOptions::default(),
            TopologySource::FreeEnds(KnownEnds { ends: &known, inlets: &[] }),
        )
        .unwrap();
        shares(&drawn)
    };
    assert_eq!(all([true; 4]), BTreeMap::from([(vec![true, true, true, false, false], 1.0)]));
    let drawn = all([false, true, true, true]);
    assert_eq!(drawn.len(), 2);
    let closed = drawn[&vec![true, true, true, false, true]];
    assert!((closed - 0.9).abs() < 0.05, "{closed}");
}

/// By hand, with odds of 1, 1/2 and 1/4: end 1 is asked first, and takes candidate 2 with 1/2.5, 3 with 0.5/2.5, none with 1/2.5. Where it takes 2, end 2 is
/// joined; else that takes 4 with 0.25/1.25, and 2 no more.
#[test]
fn a_connection_is_asked_once_and_a_free_end_joined_once() {
    let mut network = broken();
    for (row, p) in [(2, 1.0 / 2.0), (3, 1.0 / 3.0), (4, 1.0 / 5.0)] {
        network.vessel_mut(row).evidence = Some(Box::new(Evidence::undirected(p)));
    }
    let draw = |network: &Network, known: [bool; 4]| {
        let params = SamplingOptions { samples: 70_000, seed: 3, ..SamplingOptions::default() };
        let source = TopologySource::Connections(KnownEnds { ends: &known, inlets: &[] });
        shares(&Topologies::draw(network, &boundary(network, &[]), &params, source).unwrap())
    };
    let drawn = draw(&network, [true, false, false, true]);
    let expected = [(&[2][..], 0.4), (&[3, 4], 0.04), (&[3], 0.16), (&[4], 0.08), (&[], 0.32)];
    assert_eq!(drawn.len(), expected.len());
    for (rows, p) in expected {
        let found = drawn[&(0..5).map(|row| row < 2 || rows.contains(&row)).collect::<Vec<bool>>()];
        assert!((found - p).abs() < 4.5 * (p * (1.0 - p) / 70_000.0_f64).sqrt(), "{rows:?}: {found} for {p}");
    }
    // Alone between two free ends it has its own probability.
    for row in [3, 4] {
        network.vessel_mut(row).evidence = Some(Box::new(Evidence::undirected(0.0)));
    }
    network.vessel_mut(2).evidence = Some(Box::new(Evidence::undirected(0.3)));
    let alone = draw(&network, [false; 4])[&vec![true, true, true, false, false]];
    let is_three_tenths = |found: f64| assert!((found - 0.3).abs() < 4.5 * (0.3 * 0.7 / 70_000.0_f64).sqrt(), "{found}");
    is_three_tenths(alone);
    // Beside one that a person accepted it has its own too.
    network.vessel_mut(3).certain = true;
    is_three_tenths(draw(&network, [false; 4])[&vec![true, true, true, true, false]]);
}

/// By hand, where fragments form a forest: of two candidates between the first two fragments, P = 0.6 and 0.2, one is true with 0.6, and is the first with three
/// quarters of that; of the others between three fragments, 0.5 and 0.4, the last is asked unless both before it were true. Two go on from one end.
#[test]
fn two_fragments_are_joined_once_and_a_vessel_may_have_two_daughters() {
    let mut network = Network::new();
    for id in 0..6 {
        network.add_node(Node { id: format!("n{id}"), root_score: Some(0.1), ..Node::default() });
    }
    for a in [0, 2, 4] {
        network.add_vessel([a, a + 1], Vessel::new(0.01, 0.001, Origin::Observed));
    }
    for (ends, p) in [([1, 2], 0.6), ([1, 3], 0.2), ([1, 4], 0.5), ([2, 4], 0.4)] {
        let evidence = Some(Box::new(Evidence::undirected(p)));
        network.add_vessel(ends, Vessel { evidence, ..Vessel::new(0.01, 0.001, Origin::Candidate) });
    }
    let params = SamplingOptions { samples: 70_000, seed: 5, ..SamplingOptions::default() };
    let source = TopologySource::Connections(KnownEnds { ends: &[false; 6], inlets: &[] });
    let draw = |network: &Network| shares(&Topologies::draw(network, &boundary(network, &[]), &params, source).unwrap());
    let drawn = draw(&network);
    let mut expected = BTreeMap::new();
    for (first, p) in [(Some(3), 0.45), (Some(4), 0.15), (None, 0.4)] {
        for (second, q) in [(Some(5), 0.5), (None, 0.5)] {
            let asked = first.is_none() || second.is_none();
            for (third, r) in [(Some(6), if asked { 0.4 } else { 0.0 }), (None, if asked { 0.6 } else { 1.0 })] {
                let rows = [first, second, third];
                expected.insert((0..7).map(|row| row < 3 || rows.contains(&Some(row))).collect::<Vec<bool>>(), p * q * r);
            }
        }
    }
    expected.retain(|_, p| *p > 0.0);
    assert_eq!(drawn.len(), expected.len());
    for (kept, p) in expected {
        assert!((drawn[&kept] - p).abs() < 4.5 * (p * (1.0 - p) / 70_000.0_f64).sqrt(), "{kept:?}: {} for {p}", drawn[&kept]);
    }
    // A person accepted the first: one of the last two is true with 0.5, the fourth with five ninths of that, though its end is joined.
    network.vessel_mut(3).certain = true;
    let fourth: f64 = draw(&network).iter().filter(|(kept, _)| kept[5]).map(|(_, share)| share).sum();
    let p = 0.5 * 5.0 / 9.0;
    assert!((fourth - p).abs() < 4.5 * (p * (1.0 - p) / 70_000.0_f64).sqrt(), "{fourth} for {p}");
}

#[test]
fn a_sample_does_not_depend_on_how_many_are_drawn() {
    let network = broken();
    let draw = |samples| {
        let params = SamplingOptions { samples, seed: 9, ..SamplingOptions::default() };
        Topologies::draw(
            &network,
            &boundary(&network, &[]),
            &params,
            TopologySource::FreeEnds(KnownEnds { ends: &[false; 4], inlets: &[] }),
        )
        .unwrap()
    };
    let count = |t: &Topologies, kept: &Vec<bool>| shares(t).get(kept).map_or(0.0, |p| (p * t.samples as f64).round());
    let (few, many) = (draw(100), draw(101));
    let more: f64 = shares(&many).keys().map(|kept| (count(&many, kept) - count(&few, kept)).abs()).sum();
    assert_eq!(more, 1.0);
    assert_eq!(few, draw(100));
}

/// Every pattern by hand: its forest by trying all forests, the open vessels above the median beside it, its ρ_G as weight.
fn by_enumeration(
    network: &Network,
    conditions: &[(usize, Condition)],
    params: &SamplingOptions,
    above: &[bool],
) -> BTreeMap<Vec<bool>, f64> {
    let keep = exact::keep(network, params.epsilon, params.uncertain);
    let mut weights: BTreeMap<Vec<bool>, f64> = BTreeMap::new();
    for mask in 0_u32..1 << keep.len() {
        let open: Vec<bool> = (0..keep.len()).map(|row| mask >> row & 1 == 1).collect();
        let probability: f64 = open.iter().zip(&keep).map(|(open, k)| if *open { *k } else { 1.0 - k }).product();
        if probability == 0.0 {
            continue;
        }
        let diffused = Sample { network, conditions, open: open.clone() }.resiliences();
        let forest = best_of_all_forests(network, &diffused);
        let kept = (0..keep.len()).map(|row| keep[row] >= 1.0 || forest.contains(&row) || (open[row] && above[row])).collect();
        let total: f64 = diffused.iter().map(|(_, x)| x).sum();
        let weight = if params.weight == Weight::Count { 1.0 } else { total / f64::from(mask.count_ones().max(1)) };
        *weights.entry(kept).or_default() += probability * weight;
    }
    let all: f64 = weights.values().sum();
    weights.retain(|_, w| *w > 0.0);
    for w in weights.values_mut() {
        *w /= all;
    }
    weights
}

#[test]
fn samples_vote_for_their_forest_and_what_is_above_the_median() {
    let mut draw = Random::new(5);
    for case in 0..12 {
        let network = random_network(&mut draw, 6, 9, radii(0.5, 2.0));
        let conditions = random_conditions(&mut draw, 6);
        let uncertain = if case % 2 == 0 { Uncertain::Candidates } else { Uncertain::All };
        let weight = if case % 3 == 0 { Weight::Count } else { Weight::Resilience };
        let params = SamplingOptions { epsilon: 0.4, samples: 1, exact: true, uncertain, weight, ..SamplingOptions::default() };
        let likelihood = run(&network, &conditions, &params);
        let above = decide(Keep::Median, &network, &likelihood).unwrap().above_median;
        let circuit = boundary(&network, &conditions);
        let drawn = shares(&Topologies::draw(&network, &circuit, &params, TopologySource::Samples(&above)).unwrap());
        let expected = by_enumeration(&network, &conditions, &params, &above);
        for (kept, p) in &expected {
            let found = drawn.get(kept).copied().unwrap_or(0.0);
            assert!((found - p).abs() < 1e-9, "case {case}, {kept:?}: {found} for {p}");
        }
        assert!((drawn.values().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

/// Drawn samples come near the enumeration, each weight within its error; the forests are those of the run itself.
#[test]
fn drawn_votes_come_near_all_votes() {
    let mut draw = Random::new(8);
    let network = random_network(&mut draw, 6, 9, radii(0.5, 2.0));
    let conditions = random_conditions(&mut draw, 6);
    let params = SamplingOptions {
        epsilon: 0.4,
        samples: 20_000,
        weight: Weight::Count,
        uncertain: Uncertain::All,
        ..SamplingOptions::default()
    };
    let none = vec![false; network.vessel_count()];
    let circuit = boundary(&network, &conditions);
    let drawn = Topologies::draw(&network, &circuit, &params, TopologySource::Samples(&none)).unwrap();
    let expected = by_enumeration(&network, &conditions, &params, &none);
    for (kept, p) in &expected {
        let error = (p * (1.0 - p) / 20_000.0).sqrt();
        let found = shares(&drawn).get(kept).copied().unwrap_or(0.0);
        assert!((found - p).abs() < 5.0 * error + 1e-9, "{kept:?}: {found} for {p}");
    }
    let frequency = run(&network, &conditions, &params).frequency;
    for (row, frequency) in frequency.iter().enumerate() {
        let share: f64 = drawn.weighted.iter().filter(|(kept, _)| kept[row]).map(|(_, w)| w).sum();
        assert!((share - frequency).abs() < 1e-9, "vessel {row}: {share} for {frequency}");
    }
}

/// How an end continues in the first sample of a seed says nothing of any vessel in any sample of the seed's first block: were the
/// ends drawn from the masks' own stream, one of them would go with it wholly. A thousand coins agree within 0.03 of one half.
#[test]
fn how_ends_continue_does_not_depend_on_what_is_occluded() {
    const SEEDS: u64 = 1000;
    const VESSELS: usize = 20;
    let network = broken();
    let (circuit, occlusion) = (boundary(&network, &[]), Occlusion::new([0.5; VESSELS]));
    let mut agree = vec![0_u32; 64 * VESSELS];
    for seed in 0..SEEDS {
        let params = SamplingOptions { samples: 1, seed, ..SamplingOptions::default() };
        let draw = TopologySource::FreeEnds(KnownEnds { ends: &[true, false, true, true], inlets: &[] });
        let drawn = Topologies::draw(&network, &circuit, &params, draw).unwrap();
        let continues = drawn.weighted[0].0[2];
        let mut masks = Vec::new();
        occlusion.draw(seed, 0, &mut masks);
        for (at, agree) in agree.iter_mut().enumerate() {
            *agree += u32::from((masks[at / 64] >> (at % 64) & 1 == 1) == continues);
        }
    }
    for (at, agree) in agree.into_iter().enumerate() {
        let share = f64::from(agree) / SEEDS as f64;
        assert!((share - 0.5).abs() < 0.1, "vessel {}, sample {}: {share}", at / 64, at % 64);
    }
}
