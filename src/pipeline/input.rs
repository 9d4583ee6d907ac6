//! Reading: from a file of any format, or the folder of a run, to a network of vessels.

use std::{collections::BTreeSet, path::Path, path::PathBuf, time::Instant};

use serde_json::Value;

use super::{ArterySource, RunOptions, arteries::FoundArteries, require, require_in};
use crate::{Cavities, Error, FoundOutlets, LabelScheme, LengthUnit, Network, RadiusFrom, RadiusRule, ReadOptions, Result};
use willis_core::network::{Origin, Vessel, centerlines::Centerlines, units::millimetres};
use willis_core::{
    error::Fault, error::in_few_digits, support::geometry::Point, support::geometry::apart, support::geometry::bounds,
};
use willis_io::formats::{
    Content, Document, Format, FormatTrait, bytes_of, is_there, open_regular, read as read_file, read_bytes as read_file_bytes,
};
use willis_io::output::names::{COHORT, EDGES, GRAPH, LANDMARKS, RECORD, TOPOLOGY};
use willis_io::{formats::tables::reader::TableReader, formats::tables::reader::plural, masks::Foreground, output::read_json};
use willis_models::circle_of_willis::{Circle, are_topcow_classes, artery_of_label, split_where_labels_change};
use willis_report::Provenance;

/// A network and where it comes from: what every other function of this crate starts from.
#[derive(Debug, Clone)]
pub struct Input {
    /// The vessels; lengths in m. Along centerlines whose labels name arteries they are divided where the label changes.
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
    /// The vessels as they branch alone, where `network` divides them by their labels.
    undivided: Option<Network>,
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
    read_as(path, options, false)
}

/// As [`read`], but of a folder that [`infer`](crate::infer) saved the run: its over-connected graph, with what was found by sampling it.
///
/// # Errors
///
/// As [`read`], or a graph that is not the one that was sampled.
pub fn read_run(path: &Path, options: &ReadOptions) -> Result<Input> {
    read_as(path, options, true)
}

/// A file, or of the folder of a run the graph that was sampled (`as_run`), else the plausible topology.
fn read_as(path: &Path, options: &ReadOptions, as_run: bool) -> Result<Input> {
    let started = Instant::now();
    options.validate()?;
    if !path.is_dir() {
        return made_of(read_file(path, options)?, path, options, started, None);
    }
    let run = StoredRun::read(path)?;
    let file = if as_run { run.graph.clone() } else { path.join(format!("{TOPOLOGY}.graphml")) };
    open_regular(&file)?;
    let mut document = read_file(&file, options)?;
    if !as_run {
        document.notes.insert(0, format!("the plausible topology of a run; {} has all candidates", run.graph.display()));
    }
    made_of(document, &file, options, started, as_run.then_some(run))
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
    if let Some(run) = run.as_ref().filter(|run| run.sha256 != sha256) {
        let found = "not the graph that was sampled: its SHA-256 is not that of run.json";
        return Err(Fault::file(found, "expected it unedited").in_file(&run.graph));
    }
    let unequal = options.scale.spacing.filter(|[x, y, z]| !format.is_mask() && (x != y || y != z));
    let lengths = if let Contents::Centerlines(_) = contents { "" } else { ", and a length in voxels is that of the course" };
    notes.extend(unequal.map(|[x, y, z]| format!("unequal spacing {x}, {y}, {z} mm: radii are scaled by the smallest{lengths}")));
    let mut made = content.into_network(options.radius_rule, options.default_radius).map_err(|fault| fault.in_file(file))?;
    if let Some(run) = run.as_ref().filter(|run| !run.fits(&made.network)) {
        let found = "arteries, or nodes with conditions, that are not of the graph that was sampled";
        return Err(Fault::file(found, "expected it unedited").in_file(&run.graph.with_file_name(RECORD)));
    }
    notes.append(&mut made.notes);
    let is_graph = contents == Contents::Graph;
    // Edges that a run pruned, as the table of its edges says by `kept`, are left out.
    let stays = |network: &Network, row: usize| network.vessel(row).kept != Some(false);
    let pruned = (0..made.network.vessel_count()).filter(|row| !stays(&made.network, *row)).count();
    if is_graph && pruned > 0 {
        made.network = made.network.subgraph(|row| stays(&made.network, row)).0;
        notes.push(format!("{} that a run pruned (kept is 0), left out", plural(pruned, "edge")));
    }
    if let Some(frame) = options.frame {
        let stated = made.network.frame;
        let (given, own) = (frame.name().unwrap_or_default(), stated.name().unwrap_or_default());
        let accepted = format!("the file states its frame, and its positions are in {own}");
        require(!stated.is_known() || stated == frame, "frame", given, accepted)?;
        made.network.frame = frame;
    }
    let classes =
        made.lines.iter().filter(|_| lumen.is_some()).flat_map(|lines| (0..lines.links.len()).map(|row| lines.labels.of(row)));
    let is_topcow = are_topcow_classes(classes);
    notes.extend(is_topcow.then(|| "the classes are those of the TopCoW challenge, and their vessels its arteries".to_owned()));
    if is_graph && options.observed {
        (0..made.network.vessel_count()).for_each(|row| made.network.vessel_mut(row).origin = Origin::Observed);
    }
    if let Some(field_of_view) = options.field_of_view {
        let of = |ends: [usize; 2], vessel: &Vessel| {
            let nodes = ends.into_iter().filter_map(|node| made.network.node(node).position);
            apart(bounds(nodes.chain(vessel.path.iter().map(|point| point.position))), field_of_view)
        };
        let nearest = made.network.vessels().map(|(ends, vessel)| of(ends, vessel)).fold(f64::INFINITY, f64::min);
        let away = in_few_digits(format!("{:.1}", millimetres(nearest)));
        let accepted = format!(
            "no vessel lies in it, the nearest {away} mm away; expected that of the image, in mm and the frame of the file"
        );
        require(nearest == 0.0 || nearest.is_infinite(), "box", "", accepted)?;
        let ends = mark_border(&mut made.network, field_of_view);
        notes.push(format!("{} at the border of the image's box", plural(ends, "free end")));
    }
    let unit = options.scale.in_unit(made.lines.as_ref().and_then(|lines| lines.unit)).unit;
    let (input, units, frame) = (file.display().to_string(), unit.symbol().to_owned(), made.network.frame);
    let provenance = Provenance { input, format: format.name().to_owned(), sha256, units, frame, notes, ..Provenance::default() };
    let is_fragments = !is_graph || options.observed;
    let (network, lines, format, options) = (made.network, made.lines, Some(format), options.clone());
    let undivided = None;
    let mut input =
        Input { network, contents, format, is_fragments, provenance, options, run, started, lines, undivided, lumen, is_topcow };
    if input.lines.as_ref().is_some_and(name_arteries) {
        let divided = input.divided_by_labels();
        input.undivided = Some(std::mem::replace(&mut input.network, divided));
    } else if made.mixed_labels > 0 {
        let vessels = plural(made.mixed_labels, "vessel");
        input.provenance.notes.push(format!("{vessels} with more than one label along them: took that of the longest part"));
    }
    Ok(input)
}

/// Whether there are labels that are names, and some of them those of arteries.
fn name_arteries(lines: &Centerlines) -> bool {
    let labels: BTreeSet<&str> = (0..lines.links.len()).map(|row| lines.labels.of(row)).collect();
    let scheme = LabelScheme::of(labels.iter().copied());
    scheme.is_ok_and(|scheme| scheme == LabelScheme::Names && labels.iter().any(|label| artery_of_label(label, scheme).is_some()))
}

/// Marks the free ends that are no further from a face of the box than their radius, or beyond it; how many there are.
fn mark_border(network: &mut Network, [low, high]: [Point; 2]) -> usize {
    let degree = network.degrees(|vessel| vessel.origin == Origin::Observed);
    let mut radius = vec![0.0; network.node_count()];
    for ([a, b], vessel) in network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Observed) {
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
    let has_no_box = options.field_of_view.is_none() || !format.is_mask();
    require(has_no_box, "box", "", "goes with centerlines; a mask states its own")?;
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
        let accepted = "goes with centerlines; the vessels of this input state their radii";
        require(matches!(contents, Contents::Centerlines(_)), "radius_array", name, accepted)?;
        let known = Format::listed(FormatTrait::NamedRadii, "and");
        let accepted = format!("goes with {known}; {} has one radius for each point", format.name());
        require(format.is(FormatTrait::NamedRadii), "radius_array", name, accepted)?;
    }
    if options.radius_rule != RadiusRule::default() && contents == Contents::Graph && !options.observed {
        return refused("radius", "effective", "goes with centerlines; the vessels of a graph have one radius each");
    }
    let is_graph = contents == Contents::Graph;
    require(!options.observed || is_graph, "observed", "", "goes with a candidate graph; these vessels are observed anyway")
}

impl Input {
    /// A network that the caller made, which every function checks ([`Network::validate`]). Candidates are built around its vessels where all are
    /// observed.
    pub fn from_network(network: Network) -> Self {
        let is_fragments = network.vessels().all(|(_, vessel)| vessel.origin == Origin::Observed);
        let contents = if is_fragments { Contents::Vessels } else { Contents::Graph };
        Self {
            network,
            contents,
            format: None,
            is_fragments,
            provenance: Provenance::default(),
            options: ReadOptions::default(),
            run: None,
            started: Instant::now(),
            lines: None,
            undivided: None,
            lumen: None,
            is_topcow: false,
        }
    }

    /// Whether the file says in which unit its lengths are, as masks do.
    pub fn states_unit(&self) -> bool {
        self.format.is_some_and(Format::is_mask) || self.lines.as_ref().is_some_and(|lines| lines.unit.is_some())
    }

    /// The same, with the command line that repeats its run.
    #[must_use]
    pub fn with_command(mut self, command: String) -> Self {
        self.provenance.command = command;
        self
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
        let network = &self.network;
        let labels = network.vessels().map(|(_, vessel)| vessel.label.as_str());
        let named = LabelScheme::of(labels).ok().filter(|scheme| *scheme == LabelScheme::Names);
        let circle = named.and_then(|scheme| Circle::labelled(network, scheme).ok());
        circle.map_or_else(Vec::new, |(circle, _)| circle.labelled_inlets(network))
    }

    /// The same with the vessels among which candidates are built: where arteries are found by labels, divided where these change, otherwise as
    /// they branch.
    #[must_use]
    pub(crate) fn for_arteries(mut self, source: Option<&ArterySource>) -> Self {
        if matches!(source, Some(ArterySource::AnyLabels | ArterySource::Labels(_))) && self.is_fragments {
            let divided = self.divided_by_labels();
            let before = std::mem::replace(&mut self.network, divided);
            self.undivided.get_or_insert(before);
        } else if let Some(undivided) = self.undivided.take() {
            self.network = undivided;
        }
        self
    }

    /// The centerlines whose labels divide vessels.
    pub(crate) fn named_lines(&self) -> Option<Centerlines> {
        self.undivided.as_ref().and(self.lines.clone())
    }

    /// The vessels as they branch, whatever their labels.
    pub(crate) fn undivided(&self) -> &Network {
        self.undivided.as_ref().unwrap_or(&self.network)
    }

    /// The vessels, divided where their labels change along the centerlines.
    pub(crate) fn divided_by_labels(&self) -> Network {
        let Some(lines) = &self.lines else { return self.network.clone() };
        split_where_labels_change(&self.network, lines, self.options.radius_rule)
    }
}

/// A run of infer in a folder.
#[derive(Debug, Clone)]
pub(crate) struct StoredRun {
    /// Its over-connected graph.
    pub(crate) graph: PathBuf,
    pub(crate) options: RunOptions,
    /// Samples that were taken, or that an enumeration was scaled to.
    pub(crate) samples: u64,
    /// Nodes whose conditions were stated, not found.
    pub(crate) given: Vec<usize>,
    /// The SHA-256 of its landmarks.
    pub(crate) landmarks: Option<String>,
    /// Its arteries, where it found them by their geometry.
    pub(crate) named: Option<FoundArteries>,
    /// The SHA-256 of its input.
    pub(crate) input_sha256: String,
    sha256: String,
}

impl StoredRun {
    /// The run in a folder.
    ///
    /// # Errors
    ///
    /// A folder that infer did not write.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        const EXPECTED: &str = "expected a folder that willis infer wrote for one occlusion probability";
        let wrong = |found: &str| Fault::file(found, EXPECTED).in_file(folder);
        let path = folder.join(RECORD);
        let is_cohort = is_there(&folder.join(COHORT));
        require_in(folder, !is_cohort, "a cohort", "give one of its subjects, which are folders in it")?;
        require_in(folder, is_there(&path), "a folder without run.json", EXPECTED)?;
        let mut record: Value = read_json(&path, "expected the record of willis infer")?;
        let text = |value: &Value| value.as_str().map(str::to_owned);
        let sha256 = text(&record["graph"]["sha256"]).ok_or_else(|| wrong("a run without a graph of candidates"))?;
        let unlike = || wrong("parameters that are not those of willis infer");
        record.get("input").ok_or_else(unlike)?;
        let mut options: RunOptions = serde_json::from_value(record["options"].take()).map_err(|_| unlike())?;
        let named = serde_json::from_value(record["named"].take()).map_err(|_| unlike())?;
        let samples = record["parameters"]["samples"].as_u64().ok_or_else(unlike)?;
        let conditions = record["boundary_conditions"].as_array().ok_or_else(unlike)?;
        let of = |condition: &Value| Some((condition["found"].as_bool()?, condition["node"].as_u64()? as usize));
        let conditions: Vec<(bool, usize)> = conditions.iter().map(of).collect::<Option<_>>().ok_or_else(unlike)?;
        let given = conditions.into_iter().filter(|(is_found, _)| !is_found).map(|(_, node)| node).collect();
        let copy = LANDMARKS.iter().map(|name| folder.join(name)).find(|path| is_there(path));
        copy.as_deref().map(open_regular).transpose()?;
        if let (Some(ArterySource::Landmarks(path)), Some(copy)) = (&mut options.infer.arteries, copy) {
            *path = copy;
        }
        let landmarks = text(&record["parameters"]["landmarks"]["sha256"]);
        let (graph, input_sha256) = (folder.join(GRAPH), text(&record["input"]["sha256"]).unwrap_or_default());
        Ok(Self { graph, options, samples, given, landmarks, named, input_sha256, sha256 })
    }

    /// Whether its arteries and conditions may be those of a graph, by the numbers of its vessels and nodes.
    fn fits(&self, graph: &Network) -> bool {
        self.named.as_ref().is_none_or(|found| found.circle.fits(graph))
            && self.given.iter().all(|node| *node < graph.node_count())
    }

    /// Per vessel of the graph whether the run kept it.
    ///
    /// # Errors
    ///
    /// A table of vessels that cannot be read, or that is not of that graph.
    pub(crate) fn kept(&self, vessels: usize) -> Result<Vec<bool>> {
        let file = self.graph.with_file_name(EDGES);
        let here = |fault: Fault| fault.in_file(&file);
        let bytes = bytes_of(&file)?;
        let mut rows = TableReader::ragged(&bytes).map_err(here)?;
        let column =
            rows.find(&["kept"]).ok_or_else(|| here(Fault::file("no column kept", "expected it as the run wrote it")))?;
        let mut kept = Vec::with_capacity(vessels);
        while let Some(row) = rows.row().map_err(here)? {
            kept.push(row.text(column) == "1");
        }
        let (found, accepted) = (format!("{} rows", kept.len()), format!("expected one for each of {vessels} vessels"));
        require_in(&file, kept.len() == vessels, found, accepted)?;
        Ok(kept)
    }
}
