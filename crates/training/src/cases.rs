//! Reads cases from folders: the fragments of an extraction and its true connections.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::contact_truth::ContactTruth;
use super::example::Case;
use super::known_connections::KnownConnections;
use super::truth_file;
use willis_core::error::{Error, Fault, Result};
use willis_core::network::units::millimetres;
use willis_core::network::{Network, RadiusRule, locate};
use willis_core::support::geometry::distance;
use willis_core::support::in_order;
use willis_io::formats::tables::conditions::read_inlets;
use willis_io::formats::{Content, ReadOptions, is_there, open_regular, read as read_file, read_links, regular_bytes_of};
use willis_models::candidates::features::Extraction;
use willis_models::candidates::kind::CenterlineKind;
use willis_models::candidates::resample::Resampled;

/// Folders further down are not looked into.
const DEEPEST: usize = 8;
/// The truth beside the fragments, under the names that people and `willis phantom` give it.
const TRUTHS: [&str; 2] = ["truth.json", "fragments.truth.json"];
const LINKS: &str = "links.csv";
/// The mask that a skeleton was thinned from.
const MASKS: [&str; 2] = ["mask.nii.gz", "mask.nii"];
const LOOPS: [&str; 2] = ["loops.csv", "fragments.loops.csv"];
/// An end of a listed connection is a point no more than so many spacings away.
const MOST_SPACINGS: f64 = 3.0;

/// What a model is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// Tracings: fragments form a forest.
    #[default]
    Tracing,
    /// Automatic skeletons: candidates are judged one by one.
    Skeleton,
    /// Automatic skeletons: which branch ends are one vessel where they meet.
    Contacts,
}

/// Cases that were read.
#[derive(Debug, Clone, Default)]
pub struct Cases {
    /// The cases by data set, in the order of their names there.
    pub cases: Vec<Case>,
    /// What a person should know about how they were read, with the number of cases concerned.
    pub notes: BTreeMap<String, usize>,
}

/// Reads all cases in some folders, each a data set.
///
/// A case folder holds `fragments.swc` (or one other file of centerlines of that name) and the truth: `truth.json`, or
/// `links.csv`. Beside them may lie `inlets.csv`, the nodes where blood is known to enter, and `loops.csv`, links that SWC cannot hold.
///
/// # Errors
///
/// A folder without a case; a file that cannot be read or is wrong; a truth that does not fit its fragments.
pub fn read_cases(data_sets: &[PathBuf], model: Model) -> Result<Cases> {
    let mut found = Cases::default();
    let mut folders = Vec::new();
    for (at, data_set) in data_sets.iter().enumerate() {
        let short = last_name(data_set);
        let twice = data_sets.iter().enumerate().any(|(other, path)| other != at && last_name(path) == short);
        let name = if twice { data_set.display().to_string() } else { short };
        let (mut here, mut unanswered) = (Vec::new(), 0);
        walk(data_set, &mut Vec::new(), &mut here, &mut unanswered)?;
        if here.is_empty() {
            let accepted = "expected folders with fragments.swc and truth.json or links.csv in it";
            return Err(Error::parameter("CASES", format!("{}: no case", data_set.display()), accepted));
        }
        if unanswered > 0 {
            *found.notes.entry("fragments without an answer: left out".into()).or_default() += unanswered;
        }
        folders.extend(here.into_iter().map(|folder| (name.clone(), folder)));
    }
    for read in in_order(&folders, |_, (data_set, folder)| read_case(data_set, folder, model)) {
        let (case, notes) = read?;
        found.cases.push(case);
        for note in notes {
            *found.notes.entry(note).or_default() += 1;
        }
    }
    Ok(found)
}

/// The last name of a path, also of `.`.
fn last_name(path: &Path) -> String {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// The files of a case.
struct CaseFolder {
    /// Names of the folders that lead to it from its data set, its own last.
    names: Vec<String>,
    /// The centerlines.
    fragments: PathBuf,
    /// The truth, JSON or CSV.
    truth: PathBuf,
    /// Positions of inlets, where given.
    inlets: Option<PathBuf>,
    /// Links that SWC cannot hold.
    loops: Option<PathBuf>,
    /// Images in NIfTI, as many as there are.
    images: Vec<PathBuf>,
}

impl CaseFolder {
    /// Its files, none of which anybody named.
    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.fragments, &self.truth].into_iter().chain(&self.inlets).chain(&self.loops).chain(&self.images)
    }
}

/// Adds the case folders in a folder, itself among them, in the order of their names, and counts the folders that have fragments but
/// no truth.
fn walk(folder: &Path, names: &mut Vec<String>, found: &mut Vec<CaseFolder>, unanswered: &mut usize) -> Result<()> {
    let unread = |source| Error::Read { path: folder.to_owned(), source };
    let mut entries =
        fs::read_dir(folder).map_err(unread)?.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>().map_err(unread)?;
    entries.sort();
    let file = |name: &str| Some(folder.join(name)).filter(|path| is_there(path));
    let truths: Vec<PathBuf> = TRUTHS.into_iter().chain([LINKS]).filter_map(file).collect();
    match &truths[..] {
        [] => {}
        [truth] => {
            let own = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            found.push(CaseFolder {
                names: if names.is_empty() { vec![own] } else { names.clone() },
                fragments: fragments(folder, &entries)?,
                truth: truth.clone(),
                inlets: file("inlets.csv"),
                loops: LOOPS.into_iter().find_map(file),
                images: entries.iter().filter(|path| is_image(path)).cloned().collect(),
            });
            return Ok(());
        }
        [first, second, ..] => {
            return Err(Fault::file(format!("{} lies beside it", second.display()), "expected one answer").in_file(first));
        }
    }
    *unanswered += usize::from(entries.iter().any(|path| is_fragments(path)));
    for path in entries.into_iter().filter(|path| path.is_dir()) {
        if names.len() < DEEPEST {
            names.push(path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()));
            walk(&path, names, found, unanswered)?;
            names.pop();
        }
    }
    Ok(())
}

/// `image.nii.gz`, or several pictures of the same vessels: `image-NAME.nii`.
fn is_image(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let name = name.strip_suffix(".gz").unwrap_or(name).strip_suffix(".nii").unwrap_or_default();
    (name == "image" || name.starts_with("image-")) && is_there(path)
}

fn is_fragments(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    name.starts_with("fragments.") && !TRUTHS.contains(&name) && !LOOPS.contains(&name) && is_there(path)
}

/// The centerlines of a case folder.
fn fragments(folder: &Path, entries: &[PathBuf]) -> Result<PathBuf> {
    let found: Vec<&PathBuf> = entries.iter().filter(|path| is_fragments(path)).collect();
    let swc = folder.join("fragments.swc");
    match &found[..] {
        _ if found.contains(&&swc) => Ok(swc),
        [one] => Ok((*one).clone()),
        _ => {
            let what = if found.is_empty() { "no file fragments.*" } else { "several files fragments.*" };
            Err(Fault::file(what, "expected fragments.swc, or one other file of centerlines").in_file(folder))
        }
    }
}

/// The case in a folder, and what a person should know about how it was read.
fn read_case(data_set: &str, folder: &CaseFolder, model: Model) -> Result<(Case, Vec<String>)> {
    let mask = MASKS.iter().map(|name| folder.truth.with_file_name(name)).find(|path| is_there(path));
    folder.files().chain(&mask).try_for_each(|path| open_regular(path).map(drop))?;
    let (network, mut notes) = network(folder)?;
    let bytes = regular_bytes_of(&folder.truth)?;
    let here = |fault: Fault| fault.in_file(&folder.truth);
    let (own, groups) = folder.names.split_last().map_or((String::new(), &[][..]), |(own, groups)| (own.clone(), groups));
    let case = Case {
        data_set: data_set.to_owned(),
        group: groups.join("/"),
        subject: own,
        name: folder.names.join("/"),
        network: Network::new(),
        inlets: Vec::new(),
        truth: KnownConnections::default(),
        contacts: None,
        images: folder.images.clone(),
        mask,
    };
    let kind = match model {
        Model::Tracing => CenterlineKind::Tracing,
        Model::Skeleton => CenterlineKind::Skeleton,
        Model::Contacts => {
            let mut truth = ContactTruth::read(&bytes).map_err(here)?;
            let subject = truth.subject.take().unwrap_or(case.subject);
            return Ok((Case { subject, network, contacts: Some(truth), ..case }, notes));
        }
    };
    let inlets = folder.inlets.as_ref().map_or(Ok(Vec::new()), |path| inlets(path, &network))?;
    // The truth is about the points that the model sees.
    let resampled = Resampled::new(&network, kind);
    let extraction = resampled.extraction(&inlets)?;
    let (truth, subject) = if folder.truth.extension().is_some_and(|ending| ending == "json") {
        truth_file::read(&bytes, &network, &extraction).map_err(here)?
    } else {
        (listed(&bytes, &extraction, &inlets).map_err(here)?, None)
    };
    if truth.connections() == 0 {
        notes.push("an answer of no link: every fragment stands alone".into());
    }
    Ok((Case { subject: subject.unwrap_or(case.subject), network, inlets, truth, ..case }, notes))
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
    let bytes = regular_bytes_of(path)?;
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
