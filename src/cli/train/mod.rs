//! `willis train`: fit the evidence model to extractions whose true connections are known.

mod names;
mod trees;

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

use crate::error::{Error, Result};
use crate::internals::candidates::joins::model::JoinModel;
use crate::internals::candidates::model::HeldOutScores;
use crate::internals::output::StagedFiles;
use crate::internals::training::{
    CandidateExample, Case, ContactModel, CrossValidation, FittedPass, Model, TrainParams, check_folds, cross_validate, fit,
    goes_without_inlets, read_cases,
};
use clap::Args;
use serde_json::{Value, json};

use crate::cli::args::figures::whole;
use crate::cli::command_line::command_line;
use crate::cli::print::notes::say_notes;
use crate::cli::print::{Terminal, count, plural};
use crate::cli::shell::print_json;

/// Fit the evidence model to extractions whose true connections are known
///
/// Each argument is a data set, searched for case folders. A case folder holds fragments.swc (or one other file of centerlines
/// called fragments) and the answer: truth.json as `willis phantom --break` writes it, or links.csv with the columns
/// ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm, which may be an edges.csv of `willis infer` with `kept` corrected by hand; beside them
/// inlets.csv (x_mm,y_mm,z_mm) and loops.csv where there are any. Nothing is drawn at random: the same cases give the same bytes.
#[derive(Debug, Args)]
pub struct TrainArgs {
    /// Folders of cases
    #[arg(value_name = "CASES", required = true, value_hint = clap::ValueHint::DirPath)]
    cases: Vec<PathBuf>,
    /// The weights to write, for willis infer --prior
    #[arg(short, long, value_name = "FILE.toml", value_hint = clap::ValueHint::FilePath)]
    output: PathBuf,
    /// Folds of the cross-validation by subject that says how well such weights do; 0 for none
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = whole::<usize>, allow_negative_numbers = true)]
    folds: usize,
    /// Write the weights of each fold too, as FILE.fold-1.toml and so on, with the subjects that they never saw
    #[arg(long)]
    save_folds: bool,
    /// What the cases are: hand tracings, whose fragments form a forest, automatic skeletons, whose candidates are judged one by one,
    /// contacts of touching vessels, or names of arteries (labels)
    #[arg(long, value_enum, default_value_t = Kind::Tracing)]
    model: Kind,
    /// Add the pass over images to MODEL.toml, a model of skeletons, and change nothing else in it
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath)]
    images_onto: Option<PathBuf>,
    /// Calibrate MODEL.toml, a model of contacts, on cases that it was not fitted to, and change nothing else in it
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath, conflicts_with_all = ["images_onto", "save_folds"])]
    calibrate_onto: Option<PathBuf>,
    /// Cases of other damage, to which only the calibration is fitted, together with CASES
    #[arg(long, value_name = "CASES", value_hint = clap::ValueHint::DirPath)]
    calibrate_with: Vec<PathBuf>,
    /// Penalty of large weights
    #[arg(long, value_name = "L2", allow_negative_numbers = true, default_value_t = TrainParams::default().l2)]
    l2: f64,
    /// Passes over the candidates: each pass uses the probabilities that the one before gave to the candidates around
    #[arg(long, value_name = "N", default_value_t = TrainParams::default().iterations.len(), value_parser = whole::<usize>, allow_negative_numbers = true)]
    passes: usize,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
}

/// What the cases are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    Tracing,
    Skeleton,
    Contacts,
    Labels,
}

impl TrainArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let params = self.params()?;
        let output = Output { paths: self.outputs()?, force };
        StagedFiles::check(&output.paths[0], &output.paths[1..], force)?;
        if let Some(path) = self.calibrate_with.first().filter(|_| !matches!(self.model, Kind::Tracing)) {
            return Err(Error::parameter("calibrate_with", path.display(), "goes with --model tracing"));
        }
        if let Some(path) = &self.calibrate_onto {
            if !matches!(self.model, Kind::Contacts) {
                return Err(Error::parameter("calibrate_onto", path.display(), "goes with --model contacts"));
            }
            return trees::calibrate(path, &self, &output, terminal);
        }
        match self.model {
            Kind::Tracing => self.fit_tracings(&params, &output, terminal),
            Kind::Skeleton => trees::run::<JoinModel>(&self, &output, terminal),
            Kind::Contacts => trees::run::<ContactModel>(&self, &output, terminal),
            Kind::Labels => names::run(&self, &output, terminal),
        }
    }

    /// Fits the weights of tracings.
    fn fit_tracings(&self, params: &TrainParams, output: &Output, terminal: Terminal) -> Result<()> {
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
            summary(&read.cases, &names, &json!(validated.figures))?;
        }
        Ok(())
    }

    fn params(&self) -> Result<TrainParams> {
        let all = TrainParams::default().iterations;
        if !(1..=all.len()).contains(&self.passes) {
            return Err(Error::parameter("passes", self.passes, format!("expected a number from 1 to {}", all.len())));
        }
        let params = TrainParams { l2: self.l2, iterations: all[..self.passes].to_vec(), ..TrainParams::default() };
        params.validate()?;
        Ok(params)
    }

    /// The files to write: the weights, then those of the folds.
    fn outputs(&self) -> Result<Vec<PathBuf>> {
        if self.output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("toml")) {
            return Err(Error::parameter("output", self.output.display(), "expected an ending .toml"));
        }
        if self.save_folds && self.folds == 0 {
            return Err(Error::parameter("save_folds", "", "goes with --folds of 2 or more"));
        }
        let folds = if self.save_folds { self.folds } else { 0 };
        let of_fold = |fold| self.output.with_extension(format!("fold-{fold}.toml"));
        Ok([self.output.clone()].into_iter().chain((1..=folds).map(of_fold)).collect())
    }
}

/// What was read, by data set.
fn say_cases(terminal: Terminal, examples: &[CandidateExample]) {
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
                plural(sum(&|e| e.table.pairs), "candidate")
            ),
        );
    }
}

fn say_step(terminal: Terminal, heading: &str, step: &FittedPass) {
    let [before, after] = step.objective;
    let FittedPass { pass, evaluations, .. } = step;
    terminal.say(heading, format!("pass {pass}: objective {before:.5} -> {after:.5} in {}", plural(*evaluations, "evaluation")));
}

/// A figure, or that there is none.
fn or_none(x: Option<f64>) -> String {
    x.map_or("-".into(), |x| format!("{x:.3}"))
}

fn say_figures(terminal: Terminal, figures: &HeldOutScores) {
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

/// The files to write: the weights, then those of the folds.
struct Output {
    paths: Vec<PathBuf>,
    force: bool,
}

/// Writes each of some models to its file, all or none; their names.
fn save<M>(
    output: &Output,
    models: impl Iterator<Item = M>,
    write: impl Fn(M, &mut dyn Write) -> io::Result<()>,
) -> Result<Vec<String>> {
    let mut staged = StagedFiles::new(&output.paths[0], output.force)?;
    for (at, (path, model)) in output.paths.iter().zip(models).enumerate() {
        if at == 0 {
            staged.write_main(|out| write(model, out))?;
        } else {
            staged.write(path, |out| write(model, out))?;
        }
    }
    staged.commit()?;
    Ok(output.paths.iter().map(|path| path.display().to_string()).collect())
}

/// Prints a summary as JSON.
fn summary(cases: &[Case], outputs: &[String], figures: &Value) -> Result<()> {
    print_json(&json!({
        "willis": env!("CARGO_PKG_VERSION"),
        "command": command_line("again.toml"),
        "output": outputs,
        "cases": cases.len(),
        "figures": figures,
    }))
}
