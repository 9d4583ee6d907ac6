//! What each column of the table of a cohort is, as BIDS has it.

use serde_json::{Value, json};

use willis_models::circle_of_willis::{FEEDERS, RING, TERRITORIES};

/// What a column is; `None` for one that is not known.
pub fn describe(column: &str) -> Option<Value> {
    let text = |about: &str| json!({ "Description": about });
    let levels = |about: &str, levels: Value| json!({ "Description": about, "Levels": levels });
    let count = |about: &str| json!({ "Description": about, "Units": "1" });
    let whole = match column {
        "participant_id" => text("The participant."),
        "session_id" => text("The session."),
        "input" => text("The mask of the vessels; seen from the dataset of the masks where it lies there."),
        "sha256" => text("The SHA-256 of the mask."),
        "status" => {
            let known = json!({ "ok": "The run came to its end.", "failed": "The mask gave no answer." });
            levels("Whether there is an answer.", known)
        }
        "error" => text("Why there is no answer."),
        "nodes" => count("Nodes of the graph of vessels and candidate connections."),
        "observed" => count("Vessels that the mask shows."),
        "candidates" => count("Candidate connections between them."),
        "kept" => count("Candidate connections that are kept; the rest is cut."),
        "undecided" => count(
            "Uncertain vessels that a person should look at: by evidence a probability near the cut or a connection left open, by likelihood a figure within two standard errors of the threshold.",
        ),
        "components" => count("Connected components of the kept topology."),
        "cycles" => count("Independent cycles of the kept topology."),
        "sparsity" => count("Candidate connections that are kept, over all."),
        "rho_G_W_per_m3" => json!({ "Description": "Mean resilience of the network.", "Units": "W/m^3" }),
        "expected_wrong" => count("Expected number of wrong connections among those that are kept, by their probabilities."),
        "expected_missed" => count("Expected number of true connections among those that are cut, by their probabilities."),
        "wall_s" => json!({ "Description": "Time that the run took; it differs from run to run.", "Units": "s" }),
        "frame" => text("The axes of the file, RAS or LPS."),
        "vessels" => count("Vessels, divided where the name of the artery changes."),
        "named" => count("Vessels with the name of an artery."),
        "landmarks" => count("Bifurcations and ends of arteries that were found."),
        "doubtful" => count("Landmarks that a person should look at: those of a probability below 0.5."),
        "variant" => text("The variant of the Circle of Willis."),
        "completeness" => text("Which parts of the Circle of Willis are closed."),
        "p_variant" => count("The probability of the variant."),
        "needs_person" => text("Why a person should look; empty where nothing that is open could change the answer."),
        "hypoplastic" => text("The segments of the Circle of Willis that are there and thin."),
        "margin" => count("The probability of the variant minus that of the next."),
        _ => Value::Null,
    };
    if !whole.is_null() {
        return Some(whole);
    }
    let is_segment = |name: &str| RING.iter().any(|artery| artery.to_string() == name);
    let is_feeder = |name: &str| FEEDERS.iter().any(|artery| artery.to_string() == name);
    let is_there = || json!({ "0": "No.", "1": "Yes." });
    if is_segment(column) {
        return Some(levels(&format!("Whether the segment {column} of the Circle of Willis is there."), is_there()));
    }
    if let Some(segment) = column.strip_prefix("p_").filter(|name| is_segment(name)) {
        return Some(count(&format!("The probability that the segment {segment} of the Circle of Willis is there.")));
    }
    let of_circle = column.strip_prefix("circle_");
    if let Some(segment) = of_circle.and_then(|rest| rest.strip_suffix("_diameter_mm")).filter(|name| is_segment(name)) {
        let about = format!("The mean diameter of the segment {segment} of the Circle of Willis, where it is there.");
        return Some(json!({ "Description": about, "Units": "mm" }));
    }
    if let Some(segment) = of_circle.and_then(|rest| rest.strip_suffix("_hypoplastic")).filter(|name| is_segment(name)) {
        return Some(levels(
            &format!("Whether the segment {segment} of the Circle of Willis is hypoplastic, where it is there."),
            is_there(),
        ));
    }
    if let Some(pair) = of_circle.and_then(|rest| rest.strip_suffix("_asymmetry")).filter(|name| is_segment(&format!("L-{name}")))
    {
        return Some(count(&format!("The diameter of the left {pair} minus that of the right, over their mean.")));
    }
    if let Some(artery) = column.strip_prefix("fetal_") {
        return Some(levels(&format!("Whether {artery}, a posterior cerebral artery, is of fetal type."), is_there()));
    }
    if let Some(feeder) = column.strip_prefix("takes_over_").filter(|name| is_feeder(name)) {
        return Some(text(&format!("The communicating artery that takes over when {feeder} is lost.")));
    }
    let is_territory = |name: &str| TERRITORIES.iter().any(|artery| artery.to_string() == name);
    if let Some((territory, feeder)) =
        column.split_once("_from_").filter(|(name, feeder)| is_territory(name) && is_feeder(feeder))
    {
        return Some(count(&format!("The share of the blood of {territory} that comes by {feeder}, on average.")));
    }
    if let Some(territory) = column.strip_suffix("_arrival_ms").filter(|name| is_territory(name)) {
        let about = format!("Mean time since the blood of {territory} entered, the median over the plausible topologies.");
        return Some(json!({ "Description": about, "Units": "ms" }));
    }
    let (territory, feeder) = column.split_once("_without_").filter(|(_, feeder)| is_feeder(feeder))?;
    is_territory(territory).then(|| count(&format!("The share of its flow that {territory} keeps when {feeder} is lost.")))
}
