//! Reading: from a file of any format to a network of vessels.

use std::path::Path;
use std::time::Instant;

use super::stored_run::StoredRun;
use willis_core::error::{Error, Result};
use willis_core::flow::FoundOutlets;
use willis_core::network::centerlines::Centerlines;
use willis_core::network::units::LengthUnit;
use willis_core::network::{Network, Origin, RadiusRule};
use willis_core::support::geometry::Point;
use willis_io::formats::tables::reader::plural;
use willis_io::formats::{
    Content, Document, Format, FormatTrait, ReadOptions, open_regular, read as read_file, read_bytes as read_file_bytes,
};
use willis_io::masks::{Cavities, Foreground, RadiusFrom};
use willis_io::output::names::TOPOLOGY;
use willis_models::circle_of_willis::{Circle, LabelScheme, are_topcow_classes, split_where_labels_change};
use willis_report::Provenance;

/// A network and where it comes from: what every other function of this crate starts from.
#[derive(Debug, Clone)]
pub struct Input {
    /// The vessels; lengths in m.
    pub network: Network,
    /// What the file held.
    pub contents: Contents,
    /// The file's format; `None` for a network that was handed over.
    pub format: Option<Format>,
    /// Whether candidates are to be built around its vessels.
    pub is_fragments: bool,
    /// The file, its checksum, and what a person should know about how it was read.
    pub provenance: Provenance,
    /// How it was read.
    pub options: ReadOptions,
    /// The run of infer whose folder it was read from.
    pub(crate) run: Option<StoredRun>,
    /// When reading began.
    pub(crate) started: Instant,
    lines: Option<Centerlines>,
    /// The voxels inside the vessels of a mask.
    pub(crate) lumen: Option<Foreground>,
    /// Whether it is a mask of TopCoW's classes.
    pub(crate) is_topcow: bool,
}

/// What a file held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents {
    /// Centerlines of so many points.
    Centerlines(usize),
    /// Vessels that an image showed.
    Vessels,
    /// A ready graph, whose edges are vessels as they stand.
    Graph,
}

/// Reads centerlines, a mask, a graph, or the plausible topology in a folder that [`infer`](crate::infer) saved.
///
/// # Errors
///
/// A file that cannot be read, is in none of the formats or has a fault in its content: with file, place, value and accepted form. An
/// option that does not go with what the file holds.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Input> {
    let started = Instant::now();
    options.validate()?;
    if !path.is_dir() {
        return made_of(read_file(path, options)?, path, options, started, None);
    }
    let graph = StoredRun::read(path)?.graph;
    let file = path.join(format!("{TOPOLOGY}.graphml"));
    open_regular(&file)?;
    let mut document = read_file(&file, options)?;
    document.notes.insert(0, format!("the plausible topology of a run; {} has all candidates", graph.display()));
    made_of(document, &file, options, started, None)
}

/// As [`read`], but of a folder that [`infer`](crate::infer) saved the run: its over-connected graph, with what was found by sampling it.
///
/// # Errors
///
/// As [`read`], or a graph that is not the one that was sampled.
pub fn read_run(path: &Path, options: &ReadOptions) -> Result<Input> {
    if !path.is_dir() {
        return read(path, options);
    }
    let started = Instant::now();
    options.validate()?;
    let run = StoredRun::read(path)?;
    let file = run.graph.clone();
    open_regular(&file)?;
    made_of(read_file(&file, options)?, &file, options, started, Some(run))
}

/// As [`read`], of the bytes of a file that would be called `name`: arrays of another program, packed as NPZ or NIfTI.
///
/// # Errors
///
/// As [`read`], naming `name` as the file.
pub fn read_bytes(name: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Input> {
    let started = Instant::now();
    options.validate()?;
    made_of(read_file_bytes(name, bytes, options)?, name, options, started, None)
}

/// The input that a document is.
fn made_of(document: Document, file: &Path, options: &ReadOptions, started: Instant, run: Option<StoredRun>) -> Result<Input> {
    let Document { format, content, mut notes, sha256, lumen } = document;
    let contents = match &content {
        Content::Centerlines(lines) => Contents::Centerlines(lines.points.len()),
        Content::Vessels(_) => Contents::Vessels,
        Content::Graph(_) => Contents::Graph,
    };
    check_for(contents, format, options)?;
    if let Some(run) = &run {
        run.check_graph(&sha256)?;
    }
    if let Some([x, y, z]) = options.scale.spacing.filter(|[x, y, z]| !format.is_mask() && (x != y || y != z)) {
        notes.push(format!("unequal spacing {x}, {y}, {z} mm: radii are scaled by the smallest"));
    }
    let mut made = content.into_network(options.radius_rule, options.default_radius).map_err(|fault| fault.in_file(file))?;
    notes.append(&mut made.notes);
    let is_graph = contents == Contents::Graph;
    if is_graph {
        notes.extend(leave_out_pruned(&mut made.network));
    }
    if let Some(frame) = options.frame {
        let stated = made.network.frame;
        if stated.is_known() && stated != frame {
            let (given, own) = (frame.name().unwrap_or_default(), stated.name().unwrap_or_default());
            return Err(Error::parameter("frame", given, format!("the file states its frame, and its positions are in {own}")));
        }
        made.network.frame = frame;
    }
    let classes =
        made.lines.iter().filter(|_| lumen.is_some()).flat_map(|lines| (0..lines.links.len()).map(|row| lines.labels.of(row)));
    let is_topcow = are_topcow_classes(classes);
    if is_topcow {
        notes.push("the classes are those of the TopCoW challenge, and their vessels its arteries".to_owned());
    }
    if let Some(field_of_view) = options.field_of_view {
        let ends = mark_border(&mut made.network, field_of_view);
        notes.push(format!("{} at the border of the image's box", plural(ends, "free end")));
    }
    if is_graph && options.observed {
        (0..made.network.vessel_count()).for_each(|row| made.network.vessel_mut(row).origin = Origin::Observed);
    }
    let (input, units, frame) = (file.display().to_string(), options.scale.unit.symbol().to_owned(), made.network.frame);
    let provenance = Provenance { input, format: format.name().to_owned(), sha256, units, frame, notes, ..Provenance::default() };
    let is_fragments = !is_graph || options.observed;
    let (network, lines, format, options) = (made.network, made.lines, Some(format), options.clone());
    Ok(Input { network, contents, format, is_fragments, provenance, options, run, started, lines, lumen, is_topcow })
}

/// Leaves out the edges that a run pruned, as the table of its edges says by `kept`; what is said of it.
fn leave_out_pruned(network: &mut Network) -> Option<String> {
    let stays = |network: &Network, row: usize| network.vessel(row).kept != Some(false);
    let pruned = (0..network.vessel_count()).filter(|row| !stays(network, *row)).count();
    if pruned == 0 {
        return None;
    }
    *network = network.subgraph(|row| stays(network, row)).0;
    Some(format!("{} that a run pruned (kept is 0), left out", plural(pruned, "edge")))
}

/// Marks the free ends that are no further from a face of the box than their radius, or beyond it; how many there are.
fn mark_border(network: &mut Network, [low, high]: [Point; 2]) -> usize {
    let degree = network.degrees(|vessel| vessel.origin == Origin::Observed);
    let mut radius = vec![0.0; network.node_count()];
    for ([a, b], vessel) in network.vessels() {
        (radius[a], radius[b]) = (vessel.end_radius(false), vessel.end_radius(true));
    }
    let mut count = 0;
    for row in (0..network.node_count()).filter(|row| degree[*row] == 1) {
        let node = network.node_mut(row);
        let Some(at) = node.position else { continue };
        node.at_border = (0..3).any(|k| (at[k] - low[k]).min(high[k] - at[k]) <= radius[row]);
        count += usize::from(node.at_border);
    }
    count
}

/// Refuses options that do not go with what the file holds.
fn check_for(contents: Contents, format: Format, options: &ReadOptions) -> Result<()> {
    let refused = |name: &str, value: &str, why: &str| Err(Error::parameter(name, value, why));
    if options.field_of_view.is_some() && format.is_mask() {
        return refused("box", "", "goes with centerlines; a mask states its own");
    }
    let of_masks = [
        ("level", options.level.map(|level| level.to_string())),
        ("radius_from", (options.radius_from != RadiusFrom::default()).then(|| options.radius_from.name().to_owned())),
        ("cavities", (options.cavities == Cavities::Keep).then(|| "keep".to_owned())),
    ];
    if let Some((name, Some(value))) = of_masks.iter().find(|(_, value)| value.is_some() && !format.is_mask()) {
        return refused(name, value, "goes with a mask");
    }
    if !format.is_mask() {
        options.scale.check_coordinates()?;
    } else if options.scale.unit != LengthUnit::default() {
        return refused("units", options.scale.unit.symbol(), "goes with coordinates; those of a mask are in mm");
    } else if options.scale.spacing.is_some() && !format.is(FormatTrait::GivenSpacing) {
        let masks = Format::listed(FormatTrait::GivenSpacing, "or");
        return refused("spacing", "", &format!("goes with a {masks} mask; this file states its own"));
    }
    if let Some(name) = &options.radius_array {
        if !matches!(contents, Contents::Centerlines(_)) {
            return refused("radius_array", name, "goes with centerlines; the vessels of this input state their radii");
        }
        if !format.is(FormatTrait::NamedRadii) {
            let known = Format::listed(FormatTrait::NamedRadii, "and");
            return refused("radius_array", name, &format!("goes with {known}; {} has one radius for each point", format.name()));
        }
    }
    if options.radius_rule != RadiusRule::default() && contents == Contents::Graph && !options.observed {
        return refused("radius", "effective", "goes with centerlines; the vessels of a graph have one radius each");
    }
    if options.observed && contents != Contents::Graph {
        return refused("observed", "", "goes with a candidate graph; these vessels are observed anyway");
    }
    Ok(())
}

impl Input {
    /// A network that the caller made. Candidates are built around its vessels where all are observed.
    pub fn from_network(network: Network) -> Self {
        let is_fragments = network.vessels().all(|(_, vessel)| vessel.origin == Origin::Observed);
        Self {
            contents: if is_fragments { Contents::Vessels } else { Contents::Graph },
            network,
            format: None,
            is_fragments,
            provenance: Provenance::default(),
            options: ReadOptions::default(),
            run: None,
            started: Instant::now(),
            lines: None,
            lumen: None,
            is_topcow: false,
        }
    }

    /// The same, with the command line that repeats its run.
    #[must_use]
    pub fn with_command(mut self, command: String) -> Self {
        self.provenance.command = command;
        self
    }

    /// Whether it was read from the folder of a run of infer.
    pub fn is_run(&self) -> bool {
        self.run.is_some()
    }

    /// What outlets are that are found: terminal resistances at the ends of centerlines, where arteries go on outside of the image. A ready
    /// graph states the ends of its arteries; what it does not state is ground, as in the paper.
    pub(crate) fn usual_outlets(&self) -> FoundOutlets {
        if self.is_fragments { FoundOutlets::CEREBRAL } else { FoundOutlets::Ground }
    }

    /// The nodes where blood comes in by the names of arteries on the vessels; none where labels are numbers, which may mean anything.
    pub(crate) fn inlets_by_labels(&self) -> Vec<usize> {
        if self.network.vessels().all(|(_, vessel)| vessel.label.is_empty()) {
            return Vec::new();
        }
        let network = if self.is_fragments { &self.divided_by_labels() } else { &self.network };
        let labels = network.vessels().map(|(_, vessel)| vessel.label.as_str());
        let named = LabelScheme::of(labels).ok().filter(|scheme| *scheme == LabelScheme::Names);
        let circle = named.and_then(|scheme| Circle::labelled(network, scheme).ok());
        circle.map_or_else(Vec::new, |(circle, _)| circle.labelled_inlets(network))
    }

    /// The vessels, divided where their labels change along the centerlines.
    pub(crate) fn divided_by_labels(&self) -> Network {
        match &self.lines {
            Some(lines) => split_where_labels_change(&self.network, lines, self.options.radius_rule),
            None => self.network.clone(),
        }
    }
}
