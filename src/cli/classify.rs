//! `willis classify`: the phenotype of a Circle of Willis whose topology is taken as it stands, or with its probability after `willis infer`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::Value;
use willis::error::{Error, Result};
use willis::internals::circle_of_willis::{Collateral, Posterior, Variant, present_vessels};
use willis::internals::output::{StagedFolder, write_record};
use willis::internals::report::cohort::{Figures, phenotype_figures};
use willis::internals::report::{
    Classified, classification_record, collateral_json, phenotype_json, write_collaterals, write_phenotype,
};

use super::circle::CircleArgs;
use super::cohort::{Cohort, Work};
use super::loaded::Loaded;
use super::plausible::Flow;
use super::provenance::{command_line, command_line_of};
use super::reading::ReadingArgs;
use super::run::Run;
use super::shell::print_json;
use super::subjects::{Inputs, Subject, expand};
use super::tell_circle::{say_collaterals, say_variant};
use super::terminal::{Terminal, plural};

/// Name the anatomical variant of a Circle of Willis
///
/// Where each artery is, is said by the labels of vessels, or by the in- and outlets in a file of landmarks. A segment is present
/// when it connects what it should. The vessels of a file are taken as they are; of a folder of willis infer, the plausible
/// topologies are drawn again, and every segment and variant has its probability.
#[derive(Debug, Args, Serialize)]
pub struct ClassifyArgs {
    /// Labelled vessels in any format that infer reads, or folders of willis infer; of several, or of patterns in quotes, a cohort
    #[serde(skip)]
    #[arg(required = true, value_name = "INPUT", value_hint = clap::ValueHint::AnyPath)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    reading: ReadingArgs,
    /// The folder to write; it must not exist, but for that of a cohort to go on with
    #[serde(skip)]
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    #[command(flatten)]
    #[serde(flatten)]
    circle: CircleArgs,
    /// Print phenotype.json on standard output too; of a cohort, its row of each subject
    #[serde(skip)]
    #[arg(long)]
    json: bool,
}

/// What is known of one subject.
struct Answer {
    variant: Variant,
    posterior: Option<Posterior>,
    phenotype: Value,
    collaterals: Vec<Collateral>,
    record: Value,
}

impl Answer {
    fn write(&self, folder: &Path, subject: &str) -> Result<()> {
        write_phenotype(folder, subject, &self.variant, self.posterior.as_ref(), &self.phenotype)?;
        write_collaterals(folder, &self.collaterals)?;
        write_record(folder, &self.record)
    }
}

impl ClassifyArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        self.reading.refuse_candidates("classify")?;
        let input = match expand(&self.inputs)? {
            Inputs::One(input) => input,
            Inputs::Many(subjects) => {
                self.reading.check()?;
                let parameters = serde_json::to_value(&self).map_err(|e| Error::parameter("arguments", "", e.to_string()))?;
                let cohort = Cohort { command: "classify", parameters, output: &self.output, force, json: self.json };
                return cohort.run(&subjects, &self, terminal);
            }
        };
        StagedFolder::check(&self.output, force)?;
        let answer = self.answer(&input, command_line(), terminal)?;
        let folder = StagedFolder::new(&self.output, force)?;
        answer.write(&folder.path(), &Run::subject(&input))?;
        folder.commit()?;
        if self.json {
            print_json(&answer.phenotype)?;
        }
        terminal.say("written", self.output.display().to_string());
        Ok(())
    }

    fn answer(&self, input: &Path, command: String, terminal: Terminal) -> Result<Answer> {
        let run = Run::of(input)?;
        let path = run.as_ref().map_or(input, |run| &run.graph);
        let mut loaded = Loaded::read(path, &self.reading, command, terminal)?;
        if let Some(run) = &run {
            run.check_graph(&loaded.provenance.sha256)?;
        }
        let scale = self.reading.scale()?;
        if run.is_none() && loaded.fragments && !self.circle.is_by_landmarks() {
            loaded.divide_by_labels();
        }
        let network = &loaded.network;
        let found = match run.as_ref().filter(|run| run.circle.is_given() && !self.circle.is_given()) {
            Some(run) => {
                let found = run.circle.find(input, network, &scale)?;
                run.check_landmarks(&found)?;
                found
            }
            None => self.circle.find(input, network, &scale)?,
        };
        let mut notes = found.notes.clone();
        let (kept, variant, posterior) = if let Some(run) = &run {
            let (posterior, how) = run.posterior(network, &found.circle)?;
            notes.push(how);
            (posterior.topology.clone(), posterior.best(), Some(posterior))
        } else {
            let (kept, note) = present_vessels(network);
            notes.extend(note.map(str::to_owned));
            let variant = found.circle.variant(network, |row| kept[row]);
            (kept, variant, None)
        };
        let flow = run.as_ref().map_or(Flow::of_blood(loaded.fragments), Run::flow);
        let collaterals = flow.collaterals(network, &found.circle, &kept).unwrap_or_else(|why| {
            notes.push(format!("nothing is told of the loss of a feeder: {why}"));
            Vec::new()
        });
        for note in &notes {
            terminal.say("note", note);
        }
        let counted = kept.iter().filter(|kept| **kept).count();
        terminal.say("counted", format!("{}, arteries by {}", plural(counted, "vessel"), found.known_by));
        say_variant(terminal, &variant, posterior.as_ref());
        let phenotype = phenotype_json(network, &variant, posterior.as_ref());
        let classified = Classified {
            network,
            counted,
            phenotype: &phenotype,
            known_by: &found.known_by,
            landmarks: found.record(),
            collateral: collateral_json(&collaterals),
            notes: &notes,
        };
        let record = classification_record(&classified, &loaded.provenance);
        say_collaterals(terminal, &collaterals);
        Ok(Answer { variant, posterior, phenotype, collaterals, record })
    }
}

impl Work for ClassifyArgs {
    fn files(&self, input: &Path) -> Vec<PathBuf> {
        let record = Some(Run::record(input)).filter(|path| path.is_file());
        [self.reading.loops(input), self.circle.file(input), record].into_iter().flatten().collect()
    }

    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: Terminal) -> Result<()> {
        self.answer(&subject.input, command_line_of(&subject.input, &self.inputs), terminal)?.write(&folder.path(), &subject.name)
    }

    fn figures(&self, record: &Value) -> Figures {
        phenotype_figures(record)
    }
}
