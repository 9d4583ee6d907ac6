//! A folder that [`infer`](crate::infer) saved, taken up again: its graph and its options, from run.json.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::arteries::FoundArteries;
use super::artery_options::ArterySource;
use super::options::RunOptions;
use willis_core::error::{Fault, Result};
use willis_io::formats::tables::reader::TableReader;
use willis_io::formats::{bytes_of, is_there, open_regular};
use willis_io::output::names::{COHORT, EDGES, GRAPH, LANDMARKS, RECORD};
use willis_io::output::read_json;

/// A run of infer in a folder.
#[derive(Debug, Clone)]
pub(crate) struct StoredRun {
    /// Its over-connected graph.
    pub(crate) graph: PathBuf,
    pub(crate) options: RunOptions,
    /// Samples that were taken, or that an enumeration was scaled to.
    pub(crate) samples: u64,
    /// Nodes whose conditions were stated, not found.
    pub(crate) given: Vec<usize>,
    /// The SHA-256 of its landmarks.
    pub(crate) landmarks: Option<String>,
    /// Its arteries, where it found them by their geometry.
    pub(crate) named: Option<FoundArteries>,
    /// The SHA-256 of its input.
    pub(crate) input_sha256: String,
    sha256: String,
}

impl StoredRun {
    /// The run in a folder.
    ///
    /// # Errors
    ///
    /// A folder that infer did not write.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        const EXPECTED: &str = "expected a folder that willis infer wrote for one occlusion probability";
        let wrong = |found: &str| Fault::file(found, EXPECTED).in_file(folder);
        let path = folder.join(RECORD);
        if is_there(&folder.join(COHORT)) {
            return Err(Fault::file("a cohort", "give one of its subjects, which are folders in it").in_file(folder));
        }
        if !is_there(&path) {
            return Err(wrong("a folder without run.json"));
        }
        let mut record: Value = read_json(&path, "expected the record of willis infer")?;
        let text = |value: &Value| value.as_str().map(str::to_owned);
        let sha256 = text(&record["graph"]["sha256"]).ok_or_else(|| wrong("a run without a graph of candidates"))?;
        let unlike = || wrong("parameters that are not those of willis infer");
        record.get("input").ok_or_else(unlike)?;
        let mut options: RunOptions = serde_json::from_value(record["options"].take()).map_err(|_| unlike())?;
        let named = serde_json::from_value(record["named"].take()).map_err(|_| unlike())?;
        let samples = record["parameters"]["samples"].as_u64().ok_or_else(unlike)?;
        let conditions = record["boundary_conditions"].as_array().ok_or_else(unlike)?;
        let of = |condition: &Value| Some((condition["found"].as_bool()?, condition["node"].as_u64()? as usize));
        let conditions: Vec<(bool, usize)> = conditions.iter().map(of).collect::<Option<_>>().ok_or_else(unlike)?;
        let given = conditions.into_iter().filter(|(is_found, _)| !is_found).map(|(_, node)| node).collect();
        let copy = LANDMARKS.iter().map(|name| folder.join(name)).find(|path| is_there(path));
        copy.as_deref().map(open_regular).transpose()?;
        if let (Some(ArterySource::Landmarks(path)), Some(copy)) = (&mut options.infer.arteries, copy) {
            *path = copy;
        }
        let landmarks = text(&record["parameters"]["landmarks"]["sha256"]);
        let (graph, input_sha256) = (folder.join(GRAPH), text(&record["input"]["sha256"]).unwrap_or_default());
        Ok(Self { graph, options, samples, given, landmarks, named, input_sha256, sha256 })
    }

    /// Per vessel of the graph whether the run kept it.
    ///
    /// # Errors
    ///
    /// A table of vessels that cannot be read, or that is not of that graph.
    pub(crate) fn kept(&self, vessels: usize) -> Result<Vec<bool>> {
        let file = self.graph.with_file_name(EDGES);
        let here = |fault: Fault| fault.in_file(&file);
        let bytes = bytes_of(&file)?;
        let mut rows = TableReader::ragged(&bytes).map_err(here)?;
        let column =
            rows.find(&["kept"]).ok_or_else(|| here(Fault::file("no column kept", "expected it as the run wrote it")))?;
        let mut kept = Vec::with_capacity(vessels);
        while let Some(row) = rows.row().map_err(here)? {
            kept.push(row.text(column) == "1");
        }
        if kept.len() != vessels {
            return Err(here(Fault::file(format!("{} rows", kept.len()), format!("expected one for each of {vessels} vessels"))));
        }
        Ok(kept)
    }

    /// Refuses a graph that is not the one that was sampled.
    pub(crate) fn check_graph(&self, sha256: &str) -> Result<()> {
        if sha256 == self.sha256 {
            return Ok(());
        }
        let found = "not the graph that was sampled: its SHA-256 is not that of run.json";
        Err(Fault::file(found, "expected it unedited").in_file(&self.graph))
    }
}
