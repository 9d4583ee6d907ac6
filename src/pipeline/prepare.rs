//! From an input to the graph that is sampled: files, vessels, candidates, contacts, decisions, arteries and boundary conditions, in this order.

use std::{fs::File, io::Read, path::Path, path::PathBuf, sync::Arc};

use super::models::{Contacts, Cuts, LoadedPrior};
use super::prepared::{EarlyArteries, EarlyKnowledge, SourceRecords};
use super::{
    ArterySource, Contents, Cut, Follow, InferOptions, Input, PhenotypeOptions, Prepared, Preset, Prior, RunOptions, Silent,
    Step, arteries, arteries::FoundArteries, decisions::Decidable, decisions::DecisionList, picture::ImageRecord,
    picture::image_places, progress::Notes, require,
};
use crate::{Appearance, CandidateOptions, Error, Network, Result};
use willis_core::{flow::Given, network::Condition, network::Origin, network::units::millimetres};
use willis_io::{formats::Format, masks::View};
use willis_models::naming::nothing_named;
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
    input.network.validate()?;
    let inlets_by_labels = input.inlets_by_labels();
    let source = options.arteries.as_ref().map(|source| source.resolved(&input.network, input.is_topcow));
    // What is found by labels is divided already, and what is found otherwise shows whether names and labels agree.
    let named_lines = if source.is_none() { input.named_lines() } else { None };
    let input = input.for_arteries(source.as_ref());
    let loaded = Loaded::read(&input, options)?;
    let mut notes = Notes { kept: input.provenance.notes.clone(), follow: progress };
    let path = PathBuf::from(&input.provenance.input);
    let outlets = options.boundary.found_outlets.unwrap_or(input.usual_outlets());
    let mut vessels = input.network;
    let own_nodes = if matches!(input.contents, Contents::Centerlines(_)) { 0 } else { vessels.node_count() };
    let run = RunOptions { read: input.options, infer: InferOptions { arteries: source, ..options.clone() } };
    let early = EarlyArteries::find(&vessels, &path, &run, &loaded, &mut notes)?;
    early.state_ends(&mut vessels, options);
    let given = options.boundary.given(&vessels, notes.follow)?;
    let (graph, looked, unlike) =
        loaded.prior.graph(vessels, named_lines.as_ref(), &given, loaded.building.as_ref(), loaded.view)?;
    // The image as it was measured, where it shows the vessels, and why it does not.
    let (scene, unseen) = looked.transpose().map_or_else(|why| (None, Some(why)), |scene| (scene, None));
    if let Some(building) = &loaded.building {
        notes.follow.step(Step::Built { graph: &graph, options: building, by_evidence: loaded.prior.is_evidence() });
        if let Some(note) = nothing_built(&graph, building) {
            notes.say(note.to_owned());
        }
    }
    let remarks = loaded.image.as_ref().map(|image| image.remarks(unseen, scene.as_ref(), &loaded.prior));
    remarks.into_iter().flatten().for_each(|note| notes.say(note));
    let mut early = EarlyKnowledge { own_nodes, given, inlets_by_labels, arteries: early };
    let (graph, contacts, crowded) = match &loaded.cuts {
        Some(cuts) => cuts.open(graph, |node_now| early.follow(node_now), scene.as_ref(), notes.follow),
        None => (graph, Contacts::default(), None),
    };
    let undecided = Decidable { graph, contacts, uniform_prior: loaded.prior.is_uniform() }.with_marks()?;
    let keep = options.keep.unwrap_or(loaded.prior.usual_rule(&undecided.graph));
    let decided = loaded.decisions.map(|list| list.on(&undecided.graph, &input.provenance.sha256)).transpose()?;
    let before = decided.is_some().then(|| Arc::new(undecided.clone()));
    let Decidable { graph, contacts, uniform_prior } = match &decided {
        Some(decided) => undecided.decided(decided)?,
        None => undecided,
    };
    let arteries = early.arteries(&graph, &path, &run)?;
    let boundary = early.boundary(&graph, arteries.as_ref(), outlets, options, notes.follow)?;

    let nothing = loaded.building.is_none() && !options.sampling.uncertain.vessels(&graph).contains(&true);
    let of_arteries = arteries.iter().flat_map(|found| found.notes.clone());
    let unused = arteries.as_ref().and_then(|found| note_on_names(&options.phenotypes, found));
    let said = loaded.notes.into_iter().chain(unused).chain(unlike).chain(crowded).chain(of_arteries);
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
        boundary,
        provenance: Provenance { notes: notes.kept, ..input.provenance },
        outlets,
        records: SourceRecords {
            prior: loaded.prior.source,
            cut: loaded.cuts.map(|cuts| cuts.record),
            image: loaded.image.map(|image| ImageRecord { unused: unseen.map(|why| why.to_string()), ..image }),
            decisions: decided,
        },
        contacts,
        uniform_prior,
        undecided: before,
        early,
        candidates: loaded.building,
        options: run,
        arteries,
        started: input.started,
    }))
}

/// The files that the options of a run name, and how candidates are built by them.
struct Loaded {
    prior: LoadedPrior,
    /// None for a ready graph.
    building: Option<CandidateOptions>,
    cuts: Option<Cuts>,
    /// What to tell a person of options that change nothing.
    notes: Vec<String>,
    image: Option<ImageRecord>,
    view: Option<View>,
    decisions: Option<DecisionList>,
}

impl Loaded {
    fn read(input: &Input, options: &InferOptions) -> Result<Self> {
        let is_fragments = input.is_fragments;
        let kind =
            willis_models::candidates::resample::CenterlineKind::of(input.undivided(), input.format.is_some_and(Format::is_mask));
        let (mask, lumen) = (options.mask.as_deref(), input.lumen.as_ref());
        let load_cuts = || Cuts::load(&options.cut, mask, &input.options, input.undivided(), lumen, kind);
        let cuts = is_fragments.then(load_cuts).transpose()?.flatten();
        let notes = refuse_unused(input, options, cuts.as_ref())?;
        let usual = if is_fragments { Prior::Evidence } else { Prior::None };
        let chosen = options.prior.as_ref().unwrap_or(&usual);
        let prior = chosen.load(kind)?;
        let accepted = "needs centerlines; this is a ready graph, whose candidates state their own probability (see `observed`)";
        require(is_fragments || !prior.is_evidence(), "prior", chosen.to_string(), accepted)?;
        let (image, view) = ImageRecord::load(options, &prior, input)?.unzip();
        let k = options.candidates.k.or(Some(prior.usual_k()));
        let building = CandidateOptions { k, radius_rule: input.options.radius_rule, ..options.candidates.clone() };
        let decisions = options.decisions.as_deref().map(DecisionList::read).transpose()?;
        Ok(Self { prior, building: is_fragments.then_some(building), cuts, notes, image, view, decisions })
    }
}

impl EarlyArteries {
    fn find(vessels: &Network, path: &Path, run: &RunOptions, loaded: &Loaded, notes: &mut Notes<'_>) -> Result<Self> {
        let known = &run.infer.phenotypes;
        let found = match &run.infer.arteries {
            Some(source @ ArterySource::Landmarks(_)) => {
                return source.find(path, vessels, &run.read.scale, known).map(Self::Landmarks);
            }
            Some(ArterySource::Geometry) => Self::by_geometry(vessels, path, run, loaded),
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

    fn by_geometry(vessels: &Network, path: &Path, run: &RunOptions, loaded: &Loaded) -> Result<Self> {
        let models = run.infer.phenotypes.models()?;
        let given = run.infer.boundary.given(vessels, &mut Silent)?;
        let (graph, ..) = loaded.prior.graph(vessels.clone(), None, &given, loaded.building.as_ref(), None)?;
        let names = models.name(&graph).ok_or_else(|| nothing_named(&graph).in_file(path))?;
        let found = arteries::by_geometry(path, vessels, Some(&names.bearings), &models)?;
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
fn nothing_built(graph: &Network, options: &CandidateOptions) -> Option<&'static str> {
    let candidates = graph.vessels().any(|(_, vessel)| vessel.origin == Origin::Candidate);
    (!candidates).then_some(match options.max_gap {
        Some(_) => "no free end has another vessel within `max_gap`; a larger one may help",
        None => "no free end has another vessel within reach",
    })
}

/// Refuses options of `infer` that nothing will look at; the notes on those that change nothing. `cuts` is what the input is cut by.
///
/// # Errors
///
/// Names the option, its value and what it goes with; a named file that cannot be read.
fn refuse_unused(input: &Input, options: &InferOptions, cuts: Option<&Cuts>) -> Result<Vec<String>> {
    if !input.is_fragments {
        refuse_on_ready_graph(options)?;
    }
    let is_cut = matches!(options.cut, Cut::Always | Cut::File(_));
    let can_be_cut = input.network.has_positions();
    require(!is_cut || can_be_cut, "cut", options.cut.to_string(), "goes with vessels whose nodes have positions")?;
    require(options.vessels == Appearance::default() || options.image.is_some(), "vessels", "", "goes with `image`")?;
    if let Some(most) = options.image_places.filter(|_| options.image.is_none() && options.probability.is_none()) {
        return Err(Error::parameter("image_places", most, "goes with `image` or `probability`"));
    }
    if options.arteries.is_none()
        && let Some((name, value)) = given(&options.phenotypes).into_iter().next()
    {
        let accepted = "goes with `landmarks` or `labels`, which say that there is a Circle of Willis";
        return Err(Error::parameter(name, value, accepted));
    }
    options.phenotypes.check_files()?;
    let mut notes: Vec<String> = cuts.into_iter().filter_map(|cuts| cuts.note.clone()).collect();
    if let Some(mask) = options.mask.as_ref().filter(|_| cuts.is_none()) {
        let opened = File::open(mask).and_then(|file| file.take(1).read_to_end(&mut Vec::new()));
        opened.map_err(|source| Error::Read { path: mask.clone(), source })?;
        let by_itself = "only automatic skeletons are cut apart by themselves (`cut=always` does so here)";
        let why = if options.cut == Cut::Never { "`cut` never leaves all vessels together" } else { by_itself };
        notes.push(format!("`mask` changes nothing: {why}"));
    }
    Ok(notes)
}

/// Refuses what is about candidates that are built, where they stand already.
fn refuse_on_ready_graph(options: &InferOptions) -> Result<()> {
    let usual = if options.preset == Preset::Paper { InferOptions::paper() } else { InferOptions::default() };
    let (given, usual) = (&options.candidates, &usual.candidates);
    let mm = |length: Option<f64>| length.map(|m| format!("{} mm", millimetres(m)));
    let word = |value: serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let all = [
        ("k", given.k.map(|k| k.to_string())),
        ("max_gap", mm(given.max_gap)),
        ("attach", (given.attach != usual.attach).then(|| word(serde_json::json!(given.attach)))),
        ("candidate_radius", (given.radius != usual.radius).then(|| word(serde_json::json!(given.radius)))),
        ("max_candidate_radius", mm(given.max_radius)),
        ("cut", matches!(options.cut, Cut::Always | Cut::File(_)).then(|| options.cut.to_string())),
        ("mask", options.mask.as_ref().map(|path| path.display().to_string())),
    ];
    let accepted = "goes with a mask or centerlines; this is a ready graph, whose candidates stand (see `observed`)";
    let first = all.into_iter().find_map(|(name, value)| Some(Error::parameter(name, value?, accepted)));
    first.map_or(Ok(()), Err)
}

/// The options of a circle that were given, with their values.
fn given(phenotypes: &PhenotypeOptions) -> Vec<(&'static str, String)> {
    let PhenotypeOptions { frequencies, unseen, arteries, hypoplastic } = phenotypes;
    let all = [
        ("variant_prior", frequencies.as_ref().map(|path| path.display().to_string())),
        ("unseen", unseen.map(|share| share.to_string())),
        ("arteries", arteries.as_ref().map(|path| path.display().to_string())),
        ("hypoplastic", hypoplastic.map(|diameter| format!("{} mm", millimetres(diameter)))),
    ];
    all.into_iter().filter_map(|(name, value)| value.map(|value| (name, value))).collect()
}

/// The note that what is known of people's circles changes nothing, where the arteries have no names by geometry.
pub(super) fn note_on_names(phenotypes: &PhenotypeOptions, found: &FoundArteries) -> Option<String> {
    let given = given(phenotypes).into_iter().map(|(name, _)| name).filter(|name| *name != "hypoplastic");
    let names: Vec<String> = given.map(|name| format!("`{name}`")).collect();
    if names.is_empty() || found.named.is_some() {
        return None;
    }
    let (change, known_by) = (if names.len() == 1 { "changes" } else { "change" }, &found.known_by);
    let names = names.join(", ");
    Some(format!("{names} {change} nothing: the arteries are known by {known_by}, not named by their geometry"))
}
