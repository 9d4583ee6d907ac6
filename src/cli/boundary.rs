//! Boundary conditions from the command line, a file and the graph, in that order of precedence.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use willis::error::{Error, Place, Result};
use willis::internals::flow::boundary::{Total, stated};
use willis::internals::flow::{Boundary, FoundOutlets, Given};
use willis::internals::io::bytes_of;
use willis::internals::io::tables::conditions::{read_csv, read_toml};
use willis::internals::network::quantity::Dimension;
use willis::internals::network::units::{ml_per_min, mmhg, mmhg_s_per_ml};
use willis::internals::network::{Condition, FoundBy, Network, Role, locate};
use willis::internals::support::suggestions::did_you_mean;

use super::beside::beside;
use super::terminal::{Terminal, brief, plural};

const OUTLETS: &str = "expected ground, murray, murray=FLOW such as murray=700mL/min, or murray=RESISTANCE such as \
                       murray=8mmHg.s/mL, of all outlets together and positive";

#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Boundary conditions (NODE is an id, a label, or x,y,z in mm)")]
pub struct BoundaryArgs {
    /// Where blood enters, at a pressure [default: 100 mmHg]; found at the widest free ends when none is given
    #[arg(long, value_name = "NODE[=PRESSURE]", allow_hyphen_values = true)]
    inlet: Vec<String>,
    /// Where blood leaves: to ground (the default), to a pressure (5mmHg), or through a resistance (20mmHg.s/mL) to a venous
    /// pressure (20mmHg.s/mL@5mmHg); found at the other free ends when none is given
    #[arg(long, value_name = "NODE[=ground|PRESSURE|RESISTANCE[@PRESSURE]]", allow_hyphen_values = true)]
    outlet: Vec<String>,
    /// A fixed flow into the network (negative: out of it), in mL/min
    #[arg(long, value_name = "NODE=FLOW", allow_hyphen_values = true)]
    flow: Vec<String>,
    /// A CSV or TOML file of conditions; in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    bc: Option<PathBuf>,
    /// What outlets found by willis are: ground, or terminal resistances by Murray's law that come to a total flow (in
    /// mL/min) or a total resistance [default: murray=700 for infer and candidates on centerlines, else ground]
    #[arg(long, value_name = "ground|murray[=FLOW|RESISTANCE]")]
    outlets: Option<String>,
}

impl BoundaryArgs {
    /// What outlets that are found will be: by Murray's law (`murray`) or ground, when the option is not given.
    pub fn found_outlets(&self, murray: bool) -> Result<FoundOutlets> {
        let Some(text) = &self.outlets else { return Ok(if murray { FoundOutlets::CEREBRAL } else { FoundOutlets::Ground }) };
        let refused = || {
            let (word, words) = (text.split('=').next().unwrap_or_default(), ["ground", "murray"]);
            let meant = if words.contains(&word) { String::new() } else { did_you_mean(word, words) };
            Error::parameter("--outlets", format!("\"{text}\""), meant + OUTLETS)
        };
        match text.split_once('=') {
            None if text == "ground" => Ok(FoundOutlets::Ground),
            None if text == "murray" => Ok(FoundOutlets::CEREBRAL),
            Some(("murray", figure)) => {
                let is_resistance = Dimension::Resistance.has_unit_in(figure);
                let dimension = if is_resistance { Dimension::Resistance } else { Dimension::Flow };
                let total = dimension.parse(figure).ok().filter(|total| *total > 0.0).ok_or_else(refused)?;
                Ok(FoundOutlets::Murray(if is_resistance { Total::Resistance(total) } else { Total::Flow(total) }))
            }
            _ => Err(refused()),
        }
    }

    /// The conditions of the network of an input, given and found.
    pub fn resolve(&self, input: &Path, network: &Network, outlets: FoundOutlets, terminal: Terminal) -> Result<Boundary> {
        let mut given: BTreeMap<usize, Given> = stated(network).into_iter().map(|g| (g.node, g)).collect();
        for source in [self.file_conditions(input, network, terminal)?, self.typed_conditions(network, terminal)?] {
            given.extend(source);
        }
        let given: Vec<Given> = given.into_values().collect();
        let boundary = Boundary::resolve(network, &given, outlets)?;
        if self.outlets.is_some() && boundary.found_outlets.is_empty() {
            terminal.say("note", "--outlets changes nothing: every outlet is stated; --outlet NODE=ground or --bc replaces it");
        }
        Ok(boundary)
    }

    /// Whether a person said where blood comes in, or left it to a file to say.
    pub fn states_an_inlet(&self) -> bool {
        self.bc.is_some() || !self.inlet.is_empty() || !self.flow.is_empty()
    }

    /// The file of conditions that goes with an input.
    pub fn file(&self, input: &Path) -> Option<PathBuf> {
        self.bc.as_ref().map(|name| beside(name, input))
    }

    fn file_conditions(&self, input: &Path, network: &Network, terminal: Terminal) -> Result<BTreeMap<usize, Given>> {
        let Some(path) = &self.file(input) else { return Ok(BTreeMap::new()) };
        let bytes = bytes_of(path)?;
        let is_toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        let statements = if is_toml { read_toml(&bytes) } else { read_csv(&bytes) }.map_err(|f| f.in_file(path))?;
        let (mut given, mut stated_at) = (BTreeMap::new(), BTreeMap::new());
        for s in statements {
            let fault = |why: String| s.fault(why).in_file(path);
            let found = locate(network, &s.spec).map_err(fault)?;
            terminal.detail("condition", format!("{} is node {}{}", s.spec, network.node(found.node).id, found.note()));
            if given.insert(found.node, Given { node: found.node, role: s.role, condition: s.condition }).is_some() {
                let first: &Place = &stated_at[&found.node];
                let id = &network.node(found.node).id;
                return Err(fault(format!("is node {id}, as {} is; expected one condition a node", first.words())));
            }
            stated_at.insert(found.node, s.place);
        }
        Ok(given)
    }

    fn typed_conditions(&self, network: &Network, terminal: Terminal) -> Result<BTreeMap<usize, Given>> {
        let inlets = self.inlet.iter().map(|text| ("--inlet", text));
        let outlets = self.outlet.iter().map(|text| ("--outlet", text));
        let flows = self.flow.iter().map(|text| ("--flow", text));
        let mut given = BTreeMap::new();
        for (option, text) in inlets.chain(outlets).chain(flows) {
            let refused = |why: String| Error::parameter(option, format!("\"{text}\""), why);
            let whole = option != "--flow" && network.nodes().any(|n| n.id == *text || (!n.label.is_empty() && n.label == *text));
            let (spec, role, condition) = parse(option, text, whole).map_err(refused)?;
            let found = locate(network, spec).map_err(|why| refused(several(network, option, spec).unwrap_or(why)))?;
            if found.by != FoundBy::Name {
                terminal.say("condition", format!("{spec} is node {}{}", network.node(found.node).id, found.note()));
            }
            if given.insert(found.node, Given { node: found.node, role, condition }).is_some() {
                let id = &network.node(found.node).id;
                return Err(refused(format!("is node {id}, which has a condition already; expected one condition a node")));
            }
        }
        Ok(given)
    }
}

/// That several nodes are several options, where each word between commas names one.
fn several(network: &Network, option: &str, spec: &str) -> Option<String> {
    let names: Vec<&str> = spec.split(',').map(str::trim).collect();
    let is_node = |name: &&str| locate(network, name).is_ok();
    // Points inside vessels are none, but were meant as such beside one that is.
    let are_numbers = names.iter().all(|name| name.parse::<u64>().is_ok()) && names.iter().any(is_node);
    let are_nodes = names.len() > 1 && (are_numbers || names.iter().all(is_node));
    let each: Vec<String> = names.iter().map(|name| format!("{option} {name}")).collect();
    are_nodes.then(|| format!("looks like {} nodes; give one at a time: {}", names.len(), each.join(" ")))
}

/// `NODE[=VALUE]`: the value is what follows the last `=`, unless the `whole` text is what a node is called.
fn parse<'a>(option: &str, text: &'a str, whole: bool) -> Result<(&'a str, Role, Condition), String> {
    let split = text.rsplit_once('=').filter(|_| !whole);
    match option {
        "--inlet" => match split.map(|(spec, value)| (spec, Dimension::Pressure.parse(value))) {
            None => Ok((text, Role::Inlet, Condition::INLET)),
            Some((spec, pressure)) => Ok((spec, Role::Inlet, Condition::Pressure(pressure?))),
        },
        "--outlet" => match split {
            None => Ok((text, Role::Outlet, Condition::GROUND)),
            Some((spec, "ground")) => Ok((spec, Role::Outlet, Condition::GROUND)),
            Some((spec, value)) if Dimension::Resistance.has_unit_in(value.split('@').next().unwrap_or_default()) => {
                let (resistance, venous) = value.split_once('@').map_or((value, None), |(r, p)| (r, Some(p)));
                let resistance = Dimension::Resistance.parse(resistance)?;
                if resistance <= 0.0 {
                    return Err("expected a positive resistance".into());
                }
                let venous = venous.map_or(Ok(0.0), |p| Dimension::Pressure.parse(p))?;
                Ok((spec, Role::Outlet, Condition::Resistance { resistance, venous }))
            }
            Some((spec, value)) => {
                let meant = match Dimension::Pressure.near(value) {
                    near if near.is_empty() => did_you_mean(value, ["ground"]) + &Dimension::Resistance.near(value),
                    near => near,
                };
                let accepted = format!("{meant}expected ground, a pressure (5mmHg) or a resistance (20mmHg.s/mL)");
                Ok((spec, Role::Outlet, Condition::Pressure(Dimension::Pressure.parse(value).map_err(|_| accepted)?)))
            }
        },
        _ => {
            let (spec, value) = split.ok_or("expected NODE=FLOW")?;
            let flow = Dimension::Flow.parse(value)?;
            Ok((spec, Role::of_flow(flow), Condition::Flow(flow)))
        }
    }
}

/// Says which conditions are used, and which of them were found.
pub fn say_boundary(terminal: Terminal, network: &Network, boundary: &Boundary) {
    for (role, heading, found) in
        [(Role::Inlet, "inlets", &boundary.found_inlets), (Role::Outlet, "outlets", &boundary.found_outlets)]
    {
        let rows: Vec<usize> = (0..network.node_count()).filter(|n| boundary.roles[*n] == role).collect();
        let words: Vec<String> = rows
            .iter()
            .filter_map(|n| Some((*n, words(boundary.condition(*n)?))))
            .map(|(n, w)| format!("{} ({w})", network.node(n).id))
            .collect();
        let how = match found.len() {
            0 => String::new(),
            n if n == rows.len() => match role {
                Role::Inlet => ", found: the widest free ends".to_owned(),
                _ => ", found: the other free ends".to_owned(),
            },
            n => format!(", {n} of them found at free ends"),
        };
        let most = 6;
        let shown = if words.len() > most {
            format!("{}, and {} more", words[..most].join(", "), words.len() - most)
        } else {
            words.join(", ")
        };
        terminal.say(heading, format!("{}{how}: {shown}", plural(rows.len(), "node")));
        for word in words.iter().skip(most) {
            terminal.detail(heading, word);
        }
    }
}

fn words(condition: Condition) -> String {
    match condition {
        Condition::Pressure(0.0) => "ground".into(),
        Condition::Pressure(p) => format!("{} mmHg", brief(mmhg(p))),
        Condition::Resistance { resistance, venous } => {
            let venous = if venous == 0.0 { String::new() } else { format!(" to {} mmHg", brief(mmhg(venous))) };
            format!("{} mmHg·s/mL{venous}", brief(mmhg_s_per_ml(resistance)))
        }
        Condition::Flow(flow) => format!("{} mL/min", brief(ml_per_min(flow))),
    }
}
