//! The command line: one file per subcommand, each holding its arguments, their adapter to parameters, and `run`.

mod args;
mod bids;
mod candidates;
mod checkpoint;
mod classify;
mod cohort;
mod command_line;
mod convert;
mod infer;
mod merge;
mod modulate;
mod phantom;
mod print;
mod refusal;
mod shell;
mod simulate;
mod subjects;
mod train;

use std::sync::OnceLock;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use willis::error::{Error, Result};

use args::figures::whole;
use print::Terminal;

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
    Bids(Box<bids::BidsArgs>),
    Merge(merge::MergeArgs),
    Candidates(Box<candidates::CandidatesArgs>),
    Simulate(Box<simulate::SimulateArgs>),
    Modulate(Box<modulate::ModulateArgs>),
    Classify(Box<classify::ClassifyArgs>),
    Convert(Box<convert::ConvertArgs>),
    Skeleton(Box<convert::SkeletonArgs>),
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

/// The subcommand that is at work.
static COMMAND: OnceLock<String> = OnceLock::new();

/// Prints an error in one line.
pub fn say_error(error: &Error) {
    print::line(format_args!("willis: {}", with_flags(error)));
}

/// What went wrong, with options as they are typed where the library names fields: `--max-gap` for `max_gap`.
fn with_flags(error: &Error) -> String {
    let Error::Parameter { name, value, accepted } = error else { return flags_in(&error.to_string()) };
    let (field, rest) = name.split_once(' ').map_or((name.as_str(), ""), |(field, rest)| (field, rest));
    let name = flag(field).map_or_else(|| name.clone(), |flag| format!("{flag} {rest}").trim_end().to_owned());
    flags_in(&Error::Parameter { name, value: value.clone(), accepted: accepted.clone() }.to_string())
}

/// A text of the library with the fields in backticks as options: "give `default_radius`" becomes "give --default-radius".
pub fn flags_in(text: &str) -> String {
    let mut parts = text.split('`');
    let mut out = parts.next().unwrap_or_default().to_owned();
    while let Some(quoted) = parts.next() {
        match (flag(quoted), parts.next()) {
            (Some(flag), Some(after)) => out.extend([&flag, after]),
            (_, after) => out.extend(["`", quoted, after.map_or("", |_| "`"), after.unwrap_or_default()]),
        }
    }
    out
}

/// A field as the option of the subcommand at work.
fn flag(field: &str) -> Option<String> {
    let flag = field.replace('_', "-");
    let command = COMMAND.get().and_then(|command| Cli::builder().find_subcommand(command).cloned())?;
    let is_flag =
        |arg: &clap::Arg| arg.get_long() == Some(&flag) || arg.get_short().is_some_and(|short| flag == short.to_string());
    let is_common = matches!(flag.as_str(), "threads" | "force");
    let dashes = if flag.len() == 1 { "-" } else { "--" };
    (is_common || command.get_arguments().any(is_flag)).then(|| format!("{dashes}{flag}"))
}

impl Cli {
    /// The parser; options that a command shares but refuses are not in its help.
    pub fn builder() -> clap::Command {
        const REFUSE: [&str; 5] = ["simulate", "modulate", "classify", "convert", "skeleton"];
        Self::command().mut_subcommands(|command| {
            let refuses = REFUSE.contains(&command.get_name());
            if refuses { command.mut_arg("observed", |arg| arg.hide(true)) } else { command }
        })
    }

    /// The command line, or the exit status after its help or its one-line error has been printed.
    pub fn read() -> Result<Self, u8> {
        let matches = Self::builder().try_get_matches();
        if let Ok(matches) = &matches {
            let _ = COMMAND.set(matches.subcommand_name().unwrap_or_default().to_owned());
        }
        let parsed = matches.and_then(|matches| Self::from_arg_matches(&matches));
        parsed.map_err(|error| {
            let without_command = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
            if !error.use_stderr() || without_command {
                // Help and version go to standard output; a closed pipe is no fault.
                let _ = error.print();
                return if without_command { 2 } else { 0 };
            }
            let given: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
            print::line(format_args!("willis: {}", refusal::one_line(&error, &given)));
            2
        })
    }

    /// Runs the subcommand.
    pub fn run(self) -> Result<()> {
        if let Some(threads) = self.common.threads {
            if threads == 0 || threads > 4096 {
                return Err(Error::parameter("threads", threads, "expected a number from 1 to 4096"));
            }
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
            pool.map_err(|e| Error::parameter("threads", threads, e.to_string()))?;
        }
        let terminal = Terminal::new(self.common.quiet, self.common.verbose);
        let force = self.common.force;
        match self.command {
            Command::Infer(args) => args.run(terminal, force),
            Command::Bids(args) => args.run(terminal, force),
            Command::Merge(args) => args.run(terminal, force),
            Command::Candidates(args) => args.run(terminal, force),
            Command::Simulate(args) => args.run(terminal, force),
            Command::Modulate(args) => args.run(terminal, force),
            Command::Classify(args) => args.run(terminal, force),
            Command::Convert(args) => args.run(terminal, force),
            Command::Skeleton(args) => args.run(terminal, force),
            Command::Train(args) => args.run(terminal, force),
            Command::Phantom(args) => args.run(terminal, force),
            Command::Completions(args) => args.run(),
            Command::Man(args) => args.run(terminal, force),
        }
    }
}
