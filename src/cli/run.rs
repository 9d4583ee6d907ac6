//! A folder of `willis infer` taken up again: its graph, and the plausible topologies of its seed and parameters.

use std::path::{Path, PathBuf};

use serde_json::Value;
use willis::error::{Fault, Result};
use willis::formats::{bytes_of, checksum};
use willis::hemodynamics::boundary::{CEREBRAL_FLOW_ML_PER_MIN, Total, stated};
use willis::hemodynamics::poiseuille::BLOOD_VISCOSITY;
use willis::hemodynamics::{Boundary, FoundOutlets};
use willis::inference::{Draw, Keep, Known, Params, Topologies, Uncertain, Weight, decide, has_evidence, infer};
use willis::network::{Condition, INLET_PRESSURE_MMHG, Network, Role};
use willis::phenotype::{Circle, Collateral, Posterior, collaterals};
use willis::report::GRAPH_FILE;
use willis::units::{cubic_metres_per_second, pascals};

use super::terminal::is_stopped;

const RECORD: &str = "run.json";

/// A run of infer that stands in a folder.
pub struct Run {
    /// Its over-connected graph.
    pub graph: PathBuf,
    params: Params,
    /// The landmarks that it was made with.
    pub landmarks: Option<PathBuf>,
    /// Nodes whose conditions were stated, not found.
    given: Vec<usize>,
}

impl Run {
    /// The files that it is made of.
    pub fn files(folder: &Path) -> Vec<PathBuf> {
        [RECORD, GRAPH_FILE].map(|name| folder.join(name)).into()
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
    /// A folder that is none of infer, or whose graph is not the one that was sampled.
    pub fn of(input: &Path) -> Result<Option<Self>> {
        if !input.is_dir() {
            return Ok(None);
        }
        let path = input.join(RECORD);
        let wrong = |found: &str| {
            Fault::file(found, "expected a folder that willis infer wrote for one occlusion probability").in_file(input)
        };
        if !path.is_file() {
            return Err(wrong("a folder without run.json"));
        }
        let record: Value = serde_json::from_slice(&bytes_of(&path)?)
            .map_err(|e| Fault::file(e.to_string(), "expected the record of willis infer").in_file(&path))?;
        let graph = input.join(GRAPH_FILE);
        let Some(sum) = record["graph"]["sha256"].as_str() else { return Err(wrong("a run without a graph of candidates")) };
        if checksum(&bytes_of(&graph)?) != sum {
            return Err(Fault::file(
                "not the graph that was sampled: its SHA-256 is not that of run.json",
                "expected it unedited",
            )
            .in_file(&graph));
        }
        let params = parameters(&record).ok_or_else(|| wrong("parameters that are not those of willis infer"))?;
        let conditions = record["boundary_conditions"].as_array().into_iter().flatten();
        let given = conditions.filter(|c| c["found"] == Value::Bool(false)).filter_map(|c| c["node"].as_u64());
        let landmarks = record["parameters"]["landmarks"]["path"].as_str().map(PathBuf::from);
        Ok(Some(Self { graph, params, landmarks, given: given.map(|node| node as usize).collect() }))
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

/// What plausible topologies say of a circle: those of the evidence, or without any those that the samples vote for, by the vessels
/// `above` the median.
pub fn posterior(
    network: &Network,
    boundary: &Boundary,
    params: &Params,
    circle: &Circle,
    given: &[usize],
    above: Option<&[bool]>,
) -> Result<(Posterior, String)> {
    let mut known = vec![false; network.node_count()];
    let ends = circle.ends(network);
    (0..known.len()).for_each(|node| known[node] = given.contains(&node) || ends.binary_search(&node).is_ok());
    let mut inlets = circle.inlets();
    if !inlets.is_empty() {
        inlets.extend(given.iter().filter(|node| boundary.roles[**node] == Role::Inlet));
    }
    let (draw, how) = match above {
        None => (Draw::Ends(Known { ends: &known, inlets: &inlets }), "whose free ends continue by the evidence"),
        Some(above) => (Draw::Flow(above), "that samples vote for by their resilience"),
    };
    let topologies = Topologies::draw(network, boundary, params, draw)?;
    let how = format!("{} plausible topologies, {how}", topologies.samples);
    Ok((Posterior::of(circle, network, &topologies), how))
}

/// With what blood flows: what the network states, else what is found.
pub struct Flow {
    viscosity: f64,
    outlets: FoundOutlets,
}

impl Flow {
    /// Blood as infer takes it; outlets found are those of centerlines, or of a ready graph.
    pub fn of_blood(centerlines: bool) -> Self {
        let murray = FoundOutlets::Murray(Total::Flow(cubic_metres_per_second(CEREBRAL_FLOW_ML_PER_MIN)));
        Self { viscosity: BLOOD_VISCOSITY, outlets: if centerlines { murray } else { FoundOutlets::Ground } }
    }

    /// What the loss of each feeder means to the topology of the vessels `kept`.
    pub fn collaterals(&self, network: &Network, circle: &Circle, kept: &[bool]) -> Result<Vec<Collateral>> {
        let mut network = network.clone();
        state_inlets(&mut network, circle);
        let boundary = Boundary::resolve(&network, &stated(&network), self.outlets)?;
        collaterals(circle, &network, |row| kept[row], &boundary, self.viscosity)
    }
}

/// Makes inlets of the landmarks where blood comes in, unless the input states what they are.
pub fn state_inlets(network: &mut Network, circle: &Circle) {
    for node in circle.inlets() {
        let node = network.node_mut(node);
        if node.condition.is_none() {
            (node.role, node.condition) = (Some(Role::Inlet), Some(Condition::Pressure(pascals(INLET_PRESSURE_MMHG))));
        }
    }
}

/// The parameters of a record.
fn parameters(record: &Value) -> Option<Params> {
    let p = &record["parameters"];
    Some(Params {
        epsilon: p["epsilon"].as_f64()?,
        samples: p["samples"].as_u64()?,
        seed: record["seed"].as_u64()?,
        uncertain: match p["uncertain"].as_str()? {
            "candidates" => Uncertain::Candidates,
            "all" => Uncertain::All,
            _ => return None,
        },
        weight: match p["weight"].as_str()? {
            "resilience" => Weight::Resilience,
            "count" => Weight::Count,
            "global" => Weight::Global,
            _ => return None,
        },
        uniform_prior: p["prior"] == Value::String("uniform".into()),
        viscosity: p["viscosity_cP"].as_f64()? / 1e3,
        exact: p["exact"].as_bool()?,
        ..Params::default()
    })
}
