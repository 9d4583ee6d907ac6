//! The phenotype of a Circle of Willis: of vessels as they are, or with probabilities of the folder of a run.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::arteries::{FoundArteries, draw_topologies};
use super::input::StoredRun;
use super::prepare::{NO_PHENOTYPE, note_on_names};
use super::{ArterySource, Follow, InferOptions, Input, PhenotypeOptions, Prepared, Silent, prepare};
use crate::{FoundOutlets, Keep, Network, Result, SamplingOptions};
use willis_core::decision::{Topologies, decide, has_evidence};
use willis_core::{
    error::Fault, flow::Boundary, flow::boundary_conditions::stated, flow::poiseuille::BLOOD_VISCOSITY, sampling::infer,
};
use willis_io::output::{final_path, relative, write_file};
use willis_io::{formats::Column, formats::write_csv, output::names::PAGE, output::names::SUPPLY};
use willis_models::circle_of_willis::{Collateral, Posterior, Supply, Variant, present_vessels, supplies};
use willis_report::{
    CircleFigures, Provenance, collateral_columns, collateral_json, phenotype_json, supply_columns, supply_json,
    write_classified, write_phenotype,
};

/// Which segments a Circle of Willis has, how probable that is, and what the loss of a feeder means.
#[derive(Debug)]
pub struct Phenotype {
    /// The variant; of uncertain topologies the most probable one.
    pub variant: Variant,
    /// The probabilities, where the topology is uncertain.
    pub posterior: Option<Posterior>,
    /// What becomes of the flow without each feeder.
    pub collaterals: Vec<Collateral>,
    /// Who feeds each territory and outlet, and how late.
    pub supplies: Vec<Supply>,
    /// How many vessels counted.
    pub counted: usize,
    /// The segments that are there, and those of them that are thin.
    pub circle: CircleFigures,
    /// What the arteries were known by: `names`, `icafe`, `topcow` or `landmarks`.
    pub known_by: String,
    /// What a person should know.
    pub notes: Vec<String>,
    /// What phenotype.json holds.
    pub json: Value,
    /// supply.csv.
    supply_table: Vec<Column>,
    record: Value,
    /// The page of the run that was classified.
    of_run: Option<PathBuf>,
}

/// Classifies the Circle of Willis of an input. The vessels of a file are taken as they are; of the folder of a run, the plausible
/// topologies are drawn again. The arteries are known by `source`, else as the run knew them, else by labels; what `phenotypes` does not
/// say is as the run had it. `progress` says whether to go on.
///
/// # Errors
///
/// Arteries that cannot be found; landmarks of the run that have changed; a breakdown of the solver.
pub fn classify(
    input: &Input,
    source: Option<&ArterySource>,
    phenotypes: &PhenotypeOptions,
    progress: &mut dyn Follow,
) -> Result<Phenotype> {
    phenotypes.validate()?;
    phenotypes.check_files()?;
    input.network.validate()?;
    let asked = phenotypes;
    let path = Path::new(&input.provenance.input);
    let phenotypes = &input.run.as_ref().map_or_else(|| phenotypes.clone(), |run| phenotypes.or(&run.options.infer.phenotypes));
    let of_run = input.run.as_ref().and_then(|run| run.options.infer.arteries.as_ref());
    let usual = ArterySource::Automatic;
    let chosen = &source.or(of_run).unwrap_or(&usual).resolved(&input.network, input.is_topcow);
    if input.run.is_none() && input.is_fragments && *chosen == ArterySource::Geometry {
        return classify_by_geometry(input, phenotypes);
    }
    let divide = input.run.is_none() && input.is_fragments && chosen.file().is_none();
    let divided = divide.then(|| input.divided_by_labels());
    let network = divided.as_ref().unwrap_or_else(|| input.undivided());
    // The landmarks of a run are in the unit of its input.
    let scale = input.run.as_ref().filter(|_| source.is_none()).map_or(&input.options.scale, |run| &run.options.read.scale);
    // What the run found holds, as long as nobody asks for another way to find it.
    let as_the_run = |run: &StoredRun| source.is_none() && phenotypes.arteries == run.options.infer.phenotypes.arteries;
    let stored = input.run.as_ref().filter(|run| as_the_run(run)).and_then(|run| run.named.clone());
    let mut found = if let Some(found) = stored { found } else { chosen.find(path, network, scale, phenotypes)? };
    if let (None, Some(run), Some(file)) = (source, &input.run, &found.landmarks)
        && run.landmarks.as_ref() != Some(&file.sha256)
    {
        let why = "not the landmarks that the run was made with: their SHA-256 is not that of run.json";
        return Err(Fault::file(why, "expected them unedited, or `landmarks=FILE`").in_file(&file.path));
    }
    if input.run.is_some() {
        found = found.with_names(network, phenotypes)?;
    }
    let mut notes = found.notes.clone();
    notes.extend(note_on_names(asked, &found));
    let (topologies, posterior, boundary) = if let Some(run) = &input.run {
        let options = SamplingOptions { samples: run.samples, ..run.options.infer.sampling.clone() };
        let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground)?;
        let above = above_median(network, &boundary, &options, progress)?;
        let (topologies, how) = draw_topologies(Some(&found), network, &boundary, &options, &run.given, above.as_deref(), true)?;
        let posterior = found.posterior_from(network, &topologies, phenotypes)?;
        notes.push(how);
        (topologies.weighted, Some(posterior), Some(boundary))
    } else {
        let (kept, note) = present_vessels(network);
        notes.extend(note.map(str::to_owned));
        // Vessels that no blood can flow through have a variant all the same.
        (vec![(kept, 1.0)], None, found.boundary(network, input.usual_outlets()).ok())
    };
    let usual = (input.usual_outlets(), BLOOD_VISCOSITY);
    let flow = input.run.as_ref().map_or(usual, |run| (FoundOutlets::Ground, run.options.infer.sampling.viscosity));
    let answer = Answer { found, topologies, posterior, boundary, notes };
    Ok(phenotype(input, network, answer, flow, phenotypes))
}

/// Per vessel whether its L is above the median, for topologies that samples vote for; none where there is evidence to draw them by.
pub fn above_median(
    network: &Network,
    boundary: &Boundary,
    options: &SamplingOptions,
    progress: &mut dyn Follow,
) -> Result<Option<Vec<bool>>> {
    if has_evidence(network) {
        return Ok(None);
    }
    let (likelihood, _) = infer(network, boundary, options, &mut |done, total| progress.report(done, total))?;
    Ok(Some(decide(Keep::Median, network, &likelihood)?.above_median))
}

/// Classifies centerlines whose arteries are known by their geometry: vessels with the candidates around them, as infer would judge them.
fn classify_by_geometry(input: &Input, phenotypes: &PhenotypeOptions) -> Result<Phenotype> {
    let options = InferOptions { arteries: Some(ArterySource::Geometry), phenotypes: phenotypes.clone(), ..Default::default() };
    let prepared = prepare(input.clone(), &options, &mut Silent)?;
    let network = &prepared.graph;
    let Some(found) = prepared.arteries.clone() else {
        let why = prepared.provenance.notes.iter().find_map(|note| note.strip_prefix(NO_PHENOTYPE)).unwrap_or_default();
        let (why, accepted) =
            why.split_once("; ").unwrap_or((why, "expected centerlines of a head, or labels, or `landmarks=FILE`"));
        return Err(Fault::file(why, accepted).in_file(Path::new(&input.provenance.input)));
    };
    let (topologies, how, posterior) = plausible(&prepared, &found, &mut Silent)?;
    let mut notes = found.notes.clone();
    notes.push(how);
    let (topologies, boundary) = (topologies.weighted, Some(prepared.boundary.clone()));
    let answer = Answer { found, topologies, posterior: Some(posterior), boundary, notes };
    Ok(phenotype(input, network, answer, (FoundOutlets::CEREBRAL, BLOOD_VISCOSITY), phenotypes))
}

/// The plausible topologies of an input that was not sampled, how they were drawn, and what they and names say of its circle.
pub fn plausible(prepared: &Prepared, found: &FoundArteries, follow: &mut dyn Follow) -> Result<(Topologies, String, Posterior)> {
    let Prepared { graph, boundary, options, candidates, .. } = prepared;
    let sampling = &options.infer.sampling;
    let above = if candidates.is_some() { None } else { above_median(graph, boundary, sampling, follow)? };
    let (topologies, how) = draw_topologies(Some(found), graph, boundary, sampling, &prepared.given(), above.as_deref(), true)?;
    let posterior = found.posterior_from(graph, &topologies, &options.infer.phenotypes)?;
    Ok((topologies, how, posterior))
}

/// What was found of a circle.
struct Answer {
    found: FoundArteries,
    /// The vessels of each plausible topology, and its weight.
    topologies: Vec<(Vec<bool>, f64)>,
    posterior: Option<Posterior>,
    /// Where blood enters and leaves, where any can flow.
    boundary: Option<Boundary>,
    notes: Vec<String>,
}

/// The phenotype of an answer, with what the loss of each feeder means.
fn phenotype(
    input: &Input,
    network: &Network,
    answer: Answer,
    (outlets, viscosity): (FoundOutlets, f64),
    phenotypes: &PhenotypeOptions,
) -> Phenotype {
    let Answer { found, topologies, posterior, boundary, mut notes } = answer;
    let first = || topologies.first().map(|(kept, _)| kept.clone());
    let kept = posterior.as_ref().map(|posterior| posterior.topology.clone()).or_else(first).unwrap_or_default();
    let as_it_is = || found.circle.variant(network, |row| kept[row]);
    let variant = posterior.as_ref().map_or_else(as_it_is, Posterior::best);
    let collaterals = found.collaterals(network, &kept, outlets, viscosity).unwrap_or_else(|why| {
        notes.push(format!("nothing is told of the loss of a feeder: {why}"));
        Vec::new()
    });
    let who_feeds = |boundary: &Boundary| supplies(&found.circle, network, &topologies, boundary, viscosity);
    let supplies = boundary.as_ref().map_or_else(Vec::new, who_feeds);
    let counted = kept.iter().filter(|kept| **kept).count();
    let circle = found.circle_figures(network, &variant, &kept, phenotypes);
    let json = phenotype_json(network, (&variant, &circle, posterior.as_ref()));
    let Provenance { command, notes: of_input, .. } = &input.provenance;
    let record = json!({
        "willis": env!("CARGO_PKG_VERSION"),
        "command": command,
        "input": input.provenance.of_input(),
        "parameters": { "arteries": found.known_by },
        "landmarks": found.landmarks,
        "counts": { "nodes": network.node_count(), "vessels": network.vessel_count(), "counted": counted },
        "phenotype": json,
        "collateral": collateral_json(&collaterals),
        "supply": supply_json(network, &supplies),
        "notes": of_input.iter().chain(&notes).collect::<Vec<_>>(),
    });
    let supply_table = supply_columns(network, &supplies);
    let known_by = found.known_by;
    let of_run = input.run.as_ref().map(|run| run.graph.with_file_name(PAGE));
    Phenotype { variant, posterior, collaterals, supplies, counted, circle, known_by, notes, json, supply_table, record, of_run }
}

impl Phenotype {
    /// Writes every file of the classification of a `subject` into a folder that is there.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, subject: &str) -> Result<()> {
        write_phenotype(folder, subject, (&self.variant, &self.circle, self.posterior.as_ref()), &self.json)?;
        write_file(&folder.join(SUPPLY), |out| write_csv(out, &self.supply_table))?;
        let run = self.of_run.as_ref().filter(|page| page.is_file()).and_then(|page| relative(page, &final_path(folder)));
        write_classified(folder, subject, &self.record, run.as_deref(), collateral_columns(&self.collaterals))
    }
}
