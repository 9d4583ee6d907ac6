//! What is measured of an input: its vessels, bifurcations, ends, and the whole, with the doubt about its topology where there is a run.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::arteries::FoundArteries;
use super::artery_options::{ArterySource, PhenotypeOptions};
use super::classify::above_median;
use super::{BoundaryOptions, Follow, Input};
use willis_core::decision::{KnownEnds, Topologies, TopologySource};
use willis_core::error::{Error, Fault, Result};
use willis_core::flow::Boundary;
use willis_core::morphometry::{MeasureContext, Morphometry, Region, SMOOTHING, Smoothing, network_figures};
use willis_core::network::units::{metres, millimetres};
use willis_core::network::{Network, Role};
use willis_core::sampling::SamplingOptions;
use willis_core::support::geometry::{bounds, cross, dot, norm_squared};
use willis_io::formats::{Column, ReadOptions, read_image};
use willis_io::masks::Picture;
use willis_models::circle_of_willis::present_vessels;
use willis_report::cohort::Figures;
use willis_report::{CircleFigures, MeasuredSubject, NamedFigures, named_figures};

/// So many topologies of a run are drawn.
const DRAWN: u64 = 200;

/// How vessels are measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureOptions {
    /// Where blood enters, from which orders and ways are counted.
    pub boundary: BoundaryOptions,
    /// The length over which courses are smoothed before bends are measured, m; six radii of each vessel without it.
    pub smoothing: Option<f64>,
    /// A mask of the brain, to which densities refer.
    pub brain: Option<PathBuf>,
    /// The diameter below which a segment of the circle is hypoplastic, m; 1 mm without it.
    pub hypoplastic: Option<f64>,
}

impl MeasureOptions {
    /// Checks the lengths.
    ///
    /// # Errors
    ///
    /// A length that is not positive.
    pub fn validate(&self) -> Result<()> {
        self.phenotypes().validate()?;
        match self.smoothing {
            Some(length) if !(length.is_finite() && length > 0.0) => {
                Err(Error::parameter("smoothing", millimetres(length), "expected a positive length, in mm"))
            }
            _ => Ok(()),
        }
    }

    fn smoothing(&self) -> Smoothing {
        self.smoothing.map_or(Smoothing::Radii(SMOOTHING), Smoothing::Length)
    }

    fn phenotypes(&self) -> PhenotypeOptions {
        PhenotypeOptions { hypoplastic: self.hypoplastic, ..PhenotypeOptions::default() }
    }
}

/// What was measured of an input.
#[derive(Debug)]
pub struct Measurement {
    name: String,
    /// The SHA-256 of the file that was read.
    pub sha256: String,
    network: Network,
    roles: Vec<Role>,
    /// Vessel by vessel, and the whole.
    pub measured: Morphometry,
    /// The figures of the whole.
    pub figures: NamedFigures,
    /// Those of each plausible topology of a run, with its weight.
    pub plausible: Vec<(NamedFigures, f64)>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Measures the vessels of an input, as subject `name`; of a run, as [`read_run`](crate::read_run) has it, the plausible topology, and
/// beside it those that are plausible too.
///
/// # Errors
///
/// An option out of its range, a condition at a node that is not there, a mask of the brain that cannot be read or holds none.
pub fn measure(name: &str, input: &Input, options: &MeasureOptions, progress: &mut dyn Follow) -> Result<Measurement> {
    options.validate()?;
    let mut notes = Vec::new();
    let (network, kept): (Cow<'_, Network>, Vec<bool>) = if let Some(run) = &input.run {
        (Cow::Borrowed(&input.network), run.kept(input.network.vessel_count())?)
    } else {
        let network = if input.is_fragments { Cow::Owned(input.divided_by_labels()) } else { Cow::Borrowed(&input.network) };
        let (present, note) = present_vessels(&network);
        notes.extend(note.map(str::to_owned));
        let network = network.subgraph(|row| present[row]).0;
        let all = vec![true; network.vessel_count()];
        (Cow::Owned(network), all)
    };
    let network = &*network;
    let outlets = options.boundary.found_outlets.unwrap_or_else(|| input.usual_outlets());
    let boundary = match options.boundary.resolve(network, outlets, &input.inlets_by_labels(), progress) {
        Ok(boundary) => Some(boundary),
        // A ring has no end to enter by: it has no orders, but a length.
        Err(why) if !options.boundary.states_an_inlet() => {
            notes.push(format!("no orders and no ways from inlets: {why}"));
            None
        }
        Err(why) => return Err(why),
    };
    if !network.has_positions() {
        notes.push("nodes without positions: no chords, bends, angles and boxes".to_owned());
    }
    let brain = options.brain.as_ref().map(|path| brain(path, &input.options, network)).transpose()?;
    let phenotypes = options.phenotypes();
    let found = arteries(input, network, &phenotypes, &mut notes);
    let mut territory = vec![None; if found.is_some() { network.vessel_count() } else { 0 }];
    if let Some(found) = &found {
        for (at, rows) in found.circle.arteries_in(network, |_| true).1.territories.iter().enumerate() {
            for row in rows {
                territory[*row] = Some(at);
            }
        }
    }
    let measuring = Measuring { network, boundary, region: brain.as_ref(), territory, found, phenotypes };
    let plausible = measuring.plausible(input, progress)?.into_iter();
    let plausible = plausible.map(|(kept, weight)| (measuring.figures(&kept), weight)).collect();
    let (part, rows) = network.subgraph(|row| kept[row]);
    let roles = measuring.roles(&kept);
    let territory = measuring.territory_of(&rows);
    let around = MeasureContext { territory: &territory, region: brain.as_ref() };
    let measured = Morphometry::of(&part, |node| roles[node], options.smoothing(), around);
    let figures = named_figures(&measured.network, measuring.circle(&kept).as_ref());
    let sha256 = input.provenance.sha256.clone();
    Ok(Measurement { name: name.to_owned(), sha256, network: part, roles, measured, figures, plausible, notes })
}

/// A network whose topologies are measured.
struct Measuring<'a> {
    network: &'a Network,
    /// Where blood enters and leaves, where any does.
    boundary: Option<Boundary>,
    region: Option<&'a Region>,
    /// By vessel; none at all without arteries.
    territory: Vec<Option<usize>>,
    found: Option<FoundArteries>,
    phenotypes: PhenotypeOptions,
}

impl Measuring<'_> {
    fn roles(&self, kept: &[bool]) -> Vec<Role> {
        let none = || vec![Role::Inner; self.network.node_count()];
        self.boundary.as_ref().map_or_else(none, |boundary| boundary.held(self.network, |row| kept[row]).roles)
    }

    fn territory_of(&self, rows: &[usize]) -> Vec<Option<usize>> {
        rows.iter().filter_map(|row| self.territory.get(*row)).copied().collect()
    }

    /// What is measured of the topology of the vessels `kept` as a whole.
    fn figures(&self, kept: &[bool]) -> NamedFigures {
        let (roles, (part, rows)) = (self.roles(kept), self.network.subgraph(|row| kept[row]));
        let territory = self.territory_of(&rows);
        let around = MeasureContext { territory: &territory, region: self.region };
        named_figures(&network_figures(&part, |node| roles[node], around), self.circle(kept).as_ref())
    }

    /// The circle in the topology of the vessels `kept`, where arteries are known.
    fn circle(&self, kept: &[bool]) -> Option<CircleFigures> {
        let found = self.found.as_ref()?;
        let variant = found.circle.variant(self.network, |row| kept[row]);
        Some(found.circle_figures(self.network, &variant, kept, &self.phenotypes))
    }

    /// The vessels of topologies that a run finds plausible, with their weights, by the probabilities of their connections.
    fn plausible(&self, input: &Input, progress: &mut dyn Follow) -> Result<Vec<(Vec<bool>, f64)>> {
        let (network, Some(run), Some(boundary)) = (self.network, &input.run, &self.boundary) else { return Ok(Vec::new()) };
        let options = SamplingOptions { samples: DRAWN, ..run.options.infer.sampling.clone() };
        let above = above_median(network, boundary, &options, progress)?;
        if let Some(found) = &self.found {
            return Ok(found.topologies(network, boundary, &options, &run.given, above.as_deref(), false)?.0.weighted);
        }
        let mut known = vec![false; network.node_count()];
        run.given.iter().filter(|node| **node < network.node_count()).for_each(|node| known[*node] = true);
        let source = match &above {
            None => TopologySource::Connections(KnownEnds { ends: &known, inlets: &[] }),
            Some(above) => TopologySource::Samples(above),
        };
        Ok(Topologies::draw(network, boundary, &options, source)?.weighted)
    }
}

/// Where the arteries are: as the run knew them, or by labels that name any.
fn arteries(input: &Input, network: &Network, phenotypes: &PhenotypeOptions, notes: &mut Vec<String>) -> Option<FoundArteries> {
    if let Some(named) = input.run.as_ref().and_then(|run| run.named.clone()) {
        return Some(named);
    }
    let of_run = input.run.as_ref().and_then(|run| run.options.infer.arteries.clone());
    let source = of_run.as_ref().unwrap_or(&ArterySource::Automatic).resolved(network, input.is_topcow);
    if source == ArterySource::Geometry {
        return None;
    }
    let scale = input.run.as_ref().map_or(&input.options.scale, |run| &run.options.read.scale);
    let found = source.find(Path::new(&input.provenance.input), network, scale, phenotypes);
    if let (Err(why), Some(_)) = (&found, &of_run) {
        notes.push(format!("nothing is told of a circle of Willis: {why}"));
    }
    found.ok()
}

/// The voxels of a mask that are not zero, around a network.
fn brain(path: &Path, options: &ReadOptions, network: &Network) -> Result<Region> {
    let (mut image, _) = read_image(path, options)?;
    image.values.iter_mut().for_each(|x| *x = f32::from(u8::from(*x != 0.0 && x.is_finite())));
    let columns = [0, 1, 2].map(|axis| image.affine.map(|row| row[axis]));
    let voxel = dot(columns[0], cross(columns[1], columns[2])).abs();
    let count = image.values.iter().filter(|x| **x > 0.0).count();
    let step = 0.5 * columns.iter().map(|column| norm_squared(*column).sqrt()).fold(f64::INFINITY, f64::min);
    let refused = |found: &str| Fault::file(found, "expected a mask of the brain around the vessels").in_file(path);
    if count == 0 {
        return Err(refused("no voxel above 0"));
    }
    let points = network.vessels().flat_map(|(_, vessel)| vessel.path.iter().map(|point| point.position));
    let places = points.chain(network.nodes().filter_map(|node| node.position));
    let picture = Picture::of(image, bounds(places), 0.0).ok_or_else(|| refused("does not reach the vessels"))?;
    let volume = count as f64 * voxel * metres(1.0).powi(3);
    Ok(Region { volume, step: metres(step), holds: Box::new(move |place| picture.value(place).is_some_and(|x| x >= 0.5)) })
}

impl Measurement {
    fn subject(&self) -> MeasuredSubject<'_> {
        MeasuredSubject { name: &self.name, network: &self.network, measured: &self.measured }
    }

    /// The columns of vessels.csv, bifurcations.csv, ends.csv and intervals.csv; the last has no row without a run.
    pub fn tables(&self) -> [Vec<Column>; 4] {
        let subject = self.subject();
        let ends = subject.ends(|node| self.roles[node]);
        [subject.vessels(), subject.bifurcations(), ends, subject.intervals(&self.figures, &self.plausible)]
    }

    /// The figures of its row in subjects.csv.
    pub fn row(&self) -> Figures {
        self.figures.iter().map(|(name, x)| (name.clone(), serde_json::json!(Some(*x).filter(|x| x.is_finite())))).collect()
    }
}
