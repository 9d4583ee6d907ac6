//! What the options of a command mean, for bindings to other languages: their names, their units and their defaults are those of the
//! command, and so are their errors, which name fields (`max_gap`) as the library does.

use std::path::Path;

use clap::{Args, FromArgMatches};

use super::command_line::{argument, as_error, line_of, parts, replaced};
use super::print::{say_read, say_step, taken};
use super::{
    args::reading::ReadingArgs, classify::ClassifyArgs, infer::InferArgs, modulate::ModulateArgs, parser, phantom::PhantomArgs,
    print::flow::say_simulated, print::inference::say_circle, print::inference::say_outcome, simulate::SimulateArgs,
};
use crate::{
    ArterySource, BoundaryOptions, Change, FlowOptions, InferOptions, Inference, Input, ModulationOptions, Network,
    PhenotypeOptions, ReadOptions, Result, SimulationRun, Step,
};

/// How an input is read, by the words that follow its name: `--units um`.
///
/// # Errors
///
/// A word that is no option, or a value that it does not take.
pub fn reading(input: &Path, words: &[String]) -> Result<ReadOptions> {
    parsed::<ReadingArgs>(&[], words)?.options(input)
}

/// How `willis infer` works on an input, by the words that follow its name, and the command line that repeats the run.
///
/// # Errors
///
/// A word that is no option, or a value that it does not take.
pub fn infer(input: &Path, words: &[String]) -> Result<(InferOptions, String)> {
    let name = input.to_string_lossy().into_owned();
    let args = parsed::<InferArgs>(&[&name, "-o", "again"], words)?;
    let line = [vec!["infer".to_owned(), name], words.to_vec()].concat();
    Ok((args.meaning(input)?, line_of(parts(&parser(), &line), "again")))
}

/// What `willis simulate` does, by its words: the flow as it is, and the changes beside it, each of vessels by name.
///
/// # Errors
///
/// A word that is no option, or a value that it does not take.
pub fn simulate(input: &Path, words: &[String]) -> Result<(FlowOptions, Vec<(String, Change)>)> {
    parsed::<SimulateArgs>(&[&input.to_string_lossy(), "-o", "again"], words)?.meaning(input)
}

/// What `willis modulate` does with a network, by its words: conditions, modulation, and the threshold of hypertension, Pa/m².
///
/// # Errors
///
/// A word that is no option, a value that it does not take, a vessel that is not there.
pub fn modulate(input: &Path, network: &Network, words: &[String]) -> Result<(BoundaryOptions, ModulationOptions, Option<f64>)> {
    parsed::<ModulateArgs>(&[&input.to_string_lossy(), "-o", "again"], words)?.meaning(input, network)
}

/// How the arteries of an input are known, by the words of `willis classify`, where one of them says it, and what is known of people's
/// circles.
///
/// # Errors
///
/// A word that is no option, or a value that it does not take.
pub fn classify(input: &Path, words: &[String]) -> Result<(Option<ArterySource>, PhenotypeOptions)> {
    let args = parsed::<ClassifyArgs>(&[&input.to_string_lossy(), "-o", "again"], words)?;
    Ok((args.source(input), args.arteries.phenotypes.clone()))
}

/// The whole anatomy that `willis phantom KIND` makes, by its words.
///
/// # Errors
///
/// A kind that is not known, a word that is no option, or a value that it does not take.
pub fn phantom(kind: &str, words: &[String]) -> Result<Network> {
    parsed::<PhantomArgs>(&[kind, "-o", "again.graphml"], words)?.whole()
}

/// What the command says of an input that it has read: facts under headings, of which `note` is what a person should know.
pub fn said_of_input(input: &Input) -> Vec<(String, String)> {
    taken(|terminal| say_read(terminal, input, false))
}

/// What the command says of a step: facts under headings.
pub fn said_of_step(step: &Step<'_>) -> Vec<(String, String)> {
    taken(|terminal| say_step(terminal, step))
}

/// What the command says of the answer of a run: facts under headings.
pub fn said_of_run(run: &Inference) -> Vec<(String, String)> {
    taken(|terminal| {
        say_outcome(terminal, &run.outcome(), run.seconds());
        say_circle(terminal, run);
    })
}

/// What the command says of a simulation: facts under headings.
pub fn said_of_simulation(run: &SimulationRun<'_>) -> Vec<(String, String)> {
    taken(|terminal| say_simulated(terminal, run))
}

/// Runs a command inside of another program, as [`call`](super::call) does: what it says, facts under headings, and how it went.
pub fn called(words: Vec<String>) -> (Vec<(String, String)>, Result<()>) {
    let mut result = Ok(());
    let said = taken(|_| result = super::call(words));
    (said, result)
}

/// A text of the library, such as an error, with the arguments that it names as they are written: `max_gap` becomes max_gap=.
pub fn arguments_in(text: &str) -> String {
    let parser = parser();
    replaced(text, |quoted| argument(&parser, quoted))
}

/// The arguments of a command, by words.
fn parsed<A: Args + FromArgMatches>(first: &[&str], words: &[String]) -> Result<A> {
    let command = A::augment_args(clap::Command::new("willis"));
    let all = ["willis"].into_iter().chain(first.iter().copied()).chain(words.iter().map(String::as_str));
    let matches = command.try_get_matches_from(all);
    matches.and_then(|matches| A::from_arg_matches(&matches)).map_err(|error| as_error(&error))
}
