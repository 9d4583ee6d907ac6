//! What was read becomes a network: centerlines are welded and contracted, vessels without a radius take the default.

use super::document::Content;
use super::number::counted;
use crate::centerline::{Centerlines, WELD_TOLERANCE};
use crate::error::Fault;
use crate::network::{Network, RadiusRule, contract};
use crate::units::millimetres;

/// A network made of a file's content.
#[derive(Debug, Clone)]
pub struct Made {
    /// The network.
    pub network: Network,
    /// The centerlines that it was made of, welded.
    pub lines: Option<Centerlines>,
    /// What a person should know about how it was made, one line each.
    pub notes: Vec<String>,
}

impl Content {
    /// Makes a network of centerlines, or of vessels as they stand; `default_radius` (m) is that of vessels without any.
    ///
    /// # Errors
    ///
    /// No vessel, one without length, or one without a radius where no default is given.
    pub fn into_network(self, rule: RadiusRule, default_radius: Option<f64>) -> Result<Made, Fault> {
        let mut notes = Vec::new();
        let mut note = |count: usize, noun: &str, what: &str| {
            if count > 0 {
                notes.push(format!("{} {what}", counted(count, noun)));
            }
        };
        let defaulted = format!(
            "without any radius: took --default-radius, {} mm",
            default_radius.map_or(String::new(), |r| millimetres(r).to_string())
        );
        let (network, lines) = match self {
            Self::Centerlines(mut lines) => {
                note(lines.weld(WELD_TOLERANCE), "point", "coinciding with another: made one with it");
                let made = contract(&lines, rule, default_radius)?;
                note(made.repaired_radii, "point", "without a positive finite radius: interpolated along the vessel");
                note(made.mixed_labels, "vessel", "with more than one label along them: took that of the longest part");
                note(made.default_radii, "vessel", &defaulted);
                (made.network, Some(lines))
            }
            Self::Vessels(mut network) | Self::Graph(mut network) => {
                let without: Vec<usize> = (0..network.vessel_count()).filter(|v| network.vessel(*v).radius.is_nan()).collect();
                match (default_radius, without.first()) {
                    (None, None) => {}
                    (None, Some(row)) => {
                        let accepted = "expected a positive radius, or --default-radius LENGTH";
                        return Err(Fault::item(format!("vessel {row}"), "no valid radius", accepted));
                    }
                    (Some(radius), _) => {
                        for row in &without {
                            network.vessel_mut(*row).radius = radius;
                        }
                        note(without.len(), "vessel", &defaulted);
                    }
                }
                (network, None)
            }
        };
        if network.vessel_count() == 0 {
            return Err(Fault::file("no vessel", "expected centerlines with at least two linked points, or edges"));
        }
        Ok(Made { network, lines, notes })
    }
}
