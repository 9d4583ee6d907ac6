//! The flow in tiny networks made of bytes, steady and pulsating: it balances at every node, or the network is refused. Vessels join
//! nodes at random, and their lengths and radii differ by many powers of ten.
#![no_main]

use libfuzzer_sys::fuzz_target;
use willis::internals::network::{Node, Origin, Vessel};
use willis::{FlowOptions, Input, Network, PulseOptions, simulate};

/// A length or radius, m: a few digits and a power of ten.
fn size(byte: u8, least: i32) -> f64 {
    (1.0 + f64::from(byte & 7)) * 10_f64.powi(least + i32::from(byte >> 3) / 6)
}

fuzz_target!(|bytes: &[u8]| {
    let [nodes, inlet, outlet, how, vessels @ ..] = bytes else { return };
    let count = usize::from(nodes % 12) + 2;
    let mut network = Network::new();
    for id in 0..count {
        network.add_node(Node { id: id.to_string(), ..Node::default() });
    }
    for vessel in vessels.chunks_exact(4).take(24) {
        let [a, b, length, radius] = [0, 1, 2, 3].map(|k| vessel[k]);
        let ends = [a, b].map(|node| usize::from(node) % count);
        if ends[0] != ends[1] {
            network.add_vessel(ends, Vessel::new(size(length, -5), size(radius, -6), Origin::Observed));
        }
    }
    if network.vessel_count() == 0 {
        return;
    }
    let mut options = FlowOptions { transport: how & 1 == 1, ..FlowOptions::default() };
    options.boundary.inlet = vec![(usize::from(*inlet) % count).to_string()];
    options.boundary.outlet = vec![(usize::from(*outlet) % count).to_string()];
    if how & 2 == 2 {
        options.pulse = Some(PulseOptions { harmonics: 4, times: 16, ..PulseOptions::default() });
    }
    let input = Input::from_network(network);
    let Ok(run) = simulate(&input, &[], &options) else { return };
    let flow: Vec<f64> = run.result.unperturbed.vessels.iter().map(|vessel| vessel.flow).collect();
    let vessels = &run.result.unperturbed.vessels;
    let (mut most, mut least) = (0.0_f64, f64::INFINITY);
    for vessel in vessels {
        (most, least) = (most.max(vessel.resistance), least.min(vessel.resistance));
    }
    let mut net = vec![(0.0_f64, 0.0_f64); count];
    for ((ends, _), q) in input.network.vessels().zip(&flow) {
        assert!(q.is_finite(), "a flow of {q}");
        for (node, q) in [(ends[0], *q), (ends[1], -*q)] {
            net[node].0 += q;
            net[node].1 += q.abs();
        }
    }
    let largest = flow.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
    // Drops are known to the digits of two doubles beside the pressures, which is not enough where resistances differ by more than this.
    if most / least < 1e18 {
        for node in (0..count).filter(|node| [inlet, outlet].iter().all(|end| usize::from(**end) % count != *node)) {
            let (sum, all) = net[node];
            // Smaller flows than a millionth of a millionth of the largest keep at least six digits.
            let share = if all >= 1e-12 * largest { 1e-12 } else { 1e-6 };
            assert!(sum.abs() <= share * all, "node {node} lacks {sum} of {all}: {flow:?}");
        }
    }
    let _ = run.tables();
    let _ = run.transport_tables();
    let _ = run.waveforms();
});
