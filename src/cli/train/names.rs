//! `willis train --model labels`: the model that names arteries.

use std::time::Instant;

use crate::error::{Error, Result};
use crate::internals::training::names::{fit_names, read_labelled_cases};
use serde_json::json;

use super::args::{Output, TrainArgs, save, summary};
use crate::cli::command_line::command_line;
use crate::cli::print::{TextTerminal, plural};

/// Fits the model and those of its folds, and writes them.
pub(super) fn run(args: &TrainArgs, output: &Output, terminal: TextTerminal) -> Result<()> {
    let began = Instant::now();
    let cases = read_labelled_cases(&args.cases)?;
    terminal.say("read", plural(cases.len(), "case"));
    if args.folds < 2 {
        return Err(Error::parameter(
            "folds",
            args.folds,
            "expected 2 or more: which pieces are false is learnt from atlases without the subject",
        ));
    }
    let fitted = fit_names(&cases, args.folds, &mut |step| {
        terminal.say("fitted", format!("{step} after {:.0} s", began.elapsed().as_secs_f64()));
    })?;
    for of in &fitted.scores {
        terminal.say(
            "held out",
            format!(
                "{}: {:.3} of the length right, {:.3} with M1 and M2 as one; segments {:.3} right by names, {:.3} with topologies; variants {:.3} and {:.3} ({})",
                of.of,
                of.length_right,
                of.length_right_mca,
                of.presence_right[0],
                of.presence_right[1],
                of.exact[0],
                of.exact[1],
                plural(of.cases, "case")
            ),
        );
    }
    let made_by = format!("willis {}: {}", env!("CARGO_PKG_VERSION"), command_line("again.toml"));
    let folds = fitted.folds.into_iter().filter(|_| args.save_folds);
    let names = save(output, [fitted.model].into_iter().chain(folds), |mut model, out| {
        model.provenance.made_by.clone_from(&made_by);
        model.write(out)
    })?;
    terminal.say("written", format!("{} in {:.0} s", names.join(", "), began.elapsed().as_secs_f64()));
    if args.json {
        summary(cases.len(), &names, &json!(fitted.scores))?;
    }
    Ok(())
}
