//! Which folders willis wrote, and may replace.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::in_progress::{entries, is_in_progress};
use super::names::{
    ACCURACY, AGREEMENT, BESIDE_LABELLED, BIFURCATIONS, CLASSES, COHORT, COHORT_PAGE, COHORT_TABLE, COLLATERAL, COMPARISON,
    CONVERGENCE_PICTURE, DENSE_LIKELIHOOD, EDGES, ENDS, FAILURE, FLOW_PICTURE, GRAPH, HARMONICS, HYPERTENSION,
    HYPERTENSION_PICTURE, INSTANCES, INTERVALS, LABELLED, LANDMARKS, LEDGER, LIKELIHOOD, LIKELIHOOD_PICTURE, MEDIAN_TOPOLOGY,
    MODULATION_PICTURE, NODES, OCCLUSIONS, PAGE, PAIRINGS, PHENOTYPE, PHENOTYPE_TABLE, RECORD, REVIEW, SUBJECTS, SUGGESTED_CUTS,
    SUMMARY_PICTURE, SUPPLY, TERRITORIES, TERRITORY_PICTURE, TOPOLOGY, TRANSIT, VESSELS, WAVEFORM_PICTURE, WAVEFORM_TABLE,
    WAVEFORMS,
};
use crate::output::files::read_json;

/// The files that the folder of a run may hold besides pictures and topologies; --force replaces no folder with others.
const FILES: [&str; 30] = [
    RECORD,
    COMPARISON,
    OCCLUSIONS,
    VESSELS,
    BIFURCATIONS,
    ENDS,
    INTERVALS,
    SUBJECTS,
    LEDGER,
    EDGES,
    NODES,
    SUGGESTED_CUTS,
    PAIRINGS,
    REVIEW,
    DENSE_LIKELIHOOD,
    LIKELIHOOD,
    PAGE,
    GRAPH,
    CLASSES,
    HYPERTENSION,
    INSTANCES,
    PHENOTYPE,
    PHENOTYPE_TABLE,
    COLLATERAL,
    TERRITORIES,
    TRANSIT,
    WAVEFORMS,
    WAVEFORM_TABLE,
    HARMONICS,
    SUPPLY,
];
const PICTURES: [&str; 8] = [
    SUMMARY_PICTURE,
    TERRITORY_PICTURE,
    WAVEFORM_PICTURE,
    LIKELIHOOD_PICTURE,
    CONVERGENCE_PICTURE,
    FLOW_PICTURE,
    MODULATION_PICTURE,
    HYPERTENSION_PICTURE,
];
/// The files in the folder of a cohort besides the folders of its subjects.
const COHORT_FILES: &[&str] = &[COHORT, COHORT_TABLE, COHORT_PAGE, ACCURACY];

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
    let is_known = is_named(path, &FILES) || is_named(path, &LANDMARKS);
    is_known
        || is_labelled(path)
        || is(&PICTURES, &["png", "svg"])
        || is(&[TOPOLOGY, MEDIAN_TOPOLOGY], &["graphml", "vtp", "swc"])
}

/// Whether a path has the name of the labelled vessels of a subject, or of a file beside them.
fn is_labelled(path: &Path) -> bool {
    let labelled = Path::new(LABELLED);
    is_named(path, &[LABELLED]) || BESIDE_LABELLED.iter().any(|ending| path.ends_with(labelled.with_extension(ending)))
}

/// What tells a record of willis, without the conditions of a million vessels that it may hold.
#[derive(Deserialize)]
struct OwnRecord {
    #[serde(rename = "willis")]
    _version: IgnoredAny,
}

/// The first path in a folder that willis did not write; `None` if it wrote all, or there are none.
pub fn foreign_file(folder: &Path) -> Option<PathBuf> {
    let Some(paths) = entries(folder) else { return Some(folder.to_owned()) };
    let is_written_by_willis = |mark| folder.join(mark).is_file() && read_json::<OwnRecord>(&folder.join(mark), "").is_ok();
    if folder.join(RECORD).exists() {
        return if is_written_by_willis(RECORD) {
            paths.into_iter().find(|p| !is_run_file(p))
        } else {
            Some(folder.join(RECORD))
        };
    }
    if folder.join(FAILURE).exists() {
        let rest = paths.into_iter().find(|p| !is_named(p, &[FAILURE]));
        return if is_written_by_willis(FAILURE) { rest } else { Some(folder.join(FAILURE)) };
    }
    if folder.join(COHORT).exists() {
        let of_cohort =
            |path: PathBuf| if path.is_dir() { foreign_file(&path) } else { (!is_named(&path, COHORT_FILES)).then_some(path) };
        let mut rest = paths.into_iter().filter(|path| !is_in_progress(path));
        return if is_written_by_willis(COHORT) { rest.find_map(of_cohort) } else { Some(folder.join(COHORT)) };
    }
    paths.into_iter().find_map(|path| {
        if path.is_dir() && path.join(RECORD).exists() {
            return foreign_file(&path);
        }
        (!is_named(&path, &[AGREEMENT])).then_some(path)
    })
}
