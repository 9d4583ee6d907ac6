//! `--epsilon`, `--samples` and the other options of sampling.

use clap::{Args, ValueEnum};
use serde::Serialize;
use willis::error::Result;
use willis::internals::sampling::{SamplingOptions, Solver, Uncertain, Weight};

use super::checkpoint::{Interval, parse_interval};
use super::typed::{probability, viscosity, whole};

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Vessels {
    /// Candidates must earn their place, observed vessels stay
    Candidates,
    /// Every vessel must, as in the paper
    All,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contribution {
    /// Its resilience, as in the paper
    Resilience,
    /// One
    Count,
    /// The resilience of the whole network
    Global,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    Stable,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// --prior uniform --uncertain all --attach ends --candidate-radius mean --outlets ground
    Paper,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverName {
    /// By the structure of the graph
    Auto,
    /// Star-mesh elimination, many samples at a time
    Lanes,
    /// Preconditioned conjugate gradients, many samples at a time, for large meshes
    Gradients,
    /// The paper's loop, a sample at a time: slow, to compare with
    Reference,
}

#[derive(Debug, Args, Serialize)]
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
    #[arg(long, value_enum, value_name = "stable", conflicts_with = "samples")]
    pub until: Option<Until>,
    /// Enumerate every occlusion pattern of up to 20 uncertain vessels: the expectation, without Monte-Carlo error
    #[arg(long, conflicts_with = "until")]
    pub exact: bool,
    /// Every choice as in Moriconi et al. 2019, unless an option says otherwise
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// The seed; the same command with the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub seed: u64,
    /// Only samples A up to, not including, B of the --samples, each a multiple of 64 or the last: a shard of the run, for willis merge
    #[serde(skip)]
    #[arg(long, value_name = "A..B", conflicts_with_all = ["until", "exact", "json"], allow_hyphen_values = true)]
    pub range: Option<String>,
    /// Where the input cannot be used, write why to FOLDER, as failed.json alone, and end with status 0: willis merge makes a row of it
    #[serde(skip)]
    #[arg(long)]
    pub record_failure: bool,
    /// How often what is finished is kept beside FOLDER, in .willis-FOLDER, for the same command to go on from after a stop or a kill: auto
    /// (once sampling takes over a minute), off, or so many seconds apart; Ctrl-C keeps it at once
    #[serde(skip)]
    #[arg(
        long,
        value_name = "auto|off|SECONDS",
        default_value = "auto",
        value_parser = parse_interval,
    )]
    pub checkpoint: Interval,
    /// Which vessels may be occluded and pruned [default: candidates]
    #[arg(long, value_enum)]
    pub uncertain: Option<Vessels>,
    /// What a vessel adds to its likelihood when it is in a sample's forest
    #[arg(long, value_enum, default_value = "resilience")]
    pub weight: Contribution,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP")]
    pub viscosity: String,
    /// The flow solver
    #[arg(long, value_enum, default_value = "auto")]
    pub solver: SolverName,
}

impl SamplingArgs {
    /// Whether every choice is that of the paper where no option says otherwise.
    pub fn paper(&self) -> bool {
        self.preset == Some(Preset::Paper)
    }

    /// The parameters of the library for one of the probabilities.
    pub fn params(&self, epsilon: f64) -> Result<SamplingOptions> {
        let paper = self.paper();
        let params = SamplingOptions {
            epsilon,
            samples: self.samples,
            seed: self.seed,
            uncertain: match self.uncertain.unwrap_or(if paper { Vessels::All } else { Vessels::Candidates }) {
                Vessels::Candidates => Uncertain::Candidates,
                Vessels::All => Uncertain::All,
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
                SolverName::Reference => Solver::Reference,
            },
            exact: self.exact,
        };
        params.validate()?;
        Ok(params)
    }
}
