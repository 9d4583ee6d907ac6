//! Which folders this program made, and may replace.

use std::fs;
use std::path::{Path, PathBuf};

use super::making::is_in_the_making;
use crate::formats::bytes_of;

/// The record by which a folder of this program is known.
pub const MARK: &str = "run.json";
/// The record by which the folder of a shard is known.
pub const SHARD_MARK: &str = "shard.json";
/// All that such a folder holds.
const SHARD_FILES: &[&str] = &[SHARD_MARK, "shard.npz"];
/// The record by which the folder of an input that gave no run is known.
pub const FAILURE_MARK: &str = "failed.json";
/// All that such a folder may hold; --force replaces no folder with anything else in it.
const FILES: &[&str] = &[
    "edges.csv",
    "nodes.csv",
    "likelihood.npy",
    "likelihood.npz",
    "likelihood.png",
    "likelihood.svg",
    "convergence.png",
    "convergence.svg",
    "flow.png",
    "flow.svg",
    MARK,
    "report.html",
    "candidates.graphml",
    "topology.graphml",
    "topology.vtp",
    "topology.swc",
    "topology-median.graphml",
    "topology-median.vtp",
    "classes.csv",
    "hypertension.csv",
    "samples.npz",
    "modulation.png",
    "modulation.svg",
    "hypertension.png",
    "hypertension.svg",
    "phenotype.json",
    "phenotype.csv",
    "collateral.csv",
];
const AGREEMENT: &str = "agreement.csv";
/// The record by which the folder of a cohort is known.
pub const COHORT_MARK: &str = "cohort.json";
/// What such a folder holds beside the folders of its subjects.
const COHORT_FILES: &[&str] = &[COHORT_MARK, "cohort.csv", "cohort.html"];

/// The paths in a folder; `None` when it cannot be read.
pub fn entries(folder: &Path) -> Option<Vec<PathBuf>> {
    fs::read_dir(folder).ok()?.map(|entry| entry.ok().map(|e| e.path())).collect()
}

/// Whether a path is called as what stands in the folder of a cohort beside its subjects.
pub fn is_of_cohort(path: &Path) -> bool {
    is_named(path, COHORT_FILES)
}

fn is_named(path: &Path, names: &[&str]) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| names.contains(&name))
}

/// The first path in a folder that no run of this program made; `None` when all are ours, or there are none.
pub fn stranger(folder: &Path) -> Option<PathBuf> {
    let Some(paths) = entries(folder) else { return Some(folder.to_owned()) };
    let record = |mark| bytes_of(&folder.join(mark)).ok().and_then(|b| serde_json::from_slice::<serde_json::Value>(&b).ok());
    let is_ours = |mark| record(mark).is_some_and(|r| r.get("willis").is_some());
    if folder.join(MARK).exists() {
        return if is_ours(MARK) { paths.into_iter().find(|p| !is_named(p, FILES)) } else { Some(folder.join(MARK)) };
    }
    for (mark, files) in [(SHARD_MARK, SHARD_FILES), (FAILURE_MARK, &[FAILURE_MARK])] {
        if folder.join(mark).exists() {
            let rest = paths.into_iter().find(|p| !is_named(p, files));
            return if is_ours(mark) { rest } else { Some(folder.join(mark)) };
        }
    }
    if folder.join(COHORT_MARK).exists() {
        let of_cohort =
            |path: PathBuf| if path.is_dir() { stranger(&path) } else { (!is_named(&path, COHORT_FILES)).then_some(path) };
        let mut rest = paths.into_iter().filter(|path| !is_in_the_making(path));
        return if is_ours(COHORT_MARK) { rest.find_map(of_cohort) } else { Some(folder.join(COHORT_MARK)) };
    }
    paths.into_iter().find_map(|path| {
        if path.is_dir() && path.join(MARK).exists() {
            return stranger(&path);
        }
        (!is_named(&path, &[AGREEMENT])).then_some(path)
    })
}
