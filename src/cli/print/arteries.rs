//! Prints what `willis infer` and `willis classify` know of a Circle of Willis.

use crate::internals::circle_of_willis::{Artery, Collateral, Posterior, RING, TERRITORIES, Variant};

use super::{TextTerminal, brief};

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
