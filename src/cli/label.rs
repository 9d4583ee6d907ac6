//! `willis label`: names of the arteries of a Circle of Willis, from geometry alone.

use std::path::PathBuf;

use crate::error::Result;
use crate::internals::output::StagedFile;
use crate::{InferOptions, LabelOptions, label, read};
use clap::Args;

use super::args::candidates::CandidateArgs;
use super::args::reading::InputArgs;
use super::checkpoint::Follower;
use super::command_line::command_line;
use super::print::{Terminal, say_read};

/// Name the arteries of a Circle of Willis from their geometry alone, each name with a probability
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
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let beside = |ending: &str| self.output.with_extension(ending);
        let (names, landmarks, segments) = (beside("names.csv"), beside("landmarks.csv"), beside("segments.csv"));
        for path in [&self.output, &names, &landmarks, &segments] {
            StagedFile::check(path, force)?;
        }
        let path = &self.input.input;
        let mut options = LabelOptions { model: self.model.clone(), infer: InferOptions::default() };
        self.candidates.put(&mut options.infer)?;
        let input = read(path, &self.input.reading.options(path)?)?.with_command(command_line("again.graphml"));
        say_read(terminal, &input, self.input.reading.units.is_none());
        let found = label(input, &options, &mut Follower::new(terminal))?;
        found.write_names(&names, force)?;
        found.write_landmarks(&landmarks, force)?;
        found.write_segments(&segments, force)?;
        Ok(())
    }
}
