//! A case: an extraction whose right links are known.

use sha2::{Digest, Sha256};

use super::figures::found;
use super::known_links::{KnownLinks, Right};
use crate::candidates::features::Extraction;
use crate::candidates::model::feature_table::Rows;
use crate::candidates::search::{Search, search};
use crate::error::Result;
use crate::network::Network;

/// An extraction with its answer.
#[derive(Debug, Clone)]
pub struct Case {
    /// The data set it belongs to, for figures.
    pub data_set: String,
    /// The folder within the data set, for figures; empty without one.
    pub group: String,
    /// Whom it shows. No subject is on both sides of a fold.
    pub subject: String,
    /// Its name within the data set.
    pub name: String,
    /// What the image showed.
    pub network: Network,
    /// The nodes where blood is known to enter.
    pub inlets: Vec<usize>,
    /// The right links, by the points of [`Extraction`].
    pub answer: KnownLinks,
}

/// A case with its bridges measured.
pub struct Example<'a> {
    /// The case.
    pub case: &'a Case,
    /// Its extraction, with or without inlets.
    pub extraction: Extraction,
    /// Its bridges.
    pub rows: Rows,
    /// Per bridge whether its child may hang by it.
    pub allowed: Vec<bool>,
    /// Per link of [`Rows`] what it makes, if it is right.
    pub right: Vec<Option<Right>>,
}

impl<'a> Example<'a> {
    /// Searches and measures the bridges of a case, with its inlets or as if nobody had named any.
    ///
    /// # Errors
    ///
    /// A node without a position.
    pub fn new(case: &'a Case, with_inlets: bool) -> Result<Self> {
        let extraction = Extraction::new(&case.network, if with_inlets { &case.inlets } else { &[] })?;
        let rows = Rows::new(&extraction, &search(&extraction, &Search::default())?);
        let points = |bridge: usize| [extraction.ends[rows.bridges[bridge].end].point, rows.bridges[bridge].point];
        let bridges: Vec<_> = (0..rows.bridges.len()).map(|bridge| (points(bridge), rows.fragments[bridge])).collect();
        let allowed = case.answer.allowed(&bridges);
        let mut right = vec![None; rows.links];
        for (bridge, ([from, to], _)) in bridges.iter().enumerate() {
            right[rows.link[bridge]] = case.answer.right(*from, *to).or(right[rows.link[bridge]]);
        }
        Ok(Self { case, extraction, rows, allowed, right })
    }

    /// How many of the bridges that the answer needs are among those found.
    pub fn reached(&self) -> usize {
        found(self.right.iter().flatten().copied())
    }
}

/// A number in [0, 1) that looks random, the same for the same words on every machine.
pub fn share_of(words: &[&str]) -> f64 {
    let digest = Sha256::digest(words.join("\u{0}").as_bytes());
    digest.iter().take(6).rev().fold(0.0, |x, byte| (x + f64::from(*byte)) / 256.0)
}
