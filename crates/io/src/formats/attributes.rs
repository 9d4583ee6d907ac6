//! Reads the attributes of nodes and edges, whichever format stores them: makes the nodes, and of each edge one vessel, never merged or reordered.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use crate::formats::tables::{conditions::VENOUS, write::Texts};
use crate::formats::{Fault, Point, ReadOptions, Scale, box_diagonal, counted, distance, ensure, is_missing, is_radius};
use crate::formats::{millimetres, number, plural, real};
use willis_core::network::{
    Condition, ConditionFrom, Evidence, Network, Node, Origin, PathPoint, RadiusRule, Role, Vessel, Wall, Windkessel,
};
use willis_core::network::{metres, path_places::length_of, units};
use willis_core::support::distinct;

/// The attributes that may give the radius where none has "radius" in its name.
const SIZES: [&str; 5] = [AREA, "diameter", "r", "d", RESISTANCE];

/// Whether an attribute of this name is read, or named in a message.
pub(crate) fn is_wanted(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let mut asked = [POSITION_KEYS.as_flattened(), &OF_NODES, &SIZES].into_iter().chain(OF_EDGES);
    lower.contains("radius") || lower.contains("length") || asked.any(|names| names.contains(&name))
}

/// The columns with the position of a node.
pub const POSITION_COLUMNS: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
/// The attributes that may hold the position of a node; the first are in mm, the others in the unit of the file.
const POSITION_KEYS: [[&str; 3]; 4] = [POSITION_COLUMNS, ["x", "y", "z"], ["X", "Y", "Z"], ["pos_x", "pos_y", "pos_z"]];
/// The other attributes of a node.
const OF_NODES: [&str; 12] =
    ["node", "id", "pos", "label", "role", "alone", "pressure_mmHg", VENOUS, FLOW, PROXIMAL, COMPLIANCE, "found"];
/// The parts of a Windkessel beside the terminal resistance of a node.
pub(crate) const PROXIMAL: &str = "proximal_mmHg_s_per_mL";
pub(crate) const COMPLIANCE: &str = "compliance_mL_per_mmHg";
const FLOW: &str = "flow_mL_per_min";

/// Whether records have a length without a unit in its name, which the unit of the file is for.
pub(crate) fn has_lengths_without_unit(records: &Records) -> bool {
    let sizes = SIZES.iter().filter(|name| **name != RESISTANCE);
    let places = POSITION_KEYS[1..].as_flattened().iter().chain(&["pos"]);
    let lengths = ["length", "radius", "radius_avg", "avgRadiusAvg"];
    places.chain(sizes).chain(&lengths).any(|name| records.names.iter().flatten().any(|known| known == name))
}

/// The note that a unit was given for a graph without such a length.
pub(crate) fn unit_note(scale: &Scale, has_lengths_without_unit: bool) -> Option<String> {
    let is_idle = *scale != Scale::default() && !has_lengths_without_unit;
    is_idle.then(|| "`units` and `spacing` change nothing in this graph: the names of its lengths state mm".to_owned())
}

/// The nodes of records, each with its id, which must be unique.
pub(crate) fn nodes(ids: &[impl AsRef<str>], records: &Records, scale: &Scale) -> Result<Vec<Node>, Fault> {
    let named = || ids.iter().map(AsRef::as_ref).zip(records.iter());
    let items = || named().map(|(id, record)| (id, Item { record, name: Name::Node(id) }));
    let has_roles = items().any(|(_, item)| item.text("role").is_some());
    let mut seen = HashSet::new();
    let mut nodes = Vec::with_capacity(ids.len());
    for (id, item) in items() {
        ensure(seen.insert(id), || item.fault("the id comes twice", "expected every node id once"))?;
        let role = item.word("role", [Role::Inlet, Role::Outlet, Role::Inner].map(|role| (role.name(), role)))?;
        nodes.push(Node {
            id: id.to_owned(),
            position: position(&item, scale)?,
            radius: item.radius(scale)?.map(|(_, radius)| radius).filter(|radius| is_radius(*radius)),
            label: item.text("label").unwrap_or_default().to_owned(),
            role,
            condition: condition(&item, role, has_roles)?,
            windkessel: windkessel(&item)?.stated(),
            condition_from: condition_from(&item)?,
            root_score: item.share("alone")?,
            ..Node::default()
        });
    }
    Ok(nodes)
}

fn condition_from(item: &Item) -> Result<ConditionFrom, Fault> {
    let landmark = ConditionFrom::Landmark;
    if item.text("found") == Some(landmark.name()) {
        return Ok(landmark);
    }
    let found = item.boolean("found").map_err(|fault| Fault { accepted: "expected true, false or landmark".into(), ..fault })?;
    Ok(if found == Some(true) { ConditionFrom::FreeEnd } else { ConditionFrom::Statement })
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
            resistance: units::pascal_seconds_per_cubic_metre(resistance),
            venous: units::pascals(venous.unwrap_or(0.0)),
        }),
        (None, Some(flow), _) => Some(Condition::Flow(units::cubic_metres_per_second(flow))),
        (None, None, Some(pressure)) => Some(Condition::Pressure(units::pascals(pressure))),
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
        let accepted = || format!("expected at most {RESISTANCE} {total}, which it is part of");
        ensure(r <= total * (1.0 + 1e-9), || item.fault(format!("{PROXIMAL} {r}"), accepted()))?;
    }
    let compliance = item.checked(COMPLIANCE, |c| c > 0.0, POSITIVE)?.map(units::cubic_metres_per_pascal);
    Ok(Windkessel { proximal: proximal.map(units::pascal_seconds_per_cubic_metre), compliance })
}

/// The attributes of an edge, besides its length and radius.
const OF_EDGES: [&[&str]; 3] = [
    &["node_a", "label", "origin", "prior", "certain", "kept", "points"],
    &["probability", "hangs_a", "hangs_b", "continues_a", "continues_b"],
    &[SPEED, YOUNG, THICKNESS],
];
/// The wall: the speed of a pulse wave, or Young's modulus and the thickness.
pub(crate) const SPEED: &str = "pwv_m_per_s";
pub(crate) const YOUNG: &str = "young_MPa";
pub(crate) const THICKNESS: &str = "wall_mm";

/// A length that is rounded is at least this share of the distance between the nodes.
const ROUNDED: f64 = 0.99;

/// Adds the edges, in their order and with these rows of nodes as ends, to the network that has the nodes; returns what a person
/// should know. A radius that is missing or not positive, where it may, is NaN.
pub(crate) fn vessels(
    network: &mut Network,
    ends: &[[usize; 2]],
    records: &Records,
    options: &ReadOptions,
) -> Result<Vec<String>, Fault> {
    let scale = &options.scale;
    let (mut straight, mut too_short, mut from_nodes, mut origins) = (0, 0, 0, 0);
    let mut names = BTreeMap::new();
    let reach = reach(network.nodes());
    for (row, (ends, record)) in ends.iter().zip(records.iter()).enumerate() {
        let [a, b] = ends.map(|end| network.node(end));
        let item = Item { record, name: Name::Edge(row, [&a.id, &b.id]) };
        let known = [Origin::Observed, Origin::Candidate, Origin::Contact].map(|origin| (origin.name(), origin));
        let origin = item.word("origin", known)?;
        origins += usize::from(origin.is_some());
        let path = path(&item, [a, b], reach)?;
        let length = match length(&item, scale, *ends)? {
            Some(length) => length,
            None if path.is_empty() => {
                straight += 1;
                gap(&item, [a, b], *ends)?
            }
            None => length_of(&path),
        };
        let apart = a.position.zip(b.position).map_or(0.0, |(p, q)| distance(p, q));
        // A candidate at a junction that was opened goes on within the vessel there.
        too_short += usize::from(origin != Some(Origin::Candidate) && length < ROUNDED * apart);
        let radius = match item.radius(scale)? {
            Some((key, radius)) if is_radius(radius) => {
                if !key.starts_with("radius") || key == "radius_avg" {
                    *names.entry(key).or_insert(0) += 1;
                }
                radius
            }
            Some((key, _)) if !options.is_radius_optional() => {
                let value = item.text(key).unwrap_or_default();
                return Err(item.fault(format!("{key} {value}"), "expected a positive number, or give `default_radius`"));
            }
            _ if path.is_empty() => {
                if let (Some(p), Some(q)) = (a.radius, b.radius) {
                    from_nodes += 1;
                    p.min(q)
                } else if options.is_radius_optional() {
                    f64::NAN
                } else {
                    let accepted = "expected radius_mm on the edge, or on both of its nodes, or `default_radius`";
                    return Err(item.lacks("radius", accepted));
                }
            }
            _ => RadiusRule::Mean.radius(&path),
        };
        let certain = item.boolean("certain")?.unwrap_or(false);
        let evidence = evidence(&item, origin)?;
        let (evidence, earlier) = evidence.map_or((None, None), |(evidence, earlier)| (Some(Box::new(evidence)), earlier));
        // Where A was the probability that was changed by hand, it is the new one.
        let is_stated = |prior: &f64| certain || earlier.is_none_or(|earlier: f64| (earlier - prior).abs() > 1e-12 * prior);
        let prior = item.share("prior")?.filter(is_stated);
        let vessel = Vessel {
            length,
            radius,
            resistance: item.positive(RESISTANCE)?.map(units::pascal_seconds_per_cubic_metre),
            label: item.text("label").unwrap_or_default().to_owned(),
            origin: origin.unwrap_or(Origin::Candidate),
            prior: prior.or(evidence.as_ref().map(|e| e.probability)).unwrap_or(1.0),
            certain,
            evidence,
            kept: item.boolean("kept")?,
            wall: wall(&item)?,
            path,
        };
        network.add_vessel(*ends, vessel);
    }
    let mut notes = Vec::new();
    if origins == 0 && !ends.is_empty() {
        notes.push("no edge has an origin: the file is taken as a candidate graph".to_owned());
    }
    notes.extend(counted(straight, "edge", "without length_mm: took the distance between the nodes"));
    let note = "shorter than the distance between the nodes: are lengths and positions in one unit?";
    notes.extend(counted(too_short, "edge", note));
    for (name, edges) in names {
        let means = match name {
            AREA => "sqrt(avgCrossSection/π)".to_owned(),
            "diameter" | "d" => format!("half of {name}"),
            name => name.to_owned(),
        };
        notes.push(format!("the radius of {} is {means}", plural(edges, "edge")));
    }
    notes.extend(counted(from_nodes, "edge", "without radius_mm: took the smaller radius of the nodes"));
    Ok(notes)
}

/// Per edge whether it stays: not one that says the same of a vessel as one before it from the other end, as `to_directed` of NetworkX makes them.
pub(crate) fn directions_as_one(ends: &[[usize; 2]], network: &Network) -> Vec<bool> {
    // Few pairs of nodes have edges from both ends, so that few edges are looked up.
    let mut pairs = ends.to_vec();
    pairs.sort_unstable();
    let mut open: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
    let same = |a: &Vessel, b: &Vessel| a == b || *a == Vessel { path: b.path.iter().rev().copied().collect(), ..b.clone() };
    let stays = |(row, [a, b]): (usize, &[usize; 2])| {
        if a == b || pairs.binary_search(&[*b, *a]).is_err() {
            return true;
        }
        let others = open.entry([*b, *a]).or_default();
        let other = others.iter().position(|other| same(network.vessel(*other), network.vessel(row)));
        if let Some(other) = other {
            others.remove(other);
        } else {
            open.entry([*a, *b]).or_default().push(row);
        }
        other.is_none()
    };
    ends.iter().enumerate().map(stays).collect()
}

/// The length that the edge states, m. Only a self-loop may have length 0, since it carries no flow.
fn length(item: &Item, scale: &Scale, ends: [usize; 2]) -> Result<Option<f64>, Fault> {
    let Some((key, length)) = item.length(["length_mm", "length"], scale)? else { return Ok(None) };
    if key == "length" && scale.course(length).is_nan() {
        return Ok(None);
    }
    if length > 0.0 || (length == 0.0 && ends[0] == ends[1]) {
        return Ok(Some(length));
    }
    Err(item.fault(format!("{key} {}", item.text(key).unwrap_or_default()), "expected a positive number"))
}

/// The distance between the nodes, m.
fn gap(item: &Item, nodes: [&Node; 2], ends: [usize; 2]) -> Result<f64, Fault> {
    let [Some(p), Some(q)] = nodes.map(|node| node.position) else {
        return Err(item.lacks("length", "expected length_mm, or the positions of both nodes"));
    };
    match distance(p, q) {
        length if (length > 0.0 || ends[0] == ends[1]) && length.is_finite() => Ok(length),
        _ => Err(item.fault("no length_mm and both nodes in one place", "expected length_mm")),
    }
}

/// The wall that the edge states.
fn wall(item: &Item) -> Result<Option<Wall>, Fault> {
    match (item.positive(SPEED)?, item.positive(YOUNG)?, item.positive(THICKNESS)?) {
        (Some(speed), None, None) => Ok(Some(Wall::Speed(speed))),
        (None, Some(young), Some(mm)) => Ok(Some(Wall::Elastic { young: units::megapascals(young), thickness: metres(mm) })),
        (None, None, None) => Ok(None),
        (Some(_), ..) => Err(item.fault(format!("{SPEED} and {YOUNG} or {THICKNESS}"), "expected one statement of the wall")),
        (None, ..) => Err(item.fault(format!("{YOUNG} or {THICKNESS} alone"), "expected both, or neither")),
    }
}

/// The evidence that the edge states: its probability, which end feeds the other, and the odds that each end continues; and, where the probability was
/// changed by hand, what it was.
fn evidence(item: &Item, origin: Option<Origin>) -> Result<Option<(Evidence, Option<f64>)>, Fault> {
    let Some(probability) = item.share("probability")? else { return Ok(None) };
    let mut evidence = Evidence::undirected(probability);
    let odds = |key: &str| item.checked(key, |x| x >= 0.0, "expected odds, zero or more");
    if let [Some(a), Some(b)] = [odds("continues_a")?, odds("continues_b")?] {
        evidence.continuation_odds = [a, b];
    }
    if let [Some(a), Some(b)] = [item.share("hangs_a")?, item.share("hangs_b")?] {
        evidence.attached = [a, b];
        // What was written so is read to the same bits. Of a contact the two are no shares of it.
        if origin != Some(Origin::Contact) && (a + b - probability).abs() > 1e-12 * probability {
            evidence.probability = a + b;
            return Ok(Some((evidence.with_probability(probability), Some(a + b))));
        }
    }
    Ok(Some((evidence, None)))
}

/// How far a node may lie from where its edges have it, m: files may be rounded.
pub(crate) fn reach<'a>(nodes: impl Iterator<Item = &'a Node>) -> f64 {
    1e-3 * box_diagonal(nodes.filter_map(|node| node.position))
}

/// A position in mm, for messages.
pub(crate) fn place(position: Point) -> String {
    position.map(|x| real(millimetres(x))).join(" ")
}

/// The centerline `points`, mm, turned to run from the first node to the second, which may lie so far from its ends: programs that
/// hold undirected graphs write the two ends of an edge in either order.
fn path(item: &Item, nodes: [&Node; 2], reach: f64) -> Result<Vec<PathPoint>, Fault> {
    let Some(text) = item.text("points") else { return Ok(Vec::new()) };
    let mut path = Vec::new();
    for (n, point) in text.split(';').map(str::trim).filter(|point| !point.is_empty()).enumerate() {
        let wrong = || item.fault(format!("points: point {n} \"{point}\""), "expected x y z r in mm, r positive");
        let mut figures = [0.0; 4];
        let mut words = point.split_whitespace();
        for figure in &mut figures {
            *figure = words.next().and_then(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).ok_or_else(wrong)?;
        }
        let [x, y, z, radius] = figures.map(metres);
        ensure(words.next().is_none() && is_radius(radius), wrong)?;
        path.push(PathPoint { position: [x, y, z], radius, id: None });
    }
    let length = length_of(&path);
    let wrong = || item.fault(format!("points \"{text}\""), "expected two or more different points x y z r;x y z r");
    ensure(length > 0.0 && length.is_finite(), wrong)?;
    if let ([Some(a), Some(b)], Some(first), Some(last)) = (nodes.map(|n| n.position), path.first(), path.last()) {
        let stay = distance(first.position, a) + distance(last.position, b);
        if distance(first.position, b) + distance(last.position, a) < stay {
            path.reverse();
        }
        for (node, here, there) in [(nodes[0], a, path[0]), (nodes[1], b, path[path.len() - 1])] {
            let found = || format!("node {} lies at {} and its end of points at {}", node.id, place(here), place(there.position));
            let accepted = "expected points from node to node, or none";
            ensure(distance(here, there.position) <= reach, || item.fault(found(), accepted))?;
        }
    }
    Ok(path)
}

/// The texts of all items under the names of their attributes, in one buffer: a graph has millions of nodes and edges.
#[derive(Default)]
pub(crate) struct Records {
    /// The names of the attributes by number; none for those that are not read.
    pub(crate) names: Vec<Option<String>>,
    /// The values of items that state none.
    pub(crate) defaults: HashMap<String, String>,
    texts: Texts,
    /// The number of the name of each text.
    of: Vec<u32>,
    /// The line of each item, and the first of its texts.
    items: Vec<(usize, usize)>,
}

/// The attributes of one item.
pub(crate) struct Record<'a> {
    all: &'a Records,
    fields: Range<usize>,
    /// Its line in the file.
    pub(crate) line: usize,
}

impl Records {
    /// Without items, of attributes with these names.
    pub(crate) fn named(names: &[impl AsRef<str>]) -> Self {
        Self { names: names.iter().map(|name| Some(name.as_ref().to_owned())).collect(), ..Self::default() }
    }

    /// Begins an item.
    pub(crate) fn begin(&mut self, line: usize) {
        self.items.push((line, self.of.len()));
    }

    /// Sets an attribute of the last item; a later value replaces an earlier one.
    pub(crate) fn put(&mut self, name: usize, text: &str) {
        self.of.push(name as u32);
        self.texts.push(text.trim());
    }

    /// How many items there are.
    pub(crate) fn len(&self) -> usize {
        self.items.len()
    }

    /// An item.
    pub(crate) fn get(&self, row: usize) -> Record<'_> {
        let (line, first) = self.items[row];
        let end = self.items.get(row + 1).map_or(self.of.len(), |(_, next)| *next);
        Record { all: self, fields: first..end, line }
    }

    /// All items.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Record<'_>> {
        (0..self.len()).map(|row| self.get(row))
    }
}

impl<'a> Record<'a> {
    /// The text of an attribute, trimmed; none where it is missing.
    pub(crate) fn text(&self, name: &str) -> Option<&'a str> {
        self.word(name).filter(|text| !is_missing(text))
    }

    /// The text of an attribute that is a name, which may be any word; none where it is empty.
    pub(crate) fn word(&self, name: &str) -> Option<&'a str> {
        let text = match self.fields.clone().rfind(|field| self.name(*field) == Some(name)) {
            Some(field) => &self.all.texts[field],
            None => self.all.defaults.get(name)?.trim(),
        };
        Some(text).filter(|text| !text.is_empty())
    }

    /// The names of the attributes that are not empty.
    pub(crate) fn names(&self) -> Vec<&'a str> {
        let own = self.fields.clone().filter_map(|field| self.name(field));
        let mut names = distinct(own.chain(self.all.defaults.keys().map(String::as_str)));
        names.retain(|name| self.text(name).is_some());
        names
    }

    fn name(&self, field: usize) -> Option<&'a str> {
        self.all.names[self.all.of[field] as usize].as_deref()
    }
}

/// A cross-section area.
const AREA: &str = "avgCrossSection";
/// The resistance of an edge, in place of Poiseuille's law, or the terminal resistance of a node.
const RESISTANCE: &str = "resistance_mmHg_s_per_mL";

/// A node or edge with its attributes and its name for messages.
struct Item<'a> {
    record: Record<'a>,
    name: Name<'a>,
}

/// A node by its id, or an edge by its row and the ids of its ends.
enum Name<'a> {
    Node(&'a str),
    Edge(usize, [&'a str; 2]),
}

impl<'a> Item<'a> {
    fn text(&self, key: &str) -> Option<&'a str> {
        self.record.text(key)
    }

    fn fault(&self, found: impl std::fmt::Display, accepted: impl Into<String>) -> Fault {
        let found = match self.name {
            Name::Node(id) => format!("node {id}: {found}"),
            Name::Edge(row, [a, b]) => format!("edge {row} ({a} - {b}): {found}"),
        };
        Fault::line(self.record.line, found, accepted)
    }

    /// The error that a length in mm is missing; it lists attributes with similar names.
    fn lacks(&self, name: &str, accepted: &str) -> Fault {
        let mut like = self.record.names();
        like.retain(|key| key.to_ascii_lowercase().contains(name));
        let like = if like.is_empty() { String::new() } else { format!(" but {}", like.join(", ")) };
        self.fault(format!("no {name}_mm{like}"), accepted)
    }

    /// A finite number.
    fn real(&self, key: &str) -> Result<Option<f64>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        match number(text).map_err(|accepted| self.fault(format!("{key} \"{text}\""), accepted))? {
            x if x.is_finite() => Ok(Some(x)),
            x => Err(self.fault(format!("{key} {x}"), "expected a finite number")),
        }
    }

    /// A finite number that is as it has to be, which `accepted` describes for the error.
    fn checked(&self, key: &str, is_right: impl Fn(f64) -> bool, accepted: &str) -> Result<Option<f64>, Fault> {
        match self.real(key)? {
            Some(x) if !is_right(x) => Err(self.fault(format!("{key} {x}"), accepted)),
            right => Ok(right),
        }
    }

    /// A number above zero.
    fn positive(&self, key: &str) -> Result<Option<f64>, Fault> {
        self.checked(key, |x| x > 0.0, "expected a positive number")
    }

    /// A number from 0 to 1.
    fn share(&self, key: &str) -> Result<Option<f64>, Fault> {
        self.checked(key, |x| (0.0..=1.0).contains(&x), "expected a number from 0 to 1")
    }

    /// One of some words, with what it means.
    fn word<T: Copy>(&self, key: &str, words: [(&str, T); 3]) -> Result<Option<T>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        let wrong = || {
            let [a, b, c] = words.map(|(word, _)| word);
            self.fault(format!("{key} \"{text}\""), format!("expected {a}, {b} or {c}"))
        };
        words.iter().find(|(word, _)| *word == text).map(|(_, meant)| Some(*meant)).ok_or_else(wrong)
    }

    /// A length in millimetres under the first of two names, or in the unit of the file under the second: its key and value in m.
    fn length(&self, [in_mm, own]: [&'static str; 2], scale: &Scale) -> Result<Option<(&'static str, f64)>, Fault> {
        if let Some(mm) = self.real(in_mm)? {
            return Ok(Some((in_mm, metres(mm))));
        }
        Ok(self.real(own)?.map(|x| (own, scale.length(x))))
    }

    /// A radius under any of the names that programs give it: the name and its value in m.
    ///
    /// A cross-section area a gives sqrt(a/π) and comes before radii that are not willis's own.
    fn radius(&self, scale: &Scale) -> Result<Option<(&'static str, f64)>, Fault> {
        if let Some(radius) = self.length(["radius_mm", "radius"], scale)? {
            return Ok(Some(radius));
        }
        if let Some(area) = self.real(AREA)?.filter(|area| is_radius(*area)) {
            return Ok(Some((AREA, scale.length(willis_core::support::geometry::radius_of(area)))));
        }
        for (key, share) in [("radius_avg", 1.0), ("avgRadiusAvg", 1.0), ("diameter", 0.5)] {
            if let Some(size) = self.real(key)? {
                return Ok(Some((key, scale.length(share * size))));
            }
        }
        // Letters mean other things too; then they are no positive numbers.
        let letter = |key: &'static str, share: f64| {
            let size = self.text(key).and_then(|text| number(text).ok()).filter(|size| is_radius(*size))?;
            Some((key, scale.length(share * size)))
        };
        Ok(letter("r", 1.0).or_else(|| letter("d", 0.5)))
    }

    fn boolean(&self, key: &str) -> Result<Option<bool>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        match text.to_ascii_lowercase().as_str() {
            "true" | "1" | "1.0" => Ok(Some(true)),
            "false" | "0" | "0.0" => Ok(Some(false)),
            _ => Err(self.fault(format!("{key} \"{text}\""), "expected true or false")),
        }
    }
}
