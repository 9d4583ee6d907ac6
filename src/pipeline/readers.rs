//! Two readers' decisions on the connections of a run, side by side.

use std::collections::BTreeMap;
use std::path::Path;

use super::Input;
use super::decisions::DecisionList;
use willis_core::error::{Fault, Result};
use willis_core::network::units::millimetres;
use willis_report::{ReadBy, TwiceRead};

/// What two readers decided on the connections of a run, as [`read_run`](crate::read_run) has it, in the order of its rows: each that one of them decided on. `files` are their
/// decisions, as the page of the run writes them; `name` is that of the subject.
///
/// # Errors
///
/// An input that is no run; a file that cannot be read, or is of another run.
pub fn twice_read(name: &str, input: &Input, files: [&Path; 2]) -> Result<Vec<TwiceRead>> {
    let Some(run) = &input.run else {
        let accepted = "expected the folder of the run of willis infer that was looked at";
        return Err(Fault::file("no run, so nobody decided on it", accepted).in_file(Path::new(&input.provenance.input)));
    };
    let network = &input.network;
    let mut rows: BTreeMap<usize, [Option<ReadBy>; 2]> = BTreeMap::new();
    for (reader, file) in files.into_iter().enumerate() {
        for made in DecisionList::read(file)?.on(network, &run.input_sha256)?.made {
            let read = ReadBy { accepted: made.accepted, who: made.who, comment: made.comment };
            rows.entry(made.edge).or_default()[reader] = Some(read);
        }
    }
    let row = |(edge, read): (usize, [Option<ReadBy>; 2])| {
        let (subject, ends, vessel) = (name.to_owned(), network.ends(edge), network.vessel(edge));
        let (ids, middle) = (ends.map(|node| network.node(node).id.clone()), network.middle_of(ends, vessel).map(millimetres));
        let probability = vessel.evidence().map_or(f64::NAN, |evidence| evidence.probability);
        TwiceRead { subject, kind: vessel.origin.name(), edge, ids, middle, probability, read }
    };
    Ok(rows.into_iter().map(row).collect())
}
