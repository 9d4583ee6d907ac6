//! Writes a network in any format: which one, into which files, and what is lost on the way.

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::{borrow::Cow, collections::HashMap};

use super::known::Property::{
    self, Conditions, Figures, Frame, Ids, Labels, LoneNodes, Names, Paths, Radii, Resistances, Statements,
};
use super::polylines::{between, is_straight, node_points, polylines};
use super::solvers::{enters, with_few_at_a_node, without_loops, without_unfed};
use super::{
    Format, FormatTrait, SolverSetting, Written, plural, tables::pairs::nodes_table_path, vendors::edge_tables::has_whole_ids,
};
use willis_core::error::{Error, Result, require};
use willis_core::flow::Unfed;
use willis_core::network::{Condition, Network, Node, Origin, PathPoint, RadiusRule, Vessel, fragments, path_places::length_of};
use willis_core::support::geometry::lerp;

/// What to write, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The format.
    pub format: Format,
    /// The file that was named: of a pair of tables that of the vessels.
    pub path: PathBuf,
    /// The table of nodes, for formats of two tables.
    pub nodes: Option<PathBuf>,
    /// What becomes of vessels that no blood enters. Solvers in time cannot do with them.
    pub unfed: Unfed,
    /// What a solver in time gets besides the network.
    pub setting: SolverSetting,
}

impl Target {
    /// The target for a path and, optionally, a word for its format.
    ///
    /// # Errors
    ///
    /// A word that is none of [`Format::words`], an ending that means no format, a table of vessels with the name of that of
    /// nodes.
    pub fn new(path: &Path, word: Option<&str>) -> Result<Self> {
        let found = word.map_or_else(|| Format::of_ending(path), Format::of_word);
        let format = found.ok_or_else(|| {
            if let Some(word) = word {
                Error::parameter("to", word, format!("expected one of {}", Format::words().collect::<Vec<_>>().join(", ")))
            } else {
                let accepted = format!("expected an ending {}, or `to=FORMAT`", Format::written_endings());
                Error::parameter("output", path.display(), accepted)
            }
        })?;
        let nodes = nodes_table_path(path).filter(|_| format.is(FormatTrait::TwoTables));
        let accepted = "is the name of the table of nodes; expected that of the vessels";
        require(nodes.is_some() || !format.is(FormatTrait::TwoTables), "output", path.display(), accepted)?;
        let unfed = if format.is(FormatTrait::Model) { Unfed::Drop } else { Unfed::Keep };
        Ok(Self { format, path: path.to_owned(), nodes, unfed, setting: SolverSetting::default() })
    }

    /// The same, with another rule for vessels that no blood enters, if there is one.
    #[must_use]
    pub fn with_unfed(self, unfed: Option<Unfed>) -> Self {
        Self { unfed: unfed.unwrap_or(self.unfed), ..self }
    }

    /// The network as it is to be written, and what a person should know of it: without what no blood enters, if that is to go, and for a solver in
    /// time with vessels between two nodes each, and with no more at a node than it takes.
    ///
    /// # Errors
    ///
    /// No inlet where a format that needs none is to have what inlets feed.
    pub fn network<'a>(&self, network: &'a Network) -> Result<(Cow<'a, Network>, Vec<String>)> {
        let is_model = self.format.is(FormatTrait::Model);
        let drops = self.unfed == Unfed::Drop;
        let states_inlets = !drops || is_model || (0..network.node_count()).any(|node| enters(network, node));
        require(states_inlets, "unfed", "drop", "needs a node that states where blood enters; none does")?;
        let is_needed = [drops, is_model, self.format == Format::OpenBf];
        let steps = is_needed.into_iter().zip([without_unfed, without_loops, with_few_at_a_node]);
        let (mut made, mut notes) = (Cow::Borrowed(network), Vec::new());
        for (_, step) in steps.filter(|(is_needed, _)| *is_needed) {
            if let Some((changed, note)) = step(&made) {
                made = Cow::Owned(changed);
                notes.push(note);
            }
        }
        Ok((made, notes))
    }

    /// The file of links that a tree cannot hold.
    pub fn loops(&self) -> PathBuf {
        self.path.with_extension("loops.csv")
    }
}

/// The error that a format cannot hold a network, from an error of kind `InvalidInput` of [`write_into`].
pub fn refusal(target: &Target, error: &io::Error) -> Error {
    Error::parameter("output", target.path.display(), format!("{} cannot hold the network: {error}", target.format.name()))
}

/// Writes a network, as [`Target::network`] has it, as the file of a target, and as its table of nodes where it has one.
///
/// # Errors
///
/// A network that the format cannot hold at all (`InvalidInput`, see [`refusal`]), or the writers' own.
pub fn write_into(network: &Network, target: &Target, vessels: impl Write + Seek, nodes: impl Write) -> io::Result<Written> {
    let mut written = Written::default();
    let drawn;
    let network = if consists_of_lines(target.format, network) {
        let made;
        (drawn, made) = with_lines(network)?;
        if made > 0 {
            written.notes.push(format!("{} without points got some, which keep the radius", plural(made, "straight vessel")));
        }
        &drawn
    } else {
        network
    };
    target.format.write(network, &target.setting, vessels, nodes, &mut written)?;
    if target.format == Format::Markups && !network.frame.is_known() {
        let note = "no frame is stated, and markups call positions LPS: `frame` says which way the axes of the input point";
        written.notes.push(note.to_owned());
    }
    if !written.loops.is_empty() {
        let path = target.loops();
        written.notes.push(format!("the links that close loops are in {}: give it with `loops`", path.display()));
    }
    Ok(written)
}

/// Whether a format stores the vessels of a network as lines of points, so that a vessel without points needs some.
fn consists_of_lines(format: Format, network: &Network) -> bool {
    !(format.is(FormatTrait::Pairs) || format.is(FormatTrait::PairsIfStraight) && is_straight(network))
}

/// How far from its nodes, as a share of its length, a straight vessel takes the radius that is its own.
const TAPER: f64 = 0.01;

/// Whether a vessel runs from a node to itself without points between, so that it cannot be drawn.
pub(crate) fn has_no_course(network: &Network, row: usize) -> bool {
    let [a, b] = network.ends(row);
    a == b && network.vessel(row).path.len() < 4
}

/// The network with a line for every vessel, without those that cannot have one; and how many lines had to be made.
///
/// Nodes are points of several vessels, so the radius of a vessel without a line is that of two points near its ends,
/// chosen such that the mean over its arc length is the vessel's radius. A vessel that runs straight between two nodes that
/// other such vessels join gets points that none of those has, one at least: a reader takes points in one place for one.
///
/// # Errors
///
/// A node without position (`InvalidInput`).
pub(crate) fn with_lines(network: &Network) -> io::Result<(Network, usize)> {
    let at = node_points(network)?;
    let (mut drawn, _) = network.subgraph(|row| !has_no_course(network, row));
    let (mut joined, mut made) = (HashMap::new(), 0);
    for row in 0..drawn.vessel_count() {
        let rows = drawn.ends(row);
        let [a, b] = rows.map(|end| at[end]);
        let vessel = drawn.vessel_mut(row);
        let inner = between(&vessel.path, a.position, b.position, true);
        if !inner.is_empty() {
            continue;
        }
        let so_far = joined.entry([rows[0].min(rows[1]), rows[0].max(rows[1])]).or_insert(0.0);
        let others = *so_far;
        *so_far += 1.0;
        let point = |share: f64, radius: f64| PathPoint { position: lerp(a.position, b.position, share), radius, id: None };
        let taper = TAPER / (others + 1.0);
        let radius = (vessel.radius - taper * f64::midpoint(a.radius, b.radius)) / (1.0 - taper);
        let tapers = (RadiusRule::Mean.radius(&[a, b]) - vessel.radius).abs() > f64::EPSILON * vessel.radius;
        if vessel.path.is_empty() && tapers && radius > 0.0 && a.position != b.position {
            vessel.path = vec![a, point(taper, radius), point(1.0 - taper, radius), b];
            made += 1;
        } else if others > 0.0 {
            let share = 0.5 / others;
            vessel.path = vec![a, point(share, a.radius + share * (b.radius - a.radius)), b];
            made += 1;
        }
    }
    Ok((drawn, made))
}

/// Lengths and radii that differ by less than this fraction are equal.
const SAME: f64 = 1e-9;

/// What is lost when a network is written, one text for each thing.
pub fn losses(network: &Network, target: &Target) -> Vec<String> {
    let lacks = |property: Property| target.format.lacks(property);
    let (is_lines, is_openbf) = (consists_of_lines(target.format, network), target.format == Format::OpenBf);
    // An SWC is written from there again.
    let is_swc = target.format == Format::Swc;
    let is_model = target.format.is(FormatTrait::Model);
    let vessels = |of: &dyn Fn(&Vessel) -> bool| network.vessels().filter(|(_, v)| of(v)).count();
    let nodes = |of: &dyn Fn(&Node) -> bool| network.nodes().filter(|n| of(n)).count();
    let degree = network.degrees(|_| true);
    let has_course = |node: usize| target.setting.courses.contains_key(&network.node(node).id);
    let drawn = if is_lines { with_lines(network).ok() } else { None };
    let drawn = drawn.and_then(|(drawn, _)| Some((polylines(&drawn).ok()?, drawn)));
    let changed = drawn.as_ref().filter(|_| lacks(Figures)).map(|(lines, drawn)| changed_as_lines(drawn, lines));
    let [lengths, radii] = changed.unwrap_or_default();
    // These say beside their lines what is apart.
    let states_nodes = [Format::Vtp, Format::Vtk, Format::Swc].contains(&target.format);
    let points = drawn.as_ref().map_or(0, |(lines, _)| lines.iter().filter(|line| is_place(line)).count());
    let joined = drawn.filter(|_| !states_nodes).map(|(lines, drawn)| read_as_joined(&drawn, &lines, lacks(LoneNodes)));
    let meetings = joined.unwrap_or_default();
    let ids = network.nodes().enumerate().filter(|(row, node)| node.id != row.to_string()).count();
    let without_course = (0..network.vessel_count()).filter(|row| has_no_course(network, *row)).count();
    let has_venous = |n: &Node| matches!(n.condition, Some(Condition::Resistance { venous, .. }) if venous != 0.0);
    let inlets = (0..network.node_count()).filter(|node| enters(network, *node) && !has_course(*node)).count();
    let counts = [
        (lacks(Paths), vessels(&|v| v.path.len() > 2), "the points between the nodes of {vessel}"),
        (true, lengths, "the lengths of {vessel}, other than along the lines"),
        (true, radii, "the radii of {vessel}, other than the mean over the points"),
        (lacks(Ids) || lacks(Names) && !has_whole_ids(network), ids, "the ids of {node}"),
        (lacks(LoneNodes), degree.iter().filter(|d| **d == 0).count(), "{node} without a vessel"),
        (lacks(Radii) && !is_lines, nodes(&|n| n.radius.is_some()), "the radii of {node}"),
        (lacks(Labels), vessels(&|v| !v.label.is_empty()), "the labels of {vessel}"),
        (lacks(Conditions) || is_model, nodes(&|n| !n.label.is_empty()), "the labels of {node}"),
        (lacks(Conditions), nodes(&|n| n.condition.is_some()), "the boundary conditions of {node}"),
        (!is_swc, nodes(&|n| n.is_source && n.role.is_none()), "that blood comes in at {node}, as the input states"),
        (lacks(Statements), vessels(&|v| v.origin == Origin::Candidate), "the origin of {candidate}"),
        (lacks(Statements), vessels(&|v| v.prior != 1.0), "the priors of {vessel}"),
        (lacks(Statements), vessels(&|v| v.evidence.is_some()), "the probabilities of {vessel}"),
        (lacks(Statements), vessels(&|v| v.certain), "the certainty of {vessel}"),
        (lacks(Statements) || lacks(Resistances), vessels(&|v| v.resistance.is_some()), "the stated resistances of {vessel}"),
        (lacks(Statements), vessels(&|v| v.wall.is_some()), "the stated walls of {vessel}"),
        (is_lines, points, "{vessel} in one place, whose two nodes are read again as one"),
        (is_lines, degree.iter().filter(|d| **d == 2).count(), "{node} between two vessels, which are read again as one"),
        (true, meetings, "that vessels only touch in {place}, where they are read as joined"),
        (is_lines, without_course, "{vessel} from a node to itself without a course"),
        (is_openbf, inlets, "the pressure or flow of {inlet}, which openBF takes as a course in time from inlet-N.dat"),
        (is_openbf, nodes(&has_venous), "the venous pressure of {outlet}, which is 0 in openBF"),
    ];
    // The noun in braces stands for how many there are.
    let words = |what: &str, count: usize| {
        let (before, rest) = what.split_once('{')?;
        let (noun, after) = rest.split_once('}')?;
        Some(format!("{before}{}{after}", plural(count, noun)))
    };
    let lost = counts.into_iter().filter(|(is_lost, count, _)| *is_lost && *count > 0);
    let mut lost: Vec<String> = lost.filter_map(|(_, count, what)| words(what, count)).collect();
    if let Some(frame) = network.frame.name().filter(|_| lacks(Frame)) {
        lost.push(format!("that positions are in {frame}"));
    }
    lost
}

/// In how many places lines meet that have no node in common there, so that a reader joins them (`Centerlines::weld`): points of several lines, where
/// these are `apart`, or of several parts of the network, or free ends.
fn read_as_joined(drawn: &Network, lines: &[Vec<PathPoint>], apart: bool) -> usize {
    let place = |point: &PathPoint| point.position.map(|x| (x + 0.0).to_bits());
    let is_place: Vec<bool> = lines.iter().map(|line| is_place(line)).collect();
    let lines: Vec<Vec<[u64; 3]>> = lines.iter().map(|line| line.iter().map(place).collect()).collect();
    // Nodes that a vessel without extent joins are one.
    let one = fragments(drawn, |row, _| is_place.get(row).copied().unwrap_or_default()).of_node;
    let (degree, part) = (drawn.degrees(|_| true), fragments(drawn, |_, _| true).of_node);
    // Each with its place, whether it is a free end, what it is, a node or a point of a vessel, and its line or part.
    let mut points = Vec::new();
    for (row, line) in lines.iter().enumerate() {
        let ([a, b], last) = (drawn.ends(row), line.len() - 1);
        let of = if apart { row } else { part[a] };
        points.extend([(a, line[0]), (b, line[last])].map(|(node, at)| (at, [one[node], 0], of, degree[node] == 1)));
        // Of points in one place that follow each other the last counts, or the node.
        let inner = (1..last).filter(|at| line[*at] != line[0] && line[*at] != line[at + 1]);
        points.extend(inner.map(|at| (line[at], [row, at], of, false)));
    }
    points.sort_unstable();
    let is_joined = |there: &&[([u64; 3], [usize; 2], usize, bool)]| {
        let [first, .., last] = there else { return false };
        let of_others = there.iter().any(|point| point.2 != first.2);
        first.1 != last.1 && (of_others || there.iter().filter(|point| point.3).count() > 1)
    };
    points.chunk_by(|a, b| a.0 == b.0).filter(is_joined).count()
}

/// Whether all points of a line lie in one place, as those of a contact between two halves of one junction do.
fn is_place(line: &[PathPoint]) -> bool {
    line.iter().all(|point| point.position == line[0].position)
}

/// How many vessels have another length, and how many another radius, as lines from node to node; without those that are no line.
fn changed_as_lines(drawn: &Network, lines: &[Vec<PathPoint>]) -> [usize; 2] {
    let differs = |drawn: f64, stated: f64| (drawn - stated).abs() > SAME * stated.abs();
    let changed = |of: &dyn Fn(&[PathPoint]) -> f64, stated: &dyn Fn(&Vessel) -> f64| {
        let drawn = lines.iter().zip(drawn.vessels());
        drawn.filter(|(line, (_, vessel))| !is_place(line) && differs(of(line), stated(vessel))).count()
    };
    [changed(&length_of, &|vessel| vessel.length), changed(&|line| RadiusRule::Mean.radius(line), &|vessel| vessel.radius)]
}
