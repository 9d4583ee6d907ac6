//! run.json: how the run was made and what came out, enough to repeat it.

use std::ops::Deref;
use std::path::Path;
use std::sync::Arc;

use serde::ser::SerializeMap as _;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value, json};

use super::inference::Outcome;
use willis_core::decision::{Topology, UNDECIDED_BAND, UNDECIDED_Z};
use willis_core::flow::boundary_conditions::Total;
use willis_core::flow::boundary_conditions::unfed_fragments;
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::units::{centipoise, millimetres, ml_per_min, mmhg, mmhg_s_per_ml};
use willis_core::network::{Condition, Frame, Network, Origin, Role, fragments};
use willis_models::candidates;

/// Where a run comes from.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// The command line that repeats the run, without what changes no result.
    pub command: String,
    /// The input's path as given.
    pub input: String,
    /// Its format.
    pub format: String,
    /// The SHA-256 of its bytes.
    pub sha256: String,
    /// The unit its lengths were taken to be in.
    pub units: String,
    /// Which way the axes of its coordinates point.
    pub frame: Frame,
    /// What a person should know about how it was read.
    pub notes: Vec<String>,
}

/// Everything that run.json holds.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    willis: &'static str,
    command: String,
    input: Value,
    seed: u64,
    /// The options as they were given; every later command reads these back.
    options: Value,
    parameters: Value,
    boundary_conditions: ConditionRecords,
    counts: Value,
    threshold: Value,
    convergence: Value,
    expected_errors: Value,
    #[serde(rename = "rho_G_W_per_m3")]
    network_resilience: f64,
    solver: Value,
    graph: Value,
    phenotype: Value,
    /// Who feeds each territory of a Circle of Willis.
    #[serde(skip_serializing_if = "Value::is_null")]
    pub supply: Value,
    /// Where the arteries of a circle are by geometry, for a later command to go on from.
    #[serde(skip_serializing_if = "Value::is_null")]
    pub named: Value,
    notes: Vec<String>,
    /// What differs between two runs of one command.
    pub time: Value,
}

/// How the graph that was sampled came about.
#[derive(Debug, Clone, Copy)]
pub enum Built<'a> {
    /// It was handed in ready.
    Given,
    /// Candidates were added.
    Candidates(&'a candidates::CandidateOptions),
}

impl Provenance {
    /// The input by path, format, checksum and unit, and the frame of its coordinates where it is known, as every record has it.
    pub fn of_input(&self) -> Value {
        let mut input = json!({ "path": self.input, "format": self.format, "sha256": self.sha256, "units": self.units });
        if let Some(name) = self.frame.name() {
            input["frame"] = json!(name);
        }
        input
    }
}

/// What outlets that were found are.
pub fn outlets_found(outlets: FoundOutlets) -> Value {
    match outlets {
        FoundOutlets::Ground => json!("ground"),
        FoundOutlets::Murray(Total::Flow(flow)) => json!({ "murray_mL_per_min": ml_per_min(flow) }),
        FoundOutlets::Murray(Total::Resistance(resistance)) => json!({ "murray_mmHg_s_per_mL": mmhg_s_per_ml(resistance) }),
    }
}

/// How candidates were built, as run.json has it; null where they were given.
pub fn candidate_parameters(built: Built<'_>) -> Value {
    let Built::Candidates(p) = built else { return Value::Null };
    json!({
        "k": p.k,
        "max_gap_mm": p.max_gap.map(millimetres),
        "attach": p.attach,
        "candidate_radius": p.radius,
        "max_candidate_radius_mm": p.max_radius.map(millimetres),
        "radius": p.radius_rule.name(),
    })
}

/// How large a network is, and how many inlets and outlets it has.
pub(crate) fn counts(network: &Network, boundary: &Boundary) -> Value {
    let [inlets, outlets] = [Role::Inlet, Role::Outlet].map(|role| boundary.count(role));
    json!({ "nodes": network.node_count(), "vessels": network.vessel_count(), "inlets": inlets, "outlets": outlets })
}

/// A boundary condition of a run.
#[derive(Debug)]
pub struct ConditionRecord {
    /// The row of its node.
    pub node: usize,
    /// The id of its node.
    pub id: Box<str>,
    /// Inlet or outlet.
    pub role: Role,
    /// What holds there.
    pub condition: Condition,
    /// Whether it was found, not stated.
    pub found: bool,
    /// Whether it holds in the kept topology, of a run that keeps one.
    pub holds: Option<bool>,
    /// Whether the input states by its direction that blood enters here.
    pub source: bool,
}

impl ConditionRecord {
    /// What it states of pressure (mmHg), resistance (mmHg s/mL), venous pressure (mmHg) and flow (mL/min).
    pub fn figures(&self) -> [Option<f64>; 4] {
        match self.condition {
            Condition::Pressure(p) => [Some(mmhg(p)), None, None, None],
            Condition::Resistance { resistance, venous } => [None, Some(mmhg_s_per_ml(resistance)), Some(mmhg(venous)), None],
            Condition::Flow(flow) => [None, None, None, Some(ml_per_min(flow))],
        }
    }
}

impl Serialize for ConditionRecord {
    /// With its keys in alphabetical order, as in all records.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [pressure, resistance, venous, flow] = self.figures();
        let mut map = serializer.serialize_map(None)?;
        let figure = |map: &mut S::SerializeMap, name: &str, figure: Option<f64>| {
            figure.map_or(Ok(()), |figure| map.serialize_entry(name, &figure))
        };
        figure(&mut map, "flow_mL_per_min", flow)?;
        map.serialize_entry("found", &self.found)?;
        if let Some(holds) = self.holds {
            map.serialize_entry("holds", &holds)?;
        }
        map.serialize_entry("id", &self.id)?;
        map.serialize_entry("node", &self.node)?;
        figure(&mut map, "pressure_mmHg", pressure)?;
        figure(&mut map, "resistance_mmHg_s_per_mL", resistance)?;
        map.serialize_entry("role", self.role.name())?;
        if self.source {
            map.serialize_entry("source", &true)?;
        }
        figure(&mut map, "venous_pressure_mmHg", venous)?;
        map.end()
    }
}

/// The boundary conditions of a run by node; copies share the list, which is as long as a million vessels have ends.
#[derive(Debug, Clone, Default)]
pub struct ConditionRecords(Arc<Vec<ConditionRecord>>);

impl Deref for ConditionRecords {
    type Target = [ConditionRecord];

    fn deref(&self) -> &[ConditionRecord] {
        &self.0
    }
}

impl Serialize for ConditionRecords {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

/// The record of a run of any command.
pub trait Recorded: Clone + Serialize {
    /// Its boundary conditions.
    fn conditions(&mut self) -> &mut ConditionRecords;
}

impl Recorded for Summary {
    fn conditions(&mut self) -> &mut ConditionRecords {
        &mut self.boundary_conditions
    }
}

/// The boundary conditions that were used, by node; and which of them hold in the kept topology, where there is one.
pub(crate) fn conditions(network: &Network, boundary: &Boundary, held: Option<&Boundary>) -> ConditionRecords {
    let each = boundary.conditions.iter().map(|(node, condition)| ConditionRecord {
        node: *node,
        id: (&*network.node(*node).id).into(),
        role: boundary.roles[*node],
        condition: *condition,
        found: boundary.is_found(*node),
        holds: held.map(|held| held.condition(*node).is_some()),
        source: boundary.found_inlets.binary_search(node).is_ok() && network.node(*node).is_source,
    });
    ConditionRecords(Arc::new(each.collect()))
}

fn topology(t: &Topology) -> Value {
    json!({
        "kept": t.kept, "pruned": t.pruned, "kept_candidates": t.kept_candidates, "pruned_observed": t.observed[1],
        "components": t.components, "cycles": t.cycles, "unperfused_components": t.unperfused,
    })
}

impl Summary {
    /// The name of the file that the run is of.
    pub fn name(&self) -> &str {
        let path = self.input["path"].as_str().unwrap_or_default();
        Path::new(path).file_name().and_then(|name| name.to_str()).unwrap_or(path)
    }

    /// States which file holds the graph that was sampled, and its SHA-256.
    pub fn state_graph(&mut self, name: &str, sha256: &str) {
        self.graph = json!({ "path": name, "sha256": sha256 });
    }

    /// States the phenotype of a Circle of Willis, what its arteries were known by, and where landmarks come from.
    pub fn state_phenotype(&mut self, phenotype: Value, known_by: &str, landmarks: Value) {
        self.phenotype = phenotype;
        self.parameters["arteries"] = json!(known_by);
        self.parameters["landmarks"] = landmarks;
    }

    /// States where the priors come from.
    pub fn state_prior(&mut self, prior: Value) {
        self.parameters["prior"] = prior;
    }

    /// States by which model and with which mask observed vessels were cut apart; null where they were not.
    pub fn state_cut(&mut self, cut: Value) {
        if !cut.is_null() {
            self.parameters["cut"] = cut;
        }
    }

    /// States in which image candidates were looked at; null without one.
    pub fn state_image(&mut self, image: Value) {
        if !image.is_null() {
            self.parameters["image"] = image;
        }
    }

    /// States what a person decided; null where nobody did.
    pub fn state_decisions(&mut self, decisions: Value) {
        if !decisions.is_null() {
            self.parameters["decisions"] = decisions;
        }
    }

    /// Gathers the record of a run.
    pub fn new(
        outcome: &Outcome<'_>,
        provenance: &Provenance,
        options: &impl Serialize,
        built: Built<'_>,
        outlets: FoundOutlets,
    ) -> Self {
        let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
        let count = |origin: Origin| network.vessels().filter(|(_, v)| v.origin == origin).count();
        let by_evidence = outcome.rule.asks_evidence();
        let both = answer.kept.iter().zip(&answer.above_median).zip(&result.uncertain).filter(|(_, u)| **u);
        Self {
            willis: env!("CARGO_PKG_VERSION"),
            command: provenance.command.clone(),
            input: provenance.of_input(),
            seed: outcome.sampling.seed,
            options: json!(options),
            parameters: json!({
                "epsilon": outcome.sampling.epsilon,
                "samples": result.samples,
                "exact": outcome.sampling.exact,
                "uncertain": outcome.sampling.uncertain.name(),
                "weight": outcome.sampling.weight.name(),
                "keep": outcome.rule,
                "viscosity_cP": centipoise(outcome.sampling.viscosity),
                "outlets_found": outlets_found(outlets),
                "candidates": candidate_parameters(built),
            }),
            boundary_conditions: conditions(network, outcome.boundary, Some(&outcome.held())),
            counts: json!({
                "nodes": network.node_count(),
                "observed": count(Origin::Observed),
                "candidates": count(Origin::Candidate),
                "contacts": outcome.contacts(),
                "cut": outcome.cuts().count(),
                "suggested_cuts": outcome.suggested_cuts.len(),
                "left_open": answer.left_open.len(),
                "fragments": fragments(network, |_, v| v.origin == Origin::Observed).count,
                "uncertain": result.uncertain.iter().filter(|u| **u).count(),
                "inlets": outcome.boundary.count(Role::Inlet),
                "outlets": outcome.boundary.count(Role::Outlet),
                "unfed_fragments": unfed_fragments(network, outcome.boundary),
                "topology": topology(&outcome.kept),
                "topology_median": topology(&outcome.above_median),
                "decisions_shared_with_median": both.filter(|((kept, above), _)| kept == above).count(),
            }),
            threshold: json!({ "rule": outcome.rule, "value": answer.threshold, "median": answer.median }),
            convergence: json!({
                "perfused_share": result.perfused,
                "undecided": answer.undecided.len(),
                "stable": outcome.stable,
                "undecided_edges": answer.undecided,
                "within_standard_errors": (!by_evidence).then_some(UNDECIDED_Z),
                "within_probability": by_evidence.then_some(UNDECIDED_BAND),
            }),
            expected_errors: outcome.expected.map_or(Value::Null, |e| json!({ "wrong": e.wrong, "missed": e.missed })),
            network_resilience: result.network_resilience,
            solver: json!({
                "flow": outcome.method.solver,
                "size": outcome.method.solver_size,
                "forest": outcome.method.forest,
                "forest_joins": outcome.method.forest_joins,
                "residual": result.residual,
            }),
            graph: Value::Null,
            phenotype: Value::Null,
            supply: Value::Null,
            named: Value::Null,
            notes: provenance.notes.clone(),
            time: Value::Null,
        }
    }
}
