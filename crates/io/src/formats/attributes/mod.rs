//! Reads the attributes of nodes and edges, whichever format stores them; makes the nodes.

pub(crate) mod edge;
mod item;
pub(crate) mod records;

use crate::formats::attributes::item::{AREA, Item, Name, RESISTANCE};
use crate::formats::attributes::records::Records;
use crate::formats::tables::conditions::VENOUS;
use crate::formats::tables::reader::number;
use willis_core::error::Fault;
use willis_core::network::units::{cubic_metres_per_pascal, cubic_metres_per_second, pascal_seconds_per_cubic_metre, pascals};
use willis_core::network::{Condition, Node, Role, Scale, Windkessel, is_radius, metres};
use willis_core::support::geometry::Point;

/// The attributes that may give the radius where none has "radius" in its name.
const SIZES: [&str; 5] = [AREA, "diameter", "r", "d", RESISTANCE];

/// Whether an attribute of this name is read, or named in a message.
pub(crate) fn is_wanted(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let mut asked = [POSITION_KEYS.as_flattened(), &ATTRIBUTES, &SIZES].into_iter().chain(edge::ATTRIBUTES);
    lower.contains("radius") || lower.contains("length") || asked.any(|names| names.contains(&name))
}

/// The columns with the position of a node.
pub const POSITION_COLUMNS: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
/// The attributes that may hold the position of a node; the first are in mm, the others in the unit of the file.
pub(crate) const POSITION_KEYS: [[&str; 3]; 4] =
    [POSITION_COLUMNS, ["x", "y", "z"], ["X", "Y", "Z"], ["pos_x", "pos_y", "pos_z"]];
/// The other attributes of a node.
pub(crate) const ATTRIBUTES: [&str; 11] =
    ["id", "pos", "label", "role", "alone", "pressure_mmHg", VENOUS, FLOW, PROXIMAL, COMPLIANCE, "found"];
/// The parts of a Windkessel beside the terminal resistance of a node.
pub(crate) const PROXIMAL: &str = "proximal_mmHg_s_per_mL";
pub(crate) const COMPLIANCE: &str = "compliance_mL_per_mmHg";
const FLOW: &str = "flow_mL_per_min";

/// Whether records have a length without a unit in its name, which the unit of the file is for.
pub(in crate::formats) fn has_lengths_without_unit(records: &Records) -> bool {
    let sizes = SIZES.iter().filter(|name| **name != RESISTANCE);
    let places = POSITION_KEYS[1..].as_flattened().iter().chain(&["pos"]);
    let lengths = ["length", "radius", "radius_avg", "avgRadiusAvg"];
    places.chain(sizes).chain(&lengths).any(|name| records.has(name))
}

/// The note that a unit was given for a graph without such a length.
pub(in crate::formats) fn unit_note(scale: &Scale, has_lengths_without_unit: bool) -> Option<String> {
    let is_idle = *scale != Scale::default() && !has_lengths_without_unit;
    is_idle.then(|| "`units` and `spacing` change nothing in this graph: the names of its lengths state mm".to_owned())
}

/// The nodes of records, each with its id, which must be unique.
pub(in crate::formats) fn nodes(ids: &[impl AsRef<str>], records: &Records, scale: &Scale) -> Result<Vec<Node>, Fault> {
    let named = || ids.iter().map(AsRef::as_ref).zip(records.iter());
    let items = || named().map(|(id, record)| (id, Item { record, name: Name::Node(id) }));
    let has_roles = items().any(|(_, item)| item.text("role").is_some());
    let mut seen = std::collections::HashSet::new();
    let mut nodes = Vec::with_capacity(ids.len());
    for (id, item) in items() {
        if !seen.insert(id) {
            return Err(item.fault("the id comes twice", "expected every node id once"));
        }
        let role = item.word("role", [Role::Inlet, Role::Outlet, Role::Inner].map(|role| (role.name(), role)))?;
        nodes.push(Node {
            id: id.to_owned(),
            position: position(&item, scale)?,
            radius: item.radius(scale)?.map(|(_, radius)| radius).filter(|radius| is_radius(*radius)),
            label: item.text("label").unwrap_or_default().to_owned(),
            role,
            condition: condition(&item, role, has_roles)?,
            windkessel: windkessel(&item)?.stated(),
            found: item.boolean("found")?.unwrap_or(false),
            root_score: item.share("alone")?,
            ..Node::default()
        });
    }
    Ok(nodes)
}

/// The first of [`POSITION_KEYS`] and pos (in the unit of the file) that is there at all.
fn position(item: &Item, scale: &Scale) -> Result<Option<Point>, Fault> {
    for keys in POSITION_KEYS {
        match [item.real(keys[0])?, item.real(keys[1])?, item.real(keys[2])?] {
            [None, None, None] => {}
            [Some(x), Some(y), Some(z)] if keys == POSITION_COLUMNS => return Ok(Some([x, y, z].map(metres))),
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
/// replaces a pressure, which is then the result of an earlier run.
fn condition(item: &Item, role: Option<Role>, has_roles: bool) -> Result<Option<Condition>, Fault> {
    let pressure = item.real("pressure_mmHg")?;
    let resistance = item.real(RESISTANCE)?;
    let venous = item.real(VENOUS)?;
    let flow = item.real(FLOW)?;
    if has_roles && !matches!(role, Some(Role::Inlet | Role::Outlet)) {
        return Ok(None);
    }
    // Not before: an inner node may have any.
    item.positive(RESISTANCE)?;
    Ok(match (resistance, flow, pressure) {
        (Some(_), Some(_), _) => return Err(item.fault(format!("{RESISTANCE} and {FLOW}"), "expected one condition")),
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

/// The parts of a Windkessel that a node states.
fn windkessel(item: &Item) -> Result<Windkessel, Fault> {
    const POSITIVE: &str =
        "expected a positive number; an outlet without compliance is a resistance, which states none (`windkessel=none`)";
    // What is no number is said of either before what is out of range.
    item.real(PROXIMAL).and(item.real(COMPLIANCE))?;
    let proximal = item.checked(PROXIMAL, |r| r >= 0.0, "expected zero or a positive number")?;
    if let (Some(r), Some(total)) = (proximal, item.real(RESISTANCE)?) {
        // Where both are printed with a few digits they may be equal but for the last one.
        if r > total * (1.0 + 1e-9) {
            let accepted = format!("expected at most {RESISTANCE} {total}, which it is part of");
            return Err(item.fault(format!("{PROXIMAL} {r}"), accepted));
        }
    }
    let compliance = item.checked(COMPLIANCE, |c| c > 0.0, POSITIVE)?;
    Ok(Windkessel { proximal: proximal.map(pascal_seconds_per_cubic_metre), compliance: compliance.map(cubic_metres_per_pascal) })
}
