//! The whole way from a file to an answer, on tiny graphs: GraphML, or SWC that becomes a candidate graph first, by nearest
//! neighbours or by evidence.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use willis::internals::candidates::model::Weights;
use willis::internals::candidates;
use willis::internals::candidates::{build, build_with_evidence};
use willis::internals::io::{ReadOptions, read_graphml, read_swc};
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::decision::{Keep, decide};
use willis::internals::sampling::{SamplingOptions, infer};
use willis::internals::network::{Network, RadiusRule, contract};
use willis::internals::network::units::Scale;

const MOST: usize = 64;

static WEIGHTS: LazyLock<Weights> = LazyLock::new(|| Weights::shipped().expect("the shipped weights are read"));

fn graph(bytes: &[u8]) -> Option<Network> {
    if bytes.starts_with(b"<") {
        return read_graphml(bytes, &ReadOptions::default()).ok().map(|(network, _)| network).filter(|n| n.vessel_count() <= MOST);
    }
    let (mut lines, _) = read_swc(bytes, &Scale::default()).ok()?;
    lines.weld(1e-6);
    let network = contract(&lines, RadiusRule::Mean, Some(1e-3)).ok()?.network;
    if network.vessel_count() > MOST {
        return None;
    }
    let params = candidates::CandidateOptions::default();
    if bytes.len() % 2 == 0 {
        return build(&network, &params).ok();
    }
    let graph = build_with_evidence(&network, &[], &params, &WEIGHTS).ok()?;
    assert!(graph.vessels().all(|(_, vessel)| (0.0..=1.0).contains(&vessel.prior)));
    Some(graph)
}

fuzz_target!(|bytes: &[u8]| {
    let Some(network) = graph(bytes) else { return };
    let Ok(boundary) = Boundary::resolve(&network, &[], FoundOutlets::Ground) else { return };
    let params = SamplingOptions { samples: 16, ..SamplingOptions::default() };
    let Ok((likelihood, _)) = infer(&network, &boundary, &params, &mut |_, _| true) else { return };
    assert!(likelihood.likelihood.iter().all(|l| l.is_finite() && *l >= 0.0), "{:?}", likelihood.likelihood);
    let _ = decide(Keep::Median, &network, &likelihood);
});
