//! `willis train --model skeleton|contacts`: models of boosted trees for automatic skeletons.

use std::{io, io::Write, path::Path};

use serde_json::json;

use super::args::{Output, TrainArgs, made_by, or_none};
use crate::cli::print::{count, plural, say_notes};
use crate::internals::candidates::joins::model::{JoinModel, JoinScores};
use crate::internals::training::{
    Case, Cases, ContactExample, ContactModel, ContactScores, Example, Folds, JoinExample, Model, TreeExample,
    calibrate_contacts, cross_validate, read_cases,
};
use crate::{Result, error::Fault, internals::pipeline::SourceFile, internals::pipeline::require};

/// A model of boosted trees in a file, and what is said of it.
pub(super) trait TreeModel: Sized + Sync {
    /// A case with what the trees see of it.
    type Seen<'a>: TreeExample<'a, Model = Self, Scores = Self::HeldOut>;
    /// How well a model did.
    type HeldOut: Clone + serde::Serialize;
    /// Reads the text of a file.
    const READ: fn(&str) -> Result<Self, Fault>;
    const WRITE: fn(&Self, &mut dyn Write) -> io::Result<()>;
    /// What the cases of a data set hold.
    fn say_read(of_set: &[Self::Seen<'_>]) -> String;
    fn say_scores(scores: &Self::HeldOut) -> String;
    /// This model with the part for images of another one, and its figures of images.
    fn with_images_of(self, other: Self) -> Self;
}

/// Fits a model and those of its folds, and writes them.
pub(super) fn run<M: TreeModel>(args: &TrainArgs, output: &Output) -> Result<()> {
    let terminal = output.terminal;
    let Cases { cases, notes } = read_cases(&args.cases, M::Seen::KIND)?;
    say_notes(terminal, &notes, "case");
    let onto = args.images_onto.as_ref().map(|path| model_for_images::<M>(path, &cases)).transpose()?;
    let folds = Folds::new(&cases, args.folds)?;
    let examples = M::Seen::measure(&cases)?;
    for of_set in examples.chunk_by(|a, b| a.case().data_set == b.case().data_set) {
        let (data_set, held) = (&of_set[0].case().data_set, M::say_read(of_set));
        terminal.say("read", format!("{data_set}: {}, {held}", plural(of_set.len(), "case")));
    }
    terminal.say("measured", format!("in {:.0} s", output.began.elapsed().as_secs_f64()));
    let all: Vec<&M::Seen<'_>> = examples.iter().collect();
    let mut model = M::Seen::fit(&all, &mut |step| output.say_after("fitted", step))?;
    let (folds, figures) = cross_validate(&all, &folds, |fold, is_held_out| {
        let inner: Vec<&M::Seen<'_>> = examples.iter().filter(|e| !is_held_out(e.case())).collect();
        M::Seen::fit(&inner, &mut |step| output.say_after(&format!("fold {fold}"), step))
    })?;
    for scores in &figures {
        terminal.say("held out", M::say_scores(scores));
    }
    M::Seen::record(&mut model).1.clone_from(&figures);
    let mut made_by = made_by();
    if let Some(onto) = onto {
        model = onto.with_images_of(model);
        made_by = format!("{}; images: {made_by}", M::Seen::record(&mut model).0.made_by);
    }
    let write = |mut model: M, out: &mut dyn Write| {
        M::Seen::record(&mut model).0.made_by.clone_from(&made_by);
        M::WRITE(&model, out)
    };
    output.save(args, [model].into_iter().chain(folds), write, cases.len(), &json!(figures))
}

/// What parts the command of the fit from that of the calibration in `made_by`.
const CALIBRATION: &str = "; calibration: ";

/// Calibrates the model of contacts in a file, and writes it.
pub(super) fn calibrate(path: &Path, args: &TrainArgs, output: &Output) -> Result<()> {
    let terminal = output.terminal;
    let mut model = read_model::<ContactModel>(path)?;
    let Cases { cases, notes } = read_cases(&args.cases, Model::Contacts)?;
    say_notes(terminal, &notes, "case");
    calibrate_contacts(&mut model, &ContactExample::measure(&cases)?);
    for (name, part) in [("without", &model.skeleton), ("with mask", &model.mask)] {
        let [a, b] = part.calibration;
        terminal.say("calibrated", format!("{name}: log-odds {a:.3} + {b:.3} times those of the partitions"));
    }
    // A calibration from before is replaced.
    let fit = model.provenance.made_by.split(CALIBRATION).next().unwrap_or_default();
    model.provenance.made_by = format!("{fit}{CALIBRATION}{}", made_by());
    output.save(args, std::iter::once(model), |model, out| model.write(out), cases.len(), &json!([]))
}

impl TreeModel for JoinModel {
    type Seen<'a> = JoinExample<'a>;
    type HeldOut = JoinScores;
    const READ: fn(&str) -> Result<Self, Fault> = Self::read;
    const WRITE: fn(&Self, &mut dyn Write) -> io::Result<()> = |model, out| model.write(out);

    fn say_read(of_set: &[JoinExample]) -> String {
        let sum = |of: &dyn Fn(&JoinExample) -> usize| of_set.iter().map(of).sum::<usize>();
        let connections = plural(sum(&|e| e.case.truth.needed()), "true connection");
        let (reached, pairs) = (count(sum(&|e| e.reached()) as u64), plural(sum(&|e| e.truth.matches.len()), "candidate"));
        format!("{connections}, {reached} of them within reach of {pairs}")
    }

    fn say_scores(of: &JoinScores) -> String {
        let [average, precision, recall] = [of.average_precision, of.precision, of.recall].map(or_none);
        let precision = format!("average precision {average}, precision {precision} at recall {recall}");
        let calibration = format!("calibration error {:.4}, {:.0} expected of {}", of.calibration_error, of.expected, of.right);
        let cases = format!("{} of {}", plural(of.cases, "case"), plural(of.subjects, "subject"));
        format!("{}: {precision}, {calibration} ({cases})", of.of)
    }

    fn with_images_of(mut self, other: Self) -> Self {
        self.image = other.image;
        let is_new = |of: &JoinScores| other.figures.iter().all(|new| new.of != of.of);
        self.figures.retain(is_new);
        self.figures.extend(other.figures);
        self
    }
}

/// The model that gets the part for images, for cases that have some.
fn model_for_images<M: TreeModel>(path: &Path, cases: &[Case]) -> Result<M> {
    let has_images = !cases.iter().all(|case| case.images.is_empty());
    require(has_images, "images_onto", path.display(), "needs cases with images: image.nii.gz beside the truth")?;
    read_model(path)
}

/// The model in a file.
fn read_model<M: TreeModel>(path: &Path) -> Result<M> {
    Ok(SourceFile::read_text(path, "expected a model as `willis train` writes it", M::READ)?.0)
}

impl TreeModel for ContactModel {
    type Seen<'a> = ContactExample<'a>;
    type HeldOut = ContactScores;
    const READ: fn(&str) -> Result<Self, Fault> = Self::read;
    const WRITE: fn(&Self, &mut dyn Write) -> io::Result<()> = |model, out| model.write(out);

    fn say_read(of_set: &[ContactExample]) -> String {
        let sum = |of: &dyn Fn(&ContactExample) -> usize| of_set.iter().map(of).sum::<usize>();
        let masks = plural(sum(&|e| usize::from(e.has_mask())), "mask");
        let pairs = plural(sum(&|e| e.joined.iter().flatten().count()), "pair");
        let joined = count(sum(&|e| e.joined.iter().flatten().filter(|joined| **joined).count()) as u64);
        format!("{masks}, {pairs} of branch ends, {joined} of them one vessel")
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

    fn with_images_of(mut self, other: Self) -> Self {
        self.image = other.image;
        self.figures.retain(|of| of.image.is_empty());
        let in_images = other.figures.into_iter().filter(|of| !of.image.is_empty());
        self.figures.extend(in_images);
        self
    }
}
