//! Boundary conditions as a person states them: nodes by name, in options, in a file and in the graph, in that order of precedence.

use std::{collections::BTreeMap, path::PathBuf};

use serde::{Deserialize, Serialize};

use super::{Follow, Step};
use crate::{Error, FoundOutlets, Network, Result};
use willis_core::flow::boundary_conditions::{Total, stated};
use willis_core::network::{Condition, FoundBy, Node, Role, Windkessel, locate};
use willis_core::{error::Place, error::ensure, flow::Given, network::quantity::Dimension, support::suggestions::did_you_mean};
use willis_io::{formats::bytes_of, formats::tables::conditions::read_csv, formats::tables::conditions::read_toml};

const OUTLETS: &str = "expected ground, murray, murray=FLOW such as murray=700mL/min, or murray=RESISTANCE such as \
                       murray=8mmHg.s/mL, of all outlets together and positive";

#[cfg(feature = "cli")]
const OUTLET: &str = "NODE[=ground|PRESSURE|RESISTANCE[@PRESSURE]]";

/// Where blood enters and leaves. A NODE is the id of a node, its label, or `x,y,z` in mm.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[cfg_attr(feature = "cli", command(next_help_heading = "Boundary conditions (NODE is an id, a label, or x,y,z in mm)"))]
#[serde(default, deny_unknown_fields)]
pub struct BoundaryOptions {
    /// Where blood enters, at a pressure [default: 100 mmHg]; found at free ends when none is given
    #[cfg_attr(feature = "cli", arg(long, value_name = "NODE[=PRESSURE]", allow_hyphen_values = true))]
    pub inlet: Vec<String>,
    /// Where blood leaves: to ground (the default), to a pressure (5mmHg), or through a resistance (20mmHg.s/mL) or, for a pulse, a
    /// Windkessel (rcr:R1,C,R2) to a venous pressure (20mmHg.s/mL@5mmHg); found at the other free ends when none is given
    #[cfg_attr(feature = "cli", arg(long, value_name = OUTLET, allow_hyphen_values = true))]
    pub outlet: Vec<String>,
    /// A fixed flow into the network (negative: out of it), in mL/min
    #[cfg_attr(feature = "cli", arg(long, value_name = "NODE=FLOW", allow_hyphen_values = true, hide_short_help = true))]
    pub flow: Vec<String>,
    /// A CSV or TOML file of conditions; in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[cfg_attr(feature = "cli", arg(long = "bc", value_name = "FILE", value_hint = clap::ValueHint::FilePath))]
    pub conditions: Option<PathBuf>,
    /// What outlets found by willis are: ground, or terminal resistances by Murray's law that come to a total flow (in
    /// mL/min) or a total resistance [default: murray=700 on centerlines and masks, ground on a ready graph]
    #[cfg_attr(feature = "cli", arg(long = "outlets", value_name = "ground|murray[=FLOW|RESISTANCE]"))]
    #[cfg_attr(feature = "cli", arg(value_parser = parse_found_outlets, hide_short_help = true))]
    pub found_outlets: Option<FoundOutlets>,
}

impl BoundaryOptions {
    /// The conditions that are stated, by node.
    pub(crate) fn given(&self, network: &Network, progress: &mut dyn Follow) -> Result<Vec<Given>> {
        let mut given: BTreeMap<usize, Given> = stated(network).into_iter().map(|g| (g.node, g)).collect();
        given.extend(self.conditions_of_file(network, progress)?);
        given.extend(self.conditions_of_options(network, progress)?);
        Ok(given.into_values().collect())
    }

    /// Whether a person said where blood comes in, or left it to a file to say.
    pub(crate) fn states_an_inlet(&self) -> bool {
        self.conditions.is_some() || !self.inlet.is_empty() || !self.flow.is_empty()
    }

    fn conditions_of_file(&self, network: &Network, progress: &mut dyn Follow) -> Result<BTreeMap<usize, Given>> {
        let Some(path) = &self.conditions else { return Ok(BTreeMap::new()) };
        let bytes = bytes_of(path)?;
        let is_toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        let statements = if is_toml { read_toml(&bytes) } else { read_csv(&bytes) }.map_err(|f| f.in_file(path))?;
        let (mut given, mut stated_at) = (BTreeMap::new(), BTreeMap::new());
        for s in statements {
            let fault = |why: String| s.fault(why).in_file(path);
            let found = locate(network, &s.spec).map_err(fault)?;
            progress.step(Step::Located { name: &s.spec, node: &network.node(found.node).id, found, is_in_file: true });
            if given.insert(found.node, Given { node: found.node, role: s.role, condition: s.condition }).is_some() {
                let first: &Place = &stated_at[&found.node];
                let id = &network.node(found.node).id;
                return Err(fault(format!("is node {id}, as {} is; expected one condition a node", first.words())));
            }
            stated_at.insert(found.node, s.place);
        }
        Ok(given)
    }

    fn conditions_of_options(&self, network: &Network, progress: &mut dyn Follow) -> Result<BTreeMap<usize, Given>> {
        let options = [("inlet", &self.inlet), ("outlet", &self.outlet), ("flow", &self.flow)];
        let mut given = BTreeMap::new();
        for (option, text) in options.into_iter().flat_map(|(option, texts)| texts.iter().map(move |text| (option, text))) {
            let refused = |why: String| Error::parameter(option, format!("\"{text}\""), why);
            let is_name = option != "flow" && network.nodes().any(|n| n.id == *text || (!n.label.is_empty() && n.label == *text));
            let (name, role, condition) = parse(option, text, is_name).map_err(refused)?;
            let found = locate(network, name).map_err(|why| refused(several(network, option, name).unwrap_or(why)))?;
            if found.by != FoundBy::Name {
                progress.step(Step::Located { name, node: &network.node(found.node).id, found, is_in_file: false });
            }
            if given.insert(found.node, Given { node: found.node, role, condition }).is_some() {
                let id = &network.node(found.node).id;
                return Err(refused(format!("is node {id}, which has a condition already; expected one condition a node")));
            }
        }
        Ok(given)
    }

    /// By node the parts of a Windkessel: those of the options (`NODE=rcr:R1,C,R2`), else those that the nodes state.
    pub(crate) fn windkessels(&self, network: &Network) -> Result<Vec<Windkessel>> {
        let mut all: Vec<Windkessel> = network.nodes().map(Node::windkessel).collect();
        for text in &self.outlet {
            let refused = |why: String| Error::parameter("outlet", format!("\"{text}\""), why);
            let Some((name, value)) = text.rsplit_once('=') else { continue };
            let Some(parts) = value.strip_prefix(RCR) else { continue };
            let (windkessel, _, _) = rcr(parts).map_err(refused)?;
            all[locate(network, name).map_err(refused)?.node] = windkessel;
        }
        Ok(all)
    }
}

/// What an outlet with a Windkessel of three elements begins with.
const RCR: &str = "rcr:";

/// `R1,C,R2[@PRESSURE]`: the Windkessel, R1 + R2 and the venous pressure.
fn rcr(text: &str) -> Result<(Windkessel, f64, f64), String> {
    const ACCEPTED: &str = "expected rcr:R1,C,R2[@PRESSURE], such as rcr:1.9mmHg.s/mL,0.023mL/mmHg,14mmHg.s/mL";
    let (parts, venous) = text.split_once('@').map_or((text, None), |(parts, p)| (parts, Some(p)));
    let venous = venous.map_or(Ok(0.0), |p| Dimension::Pressure.parse(p))?;
    let parts: Vec<&str> = parts.split(',').collect();
    let [proximal, compliance, distal] = parts[..] else { return Err(ACCEPTED.into()) };
    let (proximal, distal) = (Dimension::Resistance.parse(proximal)?, Dimension::Resistance.parse(distal)?);
    let compliance = Dimension::Compliance.parse(compliance)?;
    let are_resistances = proximal >= 0.0 && distal >= 0.0 && proximal + distal > 0.0;
    ensure(are_resistances, || "expected resistances that are not negative, and positive together")?;
    let accepted = "expected a positive compliance; an outlet without one is a resistance, NODE=RESISTANCE";
    ensure(compliance > 0.0, || accepted)?;
    let windkessel = Windkessel { proximal: Some(proximal), compliance: Some(compliance) };
    Ok((windkessel, proximal + distal, venous))
}

/// The outlets that a text means: `ground`, `murray`, `murray=FLOW` or `murray=RESISTANCE`.
///
/// # Errors
///
/// Another text: says what is accepted.
pub fn parse_found_outlets(text: &str) -> Result<FoundOutlets> {
    let refused = || {
        let (word, words) = (text.split('=').next().unwrap_or_default(), ["ground", "murray"]);
        let meant = if words.contains(&word) { String::new() } else { did_you_mean(word, words) };
        Error::parameter("outlets", format!("\"{text}\""), meant + OUTLETS)
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

/// The advice to give one option a node, where each word between commas names one.
fn several(network: &Network, option: &str, name: &str) -> Option<String> {
    let names: Vec<&str> = name.split(',').map(str::trim).collect();
    let is_node = |name: &&str| locate(network, name).is_ok();
    // Points inside vessels are no nodes, but were meant as such beside one that is.
    let are_numbers = names.iter().all(|name| name.parse::<u64>().is_ok()) && names.iter().any(is_node);
    let are_nodes = names.len() > 1 && (are_numbers || names.iter().all(is_node));
    let each: Vec<String> = names.iter().map(|name| format!("`{option}={name}`")).collect();
    are_nodes.then(|| format!("looks like {} nodes; give one at a time: {}", names.len(), each.join(" ")))
}

/// `NODE[=VALUE]`: the value is what follows the last `=`, unless the whole text is the name of a node.
fn parse<'a>(option: &str, text: &'a str, is_name: bool) -> Result<(&'a str, Role, Condition), String> {
    let split = text.rsplit_once('=').filter(|_| !is_name);
    match option {
        "inlet" => match split.map(|(name, value)| (name, Dimension::Pressure.parse(value))) {
            None => Ok((text, Role::Inlet, Condition::INLET)),
            Some((name, pressure)) => Ok((name, Role::Inlet, Condition::Pressure(pressure?))),
        },
        "outlet" => match split {
            None => Ok((text, Role::Outlet, Condition::GROUND)),
            Some((name, value)) => Ok((name, Role::Outlet, outlet(value)?)),
        },
        _ => {
            let (name, value) = split.ok_or("expected NODE=FLOW")?;
            let flow = Dimension::Flow.parse(value)?;
            Ok((name, Role::of_flow(flow), Condition::Flow(flow)))
        }
    }
}

/// `ground`, `PRESSURE`, `RESISTANCE[@PRESSURE]` or `rcr:R1,C,R2[@PRESSURE]`.
fn outlet(value: &str) -> Result<Condition, String> {
    if let Some(parts) = value.strip_prefix(RCR) {
        let (_, resistance, venous) = rcr(parts)?;
        return Ok(Condition::Resistance { resistance, venous });
    }
    if value == "ground" {
        return Ok(Condition::GROUND);
    }
    if Dimension::Resistance.has_unit_in(value.split('@').next().unwrap_or_default()) {
        let (resistance, venous) = value.split_once('@').map_or((value, None), |(r, p)| (r, Some(p)));
        let resistance = Dimension::Resistance.parse(resistance)?;
        ensure(resistance > 0.0, || "expected a positive resistance")?;
        let venous = venous.map_or(Ok(0.0), |p| Dimension::Pressure.parse(p))?;
        return Ok(Condition::Resistance { resistance, venous });
    }
    let meant = match Dimension::Pressure.near(value) {
        near if near.is_empty() => did_you_mean(value, ["ground"]) + &Dimension::Resistance.near(value),
        near => near,
    };
    let accepted = format!("{meant}expected ground, a pressure (5mmHg) or a resistance (20mmHg.s/mL)");
    Dimension::Pressure.parse(value).map(Condition::Pressure).map_err(|_| accepted)
}
