//! `willis infer`: from centerlines or a candidate graph to the likelihood matrix and the plausible topology.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use willis::error::{Error, Result};
use willis::formats::write_csv;
use willis::hemodynamics::{Boundary, FoundOutlets};
use willis::inference::{
    Answer, Keep, Params, ROOT_FACTOR, Solver, Topology, Uncertain, Weight, decide, expected_errors, infer, infer_until_stable,
    knows_fragments,
};
use willis::network::Network;
use willis::report::summary::Built;
use willis::report::{Outcome, Provenance, StagedFolder, Summary, agreement, staged::write_file, write_outcome};

use super::boundary::{BoundaryArgs, say_boundary};
use super::input::{CandidateArgs, InputArgs, viscosity};
use super::keep::parse_rule;
use super::prior::{Prior, PriorArgs};
use super::shell::print_json;
use super::tell::{say_built, say_outcome};
use super::terminal::{Terminal, count, is_stopped, plural};

#[derive(Debug, Clone, Copy, ValueEnum)]
enum OnTrial {
    /// Candidates must earn their place, observed vessels stay
    Candidates,
    /// Every vessel is on trial, as in the paper
    All,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Contribution {
    /// Its resilience, as in the paper
    Resilience,
    /// One
    Count,
    /// The resilience of the whole network
    Global,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Until {
    Stable,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// --prior uniform --uncertain all --attach ends --candidate-radius mean --outlets ground
    Paper,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SolverName {
    Auto,
    Lanes,
    Cholesky,
}

/// Infer the plausible topology of centerlines or of a candidate graph
#[derive(Debug, Args)]
pub struct InferArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The folder to write; it must not exist
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
    #[arg(long, value_name = "N", default_value_t = 150, help_heading = "Answer")]
    dpi: u32,
    /// Print run.json on standard output too, in a line for each occlusion probability
    #[arg(long, help_heading = "Answer")]
    json: bool,
    #[command(flatten)]
    candidates: CandidateArgs,
    #[command(flatten)]
    prior: PriorArgs,
    #[command(flatten)]
    boundary: BoundaryArgs,
}

/// What all occlusion probabilities share.
struct Job<'a> {
    graph: &'a Network,
    boundary: &'a Boundary,
    outlets: FoundOutlets,
    provenance: &'a Provenance,
    prior: Value,
    built: Built<'a>,
    rule: Keep,
    until_stable: bool,
    paper: bool,
    dpi: u32,
}

impl InferArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let start = Instant::now();
        let rule = self.keep.as_deref().map(parse_rule).transpose()?;
        let mut runs = self.epsilon.iter().map(|epsilon| self.params(*epsilon)).collect::<Result<Vec<Params>>>()?;
        if let Some(epsilon) = (1..runs.len()).map(|i| self.epsilon[i]).enumerate().find(|(i, e)| self.epsilon[..=*i].contains(e))
        {
            return Err(Error::parameter("--epsilon", epsilon.1, "given twice; expected each probability once"));
        }
        self.boundary.found_outlets(true)?;
        check_dpi(self.dpi)?;
        StagedFolder::check(&self.output, force)?;

        let mut loaded = self.input.load(terminal)?;
        let prior = self.prior.resolve(&loaded, self.paper())?;
        for params in &mut runs {
            params.uniform_prior = matches!(prior, Prior::Uniform);
        }
        let candidate_params = self.candidates.params(loaded.radius_rule, self.paper(), prior.is_evidence())?;
        let outlets = self.boundary.found_outlets(loaded.fragments && !self.paper())?;
        let boundary = self.boundary.resolve(&loaded.network, outlets, terminal)?;
        let graph = prior.graph(&mut loaded, &boundary, &candidate_params)?;
        let rule =
            rule.unwrap_or(if knows_fragments(&graph) && !self.paper() { Keep::Probable(ROOT_FACTOR) } else { Keep::Median });
        let boundary = boundary.extended_to(graph.node_count());
        if loaded.fragments {
            say_built(terminal, &graph, &candidate_params, prior.is_evidence());
        }
        say_boundary(terminal, &graph, &boundary);

        let folder = StagedFolder::new(&self.output, force)?;
        let job = Job {
            graph: &graph,
            boundary: &boundary,
            outlets,
            provenance: &loaded.provenance,
            prior: prior.record(),
            built: if loaded.fragments { Built::Candidates(&candidate_params) } else { Built::Given },
            rule,
            until_stable: self.until.is_some(),
            paper: self.paper(),
            dpi: self.dpi,
        };
        let mut records = Vec::new();
        if let [params] = &runs[..] {
            records.push(job.run(params, &folder.path(), terminal)?.1);
        } else {
            let mut decisions = Vec::new();
            let uncertain = runs[0].uncertain.vessels(&graph);
            for params in &runs {
                let sub = folder.path().join(format!("epsilon-{}", params.epsilon));
                std::fs::create_dir(&sub).map_err(|source| Error::Write { path: sub.clone(), source })?;
                let (answer, record) = job.run(params, &sub, terminal)?;
                decisions.push((params.epsilon, answer));
                records.push(record);
            }
            write_file(&folder.path().join("agreement.csv"), |out| write_csv(out, &agreement(&decisions, &uncertain)))?;
        }
        if is_stopped() {
            return Err(Error::Stopped { done: self.samples, total: self.samples });
        }
        folder.commit()?;
        if self.json {
            records.iter().try_for_each(print_json)?;
        }
        terminal.say("written", format!("{} in {:.1} s", self.output.display(), start.elapsed().as_secs_f64()));
        Ok(())
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
                SolverName::Cholesky => Solver::Cholesky,
            },
            exact: self.exact,
        };
        params.validate()?;
        Ok(params)
    }
}

impl Job<'_> {
    fn run(&self, params: &Params, folder: &Path, terminal: Terminal) -> Result<(Answer, Summary)> {
        let start = Instant::now();
        let trial = params.uncertain.vessels(self.graph).iter().filter(|u| **u).count();
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
            infer_until_stable(self.graph, self.boundary, params, self.rule, &mut progress)
        } else {
            infer(self.graph, self.boundary, params, &mut progress)
        };
        progress.finish();
        let (result, method) = sampled?;
        let sampling = start.elapsed().as_secs_f64();
        let answer = decide(self.rule, self.graph, &result)?;
        let topology = |kept: &[bool]| Topology::of(self.graph, &result.uncertain, kept, self.boundary);
        let outcome = Outcome {
            network: self.graph,
            boundary: self.boundary,
            result: &result,
            rule: self.rule,
            answer: &answer,
            kept: topology(&answer.kept),
            above_median: topology(&answer.above_median),
            expected: expected_errors(self.graph, &answer.kept),
            uniform_prior: params.uniform_prior,
            method,
            weight: params.weight,
            exact: params.exact,
            viscosity: params.viscosity,
        };
        let mut summary = Summary::new(&outcome, self.provenance, params, self.built, self.outlets);
        summary.state_prior(self.prior.clone());
        if self.paper {
            summary.follow_the_paper();
        }
        summary.time = json!({ "sampling_s": sampling, "samples_per_s": result.samples as f64 / sampling, "threads": threads, "instructions": method.instructions });
        say_outcome(terminal, &outcome, sampling);
        for note in write_outcome(folder, &outcome, &summary, self.dpi)? {
            terminal.say("note", note);
        }
        Ok((answer, summary))
    }
}

/// Refuses a resolution that no picture can have.
pub fn check_dpi(dpi: u32) -> Result<()> {
    if (36..=1200).contains(&dpi) { Ok(()) } else { Err(Error::parameter("--dpi", dpi, "expected a number from 36 to 1200")) }
}
