//! The inference of one input: samples it, decides, writes its folder.

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use willis::candidates;
use willis::error::{Error, Result};
use willis::formats::write_csv;
use willis::hemodynamics::{Boundary, FoundOutlets};
use willis::inference::{Answer, Keep, Params, Topology, decide, expected_errors, has_evidence, infer, infer_until_stable};
use willis::network::Network;
use willis::report::staged::{write_file, write_record};
use willis::report::summary::Built;
use willis::report::{Outcome, Provenance, Summary, agreement, phenotype_json, write_outcome, write_phenotype};

use super::circle::Found;
use super::run::{Run, posterior};
use super::tell::{say_outcome, say_variant};
use super::terminal::{Terminal, count, plural};

/// An input made ready: what all its occlusion probabilities share.
pub struct Job {
    pub graph: Network,
    pub boundary: Boundary,
    pub outlets: FoundOutlets,
    pub provenance: Provenance,
    /// The record of the prior.
    pub prior: Value,
    pub uniform_prior: bool,
    /// How candidates were built; `None` for a ready graph.
    pub candidates: Option<candidates::Params>,
    pub rule: Keep,
    pub until_stable: bool,
    pub paper: bool,
    pub dpi: u32,
    /// Where the arteries of a Circle of Willis are, where that is asked for.
    pub circle: Option<Found>,
}

impl Job {
    /// Writes the folder of an inference, or one for each of several `runs`, and returns their records; `start` is when the work
    /// on the input began.
    pub fn write(&self, runs: &[Params], folder: &Path, start: Instant, terminal: Terminal) -> Result<Vec<Summary>> {
        let seconds = || start.elapsed().as_secs_f64();
        if let [params] = runs {
            return Ok(vec![self.run(params, folder, &seconds, terminal)?.1]);
        }
        let (mut decisions, mut records) = (Vec::new(), Vec::new());
        for params in runs {
            let sub = folder.join(format!("epsilon-{}", params.epsilon));
            std::fs::create_dir(&sub).map_err(|source| Error::Write { path: sub.clone(), source })?;
            let (answer, record) = self.run(params, &sub, &seconds, terminal)?;
            decisions.push((params.epsilon, answer));
            records.push(record);
        }
        let uncertain = runs[0].uncertain.vessels(&self.graph);
        write_file(&folder.join("agreement.csv"), |out| write_csv(out, &agreement(&decisions, &uncertain)))?;
        Ok(records)
    }

    fn run(&self, params: &Params, folder: &Path, seconds: &dyn Fn() -> f64, terminal: Terminal) -> Result<(Answer, Summary)> {
        let start = Instant::now();
        let params = &Params { uniform_prior: self.uniform_prior, ..params.clone() };
        let trial = params.uncertain.vessels(&self.graph).iter().filter(|u| **u).count();
        let threads = rayon::current_num_threads();
        let how = format!(
            "epsilon {}, {} samples, seed {}, {}",
            params.epsilon,
            count(params.samples),
            params.seed,
            plural(threads, "thread")
        );
        terminal.say(
            "sampling",
            format!("{how}: {} of {} on trial", count(trial as u64), plural(self.graph.vessel_count(), "vessel")),
        );
        let mut progress = terminal.progress("sampling", "samples", params.samples);
        let sampled = if self.until_stable {
            infer_until_stable(&self.graph, &self.boundary, params, self.rule, &mut progress)
        } else {
            infer(&self.graph, &self.boundary, params, &mut progress)
        };
        progress.finish();
        let (result, method) = sampled?;
        let sampling = start.elapsed().as_secs_f64();
        let answer = decide(self.rule, &self.graph, &result)?;
        let topology = |kept: &[bool]| Topology::of(&self.graph, &result.uncertain, kept, &self.boundary);
        let outcome = Outcome {
            network: &self.graph,
            boundary: &self.boundary,
            result: &result,
            rule: self.rule,
            answer: &answer,
            kept: topology(&answer.kept),
            above_median: topology(&answer.above_median),
            expected: expected_errors(&self.graph, &answer.kept),
            uniform_prior: params.uniform_prior,
            method,
            weight: params.weight,
            exact: params.exact,
            viscosity: params.viscosity,
        };
        let built = self.candidates.as_ref().map_or(Built::Given, Built::Candidates);
        let mut summary = Summary::new(&outcome, &self.provenance, params, built, self.outlets);
        summary.state_prior(self.prior.clone());
        if self.paper {
            summary.follow_the_paper();
        }
        summary.time = json!({ "sampling_s": sampling, "samples_per_s": result.samples as f64 / sampling, "threads": threads, "instructions": method.instructions });
        say_outcome(terminal, &outcome, sampling);
        for note in write_outcome(folder, &outcome, &mut summary, self.dpi)? {
            terminal.say("note", note);
        }
        if let Some(found) = &self.circle {
            let conditions = self.boundary.conditions.iter().map(|(node, _)| *node);
            let given: Vec<usize> = conditions.filter(|node| !self.boundary.is_found(*node)).collect();
            let above = (!has_evidence(&self.graph)).then_some(&answer.above_median[..]);
            let (posterior, how) = posterior(&self.graph, &self.boundary, params, &found.circle, &given, above)?;
            let variant = posterior.best();
            terminal.say("drawn", how);
            say_variant(terminal, &variant, Some(&posterior));
            let phenotype = phenotype_json(&self.graph, &variant, Some(&posterior));
            write_phenotype(folder, &Run::subject(Path::new(&self.provenance.input)), &variant, Some(&posterior), &phenotype)?;
            summary.state_phenotype(phenotype, found.known_by, found.record());
        }
        // Known only once all else is written.
        summary.time["wall_s"] = json!(seconds());
        write_record(folder, &summary)?;
        Ok((answer, summary))
    }
}
