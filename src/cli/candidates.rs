//! `willis candidates`: only the over-connected graph, to look at or to edit.

use super::args::{CandidateArgs, options_for};
use super::print::{TextTerminal, plural};
use super::{args::reading::InputArgs, checkpoint::Follower, command_line::command_line, shell::print_json};
use crate::{
    BoundaryOptions, InferOptions, Result, internals::formats::graph_columns, internals::formats::write_graphml,
    internals::network::Origin, internals::output::StagedFiles, internals::pipeline::require, prepare,
};

/// Build the over-connected candidate graph and stop
///
/// The graph can be edited by hand or by a script and handed to `willis infer`; unedited it gives the same answer as the
/// centerlines themselves.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis candidates extraction.vtp -o graph.graphml
  willis infer graph.graphml -o edited")]
pub struct CandidatesArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The graph to write, as GraphML
    #[arg(short, long, value_name = "FILE.graphml", value_hint = clap::ValueHint::FilePath)]
    output: std::path::PathBuf,
    #[command(flatten)]
    candidates: CandidateArgs,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    boundary: BoundaryOptions,
}

impl CandidatesArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let is_graphml = self.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("graphml"));
        require(is_graphml, "output", self.output.display(), "expected an ending .graphml")?;
        StagedFiles::check(&self.output, [], force)?;
        let path = &self.input.input;
        let mut options = InferOptions { boundary: self.boundary, ..InferOptions::default() };
        self.candidates.put(&mut options);
        let options = options_for(options, path);
        let input = self.input.reading.read(path, command_line("again.graphml"), terminal)?;
        if !input.is_fragments {
            terminal.say("note", "already a candidate graph: nothing added (see --observed)");
        }
        let made = prepare(input, &options, &mut Follower::new(terminal))?;
        let graph = made.boundary.stated_in(made.graph.clone());
        let (nodes, vessels) = graph_columns(&graph);
        StagedFiles::write_one(&self.output, force, |out| write_graphml(out, &graph, &nodes, &vessels))?;
        if self.json {
            let source = &made.provenance;
            let candidates = graph.vessels().filter(|(_, v)| v.origin == Origin::Candidate).count();
            print_json(&serde_json::json!({
                "willis": env!("CARGO_PKG_VERSION"),
                "command": source.command,
                "input": source.of_input(),
                "options": made.options,
                "notes": source.notes,
                "prior": made.prior(),
                "output": self.output.display().to_string(),
                "counts": { "nodes": graph.node_count(), "vessels": graph.vessel_count(), "candidates": candidates },
                "inlets_found": made.boundary.found_inlets.len(),
                "outlets_found": made.boundary.found_outlets.len(),
            }))?;
        }
        let size = format!("{}, {}", plural(graph.node_count(), "node"), plural(graph.vessel_count(), "vessel"));
        terminal.say("written", format!("{}: {size}", self.output.display()));
        Ok(())
    }
}
