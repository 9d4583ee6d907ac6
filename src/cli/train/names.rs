//! `willis train --model labels`: the model that names arteries.

use std::io::Write;

use crate::error::{Error, Result};
use crate::internals::training::names::{NamingModel, fit_names, read_labelled_cases};
use serde_json::json;

use super::args::{Output, TrainArgs, made_by};
use crate::cli::print::plural;

/// Fits the model and those of its folds, and writes them.
pub(super) fn run(args: &TrainArgs, output: &Output) -> Result<()> {
    let terminal = output.terminal;
    let cases = read_labelled_cases(&args.cases)?;
    terminal.say("read", plural(cases.len(), "case"));
    if args.folds < 2 {
        let accepted = "expected 2 or more: which pieces are false is learnt from atlases without the subject";
        return Err(Error::parameter("folds", args.folds, accepted));
    }
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
