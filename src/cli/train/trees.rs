//! `willis train --model skeleton|contacts`: models of boosted trees for automatic skeletons.

use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use crate::error::{Error, Fault, Result};
use crate::internals::candidates::joins::model::{JoinModel, JoinScores};
use crate::internals::formats::bytes_of;
use crate::internals::support::model_provenance::ModelProvenance;
use crate::internals::training::{
    Case, ContactExample, ContactModel, ContactScores, JoinExample, Model, calibrate_contacts, check_folds,
    cross_validate_contacts, cross_validate_joins, fit_contacts, fit_joins, read_cases,
};
use serde::Serialize;
use serde_json::json;

use super::args::{Output, TrainArgs, or_none, save, summary};
use crate::cli::command_line::command_line;
use crate::cli::print::notes::say_notes;
use crate::cli::print::{TextTerminal, count, plural};

/// A model of boosted trees and what it is fitted to.
pub(super) trait TreeModel: Sized {
    /// A case with what the trees see of it.
    type Measured<'a>;
    /// How well a model did.
    type HeldOut: Clone + Serialize;
    /// What the cases are.
    const MODEL: Model;

    fn measure<'a>(cases: &[&'a Case]) -> Result<Vec<Self::Measured<'a>>>;
    fn data_set<'e>(example: &'e Self::Measured<'_>) -> &'e str;
    /// What the cases of a data set hold.
    fn say_read(of_set: &[Self::Measured<'_>]) -> String;
    fn fit(examples: &[Self::Measured<'_>], progress: &mut dyn FnMut(&str)) -> Result<Self>;
    /// The models of the folds, and how well they did.
    fn cross_validate(
        examples: &[Self::Measured<'_>],
        folds: usize,
        progress: &mut dyn FnMut(usize, &str),
    ) -> Result<(Vec<Self>, Vec<Self::HeldOut>)>;
    fn say_scores(scores: &Self::HeldOut) -> String;
    /// The model in a file.
    fn read(text: &str) -> Result<Self, Fault>;
    /// This model with the part for images of another one, and its figures of images.
    fn with_images_of(self, other: Self) -> Self;
    fn record(&mut self) -> (&mut ModelProvenance, &mut Vec<Self::HeldOut>);
    fn write(&self, out: &mut dyn Write) -> io::Result<()>;
}

/// Fits a model and those of its folds, and writes them.
pub(super) fn run<M: TreeModel>(args: &TrainArgs, output: &Output, terminal: TextTerminal) -> Result<()> {
    let began = Instant::now();
    let read = read_cases(&args.cases, M::MODEL)?;
    say_notes(terminal, &read.notes, "case");
    let all: Vec<&Case> = read.cases.iter().collect();
    let onto = args.images_onto.as_ref().map(|path| model_for_images::<M>(path, &all)).transpose()?;
    if args.folds > 0 {
        check_folds(&all, args.folds)?;
    }
    let examples = M::measure(&all)?;
    for of_set in examples.chunk_by(|a, b| M::data_set(a) == M::data_set(b)) {
        let held = M::say_read(of_set);
        terminal.say("read", format!("{}: {}, {held}", M::data_set(&of_set[0]), plural(of_set.len(), "case")));
    }
    terminal.say("measured", format!("in {:.0} s", began.elapsed().as_secs_f64()));
    let say = |heading: &str, step: &str| {
        terminal.say(heading, format!("{step} after {:.0} s", began.elapsed().as_secs_f64()));
    };
    let mut model = M::fit(&examples, &mut |step| say("fitted", step))?;
    let (mut folds, mut figures) = (Vec::new(), Vec::new());
    if args.folds > 0 {
        (folds, figures) = M::cross_validate(&examples, args.folds, &mut |fold, step| say(&format!("fold {fold}"), step))?;
        for scores in &figures {
            terminal.say("held out", M::say_scores(scores));
        }
        model.record().1.clone_from(&figures);
    }
    let mut made_by = format!("willis {}: {}", env!("CARGO_PKG_VERSION"), command_line("again.toml"));
    if let Some(onto) = onto {
        model = onto.with_images_of(model);
        made_by = format!("{}; images: {made_by}", model.record().0.made_by);
    }
    let folds = folds.into_iter().filter(|_| args.save_folds);
    let names = save(output, [model].into_iter().chain(folds), |mut model, out| {
        model.record().0.made_by.clone_from(&made_by);
        model.write(out)
    })?;
    terminal.say("written", format!("{} in {:.0} s", names.join(", "), began.elapsed().as_secs_f64()));
    if args.json {
        summary(read.cases.len(), &names, &json!(figures))?;
    }
    Ok(())
}

/// What parts the command of the fit from that of the calibration in `made_by`.
const CALIBRATION: &str = "; calibration: ";

/// Calibrates the model of contacts in a file, and writes it.
pub(super) fn calibrate(path: &Path, args: &TrainArgs, output: &Output, terminal: TextTerminal) -> Result<()> {
    let mut model = read_model::<ContactModel>(path)?;
    let read = read_cases(&args.cases, Model::Contacts)?;
    say_notes(terminal, &read.notes, "case");
    let examples = ContactExample::measure(&read.cases.iter().collect::<Vec<_>>())?;
    calibrate_contacts(&mut model, &examples);
    for (name, part) in [("without", &model.skeleton), ("with mask", &model.mask)] {
        let [a, b] = part.calibration;
        terminal.say("calibrated", format!("{name}: log-odds {a:.3} + {b:.3} times those of the partitions"));
    }
    let made_by = &mut model.provenance.made_by;
    // A calibration from before is replaced.
    let fit = made_by.split(CALIBRATION).next().unwrap_or_default();
    *made_by = format!("{fit}{CALIBRATION}willis {}: {}", env!("CARGO_PKG_VERSION"), command_line("again.toml"));
    let names = save(output, std::iter::once(model), |model, out| model.write(out))?;
    terminal.say("written", names.join(", "));
    if args.json { summary(read.cases.len(), &names, &json!([])) } else { Ok(()) }
}

impl TreeModel for JoinModel {
    type Measured<'a> = JoinExample<'a>;
    type HeldOut = JoinScores;
    const MODEL: Model = Model::Skeleton;

    fn measure<'a>(cases: &[&'a Case]) -> Result<Vec<JoinExample<'a>>> {
        JoinExample::measure(cases)
    }

    fn data_set<'e>(example: &'e JoinExample<'_>) -> &'e str {
        &example.case.data_set
    }

    fn say_read(of_set: &[JoinExample]) -> String {
        let sum = |of: &dyn Fn(&JoinExample) -> usize| of_set.iter().map(of).sum::<usize>();
        let connections = plural(sum(&|e| e.needed), "true connection");
        let (reached, pairs) = (count(sum(&|e| e.reached()) as u64), plural(sum(&|e| e.truth.matches.len()), "candidate"));
        format!("{connections}, {reached} of them within reach of {pairs}")
    }

    fn fit(examples: &[JoinExample], progress: &mut dyn FnMut(&str)) -> Result<Self> {
        fit_joins(&examples.iter().collect::<Vec<_>>(), progress)
    }

    fn cross_validate(
        examples: &[JoinExample],
        folds: usize,
        progress: &mut dyn FnMut(usize, &str),
    ) -> Result<(Vec<Self>, Vec<JoinScores>)> {
        cross_validate_joins(examples, folds, progress)
    }

    fn say_scores(of: &JoinScores) -> String {
        format!(
            "{}: average precision {}, precision {} at recall {}, calibration error {:.4}, {:.0} expected of {} ({} of {})",
            of.of,
            or_none(of.average_precision),
            or_none(of.precision),
            or_none(of.recall),
            of.calibration_error,
            of.expected,
            of.right,
            plural(of.cases, "case"),
            plural(of.subjects, "subject")
        )
    }

    fn read(text: &str) -> Result<Self, Fault> {
        Self::read(text)
    }

    fn with_images_of(mut self, other: Self) -> Self {
        self.image = other.image;
        let is_new = |of: &JoinScores| other.figures.iter().all(|new| new.of != of.of);
        self.figures.retain(is_new);
        self.figures.extend(other.figures);
        self
    }

    fn record(&mut self) -> (&mut ModelProvenance, &mut Vec<JoinScores>) {
        (&mut self.provenance, &mut self.figures)
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        self.write(out)
    }
}

/// The model that gets the part for images, for cases that have some.
fn model_for_images<M: TreeModel>(path: &Path, cases: &[&Case]) -> Result<M> {
    if cases.iter().all(|case| case.images.is_empty()) {
        let accepted = "needs cases with images: image.nii.gz beside the truth";
        return Err(Error::parameter("images_onto", path.display(), accepted));
    }
    read_model(path)
}

/// The model in a file.
fn read_model<M: TreeModel>(path: &Path) -> Result<M> {
    let bytes = bytes_of(path)?;
    let not_utf8 = |_| Fault::file("not UTF-8", "expected a model as `willis train` writes it");
    std::str::from_utf8(&bytes).map_err(not_utf8).and_then(M::read).map_err(|fault| fault.in_file(path))
}

impl TreeModel for ContactModel {
    type Measured<'a> = ContactExample<'a>;
    type HeldOut = ContactScores;
    const MODEL: Model = Model::Contacts;

    fn measure<'a>(cases: &[&'a Case]) -> Result<Vec<ContactExample<'a>>> {
        ContactExample::measure(cases)
    }

    fn data_set<'e>(example: &'e ContactExample<'_>) -> &'e str {
        &example.case.data_set
    }

    fn say_read(of_set: &[ContactExample]) -> String {
        let sum = |of: &dyn Fn(&ContactExample) -> usize| of_set.iter().map(of).sum::<usize>();
        let masks = plural(sum(&|e| usize::from(e.has_mask())), "mask");
        let pairs = plural(sum(&|e| e.joined.iter().flatten().count()), "pair");
        let joined = count(sum(&|e| e.joined.iter().flatten().filter(|joined| **joined).count()) as u64);
        format!("{masks}, {pairs} of branch ends, {joined} of them one vessel")
    }

    fn fit(examples: &[ContactExample], progress: &mut dyn FnMut(&str)) -> Result<Self> {
        fit_contacts(&examples.iter().collect::<Vec<_>>(), progress)
    }

    fn cross_validate(
        examples: &[ContactExample],
        folds: usize,
        progress: &mut dyn FnMut(usize, &str),
    ) -> Result<(Vec<Self>, Vec<ContactScores>)> {
        cross_validate_contacts(examples, folds, progress)
    }

    fn say_scores(of: &ContactScores) -> String {
        let with = match (of.with_mask, of.image.as_str()) {
            (false, _) => "without".to_owned(),
            (true, "") => "with mask".to_owned(),
            (true, image) => format!("with mask and {image}"),
        };
        let (auc, ap, error) = (of.auc, of.average_precision, of.largest_bin_error);
        let (cases, pairs) = (plural(of.cases, "case"), plural(of.pairs, "pair"));
        let name = &of.of;
        format!(
            "{name} {with}: AUC {auc:.3}, average precision of two vessels {ap:.3}, largest bin error {error:.3} ({cases}, {pairs})"
        )
    }

    fn read(text: &str) -> Result<Self, Fault> {
        Self::read(text)
    }

    fn with_images_of(mut self, other: Self) -> Self {
        self.image = other.image;
        self.figures.retain(|of| of.image.is_empty());
        let in_images = other.figures.into_iter().filter(|of| !of.image.is_empty());
        self.figures.extend(in_images);
        self
    }

    fn record(&mut self) -> (&mut ModelProvenance, &mut Vec<ContactScores>) {
        (&mut self.provenance, &mut self.figures)
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        self.write(out)
    }
}
