//! The figures of a subject in the table of its cohort, from the record of its run.

use std::borrow::Cow;

use serde_json::{Value, json};

use super::columns::stated;
use crate::circle_figures::CircleFigures;
use willis_io::formats::tables::reader::plural;
use willis_models::circle_of_willis::{FEEDERS, RING, TERRITORIES};

/// The one column that differs between two runs of one command, from run.json, in seconds.
pub const WALL_TIME: &str = "wall_s";

/// The column that says why a subject needs a person.
const NEEDS_PERSON: &str = "needs_person";

/// What came out of a subject, by column: text, or a number, which is null where it is missing.
pub type Figures = Vec<(Cow<'static, str>, Value)>;

fn number(value: &Value) -> Value {
    json!(value.as_f64())
}

fn flag(value: &Value) -> Value {
    json!(value.as_bool().map(|there| f64::from(u8::from(there))))
}

fn text(value: &Value) -> Value {
    json!(value.as_str().unwrap_or_default())
}

/// A variant below this probability needs a person.
const SURE_VARIANT: f64 = 0.9;
/// A connection is open between this share of the plausible topologies and the rest.
const OPEN: std::ops::Range<f64> = 0.1..0.9;

/// Why a subject needs a person; empty where it does not. Where arteries are known, that is what could change the variant: it is not sure, or
/// one open connection would make another one likelier than not. Where they are not, it is any undecided connection, or an error that the
/// evidence expects.
pub fn needs_person(record: &Value) -> String {
    let mut why = Vec::new();
    let number = |pointer: &str| record.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
    if record["phenotype"].is_object() {
        let p = number("/phenotype/probabilities/variant");
        if p < SURE_VARIANT {
            why.push(format!("variant uncertain, P = {p:.3}"));
        }
        let deciding = record.pointer("/phenotype/probabilities/deciding").and_then(Value::as_array);
        let changes = |d: &&Value| {
            let of = |key: &str| d[key].as_f64().unwrap_or(f64::NAN);
            OPEN.contains(&of("share")) && of("variant_with").min(of("variant_without")) < 0.5
        };
        let changing = deciding.into_iter().flatten().filter(changes).count();
        if changing > 0 {
            why.push(format!("{} would change the variant", plural(changing, "open connection")));
        }
        return why.join("; ");
    }
    let undecided = number("/convergence/undecided");
    if undecided > 0.0 {
        why.push(format!("{undecided} undecided"));
    }
    let (wrong, missed) = (number("/expected_errors/wrong"), number("/expected_errors/missed"));
    if wrong + missed >= 1.0 {
        why.push(format!("about {wrong:.1} wrong and {missed:.1} missed expected"));
    }
    why.join("; ")
}

/// The figures of an inference. `kept`, `components` and `cycles` are those of the kept topology; `sparsity` is the share of kept
/// candidates among all; wrong and missed connections are those that the evidence expects.
pub fn infer_figures(record: &Value) -> Figures {
    let mut all = phenotype_figures(record);
    if all.is_empty() {
        all.push((NEEDS_PERSON.into(), json!(needs_person(record))));
    }
    all.extend(stated("infer", record));
    all
}

/// The figures of a naming: counts, and the probability that each segment of the circle is there. `doubtful` landmarks are those that a person
/// should look at.
pub fn label_figures(record: &Value) -> Figures {
    let doubtful = record.pointer("/counts/doubtful").and_then(Value::as_u64).unwrap_or_default();
    let why = if doubtful > 0 { format!("{} uncertain", plural(doubtful as usize, "landmark")) } else { String::new() };
    let mut figures: Figures = vec![(NEEDS_PERSON.into(), json!(why)), ("frame".into(), text(&record["frame"]))];
    figures.extend(stated("label", record));
    figures.extend(RING.map(|artery| (format!("p_{artery}").into(), number(&record["segments"][artery.to_string()]))));
    figures
}

/// The figures of a Circle of Willis; none where it was not classified. `margin` is the probability of the variant less that of the
/// next.
pub fn phenotype_figures(record: &Value) -> Figures {
    let Some(phenotype) = record.get("phenotype").filter(|p| p.is_object()) else { return Vec::new() };
    let segments = || RING.map(|artery| artery.to_string());
    let mut figures = Figures::from(["variant", "completeness"].map(|name| (name.into(), text(&phenotype[name]))));
    figures.extend(segments().map(|segment| (segment.clone().into(), flag(&phenotype["segments"][segment]))));
    figures.push((NEEDS_PERSON.into(), json!(needs_person(record))));
    let thin: Vec<&str> = phenotype["hypoplastic"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    figures.push(("hypoplastic".into(), json!(thin.join(" "))));
    if let Some(probabilities) = phenotype.get("probabilities") {
        figures.extend(stated("circle", probabilities));
        let of_segment = |segment| (format!("p_{segment}").into(), number(&probabilities["segments"][segment]));
        figures.extend(segments().map(of_segment));
    }
    figures.extend(CircleFigures::in_phenotype(phenotype).columns().into_iter().map(|(name, x)| (name, json!(x))));
    for feeder in FEEDERS.map(|artery| artery.to_string()) {
        let Some(collateral) = record["collateral"].get(&feeder) else { continue };
        figures.push((format!("takes_over_{feeder}").into(), text(&collateral["takes_over"])));
        for territory in TERRITORIES.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_without_{feeder}").into(), number(&collateral["residual"][territory])));
        }
    }
    for territory in TERRITORIES.map(|artery| artery.to_string()) {
        let Some(supply) = record["supply"].get(&territory) else { continue };
        for feeder in FEEDERS.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_from_{feeder}").into(), number(&supply["shares"][&feeder]["mean"])));
        }
        figures.push((format!("{territory}_arrival_ms").into(), number(&supply["arrival_ms"]["median"])));
    }
    figures
}
