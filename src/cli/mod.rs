//! The command line: one file per subcommand, each holding its arguments, their adapter to parameters, and `run`.
//!
//! [`main`] is the program. For bindings to other languages [`call`] runs a command inside of another program, and [`words`] tells what
//! options mean.

mod args;
mod bids;
mod candidates;
mod checkpoint;
mod classify;
mod cohort;
mod command_line;
mod convert;
mod infer;
mod label;
mod measure;
mod modulate;
mod phantom;
mod print;
mod shell;
mod signals;
mod simulate;
mod subjects;
#[cfg(feature = "train")]
mod train;
pub mod words;

use std::ffi::OsString;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::{Result, internals::pipeline::require};
use command_line::{as_error, begin, one_line, with_flags};
pub use signals::ask_to_stop;

/// What the tests of this project call. Nothing here is stable.
pub mod internals {
    pub use super::bids::dataset::{BidsName, Filter, parse_filter};
    pub use super::command_line::{LinePart, infer_parts, parts, quoted, row_parts, shared_parts, words_of};
    pub use super::parser;
    pub use super::print::counted;
    pub use super::subjects::{LONGEST, named};
}

/// Find the plausible topology of vascular centerlines.
///
/// Broken or over-connected centerlines go in; a probability and a likelihood of every possible connection and the plausible
/// topology come out. Method: Moriconi et al. 2019, Towards Quantifying Neurovascular Resilience.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 110, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Subcommand)]
enum Command {
    Infer(Box<infer::InferArgs>),
    Bids(Box<bids::BidsArgs>),
    Merge(cohort::MergeArgs),
    Candidates(Box<candidates::CandidatesArgs>),
    Simulate(Box<simulate::SimulateArgs>),
    Modulate(Box<modulate::ModulateArgs>),
    Classify(Box<classify::ClassifyArgs>),
    Label(Box<label::LabelArgs>),
    Measure(Box<measure::MeasureArgs>),
    Convert(Box<convert::ConvertArgs>),
    Skeleton(Box<convert::SkeletonArgs>),
    #[cfg(feature = "train")]
    Train(train::TrainArgs),
    Phantom(phantom::PhantomArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Common options")]
struct Common {
    /// Worker threads; the results do not depend on it [default: all processors]
    // BIDS apps call it n_cpus.
    #[arg(long, aliases = ["n-cpus", "n_cpus"], global = true, env = THREADS, value_name = "N", value_parser = args::whole::<usize>, allow_negative_numbers = true)]
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

/// The variable that says how many threads.
const THREADS: &str = "WILLIS_THREADS";

/// Runs a command line, whose first word is the name of the program, and says in one line what is wrong with it; the exit status.
pub fn main(words: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::read(words, true) {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    signals::outlive_limits();
    match cli.run() {
        Ok(()) => 0,
        Err(error) => {
            print::line(format_args!("willis: {}", with_flags(&error)));
            if error.is_usage() { 2 } else { 1 }
        }
    }
}

/// Runs a command inside of another program: its words without the name of the program, the first one being the subcommand. Nothing is
/// said on standard error but with `--verbose`, signals stay with the other program, which may [`ask_to_stop`], and errors name fields
/// (`max_gap`), not options. One at a time.
///
/// # Errors
///
/// What is wrong with the words, or what went wrong.
pub fn call(words: Vec<String>) -> Result<()> {
    signals::stay_inside();
    let verbose = words.iter().any(|word| word == "--verbose");
    let quiet = (!verbose).then(|| OsString::from("--quiet"));
    let words = [OsString::from("willis")].into_iter().chain(words.into_iter().map(OsString::from)).chain(quiet);
    Cli::read(words, false).map_err(|error| as_error(&error))?.run()
}

/// What [`main`] would say is wrong with a command line, if anything is; nothing is run.
pub fn check(words: impl IntoIterator<Item = OsString>) -> Option<String> {
    Cli::read(words, true).err().filter(clap::Error::use_stderr).as_ref().map(one_line)
}

/// The parser of every command; options that a command shares but refuses are not in its help.
pub fn parser() -> clap::Command {
    const REFUSE: [&str; 6] = ["simulate", "modulate", "classify", "measure", "convert", "skeleton"];
    let command = Cli::command().mut_subcommands(|command| {
        let refuses = REFUSE.contains(&command.get_name());
        if refuses { command.mut_arg("observed", |arg| arg.hide(true)) } else { command }
    });
    // A variable that is empty is one that is not set.
    let is_empty = std::env::var_os(THREADS).is_some_and(|value| value.is_empty());
    if is_empty { command.mut_arg("threads", |arg| arg.env(None)) } else { command }
}

impl Cli {
    /// The command line; from then on errors name its options as they are typed, where that is wanted.
    fn read(words: impl IntoIterator<Item = OsString>, as_typed: bool) -> Result<Self, clap::Error> {
        let all: Vec<OsString> = words.into_iter().collect();
        let given: Vec<String> = all.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
        let parser = parser();
        let matches = parser.clone().try_get_matches_from(all);
        begin(given, parser, as_typed);
        matches.and_then(|matches| Self::from_arg_matches(&matches))
    }

    /// Runs the subcommand.
    fn run(self) -> Result<()> {
        if let Some(threads) = self.common.threads {
            require((1..=4096).contains(&threads), "threads", threads, "expected a number from 1 to 4096")?;
            // Inside of another program there may be threads already, which do as well.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        }
        let terminal = print::TextTerminal::new(self.common.quiet, self.common.verbose);
        let force = self.common.force;
        match self.command {
            Command::Infer(args) => args.run(terminal, force),
            Command::Bids(args) => args.run(terminal, force),
            Command::Merge(args) => args.run(terminal, force),
            Command::Candidates(args) => args.run(terminal, force),
            Command::Simulate(args) => args.run(terminal, force),
            Command::Modulate(args) => args.run(terminal, force),
            Command::Classify(args) => args.run(terminal, force),
            Command::Label(args) => args.run(terminal, force),
            Command::Measure(args) => args.run(terminal, force),
            Command::Convert(args) => args.run("convert", terminal, force),
            Command::Skeleton(args) => args.run(terminal, force),
            #[cfg(feature = "train")]
            Command::Train(args) => args.run(terminal, force),
            Command::Phantom(args) => args.run(terminal, force),
            Command::Completions(args) => args.run(parser()),
            Command::Man(args) => args.run(parser(), terminal, force),
        }
    }
}

/// Prints the help that was asked for, or in one line what is wrong with the words; the exit status.
fn refuse(error: &clap::Error) -> u8 {
    let without_command = error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if !error.use_stderr() || without_command {
        // Help and version go to standard output; a closed pipe is no fault.
        let _ = error.print();
        return if without_command { 2 } else { 0 };
    }
    print::line(format_args!("willis: {}", one_line(error)));
    2
}
