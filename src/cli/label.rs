//! `willis label`: names of the arteries of a Circle of Willis, from geometry alone.

use std::path::PathBuf;

use crate::error::Result;
use crate::internals::circle_of_willis::{Artery, RING};
use crate::internals::formats::convert::Target;
use crate::{InferOptions, LabelOptions, Labelled, label};
use clap::Args;
use serde_json::{Value, json};

use super::args::candidates::CandidateArgs;
use super::args::reading::InputArgs;
use super::checkpoint::Follower;
use super::command_line::command_line;
use super::print::{TextTerminal, plural};
use super::shell::print_json;

/// Name the arteries of a Circle of Willis from their geometry alone, each name with a probability
///
/// Beside FILE it writes FILE.names.csv (a row for about every millimetre, with the probability of each name), FILE.landmarks.csv and
/// FILE.landmarks.mrk.json (bifurcations and ends, to be looked at and corrected in 3D Slicer, and handed back with --landmarks), and
/// FILE.segments.csv (which segments of the circle are there). Candidates pass names over gaps.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  willis label scan.nii.gz -o labelled.graphml
  willis classify scan.nii.gz -o phenotype --landmarks labelled.landmarks.csv")]
pub struct LabelArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The labelled vessels to write; the ending says the format, as for convert
    #[arg(short, long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    output: PathBuf,
    /// A model of `willis train --model labels` in place of the one that ships
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath)]
    model: Option<PathBuf>,
    #[command(flatten)]
    candidates: CandidateArgs,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
}

impl LabelArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let target = Target::new(&self.output, None)?;
        Labelled::check(&target, force)?;
        let mut options = LabelOptions { model: self.model.clone(), infer: InferOptions::default() };
        self.candidates.put(&mut options.infer);
        let input = self.input.reading.read(&self.input.input, command_line("again.graphml"), terminal)?;
        let found = label(input, &options, &mut Follower::new(terminal))?;
        let notes = found.notes();
        for note in &notes {
            terminal.say("note", note);
        }
        let files = found.write(&target, force)?;
        let named = found.network.vessels().filter(|(_, vessel)| !vessel.label.is_empty()).count();
        let doubtful = found.doubtful();
        terminal.say(
            "named",
            format!(
                "{named} of {}, {}, {doubtful} of them to be looked at",
                plural(found.network.vessel_count(), "vessel"),
                plural(found.landmarks.len(), "landmark")
            ),
        );
        let segment = |(artery, p): (&Artery, &f64)| format!("{artery} {p:.2}");
        let segments: Vec<String> = RING.iter().zip(&found.names.presence).map(segment).collect();
        terminal.say("segments", segments.join(", "));
        let files: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        terminal.say("written", files.join(", "));
        if self.json {
            let presence: serde_json::Map<String, Value> =
                RING.iter().zip(&found.names.presence).map(|(artery, p)| (artery.to_string(), json!(p))).collect();
            print_json(&json!({
                "willis": env!("CARGO_PKG_VERSION"),
                "command": found.prepared.provenance.command,
                "input": found.prepared.provenance.of_input(),
                "frame": found.names.frame.name(),
                "frame_was_found": found.names.frame_was_found,
                "notes": found.prepared.provenance.notes.iter().chain(&notes).collect::<Vec<_>>(),
                "output": files,
                "counts": { "vessels": found.network.vessel_count(), "named": named, "landmarks": found.landmarks.len() },
                "segments": presence,
            }))?;
        }
        Ok(())
    }
}
