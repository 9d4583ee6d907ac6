//! run.json: how the run was made and what came out, enough to repeat it.

use serde::ser::SerializeMap as _;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value, json};

use willis_core::flow::boundary_conditions::Total;
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::units::{ml_per_min, mmhg, mmhg_s_per_ml};
use willis_core::network::{Condition, Frame, Network, Role};

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

/// Everything that run.json holds of a run that solves flow (infer, simulate, modulate): its fields in their order, and its boundary conditions, which are as many as a million
/// vessels have ends.
#[derive(Debug)]
pub struct RunRecord {
    fields: Vec<(&'static str, Value)>,
    pub(crate) conditions: Vec<ConditionRecord>,
}

/// The place of the boundary conditions among the fields.
pub(crate) const CONDITIONS: (&str, Value) = ("boundary_conditions", Value::Null);

impl RunRecord {
    /// The record of a run: its fields behind those of its source, with [`CONDITIONS`] among them.
    pub(crate) fn new(provenance: &Provenance, conditions: Vec<ConditionRecord>, fields: Vec<(&'static str, Value)>) -> Self {
        let version = json!(env!("CARGO_PKG_VERSION"));
        let source = [("willis", version), ("command", json!(provenance.command)), ("input", provenance.of_input())];
        Self { fields: source.into_iter().chain(fields).collect(), conditions }
    }

    /// A field; a new one comes before the notes.
    pub fn field(&mut self, name: &'static str) -> &mut Value {
        let place = |name: &str| self.fields.iter().position(|(field, _)| *field == name);
        let (known, new) = (place(name), place("notes").unwrap_or(self.fields.len()));
        if known.is_none() {
            self.fields.insert(new, (name, Value::Null));
        }
        &mut self.fields[known.unwrap_or(new)].1
    }

    /// The fields for the page, without what differs between two runs of one command and without lists that the tables show.
    pub(crate) fn for_page(&self) -> Value {
        let fields = self.fields.iter().filter(|(name, _)| *name != "time");
        let mut record: Value = fields.map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        if let Some(convergence) = record.get_mut("convergence").and_then(Value::as_object_mut) {
            convergence.remove("undecided_edges");
        }
        record
    }

    /// The name of the file that the run is of.
    pub(crate) fn name(&self) -> String {
        let input = self.fields.iter().find(|(name, _)| *name == "input");
        let path = input.and_then(|(_, input)| input["path"].as_str()).unwrap_or_default();
        std::path::Path::new(path).file_name().and_then(|name| name.to_str()).unwrap_or(path).to_owned()
    }
}

impl Serialize for RunRecord {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, value) in &self.fields {
            if *name == CONDITIONS.0 {
                map.serialize_entry(name, &self.conditions)?;
            } else {
                map.serialize_entry(name, value)?;
            }
        }
        map.end()
    }
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

/// How large a network is, and how many inlets and outlets it has.
pub(crate) fn counts(network: &Network, boundary: &Boundary) -> Value {
    let [inlets, outlets] = [Role::Inlet, Role::Outlet].map(|role| boundary.count(role));
    json!({ "nodes": network.node_count(), "vessels": network.vessel_count(), "inlets": inlets, "outlets": outlets })
}

/// A boundary condition of a run, with its fields in alphabetical order, as in all records.
#[derive(Debug, Serialize)]
pub(crate) struct ConditionRecord {
    /// The flow that it states, mL/min.
    #[serde(rename = "flow_mL_per_min", skip_serializing_if = "Option::is_none")]
    pub flow: Option<f64>,
    /// Whether it was found, not stated.
    pub found: bool,
    /// Whether it holds in the kept topology, of a run that keeps one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The id of its node.
    pub id: Box<str>,
    /// The row of its node.
    pub node: usize,
    /// The pressure that it states, mmHg.
    #[serde(rename = "pressure_mmHg", skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// The resistance that it states, mmHg s/mL.
    #[serde(rename = "resistance_mmHg_s_per_mL", skip_serializing_if = "Option::is_none")]
    pub resistance: Option<f64>,
    /// Inlet or outlet.
    pub role: &'static str,
    /// Whether the input states by its direction that blood enters here.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub source: bool,
    /// The pressure behind that resistance, mmHg.
    #[serde(rename = "venous_pressure_mmHg", skip_serializing_if = "Option::is_none")]
    pub venous: Option<f64>,
}

/// The boundary conditions that were used, by node; and which of them hold in the kept topology, where there is one.
pub(crate) fn conditions(network: &Network, boundary: &Boundary, held: Option<&Boundary>) -> Vec<ConditionRecord> {
    let each = boundary.conditions.iter().map(|(node, condition)| {
        let (pressure, resistance, venous, flow) = match *condition {
            Condition::Pressure(p) => (Some(mmhg(p)), None, None, None),
            Condition::Resistance { resistance, venous } => (None, Some(mmhg_s_per_ml(resistance)), Some(mmhg(venous)), None),
            Condition::Flow(flow) => (None, None, None, Some(ml_per_min(flow))),
        };
        ConditionRecord {
            flow,
            found: boundary.is_found(*node),
            holds: held.map(|held| held.condition(*node).is_some()),
            id: (&*network.node(*node).id).into(),
            node: *node,
            pressure,
            resistance,
            role: boundary.roles[*node].name(),
            source: boundary.found_inlets.binary_search(node).is_ok() && network.node(*node).is_source,
            venous,
        }
    });
    each.collect()
}
