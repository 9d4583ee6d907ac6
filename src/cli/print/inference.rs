//! Prints what came out of `willis infer`, and what it and `willis classify` know of a Circle of Willis.

use super::{TextTerminal, brief, count, plural};
use crate::internals::circle_of_willis::{Artery, Collateral, Posterior, RING, TERRITORIES, Variant};
use crate::{Inference, Keep, Weight, internals::report::Outcome, internals::report::few_perfused};

/// Says what was kept, and what the kept graph looks like. Sampling took so many `seconds`.
pub fn say_outcome(terminal: TextTerminal, outcome: &Outcome<'_>, seconds: f64) {
    let say = |heading: &str, fact: String| terminal.say(heading, fact);
    let (answer, kept) = (outcome.answer, &outcome.kept);
    let rate = outcome.result.samples as f64 / seconds.max(1e-9);
    let took = if outcome.sampling.exact {
        format!("every pattern in {seconds:.2} s")
    } else {
        format!("{} samples in {seconds:.2} s, {} a second", count(outcome.result.samples), count(rate as u64))
    };
    say("sampled", format!("{took}, {} solver", outcome.solver.flow));
    let Outcome { network, boundary, sampling, result, .. } = outcome;
    if let Some(warning) = few_perfused(network, boundary, sampling, result.perfused) {
        say("warning", warning);
    }
    if let Some(stable) = outcome.stable {
        let about = if outcome.rule.asks_evidence() { "about the median of L" } else { "of the rule" };
        let clear = format!("every decision {about} is two standard errors from turning");
        let open = format!("not yet: after so many samples a decision {about} is still within two standard errors of turning");
        say("stable", if stable { clear } else { open });
    }
    let unit = if outcome.sampling.weight == Weight::Count { "" } else { " W/m³" };
    let cut = outcome.rule.says(answer.threshold.map(|cut| format!("{}{unit}", brief(cut))));
    let [stay, pruned, undecided] = [kept.kept, kept.pruned, answer.undecided.len()].map(|n| count(n as u64));
    let uncertain = plural(kept.kept + kept.pruned, "uncertain vessel");
    let within = if outcome.rule.asks_evidence() { "" } else { " within two standard errors" };
    say("kept", format!("{stay} of {uncertain} ({cut}), {pruned} pruned, {undecided} undecided{within}"));
    let [observed, pruned] = kept.observed;
    if observed > 0 {
        let rule = if outcome.rule.asks_evidence() { "; this rule keeps them, `keep=median` does not" } else { "" };
        say("observed", format!("{} of {} pruned{rule}", count(pruned as u64), plural(observed, "observed vessel")));
    }
    if outcome.contacts() > 0 {
        let contacts = plural(outcome.contacts(), "contact");
        say("cut", format!("{} of {contacts}: two vessels that only touch", count(outcome.cuts().count() as u64)));
    }
    if !answer.left_open.is_empty() {
        let open = plural(answer.left_open.len(), "connection");
        let is_cheap = matches!(outcome.rule, Keep::Probable(price) if price < 1.0);
        let more = if is_cheap { "" } else { "; `keep=probable=0.6` makes more" };
        say("open", format!("{open} of the most probable forest not made, for what hangs on them may well be nothing{more}"));
    }
    if let Some(expected) = outcome.expected {
        let [wrong, missed] = [expected.wrong, expected.missed].map(brief);
        say("expected", format!("{wrong} wrong and {missed} missed connections, by the probabilities"));
    }
    let shape = format!("{}, {}", plural(kept.components, "component"), plural(kept.cycles, "independent cycle"));
    say("topology", format!("{shape}, {} without perfusion", plural(kept.unperfused, "component")));
    if answer.kept != answer.above_median {
        let median = &outcome.above_median;
        let above = format!("{} of {}", count(median.kept as u64), plural(median.kept + median.pruned, "uncertain vessel"));
        let shape = format!("{}, {}", plural(median.components, "component"), plural(median.cycles, "independent cycle"));
        say("median", format!("{above} above the median of L: {shape}, as topology-median"));
    }
}

/// Says what a run knows of a Circle of Willis, where its arteries are known.
pub fn say_circle(terminal: TextTerminal, run: &Inference) {
    if let Some((posterior, how)) = run.posterior() {
        terminal.say("drawn", how);
        say_variant(terminal, &posterior.best(), &run.hypoplastic(), Some(posterior));
    }
}

/// Says what a Circle of Willis has, and how probable that is.
pub fn say_variant(terminal: TextTerminal, variant: &Variant, hypoplastic: &[Artery], posterior: Option<&Posterior>) {
    let likely = posterior.map_or_else(String::new, |posterior| {
        let [p, margin] = [posterior.probability(), posterior.margin()].map(brief);
        format!(", probability {p}, {margin} before the next")
    });
    terminal.say("variant", format!("{} ({}){likely}", variant.name(), variant.completeness().name()));
    terminal.say("anatomy", variant.words());
    if !hypoplastic.is_empty() {
        let names: Vec<String> = hypoplastic.iter().map(ToString::to_string).collect();
        terminal.say("thin", format!("{} (hypoplastic)", names.join(", ")));
    }
    if let Some(posterior) = posterior {
        let doubtful = RING.iter().zip(posterior.segments).filter(|(_, p)| (0.05..=0.95).contains(p));
        let words: Vec<String> = doubtful.map(|(artery, p)| format!("{artery} {}", brief(p))).collect();
        if !words.is_empty() {
            terminal.say("doubtful", words.join(", "));
        }
    }
}

/// Says what takes over when a feeder is lost.
pub fn say_collaterals(terminal: TextTerminal, collaterals: &[Collateral]) {
    for lost in collaterals {
        let least = TERRITORIES.iter().zip(lost.residual()).filter_map(|(artery, share)| Some((artery, share?)));
        let least = least.min_by(|a, b| a.1.total_cmp(&b.1));
        let least = least.map_or_else(String::new, |(to, share)| format!("; least is left to {to}, {:.0} %", 100.0 * share));
        let over = lost.takes_over.map_or("no communicating artery takes over".into(), |artery| format!("{artery} takes over"));
        terminal.detail("collateral", format!("without {}: {over}{least}", lost.occluded));
    }
}
