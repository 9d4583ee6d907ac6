//! Finds case folders and the files in them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Fault, Result};

/// Folders further down are not looked into.
const DEEPEST: usize = 8;
/// The truth beside the fragments, under the names that people and `willis phantom` give it.
const TRUTHS: [&str; 2] = ["truth.json", "fragments.truth.json"];
const LINKS: &str = "links.csv";
const LOOPS: [&str; 2] = ["loops.csv", "fragments.loops.csv"];

/// The files of a case.
#[derive(Debug, Clone)]
pub struct CaseFolder {
    /// Names of the folders that lead to it from its data set, its own last.
    pub names: Vec<String>,
    /// The centerlines.
    pub fragments: PathBuf,
    /// The truth, JSON or CSV.
    pub truth: PathBuf,
    /// Positions of inlets, where given.
    pub inlets: Option<PathBuf>,
    /// Links that SWC cannot hold.
    pub loops: Option<PathBuf>,
}

/// The case folders in a folder, itself among them, in the order of their names; and how many folders have fragments but no truth.
pub fn find(data_set: &Path) -> Result<(Vec<CaseFolder>, usize)> {
    let (mut found, mut unanswered) = (Vec::new(), 0);
    walk(data_set, &mut Vec::new(), &mut found, &mut unanswered)?;
    Ok((found, unanswered))
}

fn walk(folder: &Path, names: &mut Vec<String>, found: &mut Vec<CaseFolder>, unanswered: &mut usize) -> Result<()> {
    let unread = |source| Error::Read { path: folder.to_owned(), source };
    let mut entries =
        fs::read_dir(folder).map_err(unread)?.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>().map_err(unread)?;
    entries.sort();
    let file = |name: &str| Some(folder.join(name)).filter(|path| path.is_file());
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

fn is_fragments(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    name.starts_with("fragments.") && !TRUTHS.contains(&name) && !LOOPS.contains(&name) && path.is_file()
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
