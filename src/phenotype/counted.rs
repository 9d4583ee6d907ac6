//! Which vessels of a graph file count: those that are kept, else those that an image showed.

use crate::network::{Network, Origin};

/// Per vessel whether it counts, and a word on it where some do not.
///
/// `bytes` are those of the file that the network stands in, its edges in order. Where a table has a column `kept`, its rows with 1;
/// a graph that says of its edges whether they were kept holds those that were. Otherwise the observed vessels, or all of a graph that
/// knows no origin.
pub fn counted(network: &Network, bytes: &[u8]) -> (Vec<bool>, Option<String>) {
    let all = vec![true; network.vessel_count()];
    let observed: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.origin == Origin::Observed).collect();
    let some = observed.contains(&true) && observed.contains(&false);
    if let Some(kept) = column(bytes).filter(|kept| kept.len() == all.len()) {
        let note = kept.contains(&false).then(|| "vessels that were not kept do not count".to_owned());
        return (kept, note);
    }
    if some && !says_kept(bytes) {
        return (observed, Some("candidates do not count: nothing says which were kept".to_owned()));
    }
    (all, None)
}

/// The column `kept` of a table of edges.
fn column(bytes: &[u8]) -> Option<Vec<bool>> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let at = reader.headers().ok()?.iter().position(|name| name == "kept")?;
    reader.records().map(|record| Some(record.ok()?.get(at)? == "1")).collect()
}

/// Whether a GraphML file has the attribute `kept`.
fn says_kept(bytes: &[u8]) -> bool {
    let mark = b"attr.name=\"kept\"";
    bytes.windows(mark.len()).any(|window| window == mark)
}
