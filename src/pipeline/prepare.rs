//! From an input to the graph that is sampled: files, vessels, candidates, contacts, decisions, arteries and boundary conditions, in this order.

use std::path::PathBuf;
use std::sync::Arc;

use super::arteries::{self, FoundArteries};
use super::artery_options::ArterySource;
use super::cuts::{Contacts, Cuts};
use super::decisions::{Decidable, DecisionList};
use super::early::{EarlyArteries, EarlyKnowledge};
use super::picture::{ImageRecord, image_places};
use super::prepared::{Prepared, SourceRecords};
use super::prior::{LoadedPrior, Prior};
use super::progress::{Follow, Notes, Silent, Step};
use super::{Contents, InferOptions, Input, Preset, RunOptions, unused};
use willis_core::error::{Error, Result};
use willis_core::flow::{FoundOutlets, Given};
use willis_core::network::units::Scale;
use willis_core::network::{Condition, Network, Origin};
use willis_io::formats::Format;
use willis_io::masks::View;
use willis_models::candidates::CandidateOptions;
use willis_models::candidates::resample::CenterlineKind;
use willis_report::{Provenance, Segmentation};

/// What may help where a graph leaves nothing to decide.
const NOTHING_UNCERTAIN: &str =
    "no vessel is uncertain: for centerlines, `observed` looks for candidates; `uncertain=all` puts every vessel in question";

/// The over-connected graph of an input with its boundary conditions: all that [`infer`](crate::infer) does before it samples.
///
/// # Errors
///
/// As [`infer`](crate::infer), before any sample.
pub fn prepare(input: Input, options: &InferOptions, progress: &mut dyn Follow) -> Result<Arc<Prepared>> {
    options.validate()?;
    let (mut loaded, view) = Loaded::read(&input, options)?;
    let mut notes = Notes { kept: input.provenance.notes.clone(), follow: progress };

    let by_labels = loaded.arteries.as_ref().is_some_and(ArterySource::is_labels);
    let mut vessels = if by_labels && loaded.is_fragments { input.divided_by_labels() } else { input.network };
    let own_nodes = if matches!(input.contents, Contents::Centerlines(_)) { 0 } else { vessels.node_count() };
    let early = EarlyArteries::find(&vessels, &loaded, &mut notes)?;
    early.state_ends(&mut vessels, options);
    let given = options.boundary.given(&vessels, notes.follow)?;
    let (graph, looked, unlike) = loaded.prior.graph(vessels, loaded.is_fragments, &given, &loaded.building, view)?;
    // The image as it was measured, where it shows the vessels, and why it does not.
    let (scene, unseen) = looked.transpose().map_or_else(|why| (None, Some(why)), |scene| (scene, None));
    if loaded.is_fragments {
        let by_evidence = loaded.prior.is_evidence();
        notes.follow.step(Step::Built { graph: &graph, options: &loaded.building, by_evidence });
        // Said with the step.
        notes.kept.extend(nothing_built(&graph, &loaded.building).map(str::to_owned));
    }
    let remarks = loaded.image.as_ref().map(|image| image.remarks(unseen, scene.as_ref(), &loaded.prior));
    remarks.into_iter().flatten().for_each(|note| notes.say(note));
    let (graph, contacts, crowded) = match &loaded.cuts {
        Some(cuts) => cuts.open(graph, scene.as_ref(), notes.follow),
        None => (graph, Contacts::default(), None),
    };
    let undecided = Decidable { graph, contacts, uniform_prior: loaded.prior.is_uniform() };
    let keep = options.keep.unwrap_or(loaded.prior.usual_rule(&undecided.graph));
    let decided = loaded.decisions.take().map(|list| list.on(&undecided.graph, &input.provenance.sha256)).transpose()?;
    let before = decided.is_some().then(|| Arc::new(undecided.clone()));
    let Decidable { graph, contacts, uniform_prior } = match &decided {
        Some(decided) => undecided.decided(decided)?,
        None => undecided,
    };
    let early = EarlyKnowledge { given, inlets_by_labels: loaded.inlets_by_labels, arteries: early };
    let run = RunOptions { read: input.options, infer: InferOptions { arteries: loaded.arteries, ..options.clone() } };
    let arteries = early.arteries(&graph, &loaded.path, &run)?;
    let boundary = early.boundary(&graph, arteries.as_ref(), loaded.outlets, options, notes.follow)?;

    let nothing = !loaded.is_fragments && !options.sampling.uncertain.vessels(&graph).contains(&true);
    let of_arteries = arteries.iter().flat_map(|found| found.notes.clone());
    let unused = arteries.as_ref().and_then(|found| unused::note_on_names(&options.phenotypes, found));
    let said = loaded.notes.clone().into_iter().chain(unused).chain(unlike).chain(crowded).chain(of_arteries);
    let said = said.chain(nothing.then(|| NOTHING_UNCERTAIN.to_owned())).chain(stated_resistances(options.preset, &early.given));
    said.for_each(|note| notes.say(note));
    let image_places = scene.map(|scene| image_places(&scene, &graph, options.image_places)).unwrap_or_default();
    if options.image_places.is_some() {
        let size = image_places.iter().map(|place| place.samples.len()).sum::<usize>() as f64 / 1e6;
        let held = image_places.len();
        notes.follow.step(Step::Note(&format!("the page holds the image at {held} of the doubtful places: {size:.1} MB")));
    }
    Ok(Arc::new(Prepared {
        keep,
        segmentation: input.lumen.as_ref().map(Segmentation::of),
        image_places,
        graph,
        own_nodes,
        boundary,
        provenance: Provenance { notes: notes.kept, ..input.provenance },
        outlets: loaded.outlets,
        records: SourceRecords {
            prior: loaded.prior.source,
            cut: loaded.cuts.map(|cuts| cuts.record),
            image: loaded.image.map(|image| image.unused(unseen)),
            decisions: decided,
        },
        contacts,
        uniform_prior,
        undecided: before,
        early,
        candidates: loaded.is_fragments.then_some(loaded.building),
        options: run,
        arteries,
        started: input.started,
    }))
}

/// What the options of a run mean for an input, with every file that they name.
struct Loaded<'a> {
    options: &'a InferOptions,
    path: PathBuf,
    scale: Scale,
    is_fragments: bool,
    /// What outlets are that are found.
    outlets: FoundOutlets,
    /// Where blood comes in by labels.
    inlets_by_labels: Vec<usize>,
    /// How the arteries are known, where they are asked for.
    arteries: Option<ArterySource>,
    prior: LoadedPrior,
    building: CandidateOptions,
    cuts: Option<Cuts>,
    /// What to tell a person of options that change nothing.
    notes: Vec<String>,
    image: Option<ImageRecord>,
    decisions: Option<DecisionList>,
}

impl<'a> Loaded<'a> {
    /// Reads the files; beside them the image.
    fn read(input: &Input, options: &'a InferOptions) -> Result<(Self, Option<View>)> {
        let is_fragments = input.is_fragments;
        let kind = CenterlineKind::of(&input.network, input.format.is_some_and(Format::is_mask));
        let load_cuts = || Cuts::load(&options.cut, options.mask.as_deref(), &input.network, input.lumen.as_ref(), kind);
        let cuts = is_fragments.then(load_cuts).transpose()?.flatten();
        let notes = unused::refuse(input, options, cuts.as_ref())?;
        let usual = if is_fragments { Prior::Evidence } else { Prior::None };
        let chosen = options.prior.as_ref().unwrap_or(&usual);
        let prior = chosen.load(kind)?;
        if prior.is_evidence() && !is_fragments {
            let accepted =
                "needs centerlines; this is a ready graph, whose candidates state their own probability (see `observed`)";
            return Err(Error::parameter("prior", chosen.to_string(), accepted));
        }
        let (image, view) = ImageRecord::load(options, &prior, &input.options, is_fragments)?.unzip();
        let building = CandidateOptions {
            k: options.candidates.k.or(Some(prior.usual_k())),
            radius_rule: input.options.radius_rule,
            ..options.candidates.clone()
        };
        let loaded = Self {
            options,
            path: input.provenance.input.clone().into(),
            scale: input.options.scale,
            is_fragments,
            outlets: options.boundary.found_outlets.unwrap_or(input.usual_outlets()),
            inlets_by_labels: input.inlets_by_labels(),
            arteries: options.arteries.as_ref().map(|source| source.resolved(&input.network, input.is_topcow)),
            prior,
            building,
            cuts,
            notes,
            image,
            decisions: options.decisions.as_deref().map(DecisionList::read).transpose()?,
        };
        Ok((loaded, view))
    }

    /// The arteries of a network by landmarks or labels.
    fn find(&self, source: &ArterySource, network: &Network) -> Result<FoundArteries> {
        source.find(&self.path, network, &self.scale, &self.options.phenotypes)
    }
}

impl EarlyArteries {
    fn find(vessels: &Network, loaded: &Loaded<'_>, notes: &mut Notes<'_>) -> Result<Self> {
        let found = match &loaded.arteries {
            Some(source) if source.file().is_some() => return loaded.find(source, vessels).map(Self::Landmarks),
            Some(ArterySource::Geometry) => Self::by_geometry(vessels, loaded),
            _ => return Ok(Self::Nothing),
        };
        match found {
            // A network without a circle is no error.
            Err(Error::Input { found, accepted, .. }) => {
                notes.say(format!("{NO_PHENOTYPE}{found}; {accepted}"));
                Ok(Self::Nothing)
            }
            found => found,
        }
    }

    fn by_geometry(vessels: &Network, loaded: &Loaded<'_>) -> Result<Self> {
        let models = loaded.options.phenotypes.models()?;
        let given = loaded.options.boundary.given(vessels, &mut Silent)?;
        let (graph, ..) = loaded.prior.graph(vessels.clone(), loaded.is_fragments, &given, &loaded.building, None)?;
        let names = models.name(&graph).ok_or_else(|| arteries::no_vessel().in_file(&loaded.path))?;
        let found = arteries::by_geometry(&loaded.path, vessels, Some(&names.bearings), &models)?;
        Ok(Self::Geometry(found, names.bearings))
    }

    /// States inlets, unless the options do, and outlets where the arteries enter and leave.
    fn state_ends(&self, vessels: &mut Network, options: &InferOptions) {
        let (Self::Landmarks(found) | Self::Geometry(found, _)) = self else { return };
        if !options.boundary.states_an_inlet() {
            found.state_inlets(vessels);
        }
        found.name_outlets(vessels);
    }
}

/// What the note begins with that says why there is no phenotype.
pub(super) const NO_PHENOTYPE: &str = "no phenotype: ";

/// What a run with the choices of the paper says of outlets that are not at ground.
fn stated_resistances(preset: Preset, given: &[Given]) -> Option<String> {
    let outlets = given.iter().filter(|given| matches!(given.condition, Condition::Resistance { .. })).count();
    let several = format!("{outlets} outlets keep their resistances");
    let these = if outlets == 1 { "1 outlet keeps its resistance" } else { &several };
    (preset == Preset::Paper && outlets > 0).then(|| format!("{these}, as stated; the paper has outlets at ground only"))
}

/// That there is no candidate, and what may help.
pub fn nothing_built(graph: &Network, options: &CandidateOptions) -> Option<&'static str> {
    let candidates = graph.vessels().any(|(_, vessel)| vessel.origin == Origin::Candidate);
    (!candidates).then_some(match options.max_gap {
        Some(_) => "no free end has another vessel within `max_gap`; a larger one may help",
        None => "no free end has another vessel within reach",
    })
}
