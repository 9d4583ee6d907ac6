//! Decisions by evidence: the most probable forest against enumeration of all forests, and small graphs worked out by hand.

use std::collections::BTreeSet;

use crate::draw::Draw;
use crate::vessels;
use crate::vessels::tube;
use willis::internals::decision::{
    Decision, Keep, PRICE, RECONNECT, best_first, decide, expected_errors, has_evidence, knows_fragments, probabilities,
    probable, reconnected,
};
use willis::internals::network::{Evidence, Network, Node, Origin, Vessel};
use willis::internals::sampling::Likelihood;

/// A fragment between nodes 2i and 2i + 1 for each i.
fn fragments(count: usize) -> Network {
    vessels::network(2 * count, (0..count).map(|i| ([2 * i, 2 * i + 1], tube(5.0, 1.0))))
}

fn candidate(probability: f64, attached: [f64; 2]) -> Vessel {
    let evidence = Some(Box::new(Evidence { attached, ..Evidence::undirected(probability) }));
    Vessel { origin: Origin::Candidate, prior: probability, evidence, ..tube(1.0, 1.0) }
}

/// The largest sum of scores over all forests, by trying every choice of every fragment.
fn best(parts: usize, arcs: &[(usize, usize, f64)], roots: &[f64]) -> f64 {
    let choices: Vec<Vec<(Option<usize>, f64)>> = (0..parts)
        .map(|c| {
            let mut own = vec![(None, roots[c])];
            own.extend(arcs.iter().filter(|a| a.0 == c).map(|a| (Some(a.1), a.2)));
            own
        })
        .collect();
    let mut at = vec![0; parts];
    let mut most = f64::NEG_INFINITY;
    loop {
        let is_forest = (0..parts).all(|start| {
            let (mut here, mut steps) = (start, 0);
            while let Some(next) = choices[here][at[here]].0 {
                (here, steps) = (next, steps + 1);
                if steps > parts {
                    return false;
                }
            }
            true
        });
        if is_forest {
            most = most.max((0..parts).map(|c| choices[c][at[c]].1).sum());
        }
        let Some(turn) = (0..parts).find(|c| at[*c] + 1 < choices[*c].len()) else { return most };
        at[..turn].fill(0);
        at[turn] += 1;
    }
}

/// How probable it is that all that hangs on a fragment is nothing, by the formula of the docs, from the leaves up.
fn nothing(fragment: usize, hanging: &[Vec<(usize, f64)>], alone: &[f64]) -> f64 {
    hanging[fragment].iter().fold(alone[fragment], |q, (child, p)| q * (1.0 - p * (1.0 - nothing(*child, hanging, alone))))
}

#[test]
fn the_most_probable_forest_is_the_best_of_all_forests_and_every_row_says_why_it_is_kept() {
    let mut random = Draw::new(3);
    let mut draw = || random.within(0.0, 1.0);
    let (mut wide, mut left_open, mut hanging_counts) = (0, 0, 0);
    for case in 0..60 {
        let parts = 3 + case % 3;
        let mut network = fragments(parts);
        let mut arcs = Vec::new();
        let alone: Vec<f64> = (0..parts).map(|_| draw()).collect();
        for (a, score) in alone.iter().enumerate() {
            network.node_mut(2 * a).root_score = Some(*score);
            for b in a + 1..parts {
                if draw() < 0.8 {
                    let attached = [0.5 * draw(), 0.5 * draw()];
                    network.add_vessel([2 * a + 1, 2 * b], candidate(attached[0] + attached[1], attached));
                    arcs.extend([(a, b, attached[0]), (b, a, attached[1])]);
                }
            }
        }
        let price = [0.3, 1.0, 2.0][case % 3];
        // Roots count a fifth of their price.
        let roots: Vec<f64> = alone.iter().map(|p| 0.2 * price * p).collect();
        let forest = probable(&network, price).unwrap();
        let chosen: Vec<usize> =
            (parts..network.vessel_count()).filter(|row| forest.kept[*row] || forest.left_open.contains(row)).collect();
        wide += usize::from(chosen.len() > 1);
        // It is a forest that scores as the best does: its edges, each in its better direction, tried alone.
        let own: Vec<(usize, usize, f64)> =
            chosen.iter().flat_map(|row| [arcs[2 * (row - parts)], arcs[2 * (row - parts) + 1]]).collect();
        let (all, these) = (best(parts, &arcs, &roots), best(parts, &own, &roots));
        assert!((all - these).abs() < 1e-12, "case {case}: {these} of {all}");
        assert!(chosen.len() < parts);
        assert!(forest.kept[..parts].iter().all(|k| *k), "observed vessels stay");
        for row in parts..network.vessel_count() {
            let p = arcs[2 * (row - parts)].2 + arcs[2 * (row - parts) + 1].2;
            // One row says it all: kept is P >= needed, or another row stands in its place.
            assert_eq!(forest.kept[row], p >= forest.needed[row], "case {case}, row {row}");
            assert_eq!(forest.instead[row].is_some(), forest.needed[row].is_nan(), "case {case}, row {row}");
            assert!(forest.instead[row].is_none_or(|other| chosen.contains(&other)));
            left_open += usize::from(forest.left_open.contains(&row));
        }
        // Which fragment hangs: of the two directions of each edge those whose sum is the best one and that make a forest.
        let directions = |bits: usize| -> Vec<(usize, usize, f64)> {
            chosen.iter().enumerate().map(|(at, row)| arcs[2 * (row - parts) + (bits >> at & 1)]).collect()
        };
        let score = |arcs: &[(usize, usize, f64)]| {
            let hangs = |c: usize| arcs.iter().filter(|a| a.0 == c).count();
            let valid = (0..parts).all(|c| hangs(c) <= 1);
            let alone: f64 = (0..parts).filter(|c| hangs(*c) == 0).map(|c| roots[c]).sum();
            if valid { alone + arcs.iter().map(|a| a.2).sum::<f64>() } else { f64::NEG_INFINITY }
        };
        let taken = (0..1 << chosen.len()).map(directions).max_by(|a, b| score(a).total_cmp(&score(b))).unwrap();
        let mut hanging = vec![Vec::new(); parts];
        for ((child, parent, _), row) in taken.iter().zip(&chosen) {
            let p = arcs[2 * (row - parts)].2 + arcs[2 * (row - parts) + 1].2;
            hanging[*parent].push((*child, p));
        }
        for ((child, ..), row) in taken.iter().zip(&chosen) {
            let expected = price * nothing(*child, &hanging, &alone);
            assert!((forest.needed[*row] - expected).abs() < 1e-12, "case {case}, row {row}");
            hanging_counts += usize::from(!hanging[*child].is_empty());
        }
    }
    let counts = [wide, left_open, hanging_counts];
    assert!(
        counts.iter().all(|count| *count > 10),
        "several bridges, some left open, some with more hanging on them: {counts:?}"
    );
}

/// A short piece that may be nothing (0.8) hangs by 0.5 on a tree; a true vessel (0.1) hangs on it by 0.9. Alone the piece would need
/// 0.8 at price 1; with what hangs on it, it needs 0.8 (1 - 0.9 · 0.9) = 0.152.
#[test]
fn a_false_piece_carries_no_true_vessel() {
    let mut network = fragments(3);
    for (node, alone) in [(0, 0.01), (2, 0.8), (4, 0.1)] {
        network.node_mut(node).root_score = Some(alone);
    }
    network.add_vessel([1, 2], candidate(0.5, [0.0, 0.5]));
    let forest = probable(&network, 1.0).unwrap();
    assert_eq!((forest.kept[3], forest.needed[3], forest.left_open), (false, 0.8, vec![3]));
    network.add_vessel([3, 4], candidate(0.9, [0.0, 0.9]));
    let forest = probable(&network, 1.0).unwrap();
    assert!(forest.kept[3] && (forest.needed[3] - 0.152).abs() < 1e-12, "{:?}", forest.needed);
    assert!(forest.kept[4] && (forest.needed[4] - 0.1).abs() < 1e-12, "{:?}", forest.needed);
}

/// Two fragments of which nothing is known but a bridge of 0.4: either is nothing with 0.6, so the bridge stays where 0.4 >= 0.6 times the
/// price, up to 2/3. With the node's own word of 0.9 and 0.2 the second hangs, and the bridge stays up to a price of 2.
#[test]
fn the_price_decides_how_readily_fragments_stay_alone() {
    let mut network = fragments(2);
    network.add_vessel([1, 2], candidate(0.4, [0.1, 0.3]));
    let kept = |network: &Network, price: f64| probable(network, price).unwrap().kept;
    assert_eq!(kept(&network, 0.66), [true, true, true]);
    assert_eq!(kept(&network, 0.67), [true, true, false]);
    assert!(!knows_fragments(&network));
    network.node_mut(0).root_score = Some(0.9);
    network.node_mut(2).root_score = Some(0.2);
    assert!(knows_fragments(&network) && has_evidence(&network));
    assert_eq!(kept(&network, 1.99), [true, true, true]);
    assert_eq!(kept(&network, 2.01), [true, true, false]);
    assert_eq!(probable(&network, 2.01).unwrap().left_open, [2]);
}

/// What is just as probable as it has to be is kept, although 1.5 (1 - 0.6) and 1.5/5 are more than 0.6 and 0.3 in a computer.
#[test]
fn rounding_does_not_decide_between_as_probable_and_less() {
    let mut network = fragments(2);
    network.add_vessel([1, 2], candidate(0.6, [0.3; 2]));
    network.add_vessel([0, 1], candidate(0.3, [0.0; 2]));
    let forest = probable(&network, PRICE).unwrap();
    assert_eq!((forest.kept, forest.left_open), (vec![true; 4], vec![]));
    for (row, probability) in [(2, 0.599), (3, 0.299)] {
        let mut less = network.clone();
        *less.vessel_mut(row) = candidate(probability, [0.5 * probability; 2]);
        assert!(!probable(&less, PRICE).unwrap().kept[row], "{probability}");
    }
}

/// A bridge marked certain joins its fragments, so a second one between them closes a loop; one within a fragment does.
#[test]
fn loops_are_closed_by_their_probability_and_certain_bridges_join() {
    let mut network = fragments(2);
    network.add_vessel([1, 2], Vessel { certain: true, ..candidate(0.01, [0.0, 0.01]) });
    network.add_vessel([0, 3], candidate(0.49, [0.1, 0.09]));
    network.add_vessel([0, 2], candidate(0.5, [0.1, 0.1]));
    network.add_vessel([0, 1], candidate(0.5, [0.0; 2]));
    network.add_vessel([0, 3], Vessel { evidence: None, ..candidate(0.0, [0.0; 2]) });
    // A loop needs a fifth of the price.
    assert_eq!(probable(&network, 2.4).unwrap().kept, [true, true, true, true, true, true, false]);
    assert_eq!(probable(&network, 2.5).unwrap().kept, [true, true, true, false, true, true, false]);
    let p = probabilities(&network);
    assert_eq!(p, [Some(1.0), Some(1.0), Some(1.0), Some(0.49), Some(0.5), Some(0.5), None]);
}

fn decided(rule: Keep, network: &Network) -> Decision {
    let n = network.vessel_count();
    let likelihood = Likelihood {
        likelihood: vec![0.0; n],
        std_error: vec![0.0; n],
        frequency: vec![0.0; n],
        uncertain: network.vessels().map(|(_, v)| v.origin == Origin::Candidate && !v.certain).collect(),
        network_resilience: 0.0,
        perfused: 1.0,
        residual: 0.0,
        samples: 64,
        trace: Vec::new(),
    };
    decide(rule, network, &likelihood).unwrap()
}

#[test]
fn what_lies_near_the_cut_is_undecided_and_errors_are_expected() {
    let mut network = fragments(4);
    network.add_vessel([1, 2], candidate(0.9, [0.6, 0.3]));
    network.add_vessel([3, 4], candidate(0.6, [0.6, 0.0]));
    network.add_vessel([1, 3], candidate(0.05, [0.05, 0.0]));
    // The last fragment hangs on the third, and nothing on it: it needs what its candidates leave of one, 0.65.
    network.add_vessel([5, 6], candidate(0.35, [0.05, 0.3]));
    let answer = decided(Keep::Probability(0.55), &network);
    assert_eq!((answer.threshold, &answer.kept[4..]), (Some(0.55), &[true, true, false, false][..]));
    assert_eq!(answer.undecided, [5], "0.35 is a fifth away");
    let answer = decided(Keep::Probable(1.0), &network);
    assert_eq!((answer.threshold, &answer.kept[4..]), (None, &[true, true, false, false][..]));
    assert_eq!(answer.undecided, [5, 7]);
    // Kept 0.9 and 0.6: 0.1 + 0.4 wrong. Not kept 0.35; the 0.05 is another place of the first.
    let errors = expected_errors(&network, &answer.kept).unwrap();
    assert!((errors.wrong - 0.5).abs() < 1e-12 && (errors.missed - 0.35).abs() < 1e-12, "{errors:?}");
    let plain = fragments(2);
    assert_eq!(expected_errors(&plain, &[true; 2]), None);
}

#[test]
fn a_candidate_is_undecided_where_it_could_take_the_place_of_another() {
    // Two places for one fragment on the other: what the forest has, and another.
    for (first, second, undecided) in [
        (0.75, 0.31, vec![]),
        (0.75, 0.49, vec![]),
        (0.75, 0.55, vec![3]),
        (0.65, 0.44, vec![2]),
        (0.65, 0.46, vec![2, 3]),
        (0.25, 0.20, vec![2]),
    ] {
        let mut network = fragments(2);
        for p in [first, second] {
            network.add_vessel([1, 2], candidate(p, [p, 0.0]));
        }
        assert_eq!(decided(Keep::Probable(0.3), &network).undecided, undecided, "{first} {second}");
    }
}

#[test]
fn rules_on_evidence_ask_for_it_and_have_their_ranges() {
    let network = fragments(2);
    let likelihood = Likelihood {
        likelihood: vec![0.0; 2],
        std_error: vec![0.0; 2],
        frequency: vec![0.0; 2],
        uncertain: vec![false; 2],
        network_resilience: 0.0,
        perfused: 1.0,
        residual: 0.0,
        samples: 64,
        trace: Vec::new(),
    };
    for (rule, name) in [(Keep::Probable(PRICE), "probable"), (Keep::Probability(0.5), "probability")] {
        let said = decide(rule, &network, &likelihood).unwrap_err().to_string();
        assert!(said.starts_with(&format!("keep {name}: asks for probabilities")), "{said}");
    }
    for rule in [Keep::Probable(-0.1), Keep::Probable(f64::NAN), Keep::Probable(1001.0), Keep::Probability(1.1)] {
        assert!(rule.validate().is_err(), "{rule:?}");
    }
    for rule in [Keep::Probable(0.0), Keep::Probable(1000.0), Keep::Probability(0.0), Keep::Probability(1.0)] {
        assert!(rule.validate().is_ok(), "{rule:?}");
    }
}

#[test]
fn a_contact_is_reconnected_by_what_the_partitions_say_and_not_by_its_probability() {
    let kept = |joined: f64, least: f64| {
        let mut network = Network::new();
        (0..4).for_each(|row| {
            network.add_node(Node { id: row.to_string(), ..Node::default() });
        });
        let vessel = |origin, evidence| Vessel { evidence, ..Vessel::new(0.01, 0.001, origin) };
        network.add_vessel([0, 1], vessel(Origin::Observed, None));
        network.add_vessel([2, 3], vessel(Origin::Observed, None));
        let evidence = Evidence { attached: [0.5 * joined; 2], ..Evidence::undirected(0.6) };
        network.add_vessel([1, 2], vessel(Origin::Contact, Some(Box::new(evidence))));
        reconnected(&network, least)[2]
    };
    assert_eq!([kept(0.017, 0.018), kept(0.019, 0.018)], [false, true]);
    assert!(kept(0.0, RECONNECT), "a cut sets nothing apart");
}

#[test]
fn a_free_end_is_used_once_and_a_branch_as_often_as_it_is_met() {
    let ends = [[Some(0), Some(1)], [Some(1), Some(2)], [Some(2), None], [Some(3), None], [Some(4), None]];
    // The second loses end 1 to the first, which leaves end 2 to the third.
    assert_eq!(best_first(&[0.9, 0.8, 0.7, 0.7, 0.4], &ends, BTreeSet::new(), 0.4), [true, false, true, true, false]);
}
