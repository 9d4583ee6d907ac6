//! The output of a classification: phenotype.json, phenotype.csv, collateral.csv and the record.

use std::path::Path;

use serde_json::{Value, json};

use super::circle_figures::{CircleFigures, by_artery};
use super::page::phenotype::write_phenotype_page;
use willis_core::error::Result;
use willis_core::network::Network;
use willis_core::network::units::ml_per_min;
use willis_io::formats::{Column, write_csv};
use willis_io::output::names::{COLLATERAL, PAGE, PHENOTYPE, PHENOTYPE_TABLE};
use willis_io::output::{write_file, write_json, write_record};
use willis_models::circle_of_willis::{
    Artery, BodySide, Collateral, DecidingCandidate, FENESTRATED, Posterior, RING, TERRITORIES, Variant,
};

/// The phenotype as CoW_Centerline_Extraction writes it (`anterior`, `posterior`, `fetal`, `fenestration`), with its name, description
/// segments with their diameters, and those that are thin. Where topologies are uncertain it is the most probable variant, with probabilities.
pub fn phenotype_json(network: &Network, variant: &Variant, circle: &CircleFigures, posterior: Option<&Posterior>) -> Value {
    let mut phenotype = anatomy_json(variant);
    circle.put(&mut phenotype);
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

/// The anatomy of a variant.
fn anatomy_json(variant: &Variant) -> Value {
    let has = |artery| variant.has(artery);
    let [left, right] = BodySide::BOTH;
    let segments: Value = presence(variant).map(|(artery, present)| (artery.to_string(), json!(present))).collect();
    let [l_a1, acomm, r_a1, l_p1, r_p1] = variant.fenestration;
    json!({
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
    })
}

/// The segments of the ring and the feeding arteries, with whether each is present.
fn presence(variant: &Variant) -> impl Iterator<Item = (Artery, bool)> {
    let feeders =
        [(Artery::Ica(BodySide::Left), variant.ica[0]), (Artery::Ica(BodySide::Right), variant.ica[1]), (Artery::Ba, variant.ba)];
    RING.into_iter().zip(variant.present).chain(feeders)
}

/// The columns of phenotype.csv, which has one row.
fn phenotype_columns(subject: &str, (variant, circle): (&Variant, &CircleFigures), posterior: Option<&Posterior>) -> Vec<Column> {
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
pub fn write_phenotype(
    folder: &Path,
    subject: &str,
    (variant, circle): (&Variant, &CircleFigures),
    posterior: Option<&Posterior>,
    phenotype: &Value,
) -> Result<()> {
    write_json(&folder.join(PHENOTYPE), phenotype)?;
    let columns = phenotype_columns(subject, (variant, circle), posterior);
    write_file(&folder.join(PHENOTYPE_TABLE), |out| write_csv(out, &columns))
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

/// The columns of collateral.csv: the flow in every segment and territory, with all feeders and without each of them.
pub fn collateral_columns(collaterals: &[Collateral]) -> Vec<Column> {
    let mut rows = Vec::new();
    for collateral in collaterals {
        let segments = RING.iter().zip(&collateral.segments).map(|(artery, flows)| ("segment", artery, flows));
        let territories = TERRITORIES.iter().zip(&collateral.territories).map(|(artery, flows)| ("territory", artery, flows));
        for (kind, artery, flows) in segments.chain(territories) {
            let Some([before, after]) = flows else { continue };
            let takes_over = kind == "segment" && collateral.takes_over == Some(*artery);
            rows.push((collateral.occluded, kind, *artery, ml_per_min(*before), ml_per_min(*after), takes_over));
        }
    }
    let real = |name, of: fn(f64, f64) -> f64| Column::real(name, rows.iter().map(move |row| of(row.3, row.4)));
    vec![
        Column::text("occluded", rows.iter().map(|row| row.0.to_string())),
        Column::text("kind", rows.iter().map(|row| row.1.to_owned())),
        Column::text("artery", rows.iter().map(|row| row.2.to_string())),
        real("flow_mL_per_min", |before, _| before),
        real("flow_occluded_mL_per_min", |_, after| after),
        real("residual_share", |before, after| if before > 0.0 { after / before } else { f64::NAN }),
        Column::whole("takes_over", rows.iter().map(|row| usize::from(row.5))),
    ]
}

/// Writes collateral.csv, the page and the record of a classification of a `subject` into a folder; `run`: the page of its run, seen from there.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_classified(folder: &Path, subject: &str, record: &Value, run: Option<&str>, collaterals: Vec<Column>) -> Result<()> {
    write_file(&folder.join(COLLATERAL), |out| write_csv(out, &collaterals))?;
    write_file(&folder.join(PAGE), |out| write_phenotype_page(out, subject, record, run, collaterals))?;
    write_record(folder, record)
}
