//! A folder of `willis infer` taken up again: its graph, its seed and its parameters.

use std::path::{Path, PathBuf};

use serde_json::Value;
use willis::error::{Fault, Result};
use willis::internals::circle_of_willis::{Circle, Posterior};
use willis::internals::decision::{Keep, decide, has_evidence};
use willis::internals::flow::boundary::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::network::Network;
use willis::internals::network::units::pascal_seconds;
use willis::internals::output::names::{GRAPH, RECORD};
use willis::internals::output::read_json;
use willis::internals::sampling::{SamplingOptions, Uncertain, Weight, infer};

use super::circle::{CircleArgs, Found};
use super::plausible::{Flow, posterior};
use super::terminal::is_stopped;

/// A run of infer that stands in a folder.
pub struct Run {
    /// Its over-connected graph.
    pub graph: PathBuf,
    /// The SHA-256 of that graph as it was sampled.
    sha256: String,
    /// How it knew where the arteries are.
    pub circle: CircleArgs,
    /// The SHA-256 of its landmarks.
    landmarks: Option<String>,
    params: SamplingOptions,
    /// Nodes whose conditions were stated, not found.
    given: Vec<usize>,
}

impl Run {
    /// Whether a path is the folder of a run.
    pub fn stands_in(path: &Path) -> bool {
        path.join(RECORD).is_file()
    }

    /// The file that says how a run in a folder was made.
    pub fn record(folder: &Path) -> PathBuf {
        folder.join(RECORD)
    }

    /// The file that is read for an input: of a folder the graph.
    pub fn source(input: &Path) -> PathBuf {
        if input.is_dir() { input.join(GRAPH) } else { input.to_owned() }
    }

    /// What to call the subject of an input, file or folder.
    pub fn subject(input: &Path) -> String {
        let name = if input.is_dir() { input.file_name() } else { input.file_stem() };
        name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// The run in a folder; `None` for a file.
    ///
    /// # Errors
    ///
    /// A folder that is none of infer.
    pub fn of(input: &Path) -> Result<Option<Self>> {
        if !input.is_dir() {
            return Ok(None);
        }
        let wrong = |found: &str| {
            Fault::file(found, "expected a folder that willis infer wrote for one occlusion probability").in_file(input)
        };
        if !Self::stands_in(input) {
            return Err(wrong("a folder without run.json"));
        }
        let record: Value = read_json(&Self::record(input), "expected the record of willis infer")?;
        let Some(sha256) = record["graph"]["sha256"].as_str() else { return Err(wrong("a run without a graph of candidates")) };
        let params = parameters(&record).ok_or_else(|| wrong("parameters that are not those of willis infer"))?;
        let conditions = record["boundary_conditions"].as_array().into_iter().flatten();
        let given = conditions.filter(|c| c["found"] == false).filter_map(|c| c["node"].as_u64());
        Ok(Some(Self {
            graph: Self::source(input),
            sha256: sha256.to_owned(),
            circle: CircleArgs::of_record(&record["parameters"]),
            landmarks: record["parameters"]["landmarks"]["sha256"].as_str().map(str::to_owned),
            params,
            given: given.map(|node| node as usize).collect(),
        }))
    }

    /// Refuses a graph that is not the one that was sampled.
    pub fn check_graph(&self, sha256: &str) -> Result<()> {
        if sha256 == self.sha256 {
            return Ok(());
        }
        let found = "not the graph that was sampled: its SHA-256 is not that of run.json";
        Err(Fault::file(found, "expected it unedited").in_file(&self.graph))
    }

    /// Refuses landmarks of the run that have changed since.
    pub fn check_landmarks(&self, found: &Found) -> Result<()> {
        match &found.landmarks {
            Some((path, sha256)) if Some(sha256) != self.landmarks.as_ref() => {
                let why = "not the landmarks that the run was made with: their SHA-256 is not that of run.json";
                Err(Fault::file(why, "expected them unedited, or --landmarks FILE").in_file(Path::new(path)))
            }
            _ => Ok(()),
        }
    }

    /// With what blood flowed.
    pub fn flow(&self) -> Flow {
        Flow { viscosity: self.params.viscosity, outlets: FoundOutlets::Ground }
    }

    /// What the plausible topologies say of a circle, and how they were drawn.
    pub fn posterior(&self, network: &Network, circle: &Circle) -> Result<(Posterior, String)> {
        let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground)?;
        let above = if has_evidence(network) {
            None
        } else {
            let (likelihood, _) = infer(network, &boundary, &self.params, &mut |_, _| !is_stopped())?;
            Some(decide(Keep::Median, network, &likelihood)?.above_median)
        };
        posterior(network, &boundary, &self.params, circle, &self.given, above.as_deref())
    }
}

/// The parameters of a record.
fn parameters(record: &Value) -> Option<SamplingOptions> {
    let p = &record["parameters"];
    Some(SamplingOptions {
        epsilon: p["epsilon"].as_f64()?,
        samples: p["samples"].as_u64()?,
        seed: record["seed"].as_u64()?,
        uncertain: Uncertain::ALL.into_iter().find(|u| p["uncertain"] == u.name())?,
        weight: Weight::ALL.into_iter().find(|w| p["weight"] == w.name())?,
        uniform_prior: p["prior"] == "uniform",
        viscosity: pascal_seconds(p["viscosity_cP"].as_f64()?),
        exact: p["exact"].as_bool()?,
        ..SamplingOptions::default()
    })
}
