//! What `willis infer` does with every input, be it one or a cohort of them.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::Value;
use willis::error::{Error, Fault, Result};
use willis::internals::decision::{Keep, ROOT_FACTOR, knows_fragments};
use willis::internals::network::RadiusRule;
use willis::internals::output::StagedFolder;
use willis::internals::report::cohort::{Figures, infer_figures};
use willis::internals::sampling::SamplingOptions;

use super::boundary::say_boundary;
use super::cohort::{Cohort, Work};
use super::failure::Failure;
use super::infer::InferArgs;
use super::job::Job;
use super::loaded::Loaded;
use super::plausible::state_inlets;
use super::prior::Prior;
use super::provenance::{command_line, command_line_of};
use super::shard::samples_of;
use super::subjects::Subject;
use super::tell::say_built;
use super::terminal::Terminal;

/// What is done with every input.
pub struct Inference<'a> {
    pub args: &'a InferArgs,
    pub rule: Option<Keep>,
    pub runs: Vec<SamplingOptions>,
}

impl Inference<'_> {
    /// Reads an input and makes ready all that its samples need; `command` is the line that repeats its run.
    pub fn job(&self, input: &Path, command: String, terminal: Terminal) -> Result<Job> {
        let args = self.args;
        if input.is_dir() {
            let accepted = "expected a file, such as topology.graphml or candidates.graphml in it";
            return Err(Fault::file("a folder of willis infer", accepted).in_file(input));
        }
        let mut loaded = Loaded::read(input, &args.reading, command, terminal)?;
        let scale = args.reading.scale()?;
        if args.circle.is_given() && !args.circle.is_by_landmarks() && loaded.fragments {
            loaded.divide_by_labels();
        }
        // Landmarks are found before candidates make new nodes; labels after, when every vessel has its row.
        let mut circle = None;
        if args.circle.is_by_landmarks() {
            let found = args.circle.find(input, &loaded.network, &scale)?;
            if !args.boundary.states_an_inlet() {
                state_inlets(&mut loaded.network, &found.circle);
            }
            circle = Some(found);
        }
        let prior = args.prior.resolve(&loaded, args.sampling.paper())?;
        let params = args.candidates.params(loaded.radius_rule, args.sampling.paper(), prior.is_evidence())?;
        let outlets = args.boundary.found_outlets(loaded.fragments && !args.sampling.paper())?;
        let boundary = args.boundary.resolve(input, &loaded.network, outlets, terminal)?;
        let graph = prior.graph(&mut loaded, &boundary, &params)?;
        let usual = if knows_fragments(&graph) && !args.sampling.paper() { Keep::Probable(ROOT_FACTOR) } else { Keep::Median };
        let boundary = boundary.extended_to(graph.node_count());
        if loaded.fragments {
            let note = say_built(terminal, &graph, &params, prior.is_evidence());
            loaded.provenance.notes.extend(note.map(str::to_owned));
        }
        say_boundary(terminal, &graph, &boundary);
        if args.circle.is_given() && circle.is_none() {
            circle = Some(args.circle.find(input, &graph, &scale)?);
        }
        for note in circle.iter().flat_map(|found| &found.notes) {
            terminal.say("note", note);
            loaded.provenance.notes.push(note.clone());
        }
        Ok(Job {
            circle,
            graph,
            boundary,
            outlets,
            provenance: loaded.provenance,
            prior: prior.record(),
            uniform_prior: matches!(prior, Prior::Uniform),
            candidates: loaded.fragments.then_some(params),
            rule: self.rule.unwrap_or(usual),
            until_stable: args.sampling.until.is_some(),
            paper: args.sampling.paper(),
            dpi: args.dpi,
        })
    }

    /// Refuses options that are wrong whatever the input.
    pub fn check(&self) -> Result<()> {
        self.args.reading.check()?;
        self.args.prior.check()?;
        self.args.candidates.params(RadiusRule::Mean, self.args.sampling.paper(), false).map(drop)
    }

    /// Hands an error on, or records it in the place of the run where it is one of the input.
    pub fn fail(&self, error: Error, input: &Path, blocks: Option<&Range<u64>>, force: bool, terminal: Terminal) -> Result<()> {
        if !self.args.sampling.record_failure || !Failure::is_of_input(&error) {
            return Err(error);
        }
        let range = blocks.map(|blocks| samples_of(blocks, self.args.sampling.samples));
        terminal.say("failed", error.to_string());
        Failure::of(input, command_line(), range, &error).write(&self.args.output, force)
    }

    pub fn cohort(&self, subjects: &[Subject], terminal: Terminal, force: bool) -> Result<()> {
        let args = self.args;
        if self.runs.len() > 1 {
            let given: Vec<String> = args.sampling.epsilon.iter().map(f64::to_string).collect();
            return Err(Error::parameter("--epsilon", given.join(","), "several go with one INPUT; give one for a cohort"));
        }
        if let Some(range) = &args.sampling.range {
            return Err(Error::parameter("--range", range, "goes with one INPUT; shard the run of each subject by itself"));
        }
        if args.sampling.record_failure {
            return Err(Error::parameter(
                "--record-failure",
                "with several",
                "goes with one INPUT; a cohort has its failures as rows",
            ));
        }
        self.check()?;
        let parameters = serde_json::to_value(args).map_err(|e| Error::parameter("arguments", "", e.to_string()))?;
        let cohort = Cohort { command: "infer", parameters, output: &args.output, force, json: args.json };
        cohort.run(subjects, self, terminal)
    }
}

impl Work for Inference<'_> {
    fn files(&self, input: &Path) -> Vec<PathBuf> {
        let args = self.args;
        [args.reading.loops(input), args.boundary.file(input), args.prior.file(), args.circle.file(input)]
            .into_iter()
            .flatten()
            .collect()
    }

    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: Terminal) -> Result<()> {
        let start = Instant::now();
        let command = command_line_of(&subject.input, &self.args.inputs);
        self.job(&subject.input, command, terminal)?
            .write(&self.runs, folder, self.args.sampling.checkpoint, start, terminal)
            .map(drop)
    }

    fn figures(&self, record: &Value) -> Figures {
        infer_figures(record)
    }
}
