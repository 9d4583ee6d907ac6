//! The method, from top to bottom: read, boundary conditions, candidates, samples, decision.

mod arteries;
mod boundary_options;
mod classify;
mod cuts;
pub mod decisions;
mod inference;
mod input;
mod label;
mod options;
mod picture;
mod prior;
mod progress;
mod pulse;
mod simulate;
mod stored_run;
mod write;

pub use arteries::ArterySource;
pub use boundary_options::{BoundaryOptions, parse_found_outlets};
pub use classify::{Phenotype, classify};
pub use cuts::Cut;
pub use decisions::ConnectionDecision;
pub use inference::Inference;
pub use input::{Contents, Input, read, read_bytes};
pub use label::{LabelOptions, Labelled, label};
pub use options::{FlowOptions, InferOptions, PhenotypeOptions, Preset, RunOptions, SaveOptions, SourceFile};
pub use prior::Prior;
pub use progress::{Progress, Silent, Step};
pub use pulse::{PulseMean, PulseOptions};
pub use simulate::{ModulationRun, SimulationRun, modulate, modulate_with, simulate, simulate_with};
pub use write::{WrittenFiles, write, write_target};

use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use arteries::FoundArteries;
use cuts::{Contacts, Cuts};
use willis_core::decision::{Keep, all_decided};
use willis_core::error::{Error, Fault, Result};
use willis_core::flow::{Boundary, FoundOutlets, Given};
use willis_core::network::{Condition, Network, Origin};
use willis_core::sampling::{FIRST_STABLE, FoundConditions, PartialRun, Sampling, SamplingOptions, Solver};
use willis_io::formats::{Format, checksum, checksum_of};
use willis_io::masks::Scene;
use willis_models::candidates::CandidateOptions;
use willis_models::candidates::kind::Kind;
use willis_models::naming::{Names, NamingModels};
use willis_report::{ImageCut, Provenance, Segmentation};

/// Finds the plausible topology of an input: exactly what `willis infer` does.
///
/// # Errors
///
/// An option out of its range, a file beside the input that cannot be read, no inlet or outlet, points that are crowded, a vessel whose
/// conductance no double can hold, a breakdown of the solver.
pub fn infer(input: &Input, options: &InferOptions) -> Result<Inference> {
    infer_with(input, options, &mut Silent)
}

/// As [`infer`], followed by `progress`, which may stop it.
///
/// # Errors
///
/// As [`infer`], or [`Error::Stopped`].
pub fn infer_with(input: &Input, options: &InferOptions, progress: &mut dyn Progress) -> Result<Inference> {
    prepare(input.clone(), options, progress)?.sample(&options.sampling, progress)
}

/// The over-connected graph of an input: its vessels and the candidates around them, with their priors and boundary conditions.
///
/// # Errors
///
/// As [`infer`].
pub fn candidates(input: &Input, options: &InferOptions) -> Result<Network> {
    let prepared = prepare(input.clone(), options, &mut Silent)?;
    Ok(prepared.boundary.stated_in(prepared.graph.clone()))
}

/// What may help where a graph leaves nothing to decide.
const NOTHING_UNCERTAIN: &str =
    "no vessel is uncertain: for centerlines, `observed` looks for candidates; `uncertain` all puts every vessel in question";

/// An input made ready to be sampled: the over-connected graph and its boundary conditions, with everything that its files say.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Prepared {
    /// The over-connected graph.
    pub graph: Network,
    /// Its boundary conditions.
    pub boundary: Boundary,
    /// The file, and what a person should know.
    pub provenance: Provenance,
    /// The options that were given.
    pub options: RunOptions,
    /// What found outlets are.
    pub(crate) outlets: FoundOutlets,
    /// The record of the prior.
    pub(crate) prior: Value,
    /// The record of what opened contacts.
    pub(crate) cuts: Value,
    /// The record of the image in which candidates were looked at.
    pub(crate) image: Value,
    /// What it shows along doubtful vessels.
    pub(crate) image_cuts: Vec<ImageCut>,
    /// The segmentation that the vessels were found in, where they were.
    pub(crate) segmentation: Option<Segmentation>,
    /// The record of what a person decided.
    pub(crate) decisions: Value,
    /// What is known of the contacts beside their vessels.
    pub(crate) contacts: Contacts,
    pub(crate) uniform_prior: bool,
    /// How candidates were built; `None` for a ready graph.
    pub(crate) candidates: Option<CandidateOptions>,
    pub(crate) keep: Keep,
    pub(crate) arteries: Option<FoundArteries>,
    #[serde(skip, default = "Instant::now")]
    pub(crate) started: Instant,
}

/// Boundary conditions and candidates of an input.
///
/// # Errors
///
/// As [`infer`], before any sample.
pub fn prepare(input: Input, options: &InferOptions, progress: &mut dyn Progress) -> Result<Arc<Prepared>> {
    options.validate()?;
    let path = std::path::PathBuf::from(&input.provenance.input);
    let (scale, is_fragments) = (input.options.scale, input.is_fragments);
    let (usual_outlets, by_names) = (input.usual_outlets(), input.inlets_by_labels());
    let source = options.arteries.as_ref().map(|source| source.resolved(&input.network));
    let by_landmarks = source.as_ref().filter(|source| source.is_landmarks());
    let by_geometry = source.as_ref().is_some_and(|source| *source == ArterySource::Geometry);
    let by_labels = source.as_ref().filter(|source| !source.is_landmarks() && !by_geometry);

    let kind = Kind::of(&input.network, input.format.is_some_and(Format::is_mask));
    let cuts = Cuts::load(&options.cut, options.mask.as_deref(), &input, kind)?;

    // The vessels. Landmarks are found before candidates make new nodes; labels afterwards, when every vessel has its row.
    let mut network = if by_labels.is_some() && is_fragments { input.divided_by_labels() } else { input.network };
    let mut unnamed = None;
    let mut arteries = by_landmarks.map(|source| source.find(&path, &network, &scale, &options.phenotypes)).transpose()?;
    // The prior, whose choice depends on what the file holds.
    let usual = if is_fragments { Prior::Evidence } else { Prior::None };
    let prior = options.prior.as_ref().unwrap_or(&usual).load(kind)?;
    if prior.is_evidence() && !is_fragments {
        let accepted = "needs centerlines; this is a ready graph, whose candidates state their own probability (see `observed`)";
        return Err(Error::parameter("prior", options.prior.as_ref().unwrap_or(&usual).to_string(), accepted));
    }
    let building = CandidateOptions {
        k: options.candidates.k.or(Some(prior.usual_k())),
        radius_rule: input.options.radius_rule,
        ..options.candidates.clone()
    };

    // Names need candidates, which pass them over gaps; named inlets then are boundary conditions.
    let mut names = None;
    if by_geometry {
        let over_connected = |network: &Network| {
            let given = options.boundary.given(network, &mut Silent)?;
            Ok(prior.graph(network.clone(), is_fragments, &given, &building, None)?.0)
        };
        match named(&path, &network, over_connected, &options.phenotypes.models()?, progress)? {
            Named::Circle(found, found_names) => (arteries, names) = (Some(*found), Some(found_names)),
            Named::Nothing(why) => unnamed = Some(why),
        }
    }
    if let Some(found) = arteries.as_ref().filter(|_| !options.boundary.states_an_inlet()) {
        found.state_inlets(&mut network);
    }
    if let Some(found) = &arteries {
        found.name_outlets(&mut network);
    }

    // The stated boundary conditions, then candidates, then the conditions that are found: not where a candidate probably leaves.
    let given = options.boundary.given(&network, progress)?;
    let mut provenance = input.provenance;
    let looked = picture::Picture::load(options, &prior, &input.options, is_fragments)?;
    let (image, view) = looked.unzip();
    let (graph, looked, unlike) = prior.graph(network, is_fragments, &given, &building, view)?;
    let unseen = looked.as_ref().and_then(|looked| looked.as_ref().err().copied());
    let scene = looked.as_ref().and_then(|looked| looked.as_ref().ok());
    let said = image.as_ref().map(|image| image.remarks(unseen, scene, &prior)).unwrap_or_default();
    if is_fragments {
        progress.step(Step::Built { graph: &graph, options: &building, by_evidence: prior.is_evidence() });
        provenance.notes.extend(nothing_built(&graph, &building).map(str::to_owned));
    }
    for note in said {
        progress.step(Step::Note(&note));
        provenance.notes.push(note);
    }
    let (mut graph, contacts, crowded) = opened(cuts.as_ref(), graph, scene, progress);
    let uniform_prior = matches!(prior, prior::LoadedPrior::Uniform);
    let (uniform_prior, decided) = decided(&mut graph, options.decisions.as_deref(), &provenance.sha256, uniform_prior)?;
    arteries = match (by_labels, &names) {
        (Some(source), _) => Some(source.find(&path, &graph, &scale, &options.phenotypes)?),
        (None, Some(names)) => Some(arteries::by_geometry(&path, &graph, Some(names), &options.phenotypes.models()?)?),
        (None, None) => arteries.map(|found| found.with_names(&graph, &options.phenotypes)).transpose()?,
    };
    let outlets = options.boundary.found_outlets.unwrap_or(usual_outlets);
    let known = arteries.as_ref().map_or(by_names, |found| found.known_inlets(&graph));
    let boundary = Boundary::resolve_knowing(&graph, &given, outlets, &known)?;
    let all_stated = boundary.found_outlets.is_empty() && arteries.as_ref().is_none_or(|found| found.circle.outlets().is_empty());
    if options.preset == Preset::Willis && options.boundary.found_outlets.is_some() && all_stated {
        progress.step(Step::OutletsAllStated);
    }
    progress.step(Step::Boundary { graph: &graph, boundary: &boundary });
    provenance.notes.extend(unnamed);
    let nothing = !is_fragments && !options.sampling.uncertain.vessels(&graph).contains(&true);
    let said = unlike.into_iter().chain(crowded).chain(arteries.iter().flat_map(|found| found.notes.clone()));
    for note in said.chain(nothing.then(|| NOTHING_UNCERTAIN.to_owned())).chain(stated_resistances(options.preset, &given)) {
        progress.step(Step::Note(&note));
        provenance.notes.push(note);
    }
    Ok(Arc::new(Prepared {
        keep: options.keep.unwrap_or(prior.usual_rule(&graph)),
        segmentation: input.lumen.as_ref().map(Segmentation::of),
        image_cuts: scene.map(|scene| picture::pictures(scene, &graph)).unwrap_or_default(),
        graph,
        boundary,
        provenance,
        options: RunOptions { read: input.options, infer: InferOptions { arteries: source, ..options.clone() } },
        outlets,
        prior: prior.record(),
        cuts: cuts.as_ref().map_or(Value::Null, Cuts::record),
        image: image.map_or(Value::Null, |image| image.record(unseen)),
        contacts,
        uniform_prior,
        decisions: decided,
        candidates: is_fragments.then_some(building),
        arteries,
        started: input.started,
    }))
}

/// The graph with its contacts cut apart, where they are, and what to tell a person of them.
fn opened(
    cuts: Option<&Cuts>,
    graph: Network,
    scene: Option<&Scene>,
    progress: &mut dyn Progress,
) -> (Network, Contacts, Option<String>) {
    let Some(cuts) = cuts else { return (graph, Contacts::default(), None) };
    let (graph, contacts, note) = cuts.open(graph, scene);
    progress.step(if cuts.only_suggests() {
        Step::CutsSuggested { suggested: contacts.suggested.len() }
    } else {
        Step::Cut { graph: &graph, with_mask: cuts.has_mask(), with_image: cuts.looks_at(scene) }
    });
    (graph, contacts, note)
}

/// The arteries of a network by their geometry.
enum Named {
    /// A circle, and the names by which it was found.
    Circle(Box<FoundArteries>, Box<Names>),
    /// None, and why.
    Nothing(String),
}

/// The arteries of a network by their geometry, with the candidates that `over_connected` builds around it. A network without a circle is no error.
fn named(
    path: &Path,
    network: &Network,
    over_connected: impl Fn(&Network) -> Result<Network>,
    models: &NamingModels,
    progress: &mut dyn Progress,
) -> Result<Named> {
    let find = || {
        let graph = over_connected(network)?;
        let no_vessel = || {
            Fault::file(
                "no vessel with positions",
                "expected centerlines of a head, or labels that name an internal carotid, basilar or vertebral artery, or `landmarks` FILE",
            )
            .in_file(path)
        };
        let names = models.name(&graph).ok_or_else(no_vessel)?;
        Ok((arteries::by_geometry(path, network, Some(&names), models)?, names))
    };
    match find() {
        Ok((found, names)) => Ok(Named::Circle(Box::new(found), Box::new(names))),
        Err(Error::Input { found, accepted, .. }) => {
            let note = format!("no phenotype: {found}; {accepted}");
            progress.step(Step::Note(&note));
            Ok(Named::Nothing(note))
        }
        Err(why) => Err(why),
    }
}

/// What a run with the choices of the paper says of outlets that are not at ground.
fn stated_resistances(preset: Preset, given: &[Given]) -> Option<String> {
    let outlets = given.iter().filter(|given| matches!(given.condition, Condition::Resistance { .. })).count();
    let these = if outlets == 1 {
        "1 outlet keeps its resistance".to_owned()
    } else {
        format!("{outlets} outlets keep their resistances")
    };
    let said = format!("{these}, as stated; the paper has outlets at ground only");
    (preset == Preset::Paper && outlets > 0).then_some(said)
}

/// Applies the decisions of a file to a graph: whether A = 1 still stands for the priors of all vessels, and the record of the decisions.
fn decided(graph: &mut Network, file: Option<&Path>, sha256: &str, uniform_prior: bool) -> Result<(bool, Value)> {
    let Some(file) = file else { return Ok((uniform_prior, Value::Null)) };
    let (made, record) = decisions::load(file, graph, sha256)?;
    Ok((decide_on(graph, &made, uniform_prior)?, record))
}

/// Applies decisions to a graph, and returns whether A = 1 still stands for the priors of all vessels: a rejected connection has A = 0,
/// so from then on the vessels' own priors count, which are set to 1.
fn decide_on(graph: &mut Network, made: &[ConnectionDecision], uniform_prior: bool) -> Result<bool> {
    if uniform_prior && !made.is_empty() {
        (0..graph.vessel_count()).for_each(|row| graph.vessel_mut(row).prior = 1.0);
    }
    decisions::apply(graph, made)?;
    Ok(uniform_prior && made.is_empty())
}

/// That there is no candidate, and what may help.
pub fn nothing_built(graph: &Network, options: &CandidateOptions) -> Option<&'static str> {
    let candidates = graph.vessels().any(|(_, vessel)| vessel.origin == Origin::Candidate);
    (!candidates).then_some(match options.max_gap {
        Some(_) => "no free end has another vessel within `max_gap`; a larger one may help",
        None => "no free end has another vessel within reach",
    })
}

impl Prepared {
    /// Samples the graph and decides. The options need not be those of [`Prepared::options`]: several may share one graph.
    ///
    /// # Errors
    ///
    /// As [`infer_with`].
    pub fn sample(self: &Arc<Self>, options: &SamplingOptions, progress: &mut dyn Progress) -> Result<Inference> {
        let options = &self.sampled_with(options);
        let until_stable = self.options.infer.until_stable;
        let begun = Instant::now();
        progress.step(Step::Sampling { graph: &self.graph, options, until_stable });
        let first = SamplingOptions { samples: if until_stable { FIRST_STABLE } else { options.samples }, ..options.clone() };
        let mut sampling = Sampling::new(&self.graph, &self.boundary, &first)?;
        let samples = sampling.samples();
        let fits = |part: &PartialRun| part.samples() == samples || until_stable && part.samples().is_power_of_two();
        let resumed = progress.resume(&self.key(options), sampling.part().uncertain(), &fits);
        let mut part = resumed.unwrap_or_else(|| sampling.part());
        let before = part.done();
        let mut heard = Heard(progress);
        let sampled = if until_stable {
            sampling.until_stable(&mut part, |result| all_decided(self.keep, &self.graph, result), &mut heard)
        } else {
            sampling.sample(&mut part, &mut heard).map(|()| sampling.likelihood(&part))
        };
        heard.0.sampled(&part, sampled.is_ok());
        let seconds = begun.elapsed().as_secs_f64();
        let method = sampling.method();
        let rate = (part.done() - before) as f64 / seconds;
        let (threads, instructions) = (rayon::current_num_threads(), method.instructions);
        let time = json!({ "sampling_s": seconds, "samples_per_s": rate, "threads": threads, "instructions": instructions });
        self.decide(options, sampled?, method, time)
    }

    /// What there is to see of a run while it is at work: the answer of the samples that are finished, as if they were all. Which these are
    /// depends on the threads, so it is a look and not a result. `seconds` is how long they took.
    ///
    /// # Errors
    ///
    /// No sample is finished.
    pub fn so_far(self: &Arc<Self>, options: &SamplingOptions, part: &PartialRun, seconds: f64) -> Result<Inference> {
        let samples = part.done();
        if samples == 0 {
            return Err(Error::parameter("samples", samples, "expected finished ones"));
        }
        let options = SamplingOptions { samples, exact: false, ..self.sampled_with(options) };
        let sampling = Sampling::new(&self.graph, &self.boundary, &options)?;
        let time = json!({ "sampling_s": seconds, "samples_per_s": samples as f64 / seconds });
        self.decide(&options, sampling.likelihood(part), sampling.method(), time)
    }

    /// Where the priors come from: a word, or a file with its SHA-256.
    pub fn prior(&self) -> &Value {
        &self.prior
    }

    /// The options with the prior of this input. The paper fixes where blood enters and leaves, so its preset and its loop do too.
    fn sampled_with(&self, options: &SamplingOptions) -> SamplingOptions {
        let by_the_paper =
            self.options.infer.preset == Preset::Paper || options.solver == Solver::Reference || self.uniform_prior;
        let found_conditions = if by_the_paper { FoundConditions::Fixed } else { options.found_conditions };
        SamplingOptions { uniform_prior: self.uniform_prior, found_conditions, ..options.clone() }
    }

    /// All that the samples depend on, as SHA-256: what is kept of a run is resumed under it.
    pub fn key(&self, options: &SamplingOptions) -> String {
        let options = self.sampled_with(options);
        let samples = (!self.options.infer.until_stable).then_some(options.samples);
        let (version, graph) = (env!("CARGO_PKG_VERSION"), self.graph_checksum());
        let options = SamplingOptions { samples: 0, ..options };
        let all = json!({ "willis": version, "graph": graph, "options": options, "samples": samples });
        checksum(all.to_string().as_bytes())
    }

    /// The SHA-256 of the graph with its conditions, exactly as they are sampled.
    pub(crate) fn graph_checksum(&self) -> String {
        let written = checksum_of(|out| {
            serde_json::to_writer(&mut *out, &self.graph)?;
            write!(out, "{:?}", self.boundary)
        });
        // Nothing fails here but the memory for a number.
        written.unwrap_or_default()
    }
}

/// The sampling loop reports to whoever follows the run.
struct Heard<'a>(&'a mut dyn Progress);

impl willis_core::sampling::Progress for Heard<'_> {
    fn report(&mut self, done: u64, total: u64) -> bool {
        self.0.report(done, total)
    }

    fn finished(&mut self, part: &PartialRun) {
        self.0.finished(part);
    }
}
