//! The figures of a subject, from its run.json alone, by the columns of cohort.csv.

use std::borrow::Cow;

use serde_json::Value;

use super::WALL_TIME;
use crate::phenotype::{FEEDERS, RING, TERRITORIES};

/// A value of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A number; NaN is missing.
    Number(f64),
    /// Text.
    Text(String),
}

/// What came out of a subject, by column.
pub type Figures = Vec<(Cow<'static, str>, Cell)>;

fn number(value: &Value) -> Cell {
    Cell::Number(value.as_f64().unwrap_or(f64::NAN))
}

fn flag(value: &Value) -> Cell {
    Cell::Number(value.as_bool().map_or(f64::NAN, |there| f64::from(u8::from(there))))
}

fn text(value: &Value) -> Cell {
    Cell::Text(value.as_str().unwrap_or_default().to_owned())
}

/// The figures of an inference. `kept`, `components` and `cycles` are those of the kept topology; `sparsity` is the share of kept
/// candidates among all; wrong and missed connections are those that the evidence expects.
pub fn infer_figures(record: &Value) -> Figures {
    let number = |pointer: &str| record.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let (kept, candidates) = (number("/counts/topology/kept_candidates"), number("/counts/candidates"));
    let figures = [
        ("nodes", number("/counts/nodes")),
        ("observed", number("/counts/observed")),
        ("candidates", candidates),
        ("kept", kept),
        ("undecided", number("/convergence/undecided")),
        ("components", number("/counts/topology/components")),
        ("cycles", number("/counts/topology/cycles")),
        ("sparsity", if candidates > 0.0 { kept / candidates } else { f64::NAN }),
        ("rho_G_W_per_m3", number("/rho_G_W_per_m3")),
        ("expected_wrong", number("/expected_errors/wrong")),
        ("expected_missed", number("/expected_errors/missed")),
        (WALL_TIME, number("/time/wall_s")),
    ];
    phenotype_figures(record).into_iter().chain(figures.map(|(name, x)| (name.into(), Cell::Number(x)))).collect()
}

/// The figures of a Circle of Willis; none where it was not classified. `margin` is the probability of the variant less that of the
/// next.
pub fn phenotype_figures(record: &Value) -> Figures {
    let Some(phenotype) = record.get("phenotype").filter(|p| p.is_object()) else { return Vec::new() };
    let segments = || RING.map(|artery| artery.to_string());
    let mut figures: Figures =
        ["variant", "completeness"].map(|name| (name.into(), text(&phenotype[name]))).into_iter().collect();
    figures.extend(segments().map(|segment| (segment.clone().into(), flag(&phenotype["segments"][segment]))));
    figures.extend(["L-PCA", "R-PCA"].map(|side| (format!("fetal_{side}").into(), flag(&phenotype["fetal"][side]))));
    if let Some(probabilities) = phenotype.get("probabilities") {
        let of_variant = [("p_variant", "variant"), ("margin", "margin")];
        figures.extend(of_variant.map(|(name, key)| (name.into(), number(&probabilities[key]))));
        let of_segment = |segment| (format!("p_{segment}").into(), number(&probabilities["segments"][segment]));
        figures.extend(segments().map(of_segment));
    }
    for feeder in FEEDERS.map(|artery| artery.to_string()) {
        let Some(collateral) = record["collateral"].get(&feeder) else { continue };
        figures.push((format!("takes_over_{feeder}").into(), text(&collateral["takes_over"])));
        for territory in TERRITORIES.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_without_{feeder}").into(), number(&collateral["residual"][territory])));
        }
    }
    figures
}
