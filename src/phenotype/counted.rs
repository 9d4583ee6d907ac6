//! Which vessels of a graph file count: those that are kept, else those that an image showed.

use crate::network::{Network, Origin};

/// Per vessel whether it counts, and a word on it where some do not: those that an earlier run kept, where the file says so; otherwise
/// the observed vessels, or all of a graph that knows no origin.
pub fn counted(network: &Network) -> (Vec<bool>, Option<&'static str>) {
    if network.vessels().any(|(_, vessel)| vessel.kept.is_some()) {
        let kept: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.kept == Some(true)).collect();
        let note = kept.contains(&false).then_some("vessels that were not kept do not count");
        return (kept, note);
    }
    let observed: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.origin == Origin::Observed).collect();
    if observed.contains(&true) && observed.contains(&false) {
        return (observed, Some("candidates do not count: nothing says which were kept"));
    }
    (vec![true; network.vessel_count()], None)
}
