//! `willis infer`: from centerlines or a candidate graph to the likelihood matrix and the plausible topology.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, FromArgMatches, ValueEnum};
use serde::Serialize;
use serde_json::Value;
use willis::error::{Error, Result};
use willis::inference::{Keep, Params, ROOT_FACTOR, Solver, Uncertain, Weight, knows_fragments};
use willis::network::RadiusRule;
use willis::report::StagedFolder;
use willis::report::cohort::{Figures, infer_figures};
use willis::report::plots::{DEFAULT_DPI, check_dpi};

use super::boundary::{BoundaryArgs, say_boundary};
use super::checkpoint::{Interval, parse_interval};
use super::circle::CircleArgs;
use super::cohort::{Cohort, Work};
use super::failure::Failure;
use super::input::{CandidateArgs, ReadingArgs, viscosity};
use super::job::Job;
use super::keep::parse_rule;
use super::prior::{Prior, PriorArgs};
use super::provenance::{command_line, command_line_of, words_of};
use super::run::state_inlets;
use super::shard::{blocks_of, samples_of, write_shard};
use super::shell::print_json;
use super::subjects::{Inputs, Subject, expand};
use super::tell::say_built;
use super::terminal::{Terminal, listen};

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum OnTrial {
    /// Candidates must earn their place, observed vessels stay
    Candidates,
    /// Every vessel is on trial, as in the paper
    All,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Contribution {
    /// Its resilience, as in the paper
    Resilience,
    /// One
    Count,
    /// The resilience of the whole network
    Global,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Until {
    Stable,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Preset {
    /// --prior uniform --uncertain all --attach ends --candidate-radius mean --outlets ground
    Paper,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum SolverName {
    /// By the structure of the graph
    Auto,
    /// Star-mesh elimination, many samples at a time
    Lanes,
    /// Preconditioned conjugate gradients, many samples at a time, for large meshes
    Gradients,
    /// Sparse Cholesky factorisation, a sample at a time
    Cholesky,
}

/// Infer the plausible topology of centerlines or of a candidate graph
#[derive(Debug, Args, Serialize)]
pub struct InferArgs {
    /// Centerlines (SWC, VTP, VTK, TRE, Slicer markups, iCafe, Voreen, VesselVio, NPZ, MAT, CSV of points) or a candidate graph
    /// (GraphML, CSV of edges); several, or a pattern in quotes ('scans/*.swc'), are a cohort: a folder each, and a table of all
    #[arg(value_name = "INPUT", required = true, value_hint = clap::ValueHint::FilePath, help_heading = "Input")]
    #[serde(skip)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    reading: ReadingArgs,
    /// The folder to write; it must not exist, unless it is that of a cohort to go on with
    #[serde(skip)]
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Occlusion probability; several, with commas, make a folder each and a table of their agreement
    #[arg(
        long,
        value_name = "P,...",
        value_delimiter = ',',
        default_value = "0.5",
        help_heading = "Sampling",
        allow_hyphen_values = true
    )]
    epsilon: Vec<f64>,
    /// Samples
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1000, help_heading = "Sampling")]
    samples: u64,
    /// Instead of --samples: double the samples until every decision is two standard errors from flipping, up to 2^20
    #[arg(long, value_enum, value_name = "stable", conflicts_with = "samples", help_heading = "Sampling")]
    until: Option<Until>,
    /// Enumerate every occlusion pattern of up to 20 vessels on trial: the expectation, without Monte-Carlo error
    #[arg(long, conflicts_with = "until", help_heading = "Sampling")]
    exact: bool,
    /// Every choice as in Moriconi et al. 2019, unless an option says otherwise
    #[arg(long, value_enum, help_heading = "Sampling")]
    preset: Option<Preset>,
    /// The seed; the same command with the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 0, help_heading = "Sampling")]
    seed: u64,
    /// Only samples A up to, not including, B of the --samples, each a multiple of 64 or the last: a shard of the run, for willis merge
    #[serde(skip)]
    #[arg(long, value_name = "A..B", conflicts_with_all = ["until", "exact", "json"], help_heading = "Sampling", allow_hyphen_values = true)]
    range: Option<String>,
    /// Where the input cannot be used, write why to OUT, as failed.json alone, and end with status 0: willis merge makes a row of it
    #[serde(skip)]
    #[arg(long, help_heading = "Sampling")]
    record_failure: bool,
    /// How often what is finished is kept beside OUT, in .willis-NAME, for the same command to go on from after a stop or a kill: auto
    /// (once sampling takes over a minute), off, or so many seconds apart; Ctrl-C keeps it at once
    #[serde(skip)]
    #[arg(
        long,
        value_name = "auto|off|SECONDS",
        default_value = "auto",
        value_parser = parse_interval,
        help_heading = "Sampling"
    )]
    checkpoint: Interval,
    /// Which vessels may be occluded and pruned [default: candidates]
    #[arg(long, value_enum, help_heading = "Sampling")]
    uncertain: Option<OnTrial>,
    /// What a vessel adds to its likelihood when it is in a sample's forest
    #[arg(long, value_enum, default_value = "resilience", help_heading = "Sampling")]
    weight: Contribution,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP", help_heading = "Sampling")]
    viscosity: String,
    /// The flow solver
    #[arg(long, value_enum, default_value = "auto", help_heading = "Sampling")]
    solver: SolverName,
    /// Which vessels on trial stay: probable[=ROOT_FACTOR] (the most probable forest; a smaller factor leaves fewer fragments
    /// alone), median (of L, as in the paper), quantile=Q, value=X (W/m3), otsu, frequency=F, probability=P
    /// [default: probable where candidates come with evidence, else median]
    #[arg(long, value_name = "RULE", help_heading = "Answer")]
    keep: Option<String>,
    /// Resolution of the pictures
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DPI, help_heading = "Answer")]
    dpi: u32,
    /// Print run.json on standard output too, in a line for each occlusion probability; of a cohort, its row of each subject
    #[serde(skip)]
    #[arg(long, help_heading = "Answer")]
    json: bool,
    #[command(flatten)]
    #[serde(flatten)]
    candidates: CandidateArgs,
    #[command(flatten)]
    #[serde(flatten)]
    prior: PriorArgs,
    #[command(flatten)]
    #[serde(flatten)]
    boundary: BoundaryArgs,
    #[command(flatten)]
    #[serde(flatten)]
    circle: CircleArgs,
}

impl InferArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let start = Instant::now();
        let rule = self.keep.as_deref().map(parse_rule).transpose()?;
        let runs = self.epsilon.iter().map(|epsilon| self.params(*epsilon)).collect::<Result<Vec<Params>>>()?;
        if let Some(epsilon) = (1..runs.len()).map(|i| self.epsilon[i]).enumerate().find(|(i, e)| self.epsilon[..=*i].contains(e))
        {
            return Err(Error::parameter("--epsilon", epsilon.1, "given twice; expected each probability once"));
        }
        let range = self.range.as_deref().map(|text| blocks_of(text, self.samples)).transpose()?;
        if let (Some(range), true) = (&self.range, runs.len() > 1) {
            return Err(Error::parameter("--range", range, "goes with one --epsilon; shard the run of each by itself"));
        }
        self.boundary.found_outlets(true)?;
        check_dpi(self.dpi)?;
        let inference = Inference { args: &self, rule, runs };
        let input = match expand(&self.inputs)? {
            Inputs::One(input) => input,
            Inputs::Many(subjects) => return inference.cohort(&subjects, terminal, force),
        };
        StagedFolder::check(&self.output, force)?;
        if self.record_failure {
            inference.check()?;
        }
        let job = match inference.job(&input, command_line(), terminal) {
            Err(error) => return inference.fail(error, &input, range.as_ref(), force, terminal),
            Ok(job) => job,
        };
        listen();
        let folder = StagedFolder::new(&self.output, force)?;
        let written = match &range {
            None => job.write(&inference.runs, &folder, self.checkpoint, start, terminal),
            Some(blocks) => {
                let shard = write_shard(job, &inference.runs[0], blocks, &folder, self.checkpoint, terminal);
                shard.map(|()| Vec::new())
            }
        };
        let records = match written {
            Err(error) => {
                drop(folder);
                return inference.fail(error, &input, range.as_ref(), force, terminal);
            }
            Ok(records) => records,
        };
        folder.commit()?;
        if self.json {
            records.iter().try_for_each(print_json)?;
        }
        terminal.say("written", format!("{} in {:.1} s", self.output.display(), start.elapsed().as_secs_f64()));
        Ok(())
    }

    /// All options of a command line that change a result, as the ledger of a cohort has them; `None` for another command's.
    pub fn parameters_of(command: &str) -> Option<Value> {
        let words = words_of(command);
        let options = words.strip_prefix(&["willis".to_owned(), "infer".to_owned()][..])?;
        let all = ["infer", "--output", "-"].map(str::to_owned).into_iter().chain(options.iter().cloned());
        let matches = Self::augment_args(clap::Command::new("infer")).try_get_matches_from(all).ok()?;
        serde_json::to_value(Self::from_arg_matches(&matches).ok()?).ok()
    }

    fn paper(&self) -> bool {
        self.preset == Some(Preset::Paper)
    }

    fn params(&self, epsilon: f64) -> Result<Params> {
        let paper = self.paper();
        let params = Params {
            epsilon,
            samples: self.samples,
            seed: self.seed,
            uncertain: match self.uncertain.unwrap_or(if paper { OnTrial::All } else { OnTrial::Candidates }) {
                OnTrial::Candidates => Uncertain::Candidates,
                OnTrial::All => Uncertain::All,
            },
            weight: match self.weight {
                Contribution::Resilience => Weight::Resilience,
                Contribution::Count => Weight::Count,
                Contribution::Global => Weight::Global,
            },
            uniform_prior: false,
            viscosity: viscosity(&self.viscosity)?,
            solver: match self.solver {
                SolverName::Auto => Solver::Auto,
                SolverName::Lanes => Solver::Lanes,
                SolverName::Gradients => Solver::Gradients,
                SolverName::Cholesky => Solver::Cholesky,
            },
            exact: self.exact,
        };
        params.validate()?;
        Ok(params)
    }
}

/// What is done with every input.
struct Inference<'a> {
    args: &'a InferArgs,
    rule: Option<Keep>,
    runs: Vec<Params>,
}

impl Inference<'_> {
    /// Reads an input and makes ready all that its samples need; `command` is the line that repeats its run.
    fn job(&self, input: &Path, command: String, terminal: Terminal) -> Result<Job> {
        let args = self.args;
        let mut loaded = args.reading.load(input, command, terminal)?;
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
        let prior = args.prior.resolve(&loaded, args.paper())?;
        let params = args.candidates.params(loaded.radius_rule, args.paper(), prior.is_evidence())?;
        let outlets = args.boundary.found_outlets(loaded.fragments && !args.paper())?;
        let boundary = args.boundary.resolve(input, &loaded.network, outlets, terminal)?;
        let graph = prior.graph(&mut loaded, &boundary, &params)?;
        let usual = if knows_fragments(&graph) && !args.paper() { Keep::Probable(ROOT_FACTOR) } else { Keep::Median };
        let boundary = boundary.extended_to(graph.node_count());
        if loaded.fragments {
            say_built(terminal, &graph, &params, prior.is_evidence());
        }
        say_boundary(terminal, &graph, &boundary);
        if args.circle.is_given() && circle.is_none() {
            circle = Some(args.circle.find(input, &graph, &scale)?);
        }
        for note in circle.iter().flat_map(|found| &found.notes) {
            terminal.say("note", note);
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
            until_stable: args.until.is_some(),
            paper: args.paper(),
            dpi: args.dpi,
        })
    }

    /// Refuses options that are wrong whatever the input.
    fn check(&self) -> Result<()> {
        self.args.reading.check()?;
        self.args.prior.check()?;
        self.args.candidates.params(RadiusRule::Mean, self.args.paper(), false).map(drop)
    }

    /// Hands an error on, or records it in the place of the run where it is one of the input.
    fn fail(&self, error: Error, input: &Path, blocks: Option<&Range<u64>>, force: bool, terminal: Terminal) -> Result<()> {
        if !self.args.record_failure || !Failure::is_of_input(&error) {
            return Err(error);
        }
        let range = blocks.map(|blocks| samples_of(blocks, self.args.samples));
        terminal.say("failed", error.to_string());
        Failure::of(input, command_line(), range, &error).write(&self.args.output, force)
    }

    fn cohort(&self, subjects: &[Subject], terminal: Terminal, force: bool) -> Result<()> {
        let args = self.args;
        if self.runs.len() > 1 {
            let given: Vec<String> = args.epsilon.iter().map(f64::to_string).collect();
            return Err(Error::parameter("--epsilon", given.join(","), "several go with one INPUT; give one for a cohort"));
        }
        if let Some(range) = &args.range {
            return Err(Error::parameter("--range", range, "goes with one INPUT; shard the run of each subject by itself"));
        }
        if args.record_failure {
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
        self.job(&subject.input, command, terminal)?.write(&self.runs, folder, self.args.checkpoint, start, terminal).map(drop)
    }

    fn figures(&self, record: &Value) -> Figures {
        infer_figures(record)
    }
}
