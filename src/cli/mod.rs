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
mod modulate;
mod perturbation;
mod phantom;
mod plausible;
mod prior;
mod provenance;
mod reading;
mod refusal;
mod run;
mod sampling_args;
mod shard;
mod shell;
mod simulate;
mod subjects;
mod tell;
mod tell_circle;
mod tell_flow;
mod tell_notes;
mod terminal;
mod train;
mod typed;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use willis::error::{Error, Result};

use terminal::Terminal;
use typed::whole;

/// Find the plausible topology of vascular centerlines.
///
/// Broken or over-connected centerlines go in; a likelihood for every possible connection and the pruned plausible
/// topology come out. Method: Moriconi et al. 2019, Towards Quantifying Neurovascular Resilience.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 110, arg_required_else_help = true)]
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
    #[arg(long, global = true, env = "WILLIS_THREADS", value_name = "N", value_parser = whole::<usize>, allow_negative_numbers = true)]
    threads: Option<usize>,
    /// Print nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print more: every boundary condition, every note
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
    /// The parser; options that a command shares but refuses are not in its help.
    pub fn builder() -> clap::Command {
        const REFUSE: [&str; 4] = ["simulate", "modulate", "classify", "convert"];
        Self::command().mut_subcommands(|command| {
            let refuses = REFUSE.contains(&command.get_name());
            if refuses { command.mut_arg("observed", |arg| arg.hide(true)) } else { command }
        })
    }

    /// The command line, or the exit status after its help or its one-line error has been printed.
    pub fn read() -> Result<Self, u8> {
        let parsed = Self::builder().try_get_matches().and_then(|matches| Self::from_arg_matches(&matches));
        parsed.map_err(|error| {
            let without_command = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
            if !error.use_stderr() || without_command {
                // Help and version go to standard output; a closed pipe is no fault.
                let _ = error.print();
                return if without_command { 2 } else { 0 };
            }
            let given: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
            terminal::line(format_args!("willis: {}", refusal::one_line(&error, &given)));
            2
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
