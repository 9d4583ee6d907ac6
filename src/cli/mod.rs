//! The command line: one file per subcommand, each holding its arguments, their adapter to parameters, and `run`.

mod apart;
mod beside;
mod boundary;
mod candidate_args;
mod candidates;
mod checkpoint;
mod circle;
mod classify;
mod cohort;
mod convert;
mod failure;
mod infer;
mod inference;
mod job;
mod keep;
mod ledger;
mod loaded;
mod merge;
mod mirror;
mod modulate;
mod perturbation;
mod phantom;
mod plausible;
mod prior;
mod provenance;
mod reading;
mod run;
mod sampling_args;
mod shard;
mod shell;
mod simulate;
mod subjects;
mod tell;
mod tell_circle;
mod tell_flow;
mod terminal;
mod train;
mod typed;

use clap::{Args, Parser, Subcommand};
use willis::error::{Error, Result};

use terminal::Terminal;

/// Find the plausible topology of vascular centerlines.
///
/// Broken or over-connected centerlines go in; a likelihood for every possible connection and the pruned plausible
/// topology come out. Method: Moriconi et al. 2019, Towards Quantifying Neurovascular Resilience.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Subcommand)]
enum Command {
    Infer(Box<infer::InferArgs>),
    Merge(merge::MergeArgs),
    Candidates(Box<candidates::CandidatesArgs>),
    Simulate(Box<simulate::SimulateArgs>),
    Modulate(Box<modulate::ModulateArgs>),
    Classify(Box<classify::ClassifyArgs>),
    Convert(Box<convert::ConvertArgs>),
    Train(train::TrainArgs),
    Phantom(phantom::PhantomArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Common options")]
struct Common {
    /// Worker threads; the results do not depend on it [default: all processors]
    #[arg(long, global = true, env = "WILLIS_THREADS", value_name = "N")]
    threads: Option<usize>,
    /// Print nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print more: every boundary condition
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Replace the output of an earlier run
    #[arg(long, global = true)]
    force: bool,
}

/// Prints an error in one line.
pub fn say_error(error: &Error) {
    terminal::line(format_args!("willis: {error}"));
}

impl Cli {
    /// The command line, or the exit status after its help or its one-line error has been printed.
    pub fn read() -> Result<Self, u8> {
        Self::try_parse().map_err(|error| {
            if error.use_stderr() {
                let text = error.render().to_string();
                let lines: Vec<&str> = text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:")).collect();
                let said =
                    lines.iter().filter(|l| !l.is_empty() && !l.starts_with("For more")).copied().collect::<Vec<_>>().join(" ");
                terminal::line(format_args!("willis: {}; see willis help", said.trim_start_matches("error: ")));
                2
            } else {
                // Help and version go to standard output; a closed pipe is no fault.
                let _ = error.print();
                0
            }
        })
    }

    /// Runs the subcommand.
    pub fn run(self) -> Result<()> {
        if let Some(threads) = self.common.threads {
            if threads == 0 || threads > 4096 {
                return Err(Error::parameter("--threads", threads, "expected a number from 1 to 4096"));
            }
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
            pool.map_err(|e| Error::parameter("--threads", threads, e.to_string()))?;
        }
        let terminal = Terminal::new(self.common.quiet, self.common.verbose);
        let force = self.common.force;
        match self.command {
            Command::Infer(args) => args.run(terminal, force),
            Command::Merge(args) => args.run(terminal, force),
            Command::Candidates(args) => args.run(terminal, force),
            Command::Simulate(args) => args.run(terminal, force),
            Command::Modulate(args) => args.run(terminal, force),
            Command::Classify(args) => args.run(terminal, force),
            Command::Convert(args) => args.run(terminal, force),
            Command::Train(args) => args.run(terminal, force),
            Command::Phantom(args) => args.run(terminal, force),
            Command::Completions(args) => args.run(),
            Command::Man(args) => args.run(terminal, force),
        }
    }
}
