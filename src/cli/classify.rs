//! `willis classify`: the phenotype of a Circle of Willis whose topology is taken as it stands, or with its probability after `willis infer`.

use std::path::{Path, PathBuf};

use super::subjects::{Inputs, Subject, check_output, expand, name_of};
use super::{
    args::ArteryArgs, args::reading::RunsArgs, args::source_for, checkpoint::Follower, cohort::Cohort, cohort::Work,
    command_line::command_line, command_line::parsed, print::TextTerminal, print::inference::say_collaterals,
    print::inference::say_variant, print::plural, shell::print_json,
};
use crate::internals::circle_of_willis::{Artery, RING, present_segments};
use crate::internals::formats::{is_there, write_csv};
use crate::internals::output::names::{ACCURACY, PHENOTYPE, RECORD};
use crate::internals::output::{StagedFiles, StagedFolder, read_json};
use crate::internals::report::cohort::{Figures, phenotype_figures};
use crate::internals::report::{Segments, accuracy_columns};
use crate::{ArterySource, Error, InferOptions, Phenotype, Result, classify};

/// Name the anatomical variant of a Circle of Willis
///
/// Where each artery is, is said by the labels of vessels, by the in- and outlets in a file of landmarks, or found by the geometry. A segment is present
/// when it connects what it should. The vessels of a file are taken as they are; of a folder of willis infer, the plausible
/// topologies are drawn again, and every segment and variant has its probability.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis classify circle.graphml -o phenotype
  willis classify 'cohort/*' -o phenotypes")]
pub struct ClassifyArgs {
    #[command(flatten)]
    runs: RunsArgs,
    /// The folder to write; it must not exist, but for that of a cohort to go on with
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    #[command(flatten)]
    pub(super) arteries: ArteryArgs,
    /// The column of a manifest that has the true variants, as their missing segments (complete, or L-PComm, R-P1): accuracy.csv tells how often
    /// the answer is right
    #[arg(long, value_name = "COLUMN")]
    truth: Option<String>,
    /// Print phenotype.json on standard output too; of a cohort, its row of each subject
    #[arg(long)]
    json: bool,
}

impl ClassifyArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        self.runs.reading.refuse_candidates("classify")?;
        let input = match expand(&self.runs.inputs, true)? {
            Inputs::One(input) if self.truth.is_none() => input,
            Inputs::One(_) => {
                let column = self.truth.as_deref().unwrap_or_default();
                return Err(Error::parameter("truth", column, "goes with a manifest that has the column"));
            }
            Inputs::Many(subjects) => {
                let phenotypes = self.arteries.phenotypes.clone();
                let infer = InferOptions { arteries: self.arteries.source(), phenotypes, ..InferOptions::default() };
                let parameters = self.runs.reading.parameters(infer)?;
                let cohort = Cohort { command: "classify", parameters, output: &self.output, force, json: self.json };
                let truths = self.truth.as_ref().map(|column| truths(column, &subjects)).transpose()?;
                let done = cohort.run(&subjects, &self, terminal);
                // Of a cohort in which some subjects failed the others count.
                if let (Some(truths), Ok(()) | Err(Error::Subjects { .. })) = (&truths, &done) {
                    self.compare(&subjects, truths, terminal)?;
                }
                return done;
            }
        };
        let read = self.files(&input);
        check_output(&self.output, force, read.iter().map(|path| &**path).chain([&*input]))?;
        let phenotype = self.phenotype(&input, command_line("again"), terminal)?;
        StagedFolder::fill(&self.output, force, |folder| phenotype.write(&folder.path(), &name_of(&input)))?;
        if self.json {
            print_json(&phenotype.json)?;
        }
        terminal.say("written", self.output.display().to_string());
        Ok(())
    }

    /// Writes accuracy.csv beside the table of a cohort.
    fn compare(&self, subjects: &[Subject], truths: &[Option<Segments>], terminal: TextTerminal) -> Result<()> {
        let found = |subject: &Subject| -> Option<Segments> {
            let run: serde_json::Value =
                read_json(&self.output.join(&subject.name).join(RECORD), "expected the record of a run").ok()?;
            let there = |artery: Artery| run["phenotype"]["segments"][artery.to_string()].as_bool();
            RING.into_iter().map(there).collect::<Option<Vec<bool>>>()?.try_into().ok()
        };
        let pairs: Vec<(Segments, Segments)> =
            subjects.iter().zip(truths).filter_map(|(subject, truth)| Some(((*truth)?, found(subject)?))).collect();
        StagedFiles::write_one(&self.output.join(ACCURACY), true, |out| write_csv(out, &accuracy_columns(&pairs)))?;
        let right = pairs.iter().filter(|(truth, found)| truth == found).count();
        terminal.say("compared", format!("{right} of {} exact", plural(pairs.len(), "variant")));
        Ok(())
    }

    /// How the arteries of an input are known, where a person said it.
    pub(super) fn source(&self, input: &Path) -> Option<ArterySource> {
        self.arteries.source().map(|source| source_for(&source, input))
    }

    fn phenotype(&self, path: &Path, command: String, terminal: TextTerminal) -> Result<Phenotype> {
        let input = self.runs.reading.read_run(path, command, terminal)?;
        let phenotype = classify(&input, self.source(path).as_ref(), &self.arteries.phenotypes, &mut Follower::new(terminal))?;
        terminal.notes(&phenotype.notes);
        terminal.say("counted", format!("{}, arteries by {}", plural(phenotype.counted, "vessel"), phenotype.known_by));
        say_variant(terminal, &phenotype.variant, &phenotype.circle.thin(), phenotype.posterior.as_ref());
        say_collaterals(terminal, &phenotype.collaterals);
        Ok(phenotype)
    }
}

/// The true segments of each subject, by a column of their manifest; none where it is empty.
fn truths(column: &str, subjects: &[Subject]) -> Result<Vec<Option<Segments>>> {
    let of = |subject: &Subject| {
        let said = subject.covariates().iter().find(|(name, _)| name == column);
        let missing = || Error::parameter("truth", column, "goes with a manifest that has the column");
        let (_, text) = said.ok_or_else(missing)?;
        let wrong = |accepted| subject.fault(Error::parameter(column, format!("\"{text}\""), accepted));
        (!text.is_empty()).then(|| present_segments(text).map_err(wrong)).transpose()
    };
    subjects.iter().map(of).collect()
}

impl Work for ClassifyArgs {
    const FIGURES: fn(&serde_json::Value) -> Figures = phenotype_figures;
    const READ_AGAIN: &[&str] = &[PHENOTYPE];

    fn of(words: &[String]) -> Result<Self> {
        let args: Self = parsed(words)?;
        args.runs.reading.shared()?;
        Ok(args)
    }

    fn names(&self, column: &str) -> bool {
        self.truth.as_deref() == Some(column)
    }

    fn files(&self, input: &Path) -> Vec<PathBuf> {
        let record = Some(input.join(RECORD)).filter(|path| is_there(path));
        let landmarks = self.source(input).as_ref().and_then(ArterySource::file).map(Path::to_owned);
        let named = [self.runs.reading.loops(input), landmarks, record].into_iter().flatten();
        named.chain(self.arteries.phenotypes.files()).collect()
    }

    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: TextTerminal) -> Result<()> {
        self.phenotype(&subject.input, subject.line("again"), terminal)?.write(&folder.path(), &subject.name)
    }
}
