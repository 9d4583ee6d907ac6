//! `willis infer`: from centerlines or a candidate graph to the likelihood matrix and the plausible topology.

use std::{path::Path, path::PathBuf, sync::Arc, time::Instant};

use super::args::reading::{ReadingArgs, inputs_of_a_cohort};
use super::args::{ArteryArgs, CandidateArgs, options_for, probability, viscosity, whole, words};
use super::checkpoint::{Follower, Interval, parse_interval};
use super::cohort::{Cohort, FailedInput, Failure, Work};
use super::command_line::{LinePart, command_line, line_of, parsed, with_flags, with_options};
use super::print::inference::{say_circle, say_outcome};
use super::subjects::{Inputs, Subject, check_output, expand};
use super::{print::TextTerminal, shell::print_json, signals::listen};
use crate::internals::formats::{checksum_of_file, write_csv};
use crate::internals::output::names::{AGREEMENT, EDGES, GRAPH, NODES};
use crate::internals::output::{StagedFolder, write_error, write_file};
use crate::internals::pipeline::{RunOptions, require, require_in};
use crate::internals::report::cohort::{Figures, infer_figures};
use crate::internals::report::{RunRecord, agreement};
use crate::{
    ArterySource, BoundaryOptions, Error, InferOptions, Keep, Prepared, Preset, Result, SamplingOptions, SaveOptions, Solver,
    Uncertain, Weight, internals::report::figures::DEFAULT_DPI, prepare,
};

/// Infer the plausible topology of centerlines or of a candidate graph
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis infer extraction.vtp -o clean
  willis infer 'scans/*.swc' --landmarks '{}.landmarks.csv' -o cohort

--help lists every option.")]
pub struct InferArgs {
    #[arg(value_name = "INPUT", help = inputs_of_a_cohort(), required = true, value_hint = clap::ValueHint::FilePath, help_heading = None::<&str>)]
    inputs: Vec<PathBuf>,
    /// The folder to write; it must not exist, unless it is that of a cohort to go on with
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath, help_heading = "Input")]
    output: PathBuf,
    #[command(flatten)]
    inference: InferenceArgs,
}

/// How an input is read, sampled and decided on.
#[derive(Debug, clap::Args)]
pub struct InferenceArgs {
    #[command(flatten)]
    pub reading: ReadingArgs,
    #[command(flatten)]
    pub sampling: SamplingArgs,
    #[arg(long, value_name = "RULE", help_heading = "Answer", help = format!("Which uncertain vessels stay: {} [default: probable on tracings, \
        best-first on skeletons, reconnect where contacts were found, median without evidence]", Keep::HELP))]
    pub keep: Option<Keep>,
    /// What a person decided on connections, as report.html writes it (decisions.csv): accepted ones are certain, rejected ones are gone;
    /// {} in it is the path of INPUT without its ending
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath, help_heading = "Answer")]
    pub decisions: Option<PathBuf>,
    /// At how many of the most doubtful places at the most report.html shows the image, at 85 kB a place [default: 50]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_negative_numbers = true, help_heading = "Answer", hide_short_help = true)]
    pub image_places: Option<usize>,
    /// Resolution of the pictures
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DPI, value_parser = whole::<u32>, allow_negative_numbers = true,
        help_heading = "Answer", hide_short_help = true)]
    pub dpi: u32,
    /// Print run.json on standard output too, in a line for each occlusion probability; of a cohort, its row of each subject
    #[arg(long, help_heading = "Answer", hide_short_help = true)]
    pub json: bool,
    #[command(flatten)]
    pub candidates: CandidateArgs,
    #[command(flatten)]
    pub boundary: BoundaryOptions,
    #[command(flatten)]
    pub arteries: ArteryArgs,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Sampling")]
pub struct SamplingArgs {
    /// Occlusion probability, from 0 to below 1; several, with commas, make a folder each and a table of their agreement
    #[arg(long, value_name = "P,...", value_delimiter = ',', default_value = "0.5",
        value_parser = probability, allow_hyphen_values = true)]
    pub epsilon: Vec<f64>,
    /// How many samples to draw
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1000, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub samples: u64,
    /// Instead of --samples: double the samples until every decision is two standard errors from flipping, up to 2^20
    #[arg(long, value_name = "stable", conflicts_with = "samples", value_parser = ["stable"], hide_short_help = true)]
    pub until: Option<String>,
    /// Enumerate every occlusion pattern of up to 20 uncertain vessels: the expectation, without Monte-Carlo error
    #[arg(long, conflicts_with = "until", hide_short_help = true)]
    pub exact: bool,
    /// Every choice as in Moriconi et al. 2019, unless an option says otherwise
    #[arg(long, value_parser = words::<Preset>(&[("paper", "--prior uniform --uncertain all --attach ends --candidate-radius mean --outlets ground --keep median --cut never. \
        Resistances that a file or an option states at outlets stay, where the paper has ground only; a note says so. Inlets and outlets that are found hold in every sample, as those that are stated; by default only where the end is no gap")]))]
    pub preset: Option<Preset>,
    /// The seed; the same command with the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub seed: u64,
    /// Where the input cannot be used, write why to FOLDER, as failed.json alone, and end with status 0: willis merge makes a row of it
    #[arg(long, hide_short_help = true)]
    pub record_failure: bool,
    /// How often what is finished is kept beside FOLDER, in .willis-FOLDER, for the same command to go on from after a stop or a kill: auto
    /// (once sampling takes over a minute), off, or so many seconds apart; Ctrl-C keeps it at once
    #[arg(long, value_name = "auto|off|SECONDS", default_value = "auto", value_parser = parse_interval, hide_short_help = true)]
    pub checkpoint: Interval,
    /// Which vessels may be occluded and pruned [default: candidates]
    #[arg(long, value_parser = words::<Uncertain>(&[("candidates", "Candidates must earn their place, observed vessels stay"),
        ("all", "Every vessel must, as in the paper")]))]
    pub uncertain: Option<Uncertain>,
    /// What a vessel adds to its likelihood when it is in a sample's forest
    #[arg(long, default_value = "resilience", hide_short_help = true, value_parser = words::<Weight>(&[("resilience", "Its resilience, as in the paper"),
        ("count", "One"), ("global", "The resilience of the whole network")]))]
    pub weight: Weight,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP", value_parser = viscosity, hide_short_help = true)]
    pub viscosity: f64,
    /// The flow solver
    #[arg(long, default_value = "auto", hide_short_help = true, value_parser = words::<Solver>(&[("auto", "By the structure of the graph"),
        ("lanes", "Star-mesh elimination, many samples at a time"),
        ("gradients", "Preconditioned conjugate gradients, many samples at a time, for large meshes"),
        ("reference", "The paper's loop as it is written, a sample at a time: slow, to compare with")]))]
    pub solver: Solver,
}

impl SamplingArgs {
    /// Puts what was given in the place of the `usual` options, for each of the occlusion probabilities.
    pub fn put(&self, usual: &SamplingOptions) -> Result<Vec<SamplingOptions>> {
        let Self { samples, seed, weight, solver, exact, viscosity, .. } = *self;
        let uncertain = self.uncertain.unwrap_or(usual.uncertain);
        let each = self.epsilon.iter().enumerate().map(|(at, epsilon)| {
            require(!self.epsilon[..at].contains(epsilon), "epsilon", epsilon, "given twice; expected each probability once")?;
            let of_sampling = SamplingOptions { samples, seed, uncertain, weight, solver, exact, viscosity, ..usual.clone() };
            let options = SamplingOptions { epsilon: *epsilon, ..of_sampling };
            options.validate()?;
            Ok(options)
        });
        each.collect()
    }
}

/// The same work on every input, be it one or a cohort of them.
pub struct Inferences {
    args: InferenceArgs,
    options: InferOptions,
    /// A run for each occlusion probability.
    runs: Vec<SamplingOptions>,
    save: SaveOptions,
}

impl InferArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let start = Instant::now();
        let work = Inferences::new(self.inference)?;
        let input = match expand(&self.inputs, false)? {
            Inputs::One(input) => input,
            Inputs::Many(subjects) => {
                let work = work.of_a_cohort();
                let (parameters, json) = (work.of_many()?, work.args.json);
                let cohort = Cohort { command: "infer", parameters, output: &self.output, force, json };
                return cohort.run(&subjects, &work, terminal);
            }
        };
        let read = work.files(&input);
        check_output(&self.output, force, read.iter().map(|path| &**path).chain([&*input]))?;
        let records_failure = work.args.sampling.record_failure;
        if records_failure {
            work.args.reading.shared()?;
        }
        let records = match work.one(&input, &self.output, terminal, force) {
            Err(error) if records_failure && Failure::is_of_input(&error) => {
                let error = with_flags(&error);
                terminal.say("failed", &error);
                return work.failure(&input, command_line("again"), error)?.write(&self.output, force);
            }
            made => made?,
        };
        if work.args.json {
            records.iter().try_for_each(print_json)?;
        }
        terminal.say("written", format!("{} in {:.1} s", self.output.display(), start.elapsed().as_secs_f64()));
        Ok(())
    }

    /// The options of the library for an input, of one run.
    pub(super) fn meaning(self, input: &Path) -> Result<InferOptions> {
        let work = Inferences::new(self.inference)?;
        work.refuse_several("expected one probability a run")?;
        Ok(work.for_input(input))
    }
}

impl Inferences {
    /// The work that the arguments ask for.
    pub fn new(args: InferenceArgs) -> Result<Self> {
        let is_paper = args.sampling.preset == Some(Preset::Paper);
        let mut options = if is_paper { InferOptions::paper() } else { InferOptions::default() };
        options.keep = args.keep.or(options.keep);
        let runs = args.sampling.put(&options.sampling)?;
        options.sampling.clone_from(&runs[0]);
        options.until_stable = args.sampling.until.is_some();
        let found_outlets = args.boundary.found_outlets.or(options.boundary.found_outlets);
        options.boundary = BoundaryOptions { found_outlets, ..args.boundary.clone() };
        args.candidates.put(&mut options);
        options.arteries = args.arteries.source();
        options.phenotypes = args.arteries.phenotypes.clone();
        options.decisions.clone_from(&args.decisions);
        options.image_places = args.image_places;
        options.validate()?;
        let save = SaveOptions { dpi: args.dpi };
        save.validate()?;
        Ok(Self { args, options, runs, save })
    }

    /// The same for an input of several: its arteries are named, if it has a circle and nobody says where they are.
    fn of_a_cohort(mut self) -> Self {
        self.options.arteries = self.options.arteries.or(Some(ArterySource::Geometry));
        self
    }

    /// The command line that repeats the run of a subject.
    fn line_of(&self, subject: &Subject) -> String {
        let is_by_itself = self.options.arteries.is_some() && self.args.arteries.source().is_none();
        let named = is_by_itself.then(|| LinePart::option("landmarks", "auto"));
        line_of(with_options(subject.parts.clone(), named), "again")
    }

    /// Why an input gave no run.
    pub fn failure(&self, input: &Path, command: String, error: String) -> Result<Failure> {
        // Of an input that does not state its spacing, what all inputs share.
        let read = self.args.reading.options(input).or_else(|_| self.args.reading.shared())?;
        let options = RunOptions { read, infer: self.for_input(input) };
        let input = FailedInput { path: input.display().to_string(), sha256: checksum_of_file(input).ok() };
        Ok(Failure { willis: env!("CARGO_PKG_VERSION").to_owned(), command, input, options, error })
    }

    /// The options for an input, each file that is named for all inputs being that of this one.
    fn for_input(&self, input: &Path) -> InferOptions {
        options_for(self.options.clone(), input)
    }

    /// Reads an input and makes ready all that its samples need; `command` is the line that repeats its run.
    fn prepared(&self, input: &Path, command: String, terminal: TextTerminal) -> Result<Arc<Prepared>> {
        let accepted = "expected a file, such as topology.graphml or candidates.graphml in it";
        require_in(input, !input.is_dir(), "a folder of willis infer", accepted)?;
        let read = self.args.reading.read(input, command, terminal)?;
        prepare(read, &self.for_input(input), &mut Follower::new(terminal))
    }

    /// The output folder of one input.
    fn one(&self, input: &Path, output: &Path, terminal: TextTerminal, force: bool) -> Result<Vec<RunRecord>> {
        let prepared = self.prepared(input, command_line("again"), terminal)?;
        listen(1);
        StagedFolder::fill(output, force, |folder| self.write(&prepared, folder, terminal))
    }

    /// Writes the folder of an input, or one in it for each of several occlusion probabilities.
    fn write(&self, prepared: &Arc<Prepared>, folder: &StagedFolder, terminal: TextTerminal) -> Result<Vec<RunRecord>> {
        let path = folder.path();
        // Before the first of several looks at what is there.
        for options in &self.runs {
            Follower::file(folder, &prepared.key(options));
        }
        let (mut decisions, mut records) = (Vec::new(), Vec::new());
        for options in &self.runs {
            let mut sub = path.clone();
            if self.runs.len() > 1 {
                sub = path.join(format!("epsilon-{}", options.epsilon));
                std::fs::create_dir(&sub).map_err(write_error(&sub))?;
            }
            let (interval, command) = (self.args.sampling.checkpoint, &prepared.provenance.command);
            let mut follower = Follower::keeping(terminal, interval, folder, command);
            let written = prepared.sample(options, &mut follower).and_then(|inference| {
                say_outcome(terminal, &inference.outcome(), inference.seconds());
                let (record, notes) = inference.write(&sub, &self.save)?;
                terminal.notes(&notes);
                say_circle(terminal, &inference);
                let (done, total) = follower.samples();
                // Nothing is written after a stop.
                let stopped = terminal.is_stopped().then_some(Error::Stopped { done, total });
                stopped.map_or_else(|| Ok((inference.decision().clone(), record)), Err)
            });
            let (done, total) = follower.samples();
            let stopped = |error| terminal.stopped(error, done, total);
            let (decision, record) = written.map_err(stopped).map_err(|error| follower.rescue(error))?;
            decisions.push((options.epsilon, decision));
            records.push(record);
        }
        if self.runs.len() > 1 {
            let uncertain = self.runs[0].uncertain.vessels(&prepared.graph);
            write_file(&path.join(AGREEMENT), |out| write_csv(out, &agreement(&decisions, &uncertain)))?;
        }
        Ok(records)
    }

    fn refuse_several(&self, accepted: &str) -> Result<()> {
        let given: Vec<String> = self.args.sampling.epsilon.iter().map(f64::to_string).collect();
        require(self.runs.len() == 1, "epsilon", given.join(","), accepted)
    }

    /// Every option that changes a result of many inputs; refuses those that go with one.
    pub fn of_many(&self) -> Result<serde_json::Value> {
        let args = &self.args;
        self.refuse_several("several go with one INPUT; give one for a cohort")?;
        let accepted = "goes with one INPUT; a cohort has its failures as rows";
        require(!args.sampling.record_failure, "record_failure", "with several", accepted)?;
        args.reading.parameters(self.options.clone())
    }
}

impl Work for Inferences {
    const FIGURES: fn(&serde_json::Value) -> Figures = infer_figures;
    const READ_AGAIN: &[&str] = &[GRAPH, EDGES, NODES];

    fn of(words: &[String]) -> Result<Self> {
        let work = Self::new(parsed::<InferArgs>(words)?.inference)?;
        work.args.reading.shared()?;
        Ok(work.of_a_cohort())
    }

    fn files(&self, input: &Path) -> Vec<PathBuf> {
        self.args.reading.loops(input).into_iter().chain(self.for_input(input).files()).collect()
    }

    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: TextTerminal) -> Result<()> {
        let prepared = self.prepared(&subject.input, self.line_of(subject), terminal)?;
        self.write(&prepared, folder, terminal).map(drop)
    }
}
