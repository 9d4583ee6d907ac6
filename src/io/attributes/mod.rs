//! What the attributes of a ready graph mean, whichever format carried them.

pub(crate) mod edge;
pub(crate) mod node;
pub(crate) mod records;

use std::fmt;

use super::tables::number::number;
use crate::error::Fault;
use crate::network::centerlines::is_radius;
use crate::network::units::{Scale, metres};
use crate::support::geometry::radius_of;
use records::Record;

/// What may hold a size where nothing has the name of a radius.
const SIZES: [&str; 5] = [AREA, "diameter", "r", "d", RESISTANCE];
/// A cross-section area.
const AREA: &str = "avgCrossSection";
/// Of an edge in the place of Poiseuille's law, of a node behind it.
const RESISTANCE: &str = "resistance_mmHg_s_per_mL";

/// Whether anything here asks for an attribute of this name, or names it in a message.
pub(crate) fn is_wanted(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let asked = [node::POSITIONS.as_flattened(), &node::ASKED, &edge::ASKED, &SIZES];
    lower.contains("radius") || lower.contains("length") || asked.iter().any(|names| names.contains(&name))
}

/// A node or edge, which knows what to call itself in a message.
struct Item<'a> {
    record: Record<'a>,
    name: Name<'a>,
}

/// A node by its id, or an edge by its row and the ids of its ends.
#[derive(Debug, Clone, Copy)]
enum Name<'a> {
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
    fn text(&self, key: &str) -> Option<&'a str> {
        self.record.text(key)
    }

    fn fault(&self, found: impl fmt::Display, accepted: impl Into<String>) -> Fault {
        Fault::line(self.record.line, format!("{}: {found}", self.name), accepted)
    }

    /// A fault of a length in mm that is not there; says what is there under like names.
    fn lacks(&self, name: &str, accepted: &str) -> Fault {
        let mut like = self.record.names();
        like.retain(|key| key.to_ascii_lowercase().contains(name));
        let like = if like.is_empty() { String::new() } else { format!(" but {}", like.join(", ")) };
        self.fault(format!("no {name}_mm{like}"), accepted)
    }

    /// A number, infinite or NaN ones included.
    fn real(&self, key: &str) -> Result<Option<f64>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        number(text).map(Some).map_err(|accepted| self.fault(format!("{key} \"{text}\""), accepted))
    }

    /// A finite number; NaN is a missing one, as graphs hold it where other nodes have the attribute.
    fn finite(&self, key: &str) -> Result<Option<f64>, Fault> {
        match self.real(key)? {
            Some(x) if x.is_infinite() => Err(self.fault(format!("{key} {x}"), "expected a finite number")),
            other => Ok(other.filter(|x| !x.is_nan())),
        }
    }

    /// A number from 0 to 1; NaN is a missing one.
    fn share(&self, key: &str) -> Result<Option<f64>, Fault> {
        match self.finite(key)? {
            Some(x) if !(0.0..=1.0).contains(&x) => Err(self.fault(format!("{key} {x}"), "expected a number from 0 to 1")),
            share => Ok(share),
        }
    }

    /// A number that is not negative; NaN is a missing one.
    fn odds(&self, key: &str) -> Result<Option<f64>, Fault> {
        match self.finite(key)? {
            Some(x) if x < 0.0 => Err(self.fault(format!("{key} {x}"), "expected odds, zero or more")),
            odds => Ok(odds),
        }
    }

    /// The length in millimetres (`length_mm`) or in the unit of the file (`length`): its key and value in m.
    fn length(&self, scale: &Scale) -> Result<Option<(&'static str, f64)>, Fault> {
        if let Some(mm) = self.real("length_mm")? {
            return Ok(Some(("length_mm", metres(mm))));
        }
        Ok(self.real("length")?.map(|x| ("length", scale.length(x))))
    }

    /// A radius under any of the names that programs give it: the name and its value in m.
    ///
    /// A cross-section area a gives sqrt(a/π) and comes before radii that are not willis's own.
    fn radius(&self, scale: &Scale) -> Result<Option<(&'static str, f64)>, Fault> {
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

    fn boolean(&self, key: &str) -> Result<Option<bool>, Fault> {
        let Some(text) = self.text(key) else { return Ok(None) };
        match text.to_ascii_lowercase().as_str() {
            "true" | "1" | "1.0" => Ok(Some(true)),
            "false" | "0" | "0.0" => Ok(Some(false)),
            _ => Err(self.fault(format!("{key} \"{text}\""), "expected true or false")),
        }
    }
}
