//! The whole way from a file to an answer, on tiny graphs: GraphML, or SWC that becomes a candidate graph first.
#![no_main]

use libfuzzer_sys::fuzz_target;
use willis::candidates::{self, build};
use willis::formats::{read_graphml, read_swc};
use willis::hemodynamics::{Boundary, FoundOutlets};
use willis::inference::{Keep, Params, decide, infer};
use willis::network::{Network, RadiusRule, contract};
use willis::units::Scale;

const MOST: usize = 64;

fn graph(bytes: &[u8]) -> Option<Network> {
    if bytes.starts_with(b"<") {
        return read_graphml(bytes, &Scale::default()).ok().map(|(network, _)| network).filter(|n| n.vessel_count() <= MOST);
    }
    let (mut lines, _) = read_swc(bytes, &Scale::default()).ok()?;
    lines.weld(1e-6);
    let network = contract(&lines, RadiusRule::Mean, Some(1e-3)).ok()?.network;
    if network.vessel_count() > MOST {
        return None;
    }
    build(&network, &candidates::Params::default()).ok()
}

fuzz_target!(|bytes: &[u8]| {
    let Some(network) = graph(bytes) else { return };
    let Ok(boundary) = Boundary::resolve(&network, &[], FoundOutlets::Ground) else { return };
    let params = Params { samples: 16, ..Params::default() };
    let Ok((likelihood, _)) = infer(&network, &boundary, &params, &mut |_, _| true) else { return };
    assert!(likelihood.likelihood.iter().all(|l| l.is_finite() && *l >= 0.0), "{:?}", likelihood.likelihood);
    let _ = decide(Keep::Median, &network, &likelihood);
});
