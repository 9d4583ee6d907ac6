//! The figures of a Circle of Willis, as subjects.csv, cohort.csv and phenotype.json have them.

use std::borrow::Cow;

use serde::Serialize;
use serde_json::{Value, json};

use willis_core::network::units::millimetres;
use willis_models::circle_of_willis::{Artery, RING, Variant};

/// The sides of a body in the names of arteries.
pub(crate) const SIDES: [&str; 2] = ["L-", "R-"];

/// Figures of a whole network, by the names of their columns.
pub type NamedFigures = Vec<(Cow<'static, str>, f64)>;

/// What is said of each artery, by its name.
pub fn by_artery<T: Serialize>(arteries: &[Artery], said: impl IntoIterator<Item = T>) -> Value {
    arteries.iter().zip(said).map(|(artery, said)| (artery.to_string(), json!(said))).collect()
}

/// 2 (L - R)/(L + R).
pub(crate) fn asymmetry(left: f64, right: f64) -> f64 {
    2.0 * (left - right) / (left + right)
}

/// The segments of [`RING`] and the posterior cerebral arteries in a topology.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleFigures {
    /// The mean diameter of each segment that is there, mm.
    diameters: [Option<f64>; 7],
    /// Whether each segment that is there is hypoplastic.
    hypoplastic: [Option<bool>; 7],
    /// Whether the left and the right posterior cerebral artery are of fetal type.
    fetal: [Option<bool>; 2],
}

impl CircleFigures {
    /// Of a variant whose segments have these diameters, m; `thin` are those too thin.
    pub fn of(variant: &Variant, diameters: &[Option<f64>; 7], thin: [bool; 7]) -> Self {
        let there = |at: usize| variant.has(RING[at]);
        Self {
            diameters: std::array::from_fn(|at| diameters[at].filter(|_| there(at)).map(millimetres)),
            hypoplastic: std::array::from_fn(|at| there(at).then_some(thin[at])),
            fetal: variant.fetal.map(Some),
        }
    }

    /// The segments that are there and thin.
    pub fn thin(&self) -> Vec<Artery> {
        RING.into_iter().zip(self.hypoplastic).filter(|(_, thin)| *thin == Some(true)).map(|(artery, _)| artery).collect()
    }

    /// The columns of tables of subjects: of each segment and each pair of them, and the fetal type. No number for a segment that is not there.
    pub fn columns(&self) -> NamedFigures {
        let flag = |is: Option<bool>| is.map_or(f64::NAN, |is| f64::from(u8::from(is)));
        let diameters = self.diameters.map(|diameter| diameter.unwrap_or(f64::NAN));
        let (mut columns, mut pairs) = (NamedFigures::new(), NamedFigures::new());
        for (at, artery) in RING.iter().enumerate() {
            columns.push((format!("circle_{artery}_diameter_mm").into(), diameters[at]));
            columns.push((format!("circle_{artery}_hypoplastic").into(), flag(self.hypoplastic[at])));
            let opposite = RING.iter().position(|other| *other == artery.opposite()).filter(|other| *other > at);
            if let Some(right) = opposite {
                let name = artery.to_string();
                let name = format!("circle_{}_asymmetry", name.trim_start_matches(SIDES[0]));
                pairs.push((name.into(), asymmetry(diameters[at], diameters[right])));
            }
        }
        columns.extend(pairs);
        columns.extend(["fetal_L-PCA", "fetal_R-PCA"].into_iter().zip(self.fetal).map(|(name, is)| (name.into(), flag(is))));
        columns
    }

    /// States them in a phenotype, which says already what is there.
    pub(crate) fn put(&self, phenotype: &mut Value) {
        phenotype["diameters_mm"] = by_artery(&RING, self.diameters);
        phenotype["hypoplastic"] = json!(self.thin().iter().map(ToString::to_string).collect::<Vec<_>>());
    }

    /// Those that a phenotype states.
    pub(crate) fn in_phenotype(phenotype: &Value) -> Self {
        let thin: Vec<&str> = phenotype["hypoplastic"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let names = RING.map(|artery| artery.to_string());
        let is_there = |name: &str| phenotype["segments"][name].as_bool() == Some(true);
        Self {
            diameters: std::array::from_fn(|at| phenotype["diameters_mm"][&names[at]].as_f64()),
            hypoplastic: std::array::from_fn(|at| is_there(&names[at]).then(|| thin.contains(&&*names[at]))),
            fetal: ["L-PCA", "R-PCA"].map(|side| phenotype["fetal"][side].as_bool()),
        }
    }
}
