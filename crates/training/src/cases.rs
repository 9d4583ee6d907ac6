//! Reads cases from folders: the fragments of an extraction and its true connections.

use std::path::{Path, PathBuf};
use std::{collections::BTreeMap, fs};

use super::contact_truth::ContactTruth;
use super::example::{Case, Model};
use super::known_connections::{KnownConnections, read_truth};
use willis_core::error::{Error, Fault, Result, require};
use willis_core::network::{Network, RadiusRule, locate, units::millimetres};
use willis_core::support::{geometry::distance, in_order};
use willis_io::formats::tables::conditions::read_inlets;
use willis_io::formats::{Content, ReadOptions, is_there, open_regular, read as read_file, read_links, regular_bytes_of};
use willis_models::candidates::{features::Extraction, resample::CenterlineKind, resample::Resampled};

/// Folders further down are not looked into.
const DEEPEST: usize = 8;
/// The truth beside the fragments, under the names that people and `willis phantom` give it.
const TRUTHS: [&str; 2] = ["truth.json", "fragments.truth.json"];
const LINKS: &str = "links.csv";
/// The mask that a skeleton was thinned from.
const MASKS: [&str; 2] = ["mask.nii.gz", "mask.nii"];
const LOOPS: [&str; 2] = ["loops.csv", "fragments.loops.csv"];
/// Where the arteries enter and leave, as `willis phantom` writes it; not looked at.
const LANDMARKS: &str = "fragments.landmarks.csv";
/// An end of a listed connection is a point no more than so many spacings away.
const MOST_SPACINGS: f64 = 3.0;

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
        let (before, mut unanswered) = (folders.len(), 0);
        walk(data_set, 0, &mut |path, entries| {
            let truths: Vec<PathBuf> =
                TRUTHS.into_iter().chain([LINKS]).map(|truth| path.join(truth)).filter(|truth| is_there(truth)).collect();
            if truths.is_empty() {
                unanswered += usize::from(entries.iter().any(|path| is_fragments(path)));
                return false;
            }
            // The data set itself, or its folders down to this one.
            let way = path.strip_prefix(data_set).ok().filter(|way| *way != Path::new(""));
            let way = way.unwrap_or(Path::new(path.file_name().unwrap_or_default()));
            let names: Vec<String> = way.iter().map(|name| name.to_string_lossy().into_owned()).collect();
            let case = Case {
                data_set: name.clone(),
                group: names[..names.len().saturating_sub(1)].join("/"),
                subject: names.last().cloned().unwrap_or_default(),
                name: names.join("/"),
                images: entries.iter().filter(|path| is_image(path)).cloned().collect(),
                ..Case::default()
            };
            folders.push(CaseFolder { case, path: path.to_owned(), truths, entries: entries.to_vec() });
            true
        })?;
        let accepted = "expected folders with fragments.swc and truth.json or links.csv in it";
        require(folders.len() > before, "CASES", format!("{}: no case", data_set.display()), accepted)?;
        if unanswered > 0 {
            *found.notes.entry("fragments without an answer: left out".into()).or_default() += unanswered;
        }
    }
    each_once(folders.iter().map(|folder| &folder.path))?;
    for read in in_order(&folders, |_, folder| read_case(folder, model)) {
        let (case, notes) = read?;
        found.cases.push(case);
        for note in notes {
            *found.notes.entry(note).or_default() += 1;
        }
    }
    Ok(found)
}

/// Refuses a case that is found by two ways: it would count twice, by a link under two names, of which one may be held out.
pub(crate) fn each_once<'a>(folders: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let mut seen: BTreeMap<PathBuf, &PathBuf> = BTreeMap::new();
    for folder in folders {
        let real = folder.canonicalize().map_err(|source| Error::Read { path: folder.clone(), source })?;
        if let Some(before) = seen.insert(real, folder) {
            let found = format!("{} is {} once more", folder.display(), before.display());
            return Err(Error::parameter("CASES", found, "expected each case once"));
        }
    }
    Ok(())
}

/// The last name of a path, also of `.`.
fn last_name(path: &Path) -> String {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// A folder with a case.
struct CaseFolder {
    /// What its place tells: names, and images.
    case: Case,
    /// Where it is.
    path: PathBuf,
    /// Its truths, of which there should be one.
    truths: Vec<PathBuf>,
    /// Everything in it.
    entries: Vec<PathBuf>,
}

/// Visits a folder with all that lies in it, and the folders in it, in the order of their names, until `is_case` says that this is a case.
pub(crate) fn walk(folder: &Path, depth: usize, is_case: &mut dyn FnMut(&Path, &[PathBuf]) -> bool) -> Result<()> {
    let unread = |source| Error::Read { path: folder.to_owned(), source };
    let mut entries =
        fs::read_dir(folder).map_err(unread)?.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>().map_err(unread)?;
    entries.sort();
    if is_case(folder, &entries) {
        return Ok(());
    }
    for path in entries.into_iter().filter(|path| path.is_dir() && depth < DEEPEST) {
        walk(&path, depth + 1, is_case)?;
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
    name.starts_with("fragments.") && ![&TRUTHS[..], &LOOPS, &[LANDMARKS]].concat().contains(&name) && is_there(path)
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
fn read_case(folder: &CaseFolder, model: Model) -> Result<(Case, Vec<String>)> {
    let [path] = &folder.truths[..] else {
        let fault = Fault::file(format!("{} lies beside it", folder.truths[1].display()), "expected one answer");
        return Err(fault.in_file(&folder.truths[0]));
    };
    let file = |name: &str| Some(folder.path.join(name)).filter(|path| is_there(path));
    let lines = fragments(&folder.path, &folder.entries)?;
    let (mask, loops) = (MASKS.into_iter().find_map(file), LOOPS.into_iter().find_map(file));
    let given_inlets = file("inlets.csv");
    // Nobody named these files.
    let files = [&lines, path].into_iter().chain(&given_inlets).chain(&loops).chain(&folder.case.images).chain(&mask);
    files.into_iter().try_for_each(|path| open_regular(path).map(drop))?;
    let (network, mut notes) = read_network(&lines, loops)?;
    let bytes = regular_bytes_of(path)?;
    let here = |fault: Fault| fault.in_file(path);
    let case = Case { mask, ..folder.case.clone() };
    let kind = match model {
        Model::Tracing => CenterlineKind::Tracing,
        Model::Skeleton => CenterlineKind::Skeleton,
        Model::Contacts => {
            let mut truth = ContactTruth::read(&bytes).map_err(here)?;
            let subject = truth.subject.take().unwrap_or(case.subject);
            return Ok((Case { subject, network, contacts: Some(truth), ..case }, notes));
        }
    };
    let inlets = given_inlets.as_ref().map_or(Ok(Vec::new()), |path| inlets(path, &network))?;
    // The truth is about the points that the model sees.
    let resampled = Resampled::new(&network, kind);
    let extraction = resampled.extraction(&inlets)?;
    let (truth, subject) = if path.extension().is_some_and(|ending| ending == "json") {
        read_truth(&bytes, &network, &extraction, &inlets).map_err(here)?
    } else {
        (listed(&bytes, &extraction, &inlets).map_err(here)?, None)
    };
    if truth.connections() == 0 {
        notes.push("an answer of no link: every fragment stands alone".into());
    }
    Ok((Case { subject: subject.unwrap_or(case.subject), network, inlets, truth, ..case }, notes))
}

/// The observed vessels in a file, with links that SWC cannot hold, and what a person should know about how they were read.
pub(crate) fn read_network(path: &Path, loops: Option<PathBuf>) -> Result<(Network, Vec<String>)> {
    let own = loops.as_ref().map(|loops| format!(" {}", loops.display()));
    let document = read_file(path, &ReadOptions { loops, ..ReadOptions::default() })?;
    let network = match document.content {
        Content::Graph(_) => Err(Fault::file("a candidate graph", "expected centerlines")),
        lines => lines.into_network(RadiusRule::Mean, None).map(|made| made.network),
    }
    .map_err(|fault| fault.in_file(path))?;
    Ok((network, document.notes.into_iter().filter(|note| own.as_ref().is_none_or(|own| !note.ends_with(own))).collect()))
}

/// The nodes that a table of conditions names as inlets.
fn inlets(path: &Path, network: &Network) -> Result<Vec<usize>> {
    let bytes = regular_bytes_of(path)?;
    let wrong = |fault: Fault| fault.in_file(path);
    let stated = read_inlets(&bytes).map_err(wrong)?.into_iter();
    let found = stated.map(|one| locate(network, &one.spec).map(|at| at.node).map_err(|why| wrong(one.fault(why))));
    found.collect()
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
        if ends[0] == ends[1] {
            return Err(Fault::line(listed.line, "both ends are at one point", "expected the positions of two points"));
        }
        pairs.push(ends);
    }
    Ok(KnownConnections::between(extraction, &pairs, inlets))
}
