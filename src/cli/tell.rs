//! What `willis infer` tells a person: what was built, what came out.

use willis::candidates;
use willis::inference::{Keep, Weight};
use willis::network::{Network, Origin};
use willis::phenotype::{Collateral, Posterior, RING, TERRITORIES, Variant};
use willis::report::Outcome;

use super::terminal::{Terminal, brief, count, plural};

/// What the candidates make of the fragments.
pub fn say_built(terminal: Terminal, graph: &Network, params: &candidates::Params, evidence: bool) {
    let candidates = graph.vessels().filter(|(_, v)| v.origin == Origin::Candidate).count();
    let size = format!(
        "{} in a graph of {}, {}",
        plural(candidates, "candidate"),
        plural(graph.node_count(), "node"),
        plural(graph.vessel_count(), "vessel")
    );
    let how = if evidence { "by evidence".to_owned() } else { format!("k = {}", params.k) };
    terminal.say("built", format!("{size} ({how})"));
    if candidates == 0 {
        terminal.say(
            "note",
            match params.max_gap {
                Some(_) => "no free end has another vessel within --max-gap; a larger one may help",
                None => "no free end has another vessel within reach",
            },
        );
    }
}

/// What was kept, and what the kept graph looks like.
pub fn say_outcome(terminal: Terminal, outcome: &Outcome<'_>, seconds: f64) {
    let (answer, kept) = (outcome.answer, &outcome.kept);
    let rate = outcome.result.samples as f64 / seconds.max(1e-9);
    let took = if outcome.exact {
        format!("every pattern in {seconds:.2} s")
    } else {
        format!("{} samples in {seconds:.2} s, {} a second", count(outcome.result.samples), count(rate as u64))
    };
    terminal.say("sampled", format!("{took}, {} solver", outcome.method.solver));
    let cut = match (outcome.rule, answer.threshold) {
        (Keep::Frequency(f), _) => format!("frequency >= {f}"),
        (Keep::Probability(p), _) => format!("probability >= {p}"),
        (Keep::Probable(_), _) => "the most probable forest".into(),
        (_, Some(cut)) => format!("L > {}{}", brief(cut), if outcome.weight == Weight::Count { "" } else { " W/m³" }),
        (_, None) => "no vessel on trial has L > 0".into(),
    };
    terminal.say(
        "kept",
        format!(
            "{} of {} on trial ({cut}), {} pruned, {} undecided{}",
            count(kept.kept as u64),
            plural(kept.kept + kept.pruned, "vessel"),
            count(kept.pruned as u64),
            count(answer.undecided.len() as u64),
            if outcome.rule.asks_evidence() { "" } else { " within two standard errors" }
        ),
    );
    if let Some(expected) = outcome.expected {
        let [wrong, missed] = [expected.wrong, expected.missed].map(brief);
        terminal.say("expected", format!("{wrong} wrong and {missed} missed connections, by the probabilities"));
    }
    let shape = format!("{}, {}", plural(kept.components, "component"), plural(kept.cycles, "independent cycle"));
    terminal.say("topology", format!("{shape}, {} without perfusion", plural(kept.unperfused, "component")));
    let same = answer.kept == answer.above_median;
    if !same {
        let median = &outcome.above_median;
        terminal.say(
            "median",
            format!(
                "{} kept, {}, {}",
                count(median.kept as u64),
                plural(median.components, "component"),
                plural(median.cycles, "independent cycle")
            ),
        );
    }
}

/// Says what a Circle of Willis has, and how probable that is.
pub fn say_variant(terminal: Terminal, variant: &Variant, posterior: Option<&Posterior>) {
    let likely = posterior.map_or_else(String::new, |posterior| {
        let [p, margin] = [posterior.probability(), posterior.margin()].map(brief);
        format!(", probability {p}, {margin} before the next")
    });
    terminal.say("variant", format!("{} ({}){likely}", variant.name(), variant.completeness().name()));
    terminal.say("anatomy", variant.words());
    if let Some(posterior) = posterior {
        let doubtful = RING.iter().zip(posterior.segments).filter(|(_, p)| (0.05..=0.95).contains(p));
        let words: Vec<String> = doubtful.map(|(artery, p)| format!("{artery} {}", brief(p))).collect();
        if !words.is_empty() {
            terminal.say("uncertain", words.join(", "));
        }
    }
}

/// Says what takes over when a feeder is lost.
pub fn say_collaterals(terminal: Terminal, collaterals: &[Collateral]) {
    for collateral in collaterals {
        let least = TERRITORIES.iter().zip(collateral.residual()).filter_map(|(artery, share)| Some((artery, share?)));
        let least = least.min_by(|a, b| a.1.total_cmp(&b.1));
        let least =
            least.map_or_else(String::new, |(artery, share)| format!("; least is left to {artery}, {:.0} %", 100.0 * share));
        let over =
            collateral.takes_over.map_or("no communicating artery takes over".into(), |artery| format!("{artery} takes over"));
        terminal.detail("collateral", format!("without {}: {over}{least}", collateral.occluded));
    }
}
