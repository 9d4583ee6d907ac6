//! The edges of a graph file: each becomes one vessel, never merged, contracted or reordered.

use std::collections::BTreeMap;

use super::item::{AREA, Item, Name, RESISTANCE};
use super::records::Records;
use crate::formats::options::ReadOptions;
use crate::formats::tables::reader::{counted, plural};
use willis_core::error::Fault;
use willis_core::network::path_places::length_of;
use willis_core::network::units::{megapascals, pascal_seconds_per_cubic_metre};
use willis_core::network::{Evidence, Network, Node, Origin, PathPoint, RadiusRule, Scale, Vessel, Wall, is_radius, metres};
use willis_core::support::geometry::distance;

/// The attributes of an edge, besides its length and radius.
pub(crate) const ATTRIBUTES: [&[&str]; 3] = [
    &["label", "origin", "prior", "certain", "kept", "points"],
    &["probability", "hangs_a", "hangs_b", "continues_a", "continues_b"],
    &[SPEED, YOUNG, THICKNESS],
];
/// The wall: the speed of a pulse wave, or Young's modulus and the thickness.
pub(crate) const SPEED: &str = "pwv_m_per_s";
pub(crate) const YOUNG: &str = "young_MPa";
pub(crate) const THICKNESS: &str = "wall_mm";

/// Adds the edges, in their order and with these rows of nodes as ends, to the network that has the nodes; returns what a person
/// should know. A radius that is missing, where it may, is NaN.
pub(in crate::formats) fn vessels(
    network: &mut Network,
    ends: &[[usize; 2]],
    records: &Records,
    options: &ReadOptions,
) -> Result<Vec<String>, Fault> {
    let scale = &options.scale;
    let (mut straight, mut from_nodes, mut origins) = (0, 0, 0);
    let mut names = BTreeMap::new();
    for (row, (ends, record)) in ends.iter().zip(records.iter()).enumerate() {
        let [a, b] = ends.map(|end| network.node(end));
        let item = Item { record, name: Name::Edge(row, [&a.id, &b.id]) };
        let path = path(&item, [a, b])?;
        let length = match length(&item, scale, *ends)? {
            Some(length) => length,
            None if path.is_empty() => {
                straight += 1;
                gap(&item, [a, b], *ends)?
            }
            None => length_of(&path),
        };
        let radius = match item.radius(scale)? {
            Some((key, radius)) if is_radius(radius) => {
                if !key.starts_with("radius") || key == "radius_avg" {
                    *names.entry(key).or_insert(0) += 1;
                }
                radius
            }
            Some((key, _)) => {
                let value = item.text(key).unwrap_or_default();
                return Err(item.fault(format!("{key} {value}"), "expected a positive number"));
            }
            None if path.is_empty() => {
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
            None => RadiusRule::Mean.radius(&path),
        };
        let known = [Origin::Observed, Origin::Candidate, Origin::Contact].map(|origin| (origin.name(), origin));
        let origin = item.word("origin", known)?;
        origins += usize::from(origin.is_some());
        let vessel = Vessel {
            length,
            radius,
            resistance: item.positive(RESISTANCE)?.map(pascal_seconds_per_cubic_metre),
            label: item.text("label").unwrap_or_default().to_owned(),
            origin: origin.unwrap_or(Origin::Candidate),
            prior: item.share("prior")?.unwrap_or(1.0),
            certain: item.boolean("certain")?.unwrap_or(false),
            evidence: evidence(&item)?.map(Box::new),
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

/// The length that the edge states, m. Only a self-loop may have length 0, since it carries no flow.
fn length(item: &Item, scale: &Scale, ends: [usize; 2]) -> Result<Option<f64>, Fault> {
    let Some((key, length)) = item.length(scale)? else { return Ok(None) };
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
        (None, Some(young), Some(mm)) => Ok(Some(Wall::Elastic { young: megapascals(young), thickness: metres(mm) })),
        (None, None, None) => Ok(None),
        (Some(_), ..) => Err(item.fault(format!("{SPEED} and {YOUNG} or {THICKNESS}"), "expected one statement of the wall")),
        (None, ..) => Err(item.fault(format!("{YOUNG} or {THICKNESS} alone"), "expected both, or neither")),
    }
}

/// The evidence that the edge states: its probability, which end feeds the other, and the odds that each end continues.
fn evidence(item: &Item) -> Result<Option<Evidence>, Fault> {
    let Some(probability) = item.share("probability")? else { return Ok(None) };
    let mut evidence = Evidence::undirected(probability);
    if let [Some(a), Some(b)] = [item.share("hangs_a")?, item.share("hangs_b")?] {
        // What was written so is read to the same bits; a probability that was changed by hand is divided in the same shares.
        let is_whole = (a + b - probability).abs() <= 1e-12 * probability;
        evidence = if is_whole { Evidence { attached: [a, b], ..evidence } } else { evidence.divided([a, b]) };
    }
    let odds = |key: &str| item.checked(key, |x| x >= 0.0, "expected odds, zero or more");
    if let [Some(a), Some(b)] = [odds("continues_a")?, odds("continues_b")?] {
        evidence.continuation_odds = [a, b];
    }
    Ok(Some(evidence))
}

/// The centerline `points`, mm, turned to run from the first node to the second: programs that hold undirected graphs
/// write the two ends of an edge in either order.
fn path(item: &Item, nodes: [&Node; 2]) -> Result<Vec<PathPoint>, Fault> {
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
        if words.next().is_some() || !is_radius(radius) {
            return Err(wrong());
        }
        path.push(PathPoint { position: [x, y, z], radius, id: None });
    }
    let length = length_of(&path);
    if !(length > 0.0 && length.is_finite()) {
        return Err(item.fault(format!("points \"{text}\""), "expected two or more different points x y z r;x y z r"));
    }
    if let ([Some(a), Some(b)], Some(first), Some(last)) = (nodes.map(|n| n.position), path.first(), path.last()) {
        let stay = distance(first.position, a) + distance(last.position, b);
        if distance(first.position, b) + distance(last.position, a) < stay {
            path.reverse();
        }
    }
    Ok(path)
}
