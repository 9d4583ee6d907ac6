//! Writes the candidate bridges of an extraction by a rule: `candidates RULE FRAGMENTS.swc INLETS.csv EDGES.csv`.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufReader, Error, ErrorKind, Result};
use std::time::Instant;

use willis::error::Fault;
use willis::internals::candidates::features::features;
use willis::internals::candidates::resample::{CenterlineKind, Resampled};
use willis::internals::candidates::search::{SearchOptions, search};
use willis::internals::network::units::Scale;
use willis::internals::network::{Network, RadiusRule, contract, nearest_node, parse_position};

/// As the command line: a fraction of the box around the points.
const WELD_TOLERANCE: f64 = 1e-6;

/// From the reference model's rules to ours, a change at a time.
fn rule(name: &str) -> Option<SearchOptions> {
    let reference = SearchOptions { branches: 4, free_ends: 4, own_branches: 2, ahead: 2, behind: 0, kinks: 0 };
    let behind = SearchOptions { behind: 2, ..reference.clone() };
    let kinks = SearchOptions { kinks: 2, ..behind.clone() };
    let three = SearchOptions { ahead: 3, behind: 3, kinks: 3, ..reference.clone() };
    match name {
        "reference" => Some(reference),
        "behind" => Some(behind),
        "behind+kinks" => Some(kinks),
        "behind+kinks+three" => Some(three),
        "default" => Some(SearchOptions::default()),
        "default+branch" => Some(SearchOptions { branches: 6, ..SearchOptions::default() }),
        _ => None,
    }
}

fn observed(path: &str) -> Result<Network> {
    let wrong = |fault: Fault| Error::other(fault.in_file(path.as_ref()));
    let file = BufReader::new(fs::File::open(path)?);
    let (mut lines, _) = willis::internals::formats::read_swc(file, &Scale::default()).map_err(wrong)?;
    lines.weld(WELD_TOLERANCE);
    Ok(contract(&lines, RadiusRule::Mean, None).map_err(wrong)?.network)
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, fragments, inlets, edges] = &arguments[..] else {
        return Err(Error::new(ErrorKind::InvalidInput, "expected RULE FRAGMENTS.swc INLETS.csv EDGES.csv"));
    };
    let params = rule(name).ok_or_else(|| Error::new(ErrorKind::InvalidInput, format!("no rule {name}")))?;
    let network = observed(fragments)?;
    let inlets = fs::read_to_string(inlets)?;
    let inlets: Vec<usize> =
        inlets.lines().filter_map(|l| nearest_node(&network, parse_position(l)?, |_| true)).map(|found| found.node).collect();
    let began = Instant::now();
    let extraction = Resampled::new(&network, CenterlineKind::Tracing).extraction(&inlets).map_err(Error::other)?;
    let bridges = search(&extraction, &params).map_err(Error::other)?;
    let columns = features(&extraction, &bridges);
    let took = began.elapsed();
    let mut out = csv::Writer::from_path(edges)?;
    out.write_record(["ax_mm", "ay_mm", "az_mm", "bx_mm", "by_mm", "bz_mm", "origin", "likelihood", "kept"])?;
    // A bridge between two free ends is found from both.
    let mut pairs = BTreeSet::new();
    for bridge in &bridges {
        let ends = [extraction.ends[bridge.end].point, bridge.point];
        if pairs.insert([ends[0].min(ends[1]), ends[0].max(ends[1])]) {
            let mut row: Vec<String> = ends.iter().flat_map(|p| extraction.position[*p]).map(|x| (x * 1e3).to_string()).collect();
            row.extend(["candidate", "1", "0"].map(str::to_owned));
            out.write_record(row)?;
        }
    }
    out.flush()?;
    eprintln!(
        "{fragments}: {} points, {} fragments, {} bridges of {} features in {:.1} ms",
        extraction.position.len(),
        extraction.fragments.len(),
        columns.nrows(),
        columns.ncols(),
        took.as_secs_f64() * 1e3
    );
    Ok(())
}
