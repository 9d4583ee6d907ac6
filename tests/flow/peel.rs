//! Peeling against the circuit it peels: the same flows, dead ends exactly still, vessels in series exactly tied.

use willis::internals::flow::peeling::peel;
use willis::internals::flow::pressures::pressures;
use willis::internals::flow::{Boundary, Circuit, FoundOutlets, Given};
use willis::internals::network::Origin::{Candidate, Observed};
use willis::internals::network::{Condition, Network, Node, Origin, Role, Vessel};
use willis::internals::sampling::{SamplingOptions, infer};

fn vessel(length: f64, radius: f64, origin: Origin) -> Vessel {
    Vessel::new(length, radius, origin)
}

/// A chain 0-1-2-3 of observed vessels with a dead-end tree at 2 (4, 5), a ring at 1 (6, 7), a detour 0-3 and a dead-end
/// candidate 8; blood enters at 0 and leaves at 3.
fn network() -> (Network, Boundary) {
    let mut network = Network::new();
    for id in 0..9 {
        network.add_node(Node { id: id.to_string(), ..Node::default() });
    }
    for (ends, length, radius, origin) in [
        ([0, 1], 0.010, 1e-3, Observed),
        ([1, 2], 0.013, 1e-3, Observed),
        ([2, 3], 0.007, 1e-3, Observed),
        ([2, 4], 0.005, 5e-4, Observed),
        ([4, 5], 0.005, 5e-4, Observed),
        ([1, 6], 0.005, 5e-4, Observed),
        ([6, 7], 0.004, 5e-4, Observed),
        ([7, 1], 0.003, 5e-4, Observed),
        ([0, 3], 0.020, 8e-4, Candidate),
        ([4, 8], 0.020, 8e-4, Candidate),
        ([5, 5], 0.020, 8e-4, Observed),
    ] {
        network.add_vessel(ends, vessel(length, radius, origin));
    }
    let given = [
        Given { node: 0, role: Role::Inlet, condition: Condition::Pressure(13_000.0) },
        Given { node: 3, role: Role::Outlet, condition: Condition::Pressure(0.0) },
    ];
    let boundary = Boundary::resolve(&network, &given, FoundOutlets::Ground).expect("conditions");
    (network, boundary)
}

#[test]
fn the_flow_of_a_chain_is_that_of_each_of_its_vessels() {
    let (network, boundary) = network();
    let circuit = Circuit::new(&network, &boundary, 3.5e-3).expect("a circuit");
    let certain: Vec<bool> = network.vessels().map(|(_, v)| v.origin == Observed).collect();
    let peeled = peel(&circuit, &certain);
    let whole = pressures(&circuit, |_| true).expect("solved");
    let at = |node: usize| whole[node].expect("reached");
    // Dead ends, the ring at one node and the self-loop carry nothing.
    let still: Vec<usize> = (0..11).filter(|v| peeled.stand_in[*v].is_none()).collect();
    assert_eq!(still, [3, 4, 5, 6, 7, 9, 10]);
    for v in still {
        let [a, b] = circuit.ends[v];
        assert!((at(a) - at(b)).abs() <= 1e-12 * at(a), "vessel {v}");
    }
    for v in [0, 1, 2] {
        assert_eq!(peeled.stand_in[v], Some(0));
        let [first, last] = peeled.circuit.ends[0];
        let flow = peeled.circuit.conductance[0] * (at(first) - at(last));
        let [a, b] = circuit.ends[v];
        let own = circuit.conductance[v] * (at(a) - at(b));
        assert!((flow.abs() - own.abs()).abs() <= 1e-13 * own.abs(), "vessel {v}: {flow} for {own}");
    }
}

#[test]
fn vessels_in_series_with_one_radius_tie_to_the_last_bit_and_any_of_them_gives_way() {
    let (network, boundary) = network();
    let params = SamplingOptions { samples: 640, epsilon: 0.3, ..SamplingOptions::default() };
    let (result, _) = infer(&network, &boundary, &params, &mut |_: u64, _: u64| true).expect("sampled");
    // With the detour open the cycle 0-1-2-3 must lose a vessel: one of the chain's three, by a fair coin. Were their ρ apart by a bit, it would
    // always be the same one.
    let open = result.frequency[8];
    assert!(open > 0.4 && open < 1.0);
    let lost: Vec<f64> = result.frequency[..3].iter().map(|frequency| 1.0 - frequency).collect();
    assert!((lost.iter().sum::<f64>() - open).abs() < 1e-12, "{lost:?} {open}");
    let error = (open / 3.0 * (1.0 - open / 3.0) / 640.0).sqrt();
    assert!(lost.iter().all(|lost| (lost - open / 3.0).abs() < 4.0 * error), "{lost:?} {open}");
    for still in [3, 4, 5, 6, 7, 9, 10] {
        assert_eq!(result.frequency[still], 0.0);
    }
}
