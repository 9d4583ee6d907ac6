//! `willis train`: fit the evidence model to extractions whose true connections are known.

mod args;
mod trees;

use std::{collections::BTreeSet, io::Write, time::Instant};

use serde_json::json;

use crate::internals::candidates::model::{Fold, HeldOutScores, Weights};
use crate::internals::training::names::{NamingModel, fit_names, read_labelled_cases};
use crate::internals::training::{
    CandidateExample, Case, Cases, ContactModel, FittedPass, Folds, Model, TrainParams, cross_validate, fit, goes_without_inlets,
    read_cases,
};
use crate::{
    Result, internals::candidates::joins::model::JoinModel, internals::output::StagedFiles, internals::pipeline::require,
};

pub use args::TrainArgs;
use args::{ModelKind, Output, made_by, or_none};

use crate::cli::print::{TextTerminal, count, plural, say_notes};

impl TrainArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let params = self.params()?;
        let output = Output { paths: self.outputs()?, force, terminal, began: Instant::now() };
        StagedFiles::check(&output.paths[0], &output.paths[1..], force)?;
        self.refuse_unused()?;
        if let Some(path) = &self.calibrate_onto {
            return trees::calibrate(path, &self, &output);
        }
        match self.model {
            ModelKind::Tracing => self.fit_tracings(&params, &output),
            ModelKind::Skeleton => trees::run::<JoinModel>(&self, &output),
            ModelKind::Contacts => trees::run::<ContactModel>(&self, &output),
            ModelKind::Labels => fit_labels(&self, &output),
        }
    }

    /// Refuses options that the model does not look at.
    fn refuse_unused(&self) -> Result<()> {
        let usual = TrainParams::default();
        let (is_tracing, of_tracing) = (self.model == ModelKind::Tracing, "goes with --model tracing");
        require(is_tracing || self.l2 == usual.l2, "l2", self.l2, of_tracing)?;
        require(is_tracing || self.passes == usual.iterations.len(), "passes", self.passes, of_tracing)?;
        if let Some(path) = self.calibrate_with.first() {
            require(is_tracing, "calibrate_with", path.display(), of_tracing)?;
        }
        if let Some(path) = &self.images_onto {
            let is_of_trees = matches!(self.model, ModelKind::Skeleton | ModelKind::Contacts);
            require(is_of_trees, "images_onto", path.display(), "goes with --model skeleton or contacts")?;
        }
        let Some(path) = &self.calibrate_onto else { return Ok(()) };
        require(self.model == ModelKind::Contacts, "calibrate_onto", path.display(), "goes with --model contacts")
    }

    /// Fits the weights of tracings.
    fn fit_tracings(&self, params: &TrainParams, output: &Output) -> Result<()> {
        let terminal = output.terminal;
        let Cases { cases: all, notes } = read_cases(&self.cases, Model::Tracing)?;
        say_notes(terminal, &notes, "case");
        let folds = Folds::new(&all, self.folds)?;
        let others = read_cases(&self.calibrate_with, Model::Tracing)?;
        say_notes(terminal, &others.notes, "case");
        let calibrating = CandidateExample::measure(others.cases.iter(), true)?;
        let judged = CandidateExample::measure(all.iter(), true)?;
        let bare = |case: &Case| goes_without_inlets(case, params.without_inlets) && !case.inlets.is_empty();
        let unfed = CandidateExample::measure(all.iter().filter(|case| bare(case)), false)?;
        let mut rest = unfed.iter();
        let training: Vec<_> = judged.iter().map(|e| if bare(e.case) { rest.next().unwrap_or(e) } else { e }).collect();
        say_cases(terminal, &judged);
        say_cases(terminal, &calibrating);
        let calibrating: Vec<&CandidateExample> = calibrating.iter().collect();
        let (seconds, bare) = (output.began.elapsed().as_secs_f64(), plural(unfed.len(), "case"));
        terminal.say("measured", format!("in {seconds:.0} s; {bare} used without their inlets"));
        let mut weights = fit(&training, &calibrating, params, &mut |step| say_step(terminal, "fitted", step))?;
        let examples: Vec<&CandidateExample> = judged.iter().chain(calibrating.iter().copied()).collect();
        let (folds, figures) = cross_validate(&examples, &folds, |fold, is_held_out| {
            let stays = |e: &&CandidateExample| !is_held_out(e.case);
            let inner: Vec<&CandidateExample> = training.iter().copied().filter(stays).collect();
            let calibrating: Vec<&CandidateExample> = calibrating.iter().copied().filter(stays).collect();
            fit(&inner, &calibrating, params, &mut |step| say_step(terminal, &format!("fold {fold}"), step))
        })?;
        for figures in &figures {
            let HeldOutScores { of, log_likelihood, .. } = figures;
            let [precision, error] = [figures.average_precision, figures.calibration_error].map(or_none);
            let cases = format!("{} of {}", plural(figures.cases, "case"), plural(figures.subjects, "subject"));
            let all = format!("{precision}, calibration error {error}, log-likelihood {log_likelihood:.3} ({cases})");
            terminal.say("held out", format!("{of}: average precision {all}"));
        }
        let of_fold = |of: &Weights| Fold { held_out: of.provenance.held_out.clone(), figures: of.figures.clone() };
        weights.folds = folds.iter().map(of_fold).collect();
        weights.figures.clone_from(&figures);
        let made_by = made_by();
        let write = |mut weights: Weights, out: &mut dyn Write| {
            weights.provenance.made_by.clone_from(&made_by);
            weights.write(out)
        };
        output.save(self, [weights].into_iter().chain(folds), write, all.len(), &json!(figures))
    }
}

/// What was read, by data set.
fn say_cases(terminal: TextTerminal, examples: &[CandidateExample]) {
    for of_set in examples.chunk_by(|a, b| a.case.data_set == b.case.data_set) {
        let subjects: BTreeSet<&str> = of_set.iter().map(|e| e.case.subject.as_str()).collect();
        let sum = |of: &dyn Fn(&CandidateExample) -> usize| of_set.iter().map(of).sum::<usize>();
        let (cases, subjects) = (plural(of_set.len(), "case"), plural(subjects.len(), "subject"));
        let fragments = plural(sum(&|e| e.extraction.fragments.len()), "fragment");
        let (needed, reached) = (plural(sum(&|e| e.case.truth.needed()), "true connection"), count(sum(&|e| e.reached()) as u64));
        let within = format!("{reached} of them within reach of {}", plural(sum(&|e| e.table.pairs.points.len()), "candidate"));
        terminal.say("read", format!("{}: {cases} of {subjects}, {fragments}, {needed}, {within}", of_set[0].case.data_set));
    }
}

fn say_step(terminal: TextTerminal, heading: &str, step: &FittedPass) {
    let [before, after] = step.objective;
    let FittedPass { pass, evaluations, .. } = step;
    terminal.say(heading, format!("pass {pass}: objective {before:.5} -> {after:.5} in {}", plural(*evaluations, "evaluation")));
}

/// Fits the model that names arteries and those of its folds, and writes them.
fn fit_labels(args: &TrainArgs, output: &Output) -> Result<()> {
    let terminal = output.terminal;
    let cases = read_labelled_cases(&args.cases)?;
    terminal.say("read", plural(cases.len(), "case"));
    let accepted = "expected 2 or more: which pieces are false is learnt from atlases without the subject";
    require(args.folds >= 2, "folds", args.folds, accepted)?;
    let fitted = fit_names(&cases, args.folds, &mut |step| output.say_after("fitted", step))?;
    for of in &fitted[0].figures {
        let length = format!("{:.3} of the length right, {:.3} with M1 and M2 as one", of.length_right, of.length_right_mca);
        let segments = format!("segments {:.3}, variants {:.3} ({})", of.presence_right, of.exact, plural(of.cases, "case"));
        terminal.say("held out", format!("{}: {length}; {segments}", of.of));
    }
    let made_by = made_by();
    let write = |mut model: NamingModel, out: &mut dyn Write| {
        model.provenance.made_by.clone_from(&made_by);
        model.write(out)
    };
    let figures = json!(fitted[0].figures);
    output.save(args, fitted.into_iter(), write, cases.len(), &figures)
}
