//! `willis train`: fit the evidence model to extractions whose true connections are known.

mod args;
mod names;
mod trees;

use std::collections::BTreeSet;
use std::time::Instant;

use crate::error::{Error, Result};
use crate::internals::candidates::joins::model::JoinModel;
use crate::internals::candidates::model::HeldOutScores;
use crate::internals::output::StagedFiles;
use crate::internals::training::{
    CandidateExample, Case, ContactModel, CrossValidation, FittedPass, Model, TrainParams, check_folds, cross_validate, fit,
    goes_without_inlets, read_cases,
};
use serde_json::json;

pub use args::TrainArgs;
use args::{ModelKind, Output, or_none, save, summary};

use crate::cli::command_line::command_line;
use crate::cli::print::notes::say_notes;
use crate::cli::print::{TextTerminal, count, plural};

impl TrainArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let params = self.params()?;
        let output = Output { paths: self.outputs()?, force };
        StagedFiles::check(&output.paths[0], &output.paths[1..], force)?;
        if let Some(path) = self.calibrate_with.first().filter(|_| !matches!(self.model, ModelKind::Tracing)) {
            return Err(Error::parameter("calibrate_with", path.display(), "goes with --model tracing"));
        }
        if let Some(path) = &self.calibrate_onto {
            if !matches!(self.model, ModelKind::Contacts) {
                return Err(Error::parameter("calibrate_onto", path.display(), "goes with --model contacts"));
            }
            return trees::calibrate(path, &self, &output, terminal);
        }
        match self.model {
            ModelKind::Tracing => self.fit_tracings(&params, &output, terminal),
            ModelKind::Skeleton => trees::run::<JoinModel>(&self, &output, terminal),
            ModelKind::Contacts => trees::run::<ContactModel>(&self, &output, terminal),
            ModelKind::Labels => names::run(&self, &output, terminal),
        }
    }

    /// Fits the weights of tracings.
    fn fit_tracings(&self, params: &TrainParams, output: &Output, terminal: TextTerminal) -> Result<()> {
        let began = Instant::now();
        let read = read_cases(&self.cases, Model::Tracing)?;
        say_notes(terminal, &read.notes, "case");
        let all: Vec<&Case> = read.cases.iter().collect();
        if self.folds > 0 {
            check_folds(&all, self.folds)?;
        }
        let others = read_cases(&self.calibrate_with, Model::Tracing)?;
        say_notes(terminal, &others.notes, "case");
        let calibrating = CandidateExample::measure(&others.cases.iter().collect::<Vec<_>>(), |_| true)?;
        let judged = CandidateExample::measure(&all, |_| true)?;
        let bare = |case: &Case| goes_without_inlets(case, params.without_inlets) && !case.inlets.is_empty();
        let without: Vec<&Case> = all.iter().copied().filter(|case| bare(case)).collect();
        let unfed = CandidateExample::measure(&without, |_| false)?;
        let mut rest = unfed.iter();
        let training: Vec<&CandidateExample> =
            judged.iter().map(|e| if bare(e.case) { rest.next().unwrap_or(e) } else { e }).collect();
        say_cases(terminal, &judged);
        say_cases(terminal, &calibrating);
        let calibrating: Vec<&CandidateExample> = calibrating.iter().collect();
        terminal.say(
            "measured",
            format!("in {:.0} s; {} used without their inlets", began.elapsed().as_secs_f64(), plural(unfed.len(), "case")),
        );
        let mut weights = fit(&training, &calibrating, params, &mut |step| say_step(terminal, "fitted", step))?;
        let mut validated = CrossValidation { figures: Vec::new(), folds: Vec::new(), weights: Vec::new() };
        if self.folds > 0 {
            let judged: Vec<&CandidateExample> = judged.iter().collect();
            validated = cross_validate(&training, &judged, &calibrating, self.folds, params, &mut |fold, step| {
                say_step(terminal, &format!("fold {fold}"), step);
            })?;
            validated.figures.iter().for_each(|figures| say_figures(terminal, figures));
        }
        let made_by = format!("willis {}: {}", env!("CARGO_PKG_VERSION"), command_line("again.toml"));
        weights.figures.clone_from(&validated.figures);
        weights.folds.clone_from(&validated.folds);
        let folds = if self.save_folds { validated.weights } else { Vec::new() };
        let names = save(output, [weights].into_iter().chain(folds), |mut weights, out| {
            weights.provenance.made_by.clone_from(&made_by);
            weights.write(out)
        })?;
        terminal.say("written", format!("{} in {:.0} s", names.join(", "), began.elapsed().as_secs_f64()));
        if self.json {
            summary(read.cases.len(), &names, &json!(validated.figures))?;
        }
        Ok(())
    }
}

/// What was read, by data set.
fn say_cases(terminal: TextTerminal, examples: &[CandidateExample]) {
    for of_set in examples.chunk_by(|a, b| a.case.data_set == b.case.data_set) {
        let subjects: BTreeSet<&str> = of_set.iter().map(|e| e.case.subject.as_str()).collect();
        let sum = |of: &dyn Fn(&CandidateExample) -> usize| of_set.iter().map(of).sum::<usize>();
        let (needed, reached) = (sum(&|e| e.case.truth.needed()), sum(&|e| e.reached()));
        terminal.say(
            "read",
            format!(
                "{}: {} of {}, {}, {}, {} of them within reach of {}",
                of_set[0].case.data_set,
                plural(of_set.len(), "case"),
                plural(subjects.len(), "subject"),
                plural(sum(&|e| e.extraction.fragments.len()), "fragment"),
                plural(needed, "true connection"),
                count(reached as u64),
                plural(sum(&|e| e.table.pairs.points.len()), "candidate")
            ),
        );
    }
}

fn say_step(terminal: TextTerminal, heading: &str, step: &FittedPass) {
    let [before, after] = step.objective;
    let FittedPass { pass, evaluations, .. } = step;
    terminal.say(heading, format!("pass {pass}: objective {before:.5} -> {after:.5} in {}", plural(*evaluations, "evaluation")));
}

fn say_figures(terminal: TextTerminal, figures: &HeldOutScores) {
    terminal.say(
        "held out",
        format!(
            "{}: average precision {}, calibration error {}, log-likelihood {:.3} ({} of {})",
            figures.of,
            or_none(figures.average_precision),
            or_none(figures.calibration_error),
            figures.log_likelihood,
            plural(figures.cases, "case"),
            plural(figures.subjects, "subject")
        ),
    );
}
