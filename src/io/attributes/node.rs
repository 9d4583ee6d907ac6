//! Nodes of a ready graph: position, radius, label, role and boundary condition.

use super::records::Records;
use super::{Item, Name, RESISTANCE};
use crate::error::Fault;
use crate::io::tables::conditions::VENOUS;
use crate::io::tables::graph_columns::PLACE;
use crate::io::tables::number::number;
use crate::network::centerlines::is_radius;
use crate::network::units::{Scale, cubic_metres_per_second, metres, pascal_seconds_per_cubic_metre, pascals};
use crate::network::{Condition, Node, Role};
use crate::support::geometry::Point;

/// Where a node may say that it is; the first is in mm, the others are in the unit of the file.
pub(crate) const POSITIONS: [[&str; 3]; 4] = [PLACE, ["x", "y", "z"], ["X", "Y", "Z"], ["pos_x", "pos_y", "pos_z"]];
/// What else a node is asked for.
pub(crate) const ASKED: [&str; 7] = ["pos", "label", "role", "alone", "pressure_mmHg", VENOUS, FLOW];
const FLOW: &str = "flow_mL_per_min";

/// The nodes of records, each with its id, which must be unique.
pub(in crate::io) fn nodes(ids: &[impl AsRef<str>], records: &Records, scale: &Scale) -> Result<Vec<Node>, Fault> {
    let named = || ids.iter().map(AsRef::as_ref).zip(records.iter());
    let items = || named().map(|(id, record)| (id, Item { record, name: Name::Node(id) }));
    let has_roles = items().any(|(_, item)| item.text("role").is_some());
    let mut seen = std::collections::HashSet::new();
    let mut nodes = Vec::with_capacity(ids.len());
    for (id, item) in items() {
        if !seen.insert(id) {
            return Err(item.fault("the id comes twice", "expected every node id once"));
        }
        let role = match item.text("role") {
            None => None,
            Some("inlet") => Some(Role::Inlet),
            Some("outlet") => Some(Role::Outlet),
            Some("inner") => Some(Role::Inner),
            Some(other) => return Err(item.fault(format!("role \"{other}\""), "expected inlet, outlet or inner")),
        };
        nodes.push(Node {
            id: id.to_owned(),
            position: position(&item, scale)?,
            radius: item.radius(scale)?.map(|(_, radius)| radius).filter(|radius| is_radius(*radius)),
            label: item.text("label").unwrap_or_default().to_owned(),
            role,
            condition: condition(&item, role, has_roles)?,
            root_score: item.share("alone")?,
            ..Node::default()
        });
    }
    Ok(nodes)
}

/// The first of [`POSITIONS`] and pos (in the unit of the file) that is there at all.
fn position(item: &Item, scale: &Scale) -> Result<Option<Point>, Fault> {
    for keys in POSITIONS {
        match [item.finite(keys[0])?, item.finite(keys[1])?, item.finite(keys[2])?] {
            [None, None, None] => {}
            [Some(x), Some(y), Some(z)] if keys == PLACE => return Ok(Some([x, y, z].map(metres))),
            [Some(x), Some(y), Some(z)] => return Ok(Some(scale.position([x, y, z]))),
            some => {
                let missing = keys.iter().zip(some).find(|(_, value)| value.is_none()).map_or("", |(key, _)| *key);
                return Err(item.fault(format!("no {missing}"), format!("expected all of {} or none", keys.join(", "))));
            }
        }
    }
    let Some(text) = item.text("pos") else { return Ok(None) };
    let words = text.trim_matches(|c: char| "[]() \t\r\n".contains(c)).split(|c: char| c == ',' || c.is_whitespace());
    let numbers: Option<Vec<f64>> = words.filter(|word| !word.is_empty()).map(|word| number(word).ok()).collect();
    match numbers.as_deref() {
        Some([x, y, z]) if [x, y, z].iter().all(|x| x.is_finite()) => Ok(Some(scale.position([*x, *y, *z]))),
        // A place in a drawing.
        Some([_, _]) => Ok(None),
        _ => Err(item.fault(format!("pos \"{text}\""), "expected three finite numbers")),
    }
}

/// In a file without roles every node can have a condition, otherwise the inlets and outlets. A resistance or flow
/// stands over a pressure, which is then the result of an earlier run.
fn condition(item: &Item, role: Option<Role>, has_roles: bool) -> Result<Option<Condition>, Fault> {
    let pressure = item.finite("pressure_mmHg")?;
    let resistance = item.finite(RESISTANCE)?;
    let venous = item.finite(VENOUS)?;
    let flow = item.finite(FLOW)?;
    if has_roles && !matches!(role, Some(Role::Inlet | Role::Outlet)) {
        return Ok(None);
    }
    if let Some(resistance) = resistance.filter(|r| *r <= 0.0) {
        return Err(item.fault(format!("{RESISTANCE} {resistance}"), "expected a positive number"));
    }
    Ok(match (resistance, flow, pressure) {
        (Some(_), Some(_), _) => {
            return Err(item.fault(format!("{RESISTANCE} and {FLOW}"), "expected one condition"));
        }
        (Some(resistance), None, _) => Some(Condition::Resistance {
            resistance: pascal_seconds_per_cubic_metre(resistance),
            venous: pascals(venous.unwrap_or(0.0)),
        }),
        (None, Some(flow), _) => Some(Condition::Flow(cubic_metres_per_second(flow))),
        (None, None, Some(pressure)) => Some(Condition::Pressure(pascals(pressure))),
        (None, None, None) => match role {
            Some(Role::Inlet) => Some(Condition::INLET),
            Some(Role::Outlet) => Some(Condition::GROUND),
            Some(Role::Inner) | None => None,
        },
    })
}
