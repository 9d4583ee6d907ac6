//! Where the arteries of a Circle of Willis are in a network, and what its plausible topologies say of them.

use std::{io::Write, path::Path, sync::Arc};

use serde::{Deserialize, Serialize};

use super::{ArterySource, PhenotypeOptions, SourceFile};
use crate::{FoundOutlets, LabelScheme, Network, Result, SamplingOptions, Scale};
use willis_core::decision::{KnownEnds, Topologies, TopologySource, has_evidence};
use willis_core::network::{Condition, ConditionFrom, Role};
use willis_core::{error::Fault, flow::Boundary, flow::boundary_conditions::stated, support::marked};
use willis_io::{formats::LandmarkFormat, formats::read_landmarks, output::names::LANDMARKS, output::write_file};
use willis_models::circle_of_willis::{
    Circle, Collateral, LEAST_DIAMETER, Posterior, Variant, artery_of_label, collaterals, hypoplastic, identify_landmarks,
    in_axes_of, segment_diameters,
};
use willis_models::naming::{Bearings, NamedCircle, Names, NamingModels, nothing_named};
use willis_report::CircleFigures;

impl ArterySource {
    /// Labels or geometry in the place of [`ArterySource::Automatic`], by what an input has.
    #[must_use]
    pub(crate) fn resolved(&self, network: &Network, is_topcow: bool) -> Self {
        let labels = || network.vessels().map(|(_, vessel)| vessel.label.as_str());
        match self {
            Self::Automatic | Self::AnyLabels if is_topcow => return Self::Labels(LabelScheme::TopCow),
            Self::Automatic => {}
            given => return given.clone(),
        }
        // Labels that two lists have are for a person to say.
        let named = LabelScheme::of(labels()).map(|scheme| labels().any(|label| artery_of_label(label, scheme).is_some()));
        if named.unwrap_or(true) { Self::AnyLabels } else { Self::Geometry }
    }

    /// Finds the arteries in the network of an input.
    pub(crate) fn find(&self, input: &Path, network: &Network, scale: &Scale, known: &PhenotypeOptions) -> Result<FoundArteries> {
        let scheme = match self {
            Self::Landmarks(file) => return by_landmarks(file, network, scale),
            Self::Geometry | Self::Automatic => return by_geometry(input, network, None, &known.models()?),
            Self::Labels(scheme) => *scheme,
            Self::AnyLabels => {
                let labels = network.vessels().map(|(_, vessel)| vessel.label.as_str());
                LabelScheme::of(labels).map_err(|fault| fault.in_file(input))?
            }
        };
        let (circle, notes) = Circle::labelled(network, scheme).map_err(|fault| fault.in_file(input))?;
        Ok(FoundArteries::of(circle, scheme.name(), notes))
    }
}

fn by_landmarks(file: &Path, network: &Network, scale: &Scale) -> Result<FoundArteries> {
    let (bytes, source) = SourceFile::read(file)?;
    let here = |fault: Fault| fault.in_file(file);
    let list = read_landmarks(&bytes, scale).map_err(here)?;
    let format = list.format;
    let (listed, mut notes) = in_axes_of(network, list);
    let landmarks = identify_landmarks(listed).map_err(here)?;
    let (circle, found) = Circle::at(network, &landmarks).map_err(here)?;
    notes.extend(found);
    let copy = String::from_utf8(bytes).ok().map(|text| (format, text));
    Ok(FoundArteries { landmarks: Some(source), copy, ..FoundArteries::of(circle, "landmarks", notes) })
}

/// The arteries of a network by their geometry; `like` says where the same network with fewer vessels was found to lie.
pub fn by_geometry(input: &Path, network: &Network, like: Option<&Bearings>, models: &NamingModels) -> Result<FoundArteries> {
    let names = like.map_or_else(|| models.name(network), |bearings| models.name_again(network, bearings));
    let here = |fault: Fault| fault.in_file(input);
    let names = names.ok_or_else(|| nothing_named(network)).map_err(here)?;
    let model = models.of(&names);
    let (circle, notes) = names.located(network, model).map_err(here)?;
    let named = Some(names.circle(model));
    Ok(FoundArteries { named, names: Some(Arc::new(names)), ..FoundArteries::of(circle, "geometry", notes) })
}

/// Where the arteries are, and how that is known.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FoundArteries {
    pub(crate) circle: Circle,
    /// `names`, `icafe`, `topcow` or `landmarks`.
    pub(crate) known_by: String,
    pub(crate) landmarks: Option<SourceFile>,
    /// What that file holds.
    copy: Option<(LandmarkFormat, String)>,
    pub(crate) notes: Vec<String>,
    /// What names say of the segments, where the arteries are known by their geometry, or by landmarks in a circle that has names.
    pub(crate) named: Option<NamedCircle>,
    /// The names of all nodes, just found by geometry; they are not stored.
    #[serde(skip)]
    pub(crate) names: Option<Arc<Names>>,
}

impl FoundArteries {
    fn of(circle: Circle, known_by: &str, notes: Vec<String>) -> Self {
        Self { circle, known_by: known_by.to_owned(), landmarks: None, copy: None, notes, named: None, names: None }
    }

    /// The same with what names by geometry say of the segments, where the arteries are known by landmarks: a person says where arteries
    /// enter and leave, and which side is which; names say what lies between.
    pub fn with_names(self, graph: &Network, known: &PhenotypeOptions) -> Result<Self> {
        if self.landmarks.is_none() || !has_evidence(graph) {
            return Ok(self);
        }
        let models = known.models()?;
        let Some(names) = models.name(graph).filter(Names::is_circle) else { return Ok(self) };
        let named = names.circle(models.of(&names));
        // A person knows which side is which. Geometry does not in a mirrored file.
        let places = self.circle.sided_nodes().into_iter();
        let places: Vec<_> = places.filter_map(|(side, node)| Some((side, graph.node(node).position?))).collect();
        if names.is_mirrored(&places) {
            let note = "left and right are as the landmarks say; by the axes of the input they would be exchanged".to_owned();
            let notes = self.notes.iter().cloned().chain([note]).collect();
            return Ok(Self { named: Some(named.mirrored()), notes, ..self });
        }
        Ok(Self { named: Some(named), ..self })
    }

    /// Writes a copy of the landmarks into the folder of a run, so that the folder can be asked again wherever it is.
    pub fn write_landmarks(&self, folder: &Path) -> Result<()> {
        let Some((format, text)) = &self.copy else { return Ok(()) };
        // In the order of the formats.
        write_file(&folder.join(LANDMARKS[*format as usize]), |out| out.write_all(text.as_bytes()))
    }

    /// What topologies say of the circle, with what names say where the arteries were named.
    pub fn posterior_from(&self, network: &Network, topologies: &Topologies, known: &PhenotypeOptions) -> Result<Posterior> {
        let Some(named) = &self.named else { return Ok(Posterior::of(&self.circle, network, topologies)) };
        let prior = known.prior()?;
        let presence = |topologies: &[f64; 7]| named.presence(topologies, &prior);
        Ok(Posterior::informed(&self.circle, network, topologies, Some((&presence, named.not_seen()))))
    }

    /// The figures of a `variant` in the topology of the vessels `kept`; diameters are by name where the arteries were named, else by vessel.
    pub fn circle_figures(&self, network: &Network, variant: &Variant, kept: &[bool], known: &PhenotypeOptions) -> CircleFigures {
        let seen = segment_diameters(&self.circle, network, |row| kept.get(row).is_some_and(|kept| *kept));
        let named = self.named.as_ref().map_or([None; 7], |named| named.diameters);
        let diameters = std::array::from_fn(|s| named[s].or(seen[s]));
        let thin = hypoplastic(&diameters, known.hypoplastic.unwrap_or(LEAST_DIAMETER));
        CircleFigures::of(variant, &diameters, thin)
    }

    /// The conditions of a network whose arteries these are, where no run has any; outlets that are not stated are `outlets`.
    pub fn boundary(&self, network: &Network, outlets: FoundOutlets) -> Result<Boundary> {
        let mut network = network.clone();
        self.state_inlets(&mut network);
        Boundary::resolve_knowing(&network, &stated(&network), outlets, &self.circle.labelled_inlets(&network))
    }

    /// What the loss of each feeder means to the topology of the vessels `kept`; outlets that are not stated are `outlets`. Viscosity in
    /// Pa s.
    pub fn collaterals(&self, graph: &Network, kept: &[bool], outlets: FoundOutlets, viscosity: f64) -> Result<Vec<Collateral>> {
        let mut graph = graph.clone();
        self.name_outlets(&mut graph);
        let boundary = self.boundary(&graph, outlets)?;
        self.state_inlets(&mut graph);
        let boundary = boundary.held(&graph, |row| kept[row]);
        collaterals(&self.circle, &graph, |row| kept[row], &boundary, viscosity)
    }

    /// Makes inlets of the landmarks where blood comes in, unless the input states what they are.
    pub fn state_inlets(&self, network: &mut Network) {
        for node in self.circle.inlets() {
            let node = network.node_mut(node);
            if node.condition.is_none() || node.condition_from == ConditionFrom::FreeEnd {
                (node.role, node.condition) = (Some(Role::Inlet), Some(Condition::INLET));
                node.condition_from = ConditionFrom::Statement;
            }
        }
    }

    /// Makes outlets of the landmarks where blood leaves, unless the input states what they are. Their condition is left to
    /// [`Boundary::resolve`], which gives them that of an outlet found; but they are stated.
    pub fn name_outlets(&self, network: &mut Network) {
        for node in self.circle.outlets() {
            let node = network.node_mut(node);
            if node.condition.is_none() {
                node.role = Some(Role::Outlet);
            }
        }
    }
}

/// The plausible topologies, and how they were drawn: by the evidence, where `ends_go_on` as if no vessel ended where nobody knows of an
/// end; without evidence those that the samples vote for, by the vessels `above_median`. `given` are the nodes whose conditions were stated.
/// Names weigh the odds of candidates, and arteries say of ends, where they were found.
pub fn draw_topologies(
    found: Option<&FoundArteries>,
    network: &Network,
    boundary: &Boundary,
    options: &SamplingOptions,
    given: &[usize],
    above_median: Option<&[bool]>,
    ends_go_on: bool,
) -> Result<(Topologies, String)> {
    let weighed = found.and_then(|found| found.named.as_ref()).map(|named| named.weighed(network));
    let network = weighed.as_ref().unwrap_or(network);
    let ends = found.map_or_else(Vec::new, |found| found.circle.ends(network));
    let ends = ends.iter().chain(given).copied().filter(|node| *node < network.node_count());
    let mut inlets = found.map_or_else(Vec::new, |found| found.circle.inlets());
    if !inlets.is_empty() {
        inlets.extend(given.iter().filter(|node| boundary.roles.get(**node) == Some(&Role::Inlet)));
    }
    let ends = KnownEnds { ends: &marked(network.node_count(), ends), inlets: &inlets };
    let (draw, how) = match above_median {
        None if ends_go_on => (TopologySource::FreeEnds(ends), "whose free ends continue by the evidence"),
        None => (TopologySource::Connections(ends), "by the probabilities of their connections"),
        Some(above) => (TopologySource::Samples(above), "that samples vote for by their resilience"),
    };
    let topologies = Topologies::draw(network, boundary, options, draw)?;
    let how = format!("{} plausible topologies, {how}", topologies.samples);
    Ok((topologies, how))
}
