//! The output folder of a classification: the phenotype as JSON and as a row of a table, and how it was found.

use std::path::Path;

use serde_json::{Value, json};

use super::staged::{write_file, write_record};
use super::summary::{Provenance, input};
use crate::error::Result;
use crate::network::Network;
use crate::phenotype::{Artery, FENESTRATED, RING, Side, Variant};

/// A classification and everything its files are made of.
#[derive(Debug)]
pub struct Classified<'a> {
    /// The vessels.
    pub network: &'a Network,
    /// How many of them counted.
    pub counted: usize,
    /// What they make.
    pub variant: &'a Variant,
    /// What the arteries were known by: `names`, `icafe`, `topcow` or `landmarks`.
    pub known_by: &'a str,
    /// Path and SHA-256 of the landmarks, where they were given.
    pub landmarks: Option<(&'a str, &'a str)>,
    /// What a person should know about where the arteries are.
    pub notes: &'a [String],
}

/// The phenotype as CoW_Centerline_Extraction writes it (`anterior`, `posterior`, `fetal`, `fenestration`), and beside it the same
/// by name, in words and by segment.
pub fn phenotype_json(variant: &Variant) -> Value {
    let has = |artery| variant.has(artery);
    let [left, right] = Side::BOTH;
    let mut segments = serde_json::Map::new();
    for (artery, present) in rows(variant) {
        segments.insert(artery.to_string(), json!(present));
    }
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

/// The segments of the ring and the arteries that feed it, with whether they are there.
fn rows(variant: &Variant) -> impl Iterator<Item = (Artery, bool)> {
    let feeders =
        [(Artery::Ica(Side::Left), variant.ica[0]), (Artery::Ica(Side::Right), variant.ica[1]), (Artery::Ba, variant.ba)];
    RING.into_iter().zip(variant.present).chain(feeders)
}

/// The names of the columns of phenotype.csv.
pub fn phenotype_columns() -> Vec<String> {
    let mut columns = ["subject", "variant", "completeness"].map(str::to_owned).to_vec();
    columns.extend(rows(&Variant::COMPLETE).map(|(artery, _)| artery.to_string()));
    columns.extend(["fetal_L-PCA", "fetal_R-PCA", "third_A2"].map(str::to_owned));
    columns.extend(FENESTRATED.map(|artery| format!("fenestrated_{artery}")));
    columns
}

/// The row of a subject in phenotype.csv, in the order of [`phenotype_columns`].
pub fn phenotype_row(subject: &str, variant: &Variant) -> Vec<String> {
    let mut row = vec![subject.to_owned(), variant.name(), variant.completeness().name().to_owned()];
    let flags = rows(variant).map(|(_, present)| present).chain(variant.fetal).chain([variant.third_a2]);
    row.extend(flags.chain(variant.fenestration).map(|flag| u8::from(flag).to_string()));
    row
}

/// The record of a classification.
pub fn classification_record(classified: &Classified<'_>, provenance: &Provenance) -> Value {
    json!({
        "willis": env!("CARGO_PKG_VERSION"),
        "command": provenance.command,
        "input": input(provenance),
        "parameters": { "arteries": classified.known_by },
        "landmarks": classified.landmarks.map(|(path, sha256)| json!({ "path": path, "sha256": sha256 })),
        "counts": {
            "nodes": classified.network.node_count(),
            "vessels": classified.network.vessel_count(),
            "counted": classified.counted,
        },
        "phenotype": phenotype_json(classified.variant),
        "notes": provenance.notes.iter().chain(classified.notes).collect::<Vec<_>>(),
    })
}

/// Writes phenotype.json, phenotype.csv and run.json into a folder.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_classified(folder: &Path, subject: &str, variant: &Variant, record: &Value) -> Result<()> {
    write_file(&folder.join("phenotype.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, &phenotype_json(variant))?;
        std::io::Write::write_all(out, b"\n")
    })?;
    write_file(&folder.join("phenotype.csv"), |out| {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(phenotype_columns())?;
        csv.write_record(phenotype_row(subject, variant))?;
        csv.flush()
    })?;
    write_record(folder, record)
}
