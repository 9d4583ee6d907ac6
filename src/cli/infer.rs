//! `willis infer`: from centerlines or a candidate graph to the likelihood matrix and the plausible topology.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, FromArgMatches};
use serde::Serialize;
use serde_json::Value;
use willis::error::{Error, Result};
use willis::internals::output::StagedFolder;
use willis::internals::report::figures::{DEFAULT_DPI, check_dpi};
use willis::internals::sampling::SamplingOptions;

use super::boundary::BoundaryArgs;
use super::candidate_args::CandidateArgs;
use super::circle::CircleArgs;
use super::inference::Inference;
use super::keep::parse_rule;
use super::prior::PriorArgs;
use super::provenance::{command_line, words_of};
use super::reading::ReadingArgs;
use super::sampling_args::SamplingArgs;
use super::shard::{blocks_of, write_shard};
use super::shell::print_json;
use super::subjects::{Inputs, expand};
use super::terminal::{Terminal, listen};
use super::typed::whole;

/// Infer the plausible topology of centerlines or of a candidate graph
#[derive(Debug, Args, Serialize)]
pub struct InferArgs {
    /// Centerlines (SWC, VTP, VTK, TRE, Slicer markups, iCafe, Voreen, VesselVio, NPZ, MAT, CSV of points) or a candidate graph
    /// (GraphML, CSV of edges); several, or a pattern in quotes ('scans/*.swc'), are a cohort: a folder each, and a table of all
    #[arg(value_name = "INPUT", required = true, value_hint = clap::ValueHint::FilePath, help_heading = None::<&str>)]
    #[serde(skip)]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub reading: ReadingArgs,
    /// The folder to write; it must not exist, unless it is that of a cohort to go on with
    #[serde(skip)]
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    pub output: PathBuf,
    #[command(flatten)]
    #[serde(flatten)]
    pub sampling: SamplingArgs,
    /// Which uncertain vessels stay: probable[=ROOT_FACTOR] (the most probable forest; a smaller factor leaves fewer fragments
    /// alone), median (of L, as in the paper), quantile=Q, value=X (W/m3), otsu, frequency=F, probability=P
    /// [default: probable where candidates come with evidence, else median]
    #[arg(long, value_name = "RULE", help_heading = "Answer")]
    pub keep: Option<String>,
    /// Resolution of the pictures
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DPI, value_parser = whole::<u32>, allow_negative_numbers = true, help_heading = "Answer")]
    pub dpi: u32,
    /// Print run.json on standard output too, in a line for each occlusion probability; of a cohort, its row of each subject
    #[serde(skip)]
    #[arg(long, help_heading = "Answer")]
    pub json: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub candidates: CandidateArgs,
    #[command(flatten)]
    #[serde(flatten)]
    pub prior: PriorArgs,
    #[command(flatten)]
    #[serde(flatten)]
    pub boundary: BoundaryArgs,
    #[command(flatten)]
    #[serde(flatten)]
    pub circle: CircleArgs,
}

impl InferArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let start = Instant::now();
        let rule = self.keep.as_deref().map(parse_rule).transpose()?;
        let runs = self
            .sampling
            .epsilon
            .iter()
            .map(|epsilon| self.sampling.params(*epsilon))
            .collect::<Result<Vec<SamplingOptions>>>()?;
        if let Some(epsilon) =
            (1..runs.len()).map(|i| self.sampling.epsilon[i]).enumerate().find(|(i, e)| self.sampling.epsilon[..=*i].contains(e))
        {
            return Err(Error::parameter("--epsilon", epsilon.1, "given twice; expected each probability once"));
        }
        let range = self.sampling.range.as_deref().map(|text| blocks_of(text, self.sampling.samples)).transpose()?;
        if let (Some(range), true) = (&self.sampling.range, runs.len() > 1) {
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
        if self.sampling.record_failure {
            inference.check()?;
        }
        let job = match inference.job(&input, command_line(), terminal) {
            Err(error) => return inference.fail(error, &input, range.as_ref(), force, terminal),
            Ok(job) => job,
        };
        listen();
        let folder = StagedFolder::new(&self.output, force)?;
        let written = match &range {
            None => job.write(&inference.runs, &folder, self.sampling.checkpoint, start, terminal),
            Some(blocks) => {
                let shard = write_shard(job, &inference.runs[0], blocks, &folder, self.sampling.checkpoint, terminal);
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
}
