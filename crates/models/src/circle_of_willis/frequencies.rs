//! How frequent the variants of the circle are: a published table, or one of a study, as a prior for what is not seen.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::arteries::{Artery, RING};
use super::labels::{LabelScheme, artery_of_label};
use willis_core::error::{Fault, Result};
use willis_io::formats::tables::reader::TableReader;

/// The table that ships. Its frame is that of 1,864 people of the Tromsø study (Hindenes et al., PLoS ONE 15(11):e0241373, 2020, doi
/// 10.1371/journal.pone.0241373; 3 T time-of-flight, segments below 1 mm count as missing): the complete circle in 11.9 %, only both PComm
/// missing in 27.8 %. The abstract gives no share for each of the other 45 variants; how the rest is dealt out here (PComm most often, then
/// AComm, P1 with the PComm of the other side, A1) is an assumption, which a table of one's own replaces.
const PUBLISHED: &str = include_str!("frequencies.csv");
/// The share of all variants that a table does not name, spread over them evenly.
const UNNAMED: f64 = 0.02;

/// How frequent each variant is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariantFrequencies {
    /// The share of each of the 128 variants; bit s of the index says that segment s of [`RING`] is there.
    pub share: Vec<f64>,
}

impl VariantFrequencies {
    /// The table that ships.
    ///
    /// # Errors
    ///
    /// None in a released version: a test reads it.
    pub fn published() -> Result<Self> {
        Self::read(PUBLISHED.as_bytes()).map_err(|fault| fault.in_file(Path::new("frequencies.csv")))
    }

    /// Reads a table of `missing,share`: the missing segments (`L-A1, R-PComm`, or `complete`), and how many in 1 (or per cent, or a count) have the
    /// variant.
    ///
    /// # Errors
    ///
    /// A missing column, a segment that is none of the ring, a share that is no number from 0 on, or none above 0.
    pub fn read(bytes: &[u8]) -> Result<Self, Fault> {
        let mut rows = TableReader::ragged(bytes)?;
        let line = rows.header_line;
        let column = |name: &str| {
            rows.find(&[name]).ok_or_else(|| Fault::line(line, format!("no column {name}"), "expected missing,share"))
        };
        let (missing, share) = (column("missing")?, column("share")?);
        let mut table = vec![0.0; 1 << RING.len()];
        while let Some(row) = rows.row()? {
            let (text, value) = (row.text(missing).to_owned(), row.real(share)?);
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Fault::line(row.line, format!("share {value}"), "expected a number from 0 on"));
            }
            let index =
                index_of(&text).map_err(|part| Fault::line(row.line, format!("missing \"{part}\""), segments_accepted()))?;
            table[index] += value;
        }
        let total: f64 = table.iter().sum();
        if total <= 0.0 {
            return Err(Fault::line(line, "no variant with a share", "expected missing,share with a share above 0"));
        }
        let unnamed = table.iter().filter(|share| **share == 0.0).count().max(1) as f64;
        let spread = if table.contains(&0.0) { UNNAMED } else { 0.0 };
        for share in &mut table {
            *share = if *share > 0.0 { (1.0 - spread) * *share / total } else { spread / unnamed };
        }
        Ok(Self { share: table })
    }

    /// As [`VariantFrequencies::read`], from a file.
    ///
    /// # Errors
    ///
    /// As there, or a file that cannot be read.
    pub fn of_file(path: &Path) -> Result<Self> {
        let bytes = willis_io::formats::bytes_of(path)?;
        Self::read(&bytes).map_err(|fault| fault.in_file(path))
    }

    /// The share of people who have each segment.
    pub fn marginals(&self) -> [f64; 7] {
        std::array::from_fn(|s| self.share.iter().enumerate().filter(|(v, _)| v >> s & 1 == 1).map(|(_, p)| p).sum())
    }

    /// The probability of each segment that is not `decidable`, given the probabilities of the others; these stay.
    pub fn given(&self, presence: &[f64; 7], decidable: &[bool; 7]) -> [f64; 7] {
        let marginals = self.marginals();
        let weight = |variant: usize| -> f64 {
            let fits = (0..7).filter(|s| decidable[*s]).map(|s| {
                // What is seen, over what the table alone says of it.
                let (p, usual) = (presence[s], marginals[s]);
                if variant >> s & 1 == 1 { p / usual } else { (1.0 - p) / (1.0 - usual) }
            });
            self.share[variant] * fits.product::<f64>()
        };
        let weights: Vec<f64> = (0..self.share.len()).map(weight).collect();
        let total: f64 = weights.iter().sum();
        std::array::from_fn(|s| {
            if decidable[s] || total <= 0.0 {
                return if decidable[s] { presence[s] } else { marginals[s] };
            }
            weights.iter().enumerate().filter(|(v, _)| v >> s & 1 == 1).map(|(_, w)| w).sum::<f64>() / total
        })
    }
}

/// Which segments of [`RING`] are there where those of a text are missing (`L-A1, R-PComm`, or `complete`).
///
/// # Errors
///
/// The accepted form.
pub fn present_segments(missing: &str) -> Result<[bool; 7], String> {
    let index = index_of(missing).map_err(|_| segments_accepted())?;
    Ok(std::array::from_fn(|s| index >> s & 1 == 1))
}

fn segments_accepted() -> String {
    let ring: Vec<String> = RING.iter().map(ToString::to_string).collect();
    format!("expected complete, or segments of {}", ring.join(", "))
}

/// The index of the variant that misses the segments of a text; the part that is no segment otherwise.
fn index_of(text: &str) -> Result<usize, String> {
    let all = (1 << RING.len()) - 1;
    if text.trim() == "complete" {
        return Ok(all);
    }
    let mut index = all;
    for part in text.split([',', ';']).map(str::trim) {
        let artery: Option<Artery> = artery_of_label(part, LabelScheme::Names);
        let segment = RING.iter().position(|ring| Some(*ring) == artery).ok_or_else(|| part.to_owned())?;
        index &= !(1 << segment);
    }
    Ok(index)
}
