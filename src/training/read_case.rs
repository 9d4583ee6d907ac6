//! Reads one case.

use std::path::Path;

use super::case_folders::CaseFolder;
use super::example::Case;
use super::known_connections::KnownConnections;
use super::truth_file;
use crate::candidates::features::Extraction;
use crate::error::{Fault, Result};
use crate::io::tables::conditions::read_inlets;
use crate::io::{Content, ReadOptions, bytes_of, read as read_file, read_links};
use crate::network::units::millimetres;
use crate::network::{Network, RadiusRule, locate};
use crate::support::geometry::distance;

/// An end of a listed connection is a point no more than so many spacings away.
const MOST_SPACINGS: f64 = 3.0;

/// The case in a folder, and what a person should know about how it was read.
pub fn read(data_set: &str, folder: &CaseFolder) -> Result<(Case, Vec<String>)> {
    let (network, mut notes) = network(folder)?;
    let inlets = folder.inlets.as_ref().map_or(Ok(Vec::new()), |path| inlets(path, &network))?;
    let extraction = Extraction::new(&network, &inlets)?;
    let bytes = bytes_of(&folder.truth)?;
    let here = |fault: Fault| fault.in_file(&folder.truth);
    let (truth, subject) = if folder.truth.extension().is_some_and(|ending| ending == "json") {
        truth_file::read(&bytes, &network, &extraction).map_err(here)?
    } else {
        (listed(&bytes, &extraction, &inlets).map_err(here)?, None)
    };
    if truth.connections() == 0 {
        notes.push("an answer of no link: every fragment stands alone".into());
    }
    let (own, groups) = folder.names.split_last().map_or((String::new(), &[][..]), |(own, groups)| (own.clone(), groups));
    let case = Case {
        data_set: data_set.to_owned(),
        group: groups.join("/"),
        subject: subject.unwrap_or(own),
        name: folder.names.join("/"),
        network,
        inlets,
        truth,
    };
    Ok((case, notes))
}

/// The observed vessels.
fn network(folder: &CaseFolder) -> Result<(Network, Vec<String>)> {
    let path = &folder.fragments;
    let document = read_file(path, &ReadOptions { loops: folder.loops.clone(), ..ReadOptions::default() })?;
    let network = match document.content {
        Content::Graph(_) => Err(Fault::file("a candidate graph", "expected centerlines")),
        lines => lines.into_network(RadiusRule::Mean, None).map(|made| made.network),
    }
    .map_err(|fault| fault.in_file(path))?;
    let own = format!(" {}", folder.loops.as_ref().map_or(String::new(), |loops| loops.display().to_string()));
    Ok((network, document.notes.into_iter().filter(|note| folder.loops.is_none() || !note.ends_with(&own)).collect()))
}

/// The nodes that a table of conditions names as inlets.
fn inlets(path: &Path, network: &Network) -> Result<Vec<usize>> {
    let bytes = bytes_of(path)?;
    let wrong = |fault: Fault| fault.in_file(path);
    let mut out = Vec::new();
    for statement in read_inlets(&bytes).map_err(wrong)? {
        let found = locate(network, &statement.spec);
        out.push(found.map_err(|why| wrong(statement.fault(why)))?.node);
    }
    Ok(out)
}

/// The connections that a table lists.
fn listed(bytes: &[u8], extraction: &Extraction, inlets: &[usize]) -> Result<KnownConnections, Fault> {
    let mut pairs = Vec::new();
    for listed in read_links(bytes)? {
        let mut ends = [0; 2];
        for (end, position) in ends.iter_mut().zip(listed.ends) {
            let away = extraction.position.iter().enumerate().map(|(point, p)| (distance(*p, position), point));
            let nearest = away.min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, point)) = nearest.filter(|(away, _)| *away <= MOST_SPACINGS * extraction.spacing) else {
                let [x, y, z] = position.map(millimetres);
                let away = nearest.map_or(f64::INFINITY, |(away, _)| millimetres(away));
                let found = format!("an end at {x},{y},{z}, {away:.3} mm from the nearest point of the fragments");
                return Err(Fault::line(listed.line, found, "expected the positions of two points"));
            };
            *end = point;
        }
        pairs.push(ends);
    }
    Ok(KnownConnections::between(extraction, &pairs, inlets))
}
