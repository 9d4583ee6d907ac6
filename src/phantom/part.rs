//! A part of a network: some of its vessels, as in a person who lacks the others.

use crate::error::{Error, Result};
use crate::network::{Network, Role, Vessel};
use crate::suggestion::did_you_mean;

/// The vessels that `keep` admits. Nodes that lose all their vessels go; the others keep id, order, role and condition.
pub(super) fn part(network: &Network, keep: impl Fn(&Vessel) -> bool) -> Network {
    let degree = network.degrees(&keep);
    let mut part = Network::new();
    let mut row_of = vec![usize::MAX; network.node_count()];
    for (row, node) in network.nodes().enumerate().filter(|(row, _)| degree[*row] > 0) {
        row_of[row] = part.add_node(node.clone());
    }
    for (ends, vessel) in network.vessels().filter(|(_, vessel)| keep(vessel)) {
        part.add_vessel(ends.map(|end| row_of[end]), vessel.clone());
    }
    part
}

/// The anatomical variant that lacks the vessels of these labels.
///
/// Conditions stay where they were: an end that a missing vessel leaves behind is neither inlet nor outlet.
///
/// # Errors
///
/// No vessel has the label; no inlet or no outlet is left.
pub fn without(network: &Network, labels: &[impl AsRef<str>]) -> Result<Network> {
    let present: Vec<&str> = network.vessels().map(|(_, vessel)| vessel.label.as_str()).collect();
    if let Some(unknown) = labels.iter().map(AsRef::as_ref).find(|label| !present.contains(label)) {
        let meant = did_you_mean(unknown, present.iter().copied());
        let accepted = format!("{meant}expected labels among {}", present.join(", "));
        return Err(Error::parameter("without", format!("\"{unknown}\""), accepted));
    }
    let rest = part(network, |vessel| labels.iter().all(|label| label.as_ref() != vessel.label));
    for role in [Role::Inlet, Role::Outlet] {
        if !rest.nodes().any(|node| node.role == Some(role)) {
            let names: Vec<&str> = labels.iter().map(AsRef::as_ref).collect();
            let accepted = format!("leaves no {}; expected fewer vessels", role.name());
            return Err(Error::parameter("without", format!("\"{}\"", names.join(",")), accepted));
        }
    }
    Ok(rest)
}
