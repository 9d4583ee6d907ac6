//! Finding vessels by what a person calls them: the anatomical label, or the row of the vessel.

use super::Network;
use crate::suggestion::nearest;

/// Names offered for one that no vessel has.
const OFFERED: usize = 3;

/// The rows of the vessels called `name`: all that carry it as their label, exactly; without such a label the vessel of
/// the row in `edge:12` or `12`, counted from 0.
///
/// # Errors
///
/// No vessel is called so; the text says what is accepted and offers the labels nearest by edit distance (insertions,
/// deletions, substitutions and swaps of neighbours, without regard to case).
pub fn vessels_called(network: &Network, name: &str) -> Result<Vec<usize>, String> {
    let name = name.trim();
    let labelled: Vec<usize> =
        network.vessels().enumerate().filter(|(_, (_, v))| !v.label.is_empty() && v.label == name).map(|(row, _)| row).collect();
    if !labelled.is_empty() {
        return Ok(labelled);
    }
    let digits = name.strip_prefix("edge:").unwrap_or(name);
    let last = network.vessel_count().saturating_sub(1);
    match digits.parse::<usize>() {
        Ok(row) if row < network.vessel_count() => Ok(vec![row]),
        Ok(row) => Err(format!("there is no edge {row}; expected a vessel's label, or edge:0 to edge:{last}")),
        Err(_) => Err(format!("no vessel is called \"{name}\"; expected {}", offer(network, name, last))),
    }
}

/// The labels nearest to `name`, or the rows where the network has no labels.
fn offer(network: &Network, name: &str, last: usize) -> String {
    let labels = nearest(name, network.vessels().map(|(_, v)| v.label.as_str()));
    if labels.is_empty() {
        return format!("edge:0 to edge:{last}, for the vessels have no labels");
    }
    let nearest: Vec<String> = labels.iter().take(OFFERED).map(|label| format!("\"{label}\"")).collect();
    format!("a label such as {}, or edge:0 to edge:{last}", nearest.join(", "))
}
