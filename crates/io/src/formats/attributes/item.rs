//! A node or edge of a file by its attributes: texts, numbers, lengths, with errors that name it.

use std::fmt;

use super::records::Record;
use crate::formats::tables::reader::number;
use willis_core::error::Fault;
use willis_core::network::{Scale, is_radius, metres};
use willis_core::support::geometry::radius_of;

/// A cross-section area.
pub(super) const AREA: &str = "avgCrossSection";
/// The resistance of an edge, in place of Poiseuille's law, or the terminal resistance of a node.
pub(super) const RESISTANCE: &str = "resistance_mmHg_s_per_mL";

/// A node or edge with its attributes and its name for messages.
pub(super) struct Item<'a> {
    pub(super) record: Record<'a>,
    pub(super) name: Name<'a>,
}

/// A node by its id, or an edge by its row and the ids of its ends.
#[derive(Debug, Clone, Copy)]
pub(super) enum Name<'a> {
    Node(&'a str),
    Edge(usize, [&'a str; 2]),
}

impl fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(id) => write!(f, "node {id}"),
            Self::Edge(row, [a, b]) => write!(f, "edge {row} ({a} - {b})"),
        }
    }
}

impl<'a> Item<'a> {
    pub(super) fn text(&self, key: &str) -> Option<&'a str> {
        self.record.text(key)
    }

    pub(super) fn fault(&self, found: impl fmt::Display, accepted: impl Into<String>) -> Fault {
        Fault::line(self.record.line, format!("{}: {found}", self.name), accepted)
    }

    /// The error that a length in mm is missing; it lists attributes with similar names.
    pub(super) fn lacks(&self, name: &str, accepted: &str) -> Fault {
        let mut like = self.record.names();
        like.retain(|key| key.to_ascii_lowercase().contains(name));
        let like = if like.is_empty() { String::new() } else { format!(" but {}", like.join(", ")) };
        self.fault(format!("no {name}_mm{like}"), accepted)
    }

    /// A finite number.
    pub(super) fn real(&self, key: &str) -> Result<Option<f64>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        match number(text).map_err(|accepted| self.fault(format!("{key} \"{text}\""), accepted))? {
            x if x.is_finite() => Ok(Some(x)),
            x => Err(self.fault(format!("{key} {x}"), "expected a finite number")),
        }
    }

    /// A finite number that is as it has to be, which `accepted` describes for the error.
    pub(super) fn checked(&self, key: &str, is_right: impl Fn(f64) -> bool, accepted: &str) -> Result<Option<f64>, Fault> {
        match self.real(key)? {
            Some(x) if !is_right(x) => Err(self.fault(format!("{key} {x}"), accepted)),
            right => Ok(right),
        }
    }

    /// A number above zero.
    pub(super) fn positive(&self, key: &str) -> Result<Option<f64>, Fault> {
        self.checked(key, |x| x > 0.0, "expected a positive number")
    }

    /// A number from 0 to 1.
    pub(super) fn share(&self, key: &str) -> Result<Option<f64>, Fault> {
        self.checked(key, |x| (0.0..=1.0).contains(&x), "expected a number from 0 to 1")
    }

    /// One of some words, with what it means.
    pub(super) fn word<T: Copy>(&self, key: &str, words: [(&str, T); 3]) -> Result<Option<T>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        let wrong = || {
            let [a, b, c] = words.map(|(word, _)| word);
            self.fault(format!("{key} \"{text}\""), format!("expected {a}, {b} or {c}"))
        };
        words.iter().find(|(word, _)| *word == text).map(|(_, meant)| Some(*meant)).ok_or_else(wrong)
    }

    /// The length in millimetres (`length_mm`) or in the unit of the file (`length`): its key and value in m.
    pub(super) fn length(&self, scale: &Scale) -> Result<Option<(&'static str, f64)>, Fault> {
        if let Some(mm) = self.real("length_mm")? {
            return Ok(Some(("length_mm", metres(mm))));
        }
        Ok(self.real("length")?.map(|x| ("length", scale.length(x))))
    }

    /// A radius under any of the names that programs give it: the name and its value in m.
    ///
    /// A cross-section area a gives sqrt(a/π) and comes before radii that are not willis's own.
    pub(super) fn radius(&self, scale: &Scale) -> Result<Option<(&'static str, f64)>, Fault> {
        if let Some(mm) = self.real("radius_mm")? {
            return Ok(Some(("radius_mm", metres(mm))));
        }
        if let Some(radius) = self.real("radius")? {
            return Ok(Some(("radius", scale.length(radius))));
        }
        if let Some(area) = self.real(AREA)?.filter(|area| is_radius(*area)) {
            return Ok(Some((AREA, scale.length(radius_of(area)))));
        }
        for (key, share) in [("radius_avg", 1.0), ("avgRadiusAvg", 1.0), ("diameter", 0.5)] {
            if let Some(size) = self.real(key)? {
                return Ok(Some((key, scale.length(share * size))));
            }
        }
        // Letters mean other things too; then they are no positive numbers.
        let letter = |key: &'static str, share: f64| {
            let size = self.text(key).and_then(|text| number(text).ok()).filter(|size| is_radius(*size))?;
            Some((key, scale.length(share * size)))
        };
        Ok(letter("r", 1.0).or_else(|| letter("d", 0.5)))
    }

    pub(super) fn boolean(&self, key: &str) -> Result<Option<bool>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        match text.to_ascii_lowercase().as_str() {
            "true" | "1" | "1.0" => Ok(Some(true)),
            "false" | "0" | "0.0" => Ok(Some(false)),
            _ => Err(self.fault(format!("{key} \"{text}\""), "expected true or false")),
        }
    }
}
