//! `willis candidates`: only the over-connected graph, to look at or to edit.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use willis::error::{Error, Result};
use willis::internals::io::{graph_columns, write_graphml};
use willis::internals::network::Origin;
use willis::internals::output::StagedFile;
use willis::internals::output::atomic::write_file;

use super::boundary::{BoundaryArgs, say_boundary};
use super::candidate_args::CandidateArgs;
use super::prior::PriorArgs;
use super::reading::InputArgs;
use super::shell::print_json;
use super::tell::say_built;
use super::terminal::{Terminal, plural};

/// Build the over-connected candidate graph and stop
///
/// The graph can be edited by hand or by a script and handed to `willis infer`; unedited it gives the same answer as the
/// centerlines themselves.
#[derive(Debug, Args)]
pub struct CandidatesArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The graph to write, as GraphML
    #[arg(short, long, value_name = "FILE.graphml", value_hint = clap::ValueHint::FilePath)]
    output: PathBuf,
    #[command(flatten)]
    candidates: CandidateArgs,
    #[command(flatten)]
    prior: PriorArgs,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    boundary: BoundaryArgs,
}

impl CandidatesArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        if self.output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("graphml")) {
            return Err(Error::parameter("--output", self.output.display(), "expected an ending .graphml"));
        }
        StagedFile::check(&self.output, force)?;
        let outlets = |fragments| self.boundary.found_outlets(fragments);
        outlets(true)?;
        let mut loaded = self.input.load(terminal)?;
        let prior = self.prior.resolve(&loaded, false)?;
        let params = self.candidates.params(loaded.radius_rule, false, prior.is_evidence())?;
        let boundary = self.boundary.resolve(&self.input.input, &loaded.network, outlets(loaded.fragments)?, terminal)?;
        let graph = prior.graph(&mut loaded, &boundary, &params)?;
        let boundary = boundary.extended_to(graph.node_count());
        if loaded.fragments {
            let note = say_built(terminal, &graph, &params, prior.is_evidence());
            loaded.provenance.notes.extend(note.map(str::to_owned));
        } else {
            terminal.say("note", "already a candidate graph: nothing added (see --observed)");
        }
        say_boundary(terminal, &graph, &boundary);
        let graph = boundary.stated_in(graph);
        let (nodes, vessels) = graph_columns(&graph);
        let file = StagedFile::new(&self.output, force)?;
        write_file(&file.path(), |out| write_graphml(out, &graph, &nodes, &vessels))?;
        file.commit()?;
        if self.json {
            let source = &loaded.provenance;
            let candidates = graph.vessels().filter(|(_, v)| v.origin == Origin::Candidate).count();
            print_json(&json!({
                "willis": env!("CARGO_PKG_VERSION"),
                "command": source.command,
                "input": source.of_input(),
                "notes": source.notes,
                "prior": prior.record(),
                "output": self.output.display().to_string(),
                "counts": { "nodes": graph.node_count(), "vessels": graph.vessel_count(), "candidates": candidates },
                "inlets_found": boundary.found_inlets.len(),
                "outlets_found": boundary.found_outlets.len(),
            }))?;
        }
        let size = format!("{}, {}", plural(graph.node_count(), "node"), plural(graph.vessel_count(), "vessel"));
        terminal.say("written", format!("{}: {size}", self.output.display()));
        Ok(())
    }
}
