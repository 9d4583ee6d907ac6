//! The answer of a run: its samples, likelihoods, decisions, the plausible topology, and the folder that holds them.

use std::{path::Path, sync::Arc, time::Instant};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::arteries::draw_topologies;
use super::decisions::{Decidable, Decided, DecisionList};
use super::{ConnectionDecision, Follow, GraphEdit, Prepared, Step, progress::Notes, require};
use crate::{Decision, Error, Keep, Likelihood, Network, Result, SamplingOptions, SaveOptions};
use willis_core::decision::{Topology, all_decided, decide, expected_errors, has_evidence};
use willis_core::sampling::{FIRST_STABLE, PartialRun, Sampling};
use willis_core::{error::Fault, flow::Boundary, support::endings::stem};
use willis_io::output::{StagedFolder, read_stored, write_file, write_record, write_stored};
use willis_io::{formats::Column, formats::write_csv, output::names::SUPPLY};
use willis_models::circle_of_willis::{Artery, Posterior, Supply, supplies as who_feeds};
use willis_report::{
    CircleFigures, Outcome, RunRecord, SolverRecord, infer_record, phenotype_json, questions, review_columns, supply_columns,
    supply_json, topology_columns, vessel_columns, write_phenotype,
};

/// What a run found.
#[derive(Debug)]
pub struct Inference {
    sampled: Sampled,
    decision: Decision,
    /// Whether every decision on L is clear, where the run was to go on until it is.
    stable: Option<bool>,
    posterior: Option<(Posterior, String)>,
    /// The segments of the most probable variant, where the arteries are known.
    circle: Option<CircleFigures>,
    /// Who feeds each territory and outlet, where the arteries are known.
    supplies: Vec<Supply>,
}

/// A graph and what its samples say: what a run is made of again.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Sampled {
    prepared: Arc<Prepared>,
    sampling: SamplingOptions,
    likelihood: Likelihood,
    solver: SolverRecord,
    /// How long sampling took, on what; for run.json.
    time: Value,
}

impl Prepared {
    /// Samples the graph and decides. The options need not be those of [`Prepared::options`]: several may share one graph.
    ///
    /// # Errors
    ///
    /// As [`infer_with`](crate::infer_with).
    pub fn sample(self: &Arc<Self>, options: &SamplingOptions, progress: &mut dyn Follow) -> Result<Inference> {
        let options = &self.sampled_with(options);
        let until_stable = self.options.infer.until_stable;
        let begun = Instant::now();
        progress.step(Step::Sampling { graph: &self.graph, options, until_stable });
        let first = SamplingOptions { samples: if until_stable { FIRST_STABLE } else { options.samples }, ..options.clone() };
        let mut sampling = Sampling::new(&self.graph, &self.boundary, &first)?;
        let samples = sampling.samples();
        let fresh = sampling.part();
        let is_as_long = |part: &PartialRun| part.samples() == samples || until_stable && part.samples().is_power_of_two();
        let fits = |part: &PartialRun| part.uncertain() == fresh.uncertain() && is_as_long(part);
        let mut part = progress.resume(&self.key(options), &fits).unwrap_or(fresh);
        let before = part.done();
        let sampled = if until_stable {
            sampling.until_stable(&mut part, |result| all_decided(self.keep, &self.graph, result), progress)
        } else {
            sampling.sample(&mut part, progress).map(|()| sampling.likelihood(&part))
        };
        progress.sampled(&part, sampled.is_ok());
        let seconds = begun.elapsed().as_secs_f64();
        let method = sampling.method();
        let rate = (part.done() - before) as f64 / seconds;
        let (threads, instructions) = (rayon::current_num_threads(), method.instructions);
        let time = json!({ "sampling_s": seconds, "samples_per_s": rate, "threads": threads, "instructions": instructions });
        let (prepared, sampling, solver) = (self.clone(), options.clone(), method.into());
        Sampled { prepared, sampling, likelihood: sampled?, solver, time }.decide()
    }

    /// What there is to see of a run while it is at work: the answer of the samples that are finished, as if they were all. Which these are
    /// depends on the threads, so it is a look and not a result. `seconds` is how long they took.
    ///
    /// # Errors
    ///
    /// No sample is finished.
    pub fn so_far(self: &Arc<Self>, options: &SamplingOptions, part: &PartialRun, seconds: f64) -> Result<Inference> {
        let samples = part.done();
        require(samples > 0, "samples", samples, "expected finished ones")?;
        let sampling = SamplingOptions { samples, exact: false, ..self.sampled_with(options) };
        let again = Sampling::new(&self.graph, &self.boundary, &sampling)?;
        let time = json!({ "sampling_s": seconds, "samples_per_s": samples as f64 / seconds });
        let (likelihood, solver) = (again.likelihood(part), again.method().into());
        Sampled { prepared: self.clone(), sampling, likelihood, solver, time }.decide()
    }
}

impl Sampled {
    /// Decides on every vessel, given what the samples say.
    fn decide(self) -> Result<Inference> {
        let Prepared { graph, boundary, keep, options, arteries, .. } = &*self.prepared;
        let decision = decide(*keep, graph, &self.likelihood)?;
        let stable = options.infer.until_stable.then(|| all_decided(*keep, graph, &self.likelihood)).transpose()?;
        let (mut posterior, mut circle, mut supplies) = (None, None, Vec::new());
        if let Some(found) = arteries {
            let above = (!has_evidence(graph)).then_some(&decision.above_median[..]);
            let (topologies, how) =
                draw_topologies(Some(found), graph, boundary, &self.sampling, &self.prepared.given(), above, true)?;
            let phenotypes = &options.infer.phenotypes;
            let said = found.posterior_from(graph, &topologies, phenotypes)?;
            circle = Some(found.circle_figures(graph, &said.best(), &said.topology, phenotypes));
            posterior = Some((said, how));
            supplies = who_feeds(&found.circle, graph, &topologies.weighted, boundary, self.sampling.viscosity);
        }
        Ok(Inference { sampled: self, decision, stable, posterior, circle, supplies })
    }
}

impl Inference {
    /// The over-connected graph that was sampled; vessel i of the other answers is its edge i.
    pub fn graph(&self) -> &Network {
        &self.sampled.prepared.graph
    }

    /// Its boundary conditions.
    pub fn boundary(&self) -> &Boundary {
        &self.sampled.prepared.boundary
    }

    /// L of each vessel with its standard error, the frequency in the forests, and the matrix.
    pub fn likelihood(&self) -> &Likelihood {
        &self.sampled.likelihood
    }

    /// Per vessel whether it belongs to the plausible topology.
    pub fn kept(&self) -> &[bool] {
        &self.decision.kept
    }

    /// The decision on every vessel, with its threshold and what is undecided.
    pub fn decision(&self) -> &Decision {
        &self.decision
    }

    /// The plausible topology, with the conditions that hold in it: the vessels that are kept, as topology.graphml has them, whole where no
    /// candidate is left that ended on them.
    pub fn topology(&self) -> Network {
        self.outcome().topology(&self.decision.kept).network.into_owned()
    }

    /// What plausible topologies say of the Circle of Willis, where its arteries are known, and how the topologies were drawn.
    pub fn posterior(&self) -> Option<(&Posterior, &str)> {
        self.posterior.as_ref().map(|(posterior, how)| (posterior, how.as_str()))
    }

    /// The segments of the most probable variant of the circle that are thin; none where its arteries are not known.
    pub fn hypoplastic(&self) -> Vec<Artery> {
        self.circle.as_ref().map_or_else(Vec::new, CircleFigures::thin)
    }

    /// Everything that the files of the run are made of.
    pub fn outcome(&self) -> Outcome<'_> {
        let Sampled { prepared, sampling, likelihood: result, solver, .. } = &self.sampled;
        let Prepared { graph: network, early, boundary, contacts, image_places, keep, .. } = &**prepared;
        let topology = |kept: &[bool]| Topology::of(network, &result.uncertain, kept, &boundary.held(network, |row| kept[row]));
        Outcome {
            network,
            without_decisions: prepared.without_decisions(),
            own_nodes: early.own_nodes,
            boundary,
            suggested_cuts: &contacts.suggested,
            pairings: &contacts.pairings,
            arteries: prepared.arteries.as_ref().and_then(|found| found.named.as_ref()).map_or(&[], |named| &named.names[..]),
            image_places,
            segmentation: prepared.segmentation.as_ref(),
            result,
            rule: *keep,
            answer: &self.decision,
            stable: self.stable,
            kept: topology(&self.decision.kept),
            above_median: topology(&self.decision.above_median),
            expected: expected_errors(network, &self.decision.kept),
            sampling,
            solver,
        }
    }

    /// The same samples decided on by another rule; no command is known that makes this run.
    ///
    /// # Errors
    ///
    /// A rule that asks for evidence where there is none, or is out of its range.
    pub fn decided_by(&self, rule: Keep) -> Result<Self> {
        rule.validate()?;
        let mut sampled = self.sampled.clone();
        let prepared = Arc::make_mut(&mut sampled.prepared);
        (prepared.keep, prepared.options.infer.keep) = (rule, Some(rule));
        prepared.provenance.command.clear();
        sampled.decide()
    }

    /// The run again with decisions of a person, as if a list had all of them: accepted connections are certain, rejected ones are gone, those
    /// beside them follow, and then the graph is edited; in that, arteries, inlets and outlets are found. Decisions that the run was made with
    /// stay. What the page shows of an image stays where it was doubtful before. No command is known that makes this run.
    ///
    /// # Errors
    ///
    /// A row that is no candidate and no contact, or was decided on before; an edit whose places mean nothing here; as
    /// [`infer`](crate::infer).
    pub fn with_decisions(&self, made: &[ConnectionDecision], edits: &[GraphEdit], progress: &mut dyn Follow) -> Result<Self> {
        let mut prepared = Prepared::clone(&self.sampled.prepared);
        let mut decided = prepared.records.decisions.take().unwrap_or_default();
        decided.made.retain(|old| old.accepted.is_some() || made.iter().all(|new| new.edge != old.edge));
        if let Some(again) = made.iter().find(|new| decided.made.iter().any(|old| old.edge == new.edge)) {
            return Err(Error::parameter("decisions", again.edge, "was decided on before; expected another connection"));
        }
        decided.made.extend_from_slice(made);
        decided.edits.extend_from_slice(edits);
        let Prepared { graph, contacts, uniform_prior, undecided, .. } = prepared;
        let before = undecided.unwrap_or_else(|| Arc::new(Decidable { graph, contacts, uniform_prior }));
        let Decidable { graph, contacts, uniform_prior } = Decidable::clone(&before).decided(&decided)?;
        let arteries = prepared.early.arteries(&graph, Path::new(&prepared.provenance.input), &prepared.options)?;
        let mut notes = Notes { kept: std::mem::take(&mut prepared.provenance.notes), follow: progress };
        for note in arteries.iter().flat_map(|found| &found.notes) {
            if !notes.kept.contains(note) {
                notes.say(note.clone());
            }
        }
        prepared.provenance.notes = notes.kept;
        prepared.provenance.command.clear();
        let boundary = prepared.early.boundary(&graph, arteries.as_ref(), prepared.outlets, &prepared.options.infer, progress)?;
        prepared.records.decisions = Some(decided);
        let prepared = Prepared { graph, contacts, uniform_prior, undecided: Some(before), arteries, boundary, ..prepared };
        Arc::new(prepared).sample(&self.sampled.sampling, progress)
    }

    /// What a list decides, as the page of this run writes it, on the connections of its graph and by edits. `input_sha256` is that of the input.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or that was made for another input or another graph.
    pub fn listed_decisions(&self, path: &Path, input_sha256: &str) -> Result<(Vec<ConnectionDecision>, Vec<GraphEdit>)> {
        let Prepared { graph, undecided, .. } = &*self.sampled.prepared;
        let graph = undecided.as_ref().map_or(graph, |before| &before.graph);
        let Decided { made, edits, .. } = DecisionList::read(path)?.on(graph, input_sha256)?;
        Ok((made, edits))
    }

    /// The tables of nodes and of vessels, as nodes.csv and edges.csv have them.
    ///
    /// # Errors
    ///
    /// Pressures that cannot be solved for.
    pub fn tables(&self) -> Result<[Vec<Column>; 2]> {
        let outcome = self.outcome();
        Ok([topology_columns(&outcome, &self.decision.kept)?, vessel_columns(&outcome)])
    }

    /// What a person is asked, as review.csv has it; `None` where that is not written.
    pub fn review(&self) -> Option<Vec<Column>> {
        let outcome = self.outcome();
        review_columns(&outcome, &questions(&outcome))
    }

    /// SHA-256 of the input, as run.json has it.
    pub fn input_sha256(&self) -> &str {
        &self.sampled.prepared.provenance.sha256
    }

    /// Everything that it takes to make it again with [`Inference::from_bytes`].
    ///
    /// # Errors
    ///
    /// A graph with numbers that are not finite.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let stored = write_stored(&mut bytes, &self.sampled);
        stored.map(|()| bytes).map_err(|e| Error::parameter("run", "cannot be stored", e.to_string()))
    }

    /// What [`Inference::to_bytes`] stored.
    ///
    /// # Errors
    ///
    /// Other bytes, or some of them altered.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let wrong = |fault: Fault| Error::parameter("run", "cannot be read", format!("{}; {}", fault.found, fault.accepted));
        read_stored::<Sampled>(bytes).map_err(wrong)?.decide()
    }

    /// How long sampling took, s.
    pub fn seconds(&self) -> f64 {
        self.sampled.time["sampling_s"].as_f64().unwrap_or(f64::NAN)
    }

    /// Saves every file of the run in a new folder, which appears whole or not at all; returns what a person should know about files
    /// left out.
    ///
    /// # Errors
    ///
    /// The folder exists, or cannot be written.
    pub fn save(&self, folder: &Path, options: &SaveOptions) -> Result<Vec<String>> {
        let (_, notes) = StagedFolder::fill(folder, false, |staged| self.write(&staged.path(), options))?;
        Ok(notes)
    }

    /// Writes every file into a folder that is there; the record of the run, and what a person should know about files left out.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, options: &SaveOptions) -> Result<(RunRecord, Vec<String>)> {
        options.validate()?;
        let Sampled { prepared, sampling, time, .. } = &self.sampled;
        let outcome = self.outcome();
        let mut run = prepared.options.clone();
        run.infer.sampling = SamplingOptions { uniform_prior: false, ..sampling.clone() };
        let tables = outcome.write_tables(folder)?;
        let built = prepared.candidates.as_ref();
        let mut record = infer_record(&outcome, &prepared.provenance, &run, built, prepared.outlets);
        if let Value::Object(sources) = json!(prepared.records) {
            let stated = sources.into_iter().filter(|(_, source)| !source.is_null());
            stated.for_each(|(name, source)| record.field("parameters")[name] = source);
        }
        record.field("time").clone_from(time);
        if let (Some((posterior, _)), Some(circle), Some(found)) = (&self.posterior, &self.circle, &prepared.arteries) {
            let variant = posterior.best();
            let of = (&variant, circle, Some(posterior));
            let phenotype = phenotype_json(&prepared.graph, of);
            let subject = stem(Path::new(&prepared.provenance.input));
            write_phenotype(folder, &subject, of, &phenotype)?;
            *record.field("phenotype") = phenotype;
            record.field("parameters")["arteries"] = json!(found.known_by);
            record.field("parameters")["landmarks"] = json!(found.landmarks);
            *record.field("supply") = supply_json(&prepared.graph, &self.supplies);
            // For a later command to go on from: a search of the pose from other beginnings ends in other last digits.
            if found.landmarks.is_none() && found.named.is_some() {
                *record.field("named") = json!(found);
            }
            write_file(&folder.join(SUPPLY), |out| write_csv(out, &supply_columns(&prepared.graph, &self.supplies)))?;
            found.write_landmarks(folder)?;
        }
        let notes = outcome.write(folder, tables, &mut record, options.dpi)?;
        // Known only once all else is written.
        record.field("time")["wall_s"] = json!(prepared.started.elapsed().as_secs_f64());
        write_record(folder, &record)?;
        Ok((record, notes))
    }
}
