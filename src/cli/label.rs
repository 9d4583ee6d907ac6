//! `willis label`: names of the arteries of a Circle of Willis, from geometry alone, of one input or of a cohort.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::subjects::{Inputs, Subject, expand};
use super::{
    args::CandidateArgs, args::options_for, args::reading::ReadingArgs, args::reading::inputs_of_a_cohort, checkpoint::Follower,
    cohort::Cohort, cohort::Work, command_line::command_line, command_line::parsed, print::TextTerminal, print::plural,
    shell::print_json,
};
use crate::internals::output::{StagedFolder, write_record};
use crate::internals::report::cohort::{Figures, label_figures};
use crate::{
    InferOptions, Labelled, Result, internals::circle_of_willis::RING, internals::formats::Format,
    internals::formats::convert::Target, internals::output::names::LABELLED, internals::pipeline::require, label,
};

/// Name the arteries of a Circle of Willis from their geometry alone, each name with a probability
///
/// Beside FILE it writes FILE.names.csv (a row for about every millimetre, with the probability of each name), FILE.landmarks.csv and
/// FILE.landmarks.mrk.json (bifurcations and ends, to be looked at and corrected in 3D Slicer, and handed back with --landmarks), and
/// FILE.segments.csv (which segments of the circle are there). Candidates pass names over gaps. Of several inputs each has these files, as
/// labelled.graphml and so on, in a folder of its own.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis label scan.nii.gz -o labelled.graphml
  willis label 'scans/*.swc' -o labelled
  willis classify scan.nii.gz -o phenotype --landmarks labelled.landmarks.csv")]
pub struct LabelArgs {
    #[arg(value_name = "INPUT", help = inputs_of_a_cohort(), required = true, value_hint = clap::ValueHint::FilePath, help_heading = None::<&str>)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingArgs,
    /// The labelled vessels to write, the ending says the format, as for convert; of several inputs the folder, which must not exist, unless it is that
    /// of a cohort to go on with
    #[arg(short, long, value_name = "FILE|FOLDER", value_hint = clap::ValueHint::AnyPath)]
    output: PathBuf,
    /// A model of `willis train --model labels` in place of the one that ships
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath)]
    model: Option<PathBuf>,
    #[command(flatten)]
    candidates: CandidateArgs,
    /// Print a summary on standard output, as JSON; of a cohort, its row of each subject
    #[arg(long)]
    json: bool,
}

impl LabelArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let input = match expand(&self.inputs, false)? {
            Inputs::One(input) => input,
            Inputs::Many(subjects) => {
                let accepted = "is the name of a file; expected a folder, since there are several inputs";
                require(Format::of_ending(&self.output).is_none(), "output", self.output.display(), accepted)?;
                let mut parameters = self.reading.parameters(self.options())?;
                parameters["model"] = json!(self.model);
                let cohort = Cohort { command: "label", parameters, output: &self.output, force, json: self.json };
                return cohort.run(&subjects, &self, terminal);
            }
        };
        let accepted = format!("expected an ending {}", Format::written_endings());
        require(Format::of_ending(&self.output).is_some(), "output", self.output.display(), accepted)?;
        let target = Target::new(&self.output, None)?;
        Labelled::check(&target, force)?;
        let found = self.label(&input, command_line("again.graphml"), terminal)?;
        let files = found.write(&target, force)?;
        let files: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        terminal.say("written", files.join(", "));
        if self.json {
            let mut record = found.record();
            record["output"] = json!(files);
            print_json(&record)?;
        }
        Ok(())
    }

    fn options(&self) -> InferOptions {
        let mut options = InferOptions::default();
        options.phenotypes.arteries.clone_from(&self.model);
        self.candidates.put(&mut options);
        options
    }

    fn label(&self, input: &Path, command: String, terminal: TextTerminal) -> Result<Labelled> {
        let options = options_for(self.options(), input);
        let input = self.reading.read(input, command, terminal)?;
        let found = label(input, &options, &mut Follower::new(terminal))?;
        terminal.notes(&found.notes());
        let (vessels, marks) = (plural(found.network.vessel_count(), "vessel"), plural(found.landmarks.len(), "landmark"));
        let doubtful = found.doubtful();
        terminal.say("named", format!("{} of {vessels}, {marks}, {doubtful} of them to be looked at", found.named()));
        let segments = RING.iter().zip(&found.segments).map(|(artery, p)| format!("{artery} {p:.2}"));
        terminal.say("segments", segments.collect::<Vec<_>>().join(", "));
        Ok(found)
    }
}

impl Work for LabelArgs {
    const FIGURES: fn(&Value) -> Figures = label_figures;
    const READ_AGAIN: &[&str] = &[LABELLED];

    fn of(words: &[String]) -> Result<Self> {
        let args: Self = parsed(words)?;
        args.reading.shared()?;
        Ok(args)
    }

    fn files(&self, input: &Path) -> Vec<PathBuf> {
        self.reading.loops(input).into_iter().chain(options_for(self.options(), input).files()).collect()
    }

    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: TextTerminal) -> Result<()> {
        let found = self.label(&subject.input, subject.line("again.graphml"), terminal)?;
        found.write(&Target::new(&folder.path().join(LABELLED), None)?, false)?;
        write_record(&folder.path(), &found.record())
    }
}
