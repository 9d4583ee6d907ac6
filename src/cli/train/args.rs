//! The arguments of `willis train`, and what every kind of model has in common: the files to write, and the summary.

use std::{io, io::Write, path::PathBuf, time::Instant};

use serde_json::{Value, json};

use crate::{
    Result, cli::args::whole, cli::command_line::command_line, cli::print::TextTerminal, cli::shell::print_json,
    internals::output::StagedFiles, internals::pipeline::require, internals::training::TrainParams,
};

/// Fit the evidence model to extractions whose true connections are known
///
/// Each argument is a data set, searched for case folders. A case folder holds fragments.swc (or one other file of centerlines
/// called fragments) and the answer: truth.json as `willis phantom --break` writes it, or links.csv with the columns
/// ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm, which may be an edges.csv of `willis infer` with `kept` corrected by hand; beside them
/// inlets.csv (x_mm,y_mm,z_mm) and loops.csv where there are any. Nothing is drawn at random: the same cases give the same bytes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis train cases -o weights.toml
  willis infer extraction.vtp -o clean --prior weights.toml")]
pub struct TrainArgs {
    /// Folders of cases
    #[arg(value_name = "CASES", required = true, value_hint = clap::ValueHint::DirPath)]
    pub cases: Vec<PathBuf>,
    /// The weights to write, for willis infer --prior
    #[arg(short, long, value_name = "FILE.toml", value_hint = clap::ValueHint::FilePath)]
    pub output: PathBuf,
    /// Folds of the cross-validation by subject that says how well such weights do; 0 for none
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub folds: usize,
    /// Write the weights of each fold too, as FILE.fold-1.toml and so on, with the subjects that they never saw
    #[arg(long)]
    pub save_folds: bool,
    /// What the cases are: hand tracings, whose fragments form a forest, automatic skeletons, whose candidates are judged one by one,
    /// contacts of touching vessels, or names of arteries (labels)
    #[arg(long, value_enum, default_value_t = ModelKind::Tracing)]
    pub model: ModelKind,
    /// Add the pass over images to MODEL.toml, a model of skeletons, and change nothing else in it
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath)]
    pub images_onto: Option<PathBuf>,
    /// Calibrate MODEL.toml, a model of contacts, on cases that it was not fitted to, and change nothing else in it
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath, conflicts_with_all = ["images_onto", "save_folds"])]
    pub calibrate_onto: Option<PathBuf>,
    /// Cases of other damage, to which only the calibration is fitted, together with CASES
    #[arg(long, value_name = "CASES", value_hint = clap::ValueHint::DirPath)]
    pub calibrate_with: Vec<PathBuf>,
    /// Penalty of large weights
    #[arg(long, value_name = "L2", allow_negative_numbers = true, default_value_t = TrainParams::default().l2)]
    pub l2: f64,
    /// Passes over the candidates: each pass uses the probabilities that the one before gave to the candidates around
    #[arg(long, value_name = "N", default_value_t = TrainParams::default().iterations.len(), value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub passes: usize,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    pub json: bool,
}

/// What the cases are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ModelKind {
    Tracing,
    Skeleton,
    Contacts,
    Labels,
}

impl TrainArgs {
    /// The parameters of the fit of tracings.
    pub fn params(&self) -> Result<TrainParams> {
        let all = TrainParams::default().iterations;
        let accepted = format!("expected a number from 1 to {}", all.len());
        require((1..=all.len()).contains(&self.passes), "passes", self.passes, accepted)?;
        let params = TrainParams { l2: self.l2, iterations: all[..self.passes].to_vec(), ..TrainParams::default() };
        params.validate()?;
        Ok(params)
    }

    /// The files to write: the weights, then those of the folds.
    pub fn outputs(&self) -> Result<Vec<PathBuf>> {
        let is_toml = self.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        require(is_toml, "output", self.output.display(), "expected an ending .toml")?;
        require(!self.save_folds || self.folds > 0, "save_folds", "", "goes with --folds of 2 or more")?;
        let folds = if self.save_folds { self.folds } else { 0 };
        let of_fold = |fold| self.output.with_extension(format!("fold-{fold}.toml"));
        Ok([self.output.clone()].into_iter().chain((1..=folds).map(of_fold)).collect())
    }
}

/// Where the models go, and what is said of them.
pub struct Output {
    /// The files to write: the weights, then those of the folds.
    pub paths: Vec<PathBuf>,
    pub force: bool,
    pub terminal: TextTerminal,
    pub began: Instant,
}

impl Output {
    /// Says that so many seconds have passed.
    pub fn say_after(&self, heading: &str, step: &str) {
        self.terminal.say(heading, format!("{step} after {:.0} s", self.began.elapsed().as_secs_f64()));
    }

    /// Writes each of some models to its file, all or none, with a summary where it is asked for: how many cases there were, and the figures.
    pub fn save<M>(
        &self,
        args: &TrainArgs,
        models: impl Iterator<Item = M>,
        write: impl Fn(M, &mut dyn Write) -> io::Result<()>,
        cases: usize,
        figures: &Value,
    ) -> Result<()> {
        let mut staged = StagedFiles::new(&self.paths[0], self.force)?;
        for (at, (path, model)) in self.paths.iter().zip(models).enumerate() {
            let made =
                if at == 0 { staged.write_main(|out| write(model, out)) } else { staged.write(path, |out| write(model, out)) };
            made?;
        }
        staged.commit()?;
        let names: Vec<String> = self.paths.iter().map(|path| path.display().to_string()).collect();
        let seconds = args.calibrate_onto.is_none().then(|| format!(" in {:.0} s", self.began.elapsed().as_secs_f64()));
        let took = seconds.unwrap_or_default();
        self.terminal.say("written", format!("{}{took}", names.join(", ")));
        if !args.json {
            return Ok(());
        }
        print_json(&json!({
            "willis": env!("CARGO_PKG_VERSION"),
            "command": command_line("again.toml"),
            "output": names,
            "cases": cases,
            "figures": figures,
        }))
    }
}

/// Program and command, for models.
pub fn made_by() -> String {
    format!("willis {}: {}", env!("CARGO_PKG_VERSION"), command_line("again.toml"))
}

/// A figure, or that there is none.
pub fn or_none(x: Option<f64>) -> String {
    x.map_or("-".into(), |x| format!("{x:.3}"))
}
