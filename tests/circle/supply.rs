//! Who feeds the territories of a circle, and how late: an independent program's values on the circles that ship.

use willis::internals::circle_of_willis::supply::{MOST_TOPOLOGIES, by_weight, most_followed};
use willis::internals::circle_of_willis::{Destination, Spread};
use willis::{Phenotype, PhenotypeOptions, ReadOptions, Silent};

fn classified(name: &str) -> (Phenotype, willis::Network) {
    let path = format!("{}/data/circle-of-willis/{name}.graphml", env!("CARGO_MANIFEST_DIR"));
    let input = willis::read(path.as_ref(), &ReadOptions::default()).expect("a circle");
    let phenotype = willis::classify(&input, None, &PhenotypeOptions::default(), &mut Silent).expect("a phenotype");
    (phenotype, input.network)
}

/// The share of the blood behind L-P2 that comes by the left carotid, and its mean arrival (ms), of another program. A fetal posterior
/// cerebral artery is fed by the carotid alone, and earlier; without PComm by none.
#[test]
fn a_fetal_artery_is_fed_by_the_carotid() {
    let cases = [
        ("complete", 0.167_903, 1301.33),
        ("without-L-P1", 1.0, 822.86),
        ("without-L-PComm", 0.0, 1290.80),
        ("without-L-A1", 0.377_365, 1311.63),
    ];
    for (name, share, arrival) in cases {
        let (phenotype, network) = classified(name);
        let label = |node: usize| {
            network.vessels().find(|(ends, _)| ends.contains(&node)).map_or("", |(_, vessel)| vessel.label.as_str())
        };
        let is_it = |destination: &Destination| matches!(destination, Destination::Outlet(node) if label(*node) == "L-P2");
        let outlet = phenotype.supplies.iter().find(|supply| is_it(&supply.destination)).expect("the outlet");
        let shares = outlet.shares.map(|share| share.middle);
        assert!((shares[0] - share).abs() < 1e-6, "{name}: {shares:?}");
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{name}: {shares:?}");
        assert!((1e3 * outlet.arrival.middle - arrival).abs() < 0.01, "{name}: {}", outlet.arrival.middle);
        assert_eq!(outlet.shares[0].interval, [shares[0]; 2], "there is one topology");
        assert!((outlet.fed - 1.0).abs() < 1e-12);
        // The territory is where the artery begins: the same blood, earlier.
        let territory = phenotype
            .supplies
            .iter()
            .find(|supply| matches!(supply.destination, Destination::Territory(artery) if artery.to_string() == "L-P2"));
        let territory = territory.expect("the territory");
        assert!((territory.shares[0].middle - share).abs() < 1e-6 && territory.arrival.middle < outlet.arrival.middle, "{name}");
    }
}

/// By hand: 1 with weight 8, 3 with weight 2; what has 4 in 100 is out of the interval, and moves the mean; of 2,500 equal weights as many are
/// followed as may be.
#[test]
fn spreads_and_choices_go_by_weight() {
    let both = [(3.0, 2.0), (1.0, 8.0)];
    assert_eq!(Spread::about_mean(&both), Spread { middle: 1.4, interval: [1.0, 3.0] });
    assert_eq!(Spread::about_median(&both), Spread { middle: 1.0, interval: [1.0, 3.0] });
    let skewed = [(1.0, 96.0), (101.0, 4.0)];
    assert_eq!(Spread::about_mean(&skewed), Spread { middle: 5.0, interval: [1.0, 5.0] });
    assert_eq!(Spread::about_median(&skewed), Spread { middle: 1.0, interval: [1.0, 1.0] });
    assert!(Spread::about_median(&[]).middle.is_nan() && Spread::about_mean(&[]).middle.is_nan());
    let many: Vec<(Vec<bool>, f64)> = (0..2500).map(|_| (vec![true], 1.0)).collect();
    let chosen = by_weight(&many, MOST_TOPOLOGIES);
    assert!(chosen.len() == MOST_TOPOLOGIES && chosen.iter().all(|(_, weight)| *weight == 1.0));
    // Of twenty thousand vessels two million together; of a circle as many as may be, of a million vessels still a hundred.
    assert_eq!([20, 2_000, 20_000, 1_000_000].map(most_followed), [1000, 1000, 100, 100]);
    assert_eq!([2_500, 4_000].map(most_followed), [800, 500]);
    let few = [(vec![true], 0.9), (vec![false], 0.1)];
    assert_eq!(by_weight(&few, 2).iter().map(|(_, weight)| *weight).collect::<Vec<_>>(), [0.9, 0.1]);
}
