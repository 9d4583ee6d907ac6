//! The whole method on tiny graphs, by the front door: GraphML, or SWC that becomes a candidate graph first, with evidence or without.
#![no_main]

use libfuzzer_sys::fuzz_target;
use willis::internals::formats::{ReadOptions, read_graphml, read_swc};
use willis::internals::network::contract;
use willis::internals::network::units::Scale;
use willis::{FoundOutlets, InferOptions, Input, Keep, Network, Prior, RadiusRule, infer};

const MOST: usize = 64;

fn network(bytes: &[u8]) -> Option<Network> {
    if bytes.starts_with(b"<") {
        return read_graphml(bytes, &ReadOptions::default()).ok().map(|(network, _)| network);
    }
    let (mut lines, _) = read_swc(bytes, &Scale::default()).ok()?;
    lines.weld(1e-6);
    Some(contract(&lines, RadiusRule::Mean, Some(1e-3)).ok()?.network)
}

fuzz_target!(|bytes: &[u8]| {
    // Vessels of a kilometre have as many points as there may be, four million: that takes seconds.
    let is_near = |network: &Network| network.nodes().filter_map(|n| n.position).flatten().all(|x| x.abs() < 1e3);
    let Some(network) = network(bytes).filter(|network| network.vessel_count() <= MOST && is_near(network)) else { return };
    let input = Input::from_network(network);
    let mut options = InferOptions { keep: Some(Keep::Median), ..InferOptions::default() };
    options.sampling.samples = 16;
    options.boundary.found_outlets = Some(FoundOutlets::Ground);
    if input.is_fragments && bytes.len() % 2 == 0 {
        options.prior = Some(Prior::None);
    }
    let Ok(run) = infer(&input, &options) else { return };
    assert!(run.likelihood().likelihood.iter().all(|l| l.is_finite() && *l >= 0.0), "{:?}", run.likelihood().likelihood);
    assert!(run.graph().vessels().all(|(_, vessel)| (0.0..=1.0).contains(&vessel.prior)));
});
