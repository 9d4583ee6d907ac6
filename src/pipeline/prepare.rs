//! From an input to the graph that is sampled: files, vessels, candidates, contacts, decisions, arteries and boundary conditions, in this order.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::arteries::{self, FoundArteries};
use super::artery_options::ArterySource;
use super::cuts::{Contacts, Cuts};
use super::decisions::{Decidable, DecisionList};
use super::picture::{ImageSource, image_places};
use super::prepared::{Prepared, SourceRecords};
use super::prior::{LoadedPrior, Prior};
use super::progress::{Follow, Notes, Silent, Step};
use super::{Contents, InferOptions, Input, Preset, RunOptions, unused};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, FoundOutlets, Given};
use willis_core::network::units::Scale;
use willis_core::network::{Condition, Network, Origin};
use willis_io::formats::Format;
use willis_io::masks::{Scene, Unseen, View};
use willis_models::candidates::CandidateOptions;
use willis_models::candidates::kind::CenterlineKind;
use willis_models::naming::Bearings;
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
    let built = OverConnected::build(vessels, &loaded, &given, view, &mut notes)?;
    let opened = CutGraph::of(built.graph, &loaded, built.scene.as_ref(), notes.follow);
    let undecided = Decidable { graph: opened.graph, contacts: opened.contacts, uniform_prior: loaded.prior.is_uniform() };
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
    let said = loaded.notes.clone().into_iter().chain(unused).chain(built.unlike).chain(opened.crowded).chain(of_arteries);
    said.chain(nothing.then(|| NOTHING_UNCERTAIN.to_owned()))
        .chain(stated_resistances(options.preset, &early.given))
        .for_each(|note| notes.say(note));
    let image_places = built.scene.map(|scene| image_places(&scene, &graph, options.image_places)).unwrap_or_default();
    if options.image_places.is_some() {
        let size = image_places.iter().map(|place| place.samples.len()).sum::<usize>() as f64 / 1e6;
        notes.follow.step(Step::Note(&format!(
            "the page holds the image at {} of the doubtful places: {size:.1} MB",
            image_places.len()
        )));
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
            image: loaded.image.map(|image| image.record(built.unseen)),
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
    image: Option<ImageSource>,
    decisions: Option<DecisionList>,
}

impl<'a> Loaded<'a> {
    /// Reads the files; beside them the image.
    fn read(input: &Input, options: &'a InferOptions) -> Result<(Self, Option<View>)> {
        let is_fragments = input.is_fragments;
        let kind = CenterlineKind::of(&input.network, input.format.is_some_and(Format::is_mask));
        let cuts = if is_fragments {
            Cuts::load(&options.cut, options.mask.as_deref(), &input.network, input.lumen.as_ref(), kind)?
        } else {
            None
        };
        let notes = unused::refuse(input, options, cuts.as_ref())?;
        let usual = if is_fragments { Prior::Evidence } else { Prior::None };
        let chosen = options.prior.as_ref().unwrap_or(&usual);
        let prior = chosen.load(kind)?;
        if prior.is_evidence() && !is_fragments {
            let accepted =
                "needs centerlines; this is a ready graph, whose candidates state their own probability (see `observed`)";
            return Err(Error::parameter("prior", chosen.to_string(), accepted));
        }
        let (image, view) = ImageSource::load(options, &prior, &input.options, is_fragments)?.unzip();
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

/// What is known of an input before there are candidates. Its arteries and boundary conditions follow from it and from the graph, and do so
/// again when a person has decided on that.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct EarlyKnowledge {
    given: Vec<Given>,
    inlets_by_labels: Vec<usize>,
    arteries: EarlyArteries,
}

impl EarlyKnowledge {
    /// Whether it may be that of this graph, by the number of its nodes.
    pub(crate) fn fits(&self, graph: &Network) -> bool {
        self.given.iter().all(|given| given.node < graph.node_count())
            && !matches!(&self.arteries, EarlyArteries::Landmarks(found) if !found.circle.fits(graph))
    }

    /// The arteries of a graph of the input at this path.
    pub(crate) fn arteries(&self, graph: &Network, path: &Path, run: &RunOptions) -> Result<Option<FoundArteries>> {
        let phenotypes = &run.infer.phenotypes;
        match (&self.arteries, &run.infer.arteries) {
            (EarlyArteries::Landmarks(found), _) => found.clone().with_names(graph, phenotypes).map(Some),
            (EarlyArteries::Geometry(_, bearings), _) => {
                arteries::by_geometry(path, graph, Some(bearings), &phenotypes.models()?).map(Some)
            }
            (EarlyArteries::Nothing, None | Some(ArterySource::Geometry)) => Ok(None),
            (EarlyArteries::Nothing, Some(labels)) => labels.find(path, graph, &run.read.scale, phenotypes).map(Some),
        }
    }

    /// The stated conditions of a graph, and those that are found: not where a candidate probably leaves.
    pub(crate) fn boundary(
        &self,
        graph: &Network,
        arteries: Option<&FoundArteries>,
        outlets: FoundOutlets,
        options: &InferOptions,
        follow: &mut dyn Follow,
    ) -> Result<Boundary> {
        let known = arteries.map_or_else(|| self.inlets_by_labels.clone(), |found| found.known_inlets(graph));
        let boundary = Boundary::resolve_knowing(graph, &self.given, outlets, &known)?;
        let all_stated = boundary.found_outlets.is_empty() && arteries.is_none_or(|found| found.circle.outlets().is_empty());
        if options.preset == Preset::Willis && options.boundary.found_outlets.is_some() && all_stated {
            follow.step(Step::OutletsAllStated);
        }
        follow.step(Step::Boundary { graph, boundary: &boundary });
        Ok(boundary)
    }
}

/// What is known of the arteries before there are candidates: where they enter and leave is a boundary condition.
#[derive(Debug, Clone, Serialize, Deserialize)]
enum EarlyArteries {
    /// Nothing: labels are looked at when every vessel has its row.
    Nothing,
    /// By landmarks, found before candidates make new nodes.
    Landmarks(FoundArteries),
    /// By geometry: where they lie was found with the candidates of a first over-connected graph, which pass names over gaps.
    Geometry(FoundArteries, Bearings),
}

impl EarlyArteries {
    fn find(vessels: &Network, loaded: &Loaded<'_>, notes: &mut Notes<'_>) -> Result<Self> {
        let found = match &loaded.arteries {
            Some(source) if source.is_landmarks() => return loaded.find(source, vessels).map(Self::Landmarks),
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
        let found = arteries::by_geometry(&loaded.path, vessels, Some(&names.bearings()), &models)?;
        Ok(Self::Geometry(found, names.bearings()))
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

/// The over-connected graph, before contacts are opened.
struct OverConnected {
    graph: Network,
    /// The image as it was measured, where it shows the vessels, ...
    scene: Option<Scene>,
    /// ... and why it does not.
    unseen: Option<Unseen>,
    /// What to tell a person where the model knows no such fragments.
    unlike: Option<String>,
}

impl OverConnected {
    fn build(vessels: Network, loaded: &Loaded<'_>, given: &[Given], view: Option<View>, notes: &mut Notes<'_>) -> Result<Self> {
        let Loaded { prior, building, is_fragments, .. } = loaded;
        let (graph, looked, unlike) = prior.graph(vessels, *is_fragments, given, building, view)?;
        let (scene, unseen) = match looked {
            None => (None, None),
            Some(Ok(scene)) => (Some(scene), None),
            Some(Err(why)) => (None, Some(why)),
        };
        if *is_fragments {
            notes.follow.step(Step::Built { graph: &graph, options: building, by_evidence: prior.is_evidence() });
            // Said with the step.
            notes.kept.extend(nothing_built(&graph, building).map(str::to_owned));
        }
        let remarks = loaded.image.as_ref().map(|image| image.remarks(unseen, scene.as_ref(), prior));
        remarks.into_iter().flatten().for_each(|note| notes.say(note));
        Ok(Self { graph, scene, unseen, unlike })
    }
}

/// The over-connected graph with its contacts cut apart, where they are.
struct CutGraph {
    graph: Network,
    contacts: Contacts,
    /// What to tell a person of contacts.
    crowded: Option<String>,
}

impl CutGraph {
    fn of(graph: Network, loaded: &Loaded<'_>, scene: Option<&Scene>, follow: &mut dyn Follow) -> Self {
        let Some(cuts) = &loaded.cuts else { return Self { graph, contacts: Contacts::default(), crowded: None } };
        let (graph, contacts, crowded) = cuts.open(graph, scene);
        follow.step(if cuts.record.only_suggested {
            Step::CutsSuggested { suggested: contacts.suggested.len() }
        } else {
            Step::Cut { graph: &graph, with_mask: cuts.record.mask, with_image: cuts.looks_at(scene) }
        });
        Self { graph, contacts, crowded }
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

/// That there is no candidate, and what may help.
pub fn nothing_built(graph: &Network, options: &CandidateOptions) -> Option<&'static str> {
    let candidates = graph.vessels().any(|(_, vessel)| vessel.origin == Origin::Candidate);
    (!candidates).then_some(match options.max_gap {
        Some(_) => "no free end has another vessel within `max_gap`; a larger one may help",
        None => "no free end has another vessel within reach",
    })
}
