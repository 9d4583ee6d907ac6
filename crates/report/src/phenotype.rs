//! What is written of a Circle of Willis: phenotype.json, phenotype.csv, collateral.csv, supply.csv, accuracy.csv, and the page of a classification.

use std::path::Path;

use serde_json::{Map, Value, json};

use crate::page::{PageKind, PageTable, colours, warnings, write_page};
use willis_core::error::Result;
use willis_core::network::Network;
use willis_core::network::units::{millimetres, milliseconds, ml_per_min};
use willis_io::formats::{Column, write_csv};
use willis_io::output::names::{COLLATERAL, PAGE, PHENOTYPE, PHENOTYPE_TABLE};
use willis_io::output::{write_file, write_json, write_record};
use willis_models::circle_of_willis::{
    Artery, BodySide, Collateral, DecidingCandidate, Destination, FEEDERS, FENESTRATED, Posterior, RING, Spread, Supply,
    TERRITORIES, Variant,
};

/// The sides of a body in the names of arteries.
pub(crate) const SIDES: [&str; 2] = ["L-", "R-"];

/// Figures of a whole network, by the names of their columns.
pub type NamedFigures = Vec<(std::borrow::Cow<'static, str>, f64)>;

/// What is said of each artery, by its name.
pub fn by_artery<T: serde::Serialize>(arteries: &[Artery], said: impl IntoIterator<Item = T>) -> Value {
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
            let opposite = artery.opposite().in_ring().filter(|other| *other > at);
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

/// A variant, its segments, and what topologies say of it where they are uncertain.
pub type Classified<'a> = (&'a Variant, &'a CircleFigures, Option<&'a Posterior>);

/// The phenotype as CoW_Centerline_Extraction writes it (`anterior`, `posterior`, `fetal`, `fenestration`), with its name, its description,
/// segments with their diameters, and those that are thin. Where topologies are uncertain it is the most probable variant, with probabilities.
pub fn phenotype_json(network: &Network, (variant, circle, posterior): Classified<'_>) -> Value {
    let has = |artery| variant.has(artery);
    let [left, right] = BodySide::BOTH;
    let segments: Value = presence(variant).map(|(artery, present)| (artery.to_string(), json!(present))).collect();
    let [l_a1, acomm, r_a1, l_p1, r_p1] = variant.fenestration;
    let mut phenotype = json!({
        "anterior": {
            "L-A1": has(Artery::A1(left)), "Acom": has(Artery::AComm), "3rd-A2": variant.third_a2, "R-A1": has(Artery::A1(right)),
        },
        "posterior": {
            "L-Pcom": has(Artery::PComm(left)), "L-P1": has(Artery::P1(left)),
            "R-P1": has(Artery::P1(right)), "R-Pcom": has(Artery::PComm(right)),
        },
        "fetal": { "L-PCA": variant.fetal[0], "R-PCA": variant.fetal[1] },
        "fenestration": { "L-A1": l_a1, "Acom": acomm, "R-A1": r_a1, "L-P1": l_p1, "R-P1": r_p1 },
        "willis": env!("CARGO_PKG_VERSION"),
        "variant": variant.name(),
        "published": variant.is_published(),
        "completeness": variant.completeness().name(),
        "words": variant.words(),
        "segments": segments,
        "diameters_mm": by_artery(&RING, circle.diameters),
        "hypoplastic": names(&circle.thin()),
    });
    if let Some(posterior) = posterior {
        phenotype["probabilities"] = probabilities_json(network, posterior);
    }
    phenotype
}

/// How many variants and candidates are listed.
const MOST_LISTED: usize = 10;

fn probabilities_json(network: &Network, posterior: &Posterior) -> Value {
    let variant =
        |(variant, p): &(Variant, f64)| json!({ "variant": variant.name(), "words": variant.words(), "probability": p });
    let deciding = |d: &DecidingCandidate| {
        let [a, b] = network.ends(d.vessel);
        json!({
            "edge": d.vessel, "node_a": a, "node_b": b, "id_a": network.node(a).id, "id_b": network.node(b).id,
            // P as edges.csv has it, and how much of the weight of the topologies has the candidate.
            "probability": network.vessel(d.vessel).evidence().map(|evidence| evidence.probability),
            "share": d.share_with, "variant_with": d.with, "variant_without": d.without,
        })
    };
    json!({
        "not_seen": names(&of_ring(posterior.not_seen)),
        "impossible": names(&of_ring(posterior.impossible)),
        "variant": posterior.probability(),
        "margin": posterior.margin(),
        "segments": by_artery(&RING, posterior.segments),
        "fetal": { "L-PCA": posterior.fetal[0], "R-PCA": posterior.fetal[1] },
        "variants": posterior.variants.iter().take(MOST_LISTED).map(variant).collect::<Vec<_>>(),
        "deciding": posterior.deciding.iter().take(MOST_LISTED).map(deciding).collect::<Vec<_>>(),
        "topologies": posterior.samples,
    })
}

/// The segments that are marked.
fn of_ring(marked: [bool; 7]) -> Vec<Artery> {
    RING.into_iter().zip(marked).filter(|(_, is)| *is).map(|(artery, _)| artery).collect()
}

fn names(arteries: &[Artery]) -> Vec<String> {
    arteries.iter().map(ToString::to_string).collect()
}

/// The segments of the ring and the feeding arteries, with whether each is present.
fn presence(variant: &Variant) -> impl Iterator<Item = (Artery, bool)> {
    let feeders =
        [(Artery::Ica(BodySide::Left), variant.ica[0]), (Artery::Ica(BodySide::Right), variant.ica[1]), (Artery::Ba, variant.ba)];
    RING.into_iter().zip(variant.present).chain(feeders)
}

/// The columns of phenotype.csv, which has one row.
fn phenotype_columns(subject: &str, (variant, circle, posterior): Classified<'_>) -> Vec<Column> {
    let text = |name: &'static str, text: &str| Column::text(name, [text.to_owned()].into_iter());
    let flag = |name: String, flag: bool| Column::whole(name, [usize::from(flag)].into_iter());
    let share = |name: String, share: f64| Column::real(name, [share].into_iter());
    let mut columns =
        vec![text("subject", subject), text("variant", &variant.name()), text("completeness", variant.completeness().name())];
    columns.extend(presence(variant).map(|(artery, present)| flag(artery.to_string(), present)));
    let [left, right] = variant.fetal;
    let others = [("fetal_L-PCA", left), ("fetal_R-PCA", right), ("third_A2", variant.third_a2)];
    columns.extend(others.map(|(name, is)| flag(name.to_owned(), is)));
    let fenestrated = FENESTRATED.iter().zip(variant.fenestration);
    columns.extend(fenestrated.map(|(artery, is)| flag(format!("fenestrated_{artery}"), is)));
    if let Some(posterior) = posterior {
        columns.push(share("p_variant".to_owned(), posterior.probability()));
        columns.extend(RING.iter().zip(posterior.segments).map(|(artery, p)| share(format!("p_{artery}"), p)));
        columns.push(text("not_seen", &names(&of_ring(posterior.not_seen)).join(" ")));
    }
    columns.push(text("hypoplastic", &names(&circle.thin()).join(" ")));
    columns
}

/// Writes phenotype.json and phenotype.csv into a folder.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_phenotype(folder: &Path, subject: &str, of: Classified<'_>, phenotype: &Value) -> Result<()> {
    write_json(&folder.join(PHENOTYPE), phenotype)?;
    write_file(&folder.join(PHENOTYPE_TABLE), |out| write_csv(out, &phenotype_columns(subject, of)))
}

/// For each feeder that is closed the artery that takes over and, for each territory, the share of its flow that is left.
pub fn collateral_json(collaterals: &[Collateral]) -> Value {
    let each = |collateral: &Collateral| {
        let residual = by_artery(&TERRITORIES, collateral.residual());
        let takes_over = collateral.takes_over.map(|artery| artery.to_string());
        (collateral.occluded.to_string(), json!({ "takes_over": takes_over, "residual": residual }))
    };
    Value::Object(collaterals.iter().map(each).collect())
}

/// A row of collateral.csv: the flow in an artery with all feeders and without one of them, mL/min.
struct CollateralFlow {
    occluded: Artery,
    kind: &'static str,
    artery: Artery,
    before: f64,
    after: f64,
    takes_over: bool,
}

/// The columns of collateral.csv: the flow in every segment and territory, with all feeders and without each of them.
pub fn collateral_columns(collaterals: &[Collateral]) -> Vec<Column> {
    let mut rows = Vec::new();
    for collateral in collaterals {
        let segments = RING.iter().zip(&collateral.segments).map(|(artery, flows)| ("segment", artery, flows));
        let territories = TERRITORIES.iter().zip(&collateral.territories).map(|(artery, flows)| ("territory", artery, flows));
        for (kind, artery, flows) in segments.chain(territories) {
            let Some([before, after]) = flows.map(|flows| flows.map(ml_per_min)) else { continue };
            let takes_over = kind == "segment" && collateral.takes_over == Some(*artery);
            rows.push(CollateralFlow { occluded: collateral.occluded, kind, artery: *artery, before, after, takes_over });
        }
    }
    let real = |name, of: fn(&CollateralFlow) -> f64| Column::real(name, rows.iter().map(of));
    vec![
        Column::text("occluded", rows.iter().map(|row| row.occluded.to_string())),
        Column::text("kind", rows.iter().map(|row| row.kind.to_owned())),
        Column::text("artery", rows.iter().map(|row| row.artery.to_string())),
        real("flow_mL_per_min", |row| row.before),
        real("flow_occluded_mL_per_min", |row| row.after),
        real("residual_share", |row| if row.before > 0.0 { row.after / row.before } else { f64::NAN }),
        Column::whole("takes_over", rows.iter().map(|row| usize::from(row.takes_over))),
    ]
}

const CLASSIFIED: PageKind =
    ["circle", include_str!("page/assets/phenotype.html"), "dom data colour table record circle phenotype"];

/// Writes collateral.csv, the page and the record of a classification of a `subject` into a folder; `run`: the page of its run, seen from there.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_classified(folder: &Path, subject: &str, record: &Value, run: Option<&str>, collaterals: Vec<Column>) -> Result<()> {
    write_file(&folder.join(COLLATERAL), |out| write_csv(out, &collaterals))?;
    let mut shown = record.clone();
    let phenotype = shown["phenotype"].take();
    shown["collateral"].take();
    let data = json!({
        "phenotype": phenotype,
        "run": run,
        "warnings": warnings(&shown, &[]),
        "record": shown,
        "colours": colours(),
        "collaterals": PageTable::new("Flow without each feeder", collaterals, false),
    });
    let title = format!("willis classify: {subject}");
    write_file(&folder.join(PAGE), |out| write_page(out, &title, CLASSIFIED, &data))?;
    write_record(folder, record)
}

fn name(network: &Network, destination: Destination) -> String {
    match destination {
        Destination::Territory(artery) => artery.to_string(),
        Destination::Outlet(node) => crate::simulation::end_name(network, node),
    }
}

/// The columns of supply.csv: a row for every territory and outlet and every feeder.
pub fn supply_columns(network: &Network, supplies: &[Supply]) -> Vec<Column> {
    let rows = || supplies.iter().flat_map(|supply| (0..FEEDERS.len()).map(move |feeder| (supply, feeder)));
    let text = |name: &'static str, of: &dyn Fn(&Supply, usize) -> String| Column::text(name, rows().map(|(s, f)| of(s, f)));
    let real = |name: &'static str, of: &dyn Fn(&Supply, usize) -> f64| Column::real(name, rows().map(|(s, f)| of(s, f)));
    let spread = |names: [&'static str; 3], of: &dyn Fn(&Supply, usize) -> Spread| {
        [
            real(names[0], &|s, f| of(s, f).middle),
            real(names[1], &|s, f| of(s, f).interval[0]),
            real(names[2], &|s, f| of(s, f).interval[1]),
        ]
    };
    let arrival = |supply: &Supply, _: usize| {
        let Spread { middle, interval } = supply.arrival;
        Spread { middle: milliseconds(middle), interval: interval.map(milliseconds) }
    };
    let mut columns = vec![
        text("kind", &|s, _| if matches!(s.destination, Destination::Outlet(_)) { "outlet" } else { "territory" }.to_owned()),
        text("name", &|s, _| name(network, s.destination)),
        text("feeder", &|_, f| FEEDERS[f].to_string()),
        real("p_fed", &|s, _| s.fed),
    ];
    columns.extend(spread(["supply", "supply_low", "supply_high"], &|s, f| s.shares[f]));
    columns.extend(spread(["arrival_ms", "arrival_low_ms", "arrival_high_ms"], &arrival));
    columns
}

/// For each territory the shares of its blood by feeder, with their means, and the mean time since it entered in ms, with its median; each with its interval.
pub fn supply_json(network: &Network, supplies: &[Supply]) -> Value {
    let spread = |middle: &str, spread: &Spread, unit: fn(f64) -> f64| json!({ middle: unit(spread.middle), "interval_90": spread.interval.map(unit) });
    let each = |supply: &Supply| {
        let shares = FEEDERS.iter().zip(&supply.shares).map(|(feeder, share)| (feeder.to_string(), spread("mean", share, |x| x)));
        let shares: Map<String, Value> = shares.collect();
        let arrival = spread("median", &supply.arrival, milliseconds);
        (name(network, supply.destination), json!({ "p_fed": supply.fed, "shares": shares, "arrival_ms": arrival }))
    };
    let territories = supplies.iter().filter(|supply| matches!(supply.destination, Destination::Territory(_)));
    Value::Object(territories.map(each).collect())
}

/// Which segments of [`RING`] are there.
pub type Segments = [bool; 7];

/// The segments of the front, those of the back, and all: L-A1, R-A1, AComm, then P1 and PComm.
const PARTS: [(&str, std::ops::Range<usize>); 3] = [("anterior", 0..3), ("posterior", 3..7), ("circle", 0..7)];

/// The figures of accuracy.csv; NaN where a row has none.
const ACCURACY: [&str; 9] = [
    "variants",
    "there_found",
    "there_missed",
    "absent_found",
    "absent_missed",
    "sensitivity",
    "specificity",
    "accuracy",
    "balanced_accuracy",
];

/// The columns of accuracy.csv, of pairs of what is true and what was found: a row for each segment, then for the variants of each part of the circle.
///
/// The balanced accuracy of a segment is the mean of sensitivity and specificity. That of a part is the mean, over the variants that are true of any subject, of the share
/// of their subjects in whom every segment of the part is right: the variant-balanced accuracy of TopCoW (Yang et al. 2023, arXiv:2312.17670).
pub fn accuracy_columns(pairs: &[(Segments, Segments)]) -> Vec<Column> {
    const NONE: f64 = f64::NAN;
    let share = |part: usize, of: usize| if of > 0 { part as f64 / of as f64 } else { NONE };
    let mean = |of: &[f64]| {
        let known: Vec<f64> = of.iter().copied().filter(|x| x.is_finite()).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    let segments = RING.iter().enumerate().map(|(at, artery)| {
        let count = |truth: bool, found: bool| pairs.iter().filter(|(t, f)| (t[at], f[at]) == (truth, found)).count();
        let [hit, missed, invented, absent] =
            [(true, true), (true, false), (false, true), (false, false)].map(|(t, f)| count(t, f));
        let (sensitivity, specificity) = (share(hit, hit + missed), share(absent, absent + invented));
        let (accuracy, balanced) = (share(hit + absent, pairs.len()), mean(&[sensitivity, specificity]));
        let [hit, missed, invented, absent] = [hit, missed, invented, absent].map(|count| count as f64);
        (artery.to_string(), [NONE, hit, missed, invented, absent, sensitivity, specificity, accuracy, balanced])
    });
    let parts = PARTS.into_iter().map(|(name, of)| {
        let mut variants = std::collections::BTreeMap::<&[bool], [usize; 2]>::new();
        for (truth, found) in pairs {
            let counts = variants.entry(&truth[of.clone()]).or_default();
            counts[0] += usize::from(truth[of.clone()] == found[of.clone()]);
            counts[1] += 1;
        }
        let right: usize = variants.values().map(|[right, _]| right).sum();
        let each: Vec<f64> = variants.values().map(|[right, all]| share(*right, *all)).collect();
        let (accuracy, balanced) = (share(right, pairs.len()), mean(&each));
        (name.to_owned(), [variants.len() as f64, NONE, NONE, NONE, NONE, NONE, NONE, accuracy, balanced])
    });
    let rows: Vec<(String, [f64; 9])> = segments.chain(parts).collect();
    let names = Column::text("what", rows.iter().map(|(what, _)| what));
    let subjects = Column::whole("subjects", rows.iter().map(|_| pairs.len()));
    let figures = ACCURACY.iter().enumerate().map(|(at, name)| Column::real(*name, rows.iter().map(move |(_, of)| of[at])));
    [names, subjects].into_iter().chain(figures).collect()
}
