//! Which folders willis wrote, and may replace.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::names::{
    AGREEMENT, BESIDE_LABELLED, COHORT, COHORT_FILES, FAILURE, FILES, LABELLED, MEDIAN_TOPOLOGY, PICTURES, RECORD, TOPOLOGY,
    TOPOLOGY_ENDINGS,
};
use crate::output::files::read_json;

/// Whether a path has the name of a file of a cohort.
pub fn is_cohort_file(path: &Path) -> bool {
    is_named(path, COHORT_FILES)
}

fn is_named(path: &Path, names: &[&str]) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| names.contains(&name))
}

/// Whether a path has the name of a file of a run.
fn is_run_file(path: &Path) -> bool {
    let part = |part: Option<&OsStr>, known: &[&str]| part.and_then(OsStr::to_str).is_some_and(|part| known.contains(&part));
    let is = |stems: &[&str], endings: &[&str]| part(path.file_stem(), stems) && part(path.extension(), endings);
    is_named(path, &FILES.concat())
        || BESIDE_LABELLED.iter().any(|ending| path.ends_with(Path::new(LABELLED).with_extension(ending)))
        || is(&PICTURES.concat(), &["png", "svg"])
        || is(&[TOPOLOGY, MEDIAN_TOPOLOGY], &TOPOLOGY_ENDINGS)
}

/// What tells a record of willis, without the conditions of a million vessels that it may hold.
#[derive(serde::Deserialize)]
struct OwnRecord {
    #[serde(rename = "willis")]
    _version: serde::de::IgnoredAny,
}

/// The first path in a folder that willis did not write; `None` if it wrote all, or there are none.
pub fn foreign_file(folder: &Path) -> Option<PathBuf> {
    let Some(paths) = super::in_progress::entries(folder) else { return Some(folder.to_owned()) };
    let is_written_by_willis = |mark| folder.join(mark).is_file() && read_json::<OwnRecord>(&folder.join(mark), "").is_ok();
    if let Some(mark) = [RECORD, FAILURE, COHORT].into_iter().find(|mark| folder.join(mark).exists()) {
        if !is_written_by_willis(mark) {
            return Some(folder.join(mark));
        }
        let of_cohort =
            |path: PathBuf| if path.is_dir() { foreign_file(&path) } else { (!is_named(&path, COHORT_FILES)).then_some(path) };
        let mut paths = paths.into_iter();
        return match mark {
            RECORD => paths.find(|path| !is_run_file(path)),
            FAILURE => paths.find(|path| !is_named(path, &[FAILURE])),
            _ => paths.filter(|path| !super::in_progress::is_in_progress(path)).find_map(of_cohort),
        };
    }
    let is_run = |path: &Path| path.is_dir() && path.join(RECORD).exists();
    let of_sweep =
        |path: PathBuf| if is_run(&path) { foreign_file(&path) } else { (!is_named(&path, &[AGREEMENT])).then_some(path) };
    paths.into_iter().find_map(of_sweep)
}
