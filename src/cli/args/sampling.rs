//! `--epsilon`, `--samples` and the other options of sampling.

use super::{probability, viscosity, whole, words};
use crate::cli::checkpoint::{Interval, parse_interval};
use crate::{Preset, Result, SamplingOptions, Solver, Uncertain, Weight, internals::pipeline::require};

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
