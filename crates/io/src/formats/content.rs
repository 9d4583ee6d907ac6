//! What a file holds, and the network that it becomes.

use crate::formats::tables::reader::{counted, is_missing};
use willis_core::error::Fault;
use willis_core::network::{Centerlines, Network, RadiusRule, WELD_TOLERANCE, contract, millimetres};

/// The content of a file.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a file has one")]
pub enum Content {
    /// Points and links, to be contracted.
    Centerlines(Centerlines),
    /// Observed vessels, ready as they are; a missing radius, where radii are optional, is NaN.
    Vessels(Network),
    /// A graph whose edges are vessels, ready as they are; a missing radius, where radii are optional, is NaN.
    Graph(Network),
}

/// A network made of a file's content.
#[derive(Debug, Clone)]
pub struct BuiltNetwork {
    /// The network.
    pub network: Network,
    /// The centerlines that it was made of, with coincident points merged.
    pub lines: Option<Centerlines>,
    /// Notes for the user about how it was made, one line each.
    pub notes: Vec<String>,
}

/// A label as its author meant it: a missing one is none, and a class that went through real numbers (`3.0`, as pandas writes it) is
/// whole.
fn label(text: &str) -> String {
    let whole = text.parse::<f64>().ok().filter(|x| text.contains('.') && x.fract() == 0.0);
    if is_missing(text) { String::new() } else { whole.map_or_else(|| text.to_owned(), |x| x.to_string()) }
}

impl Content {
    /// Makes the labels, of whichever format, what they mean.
    pub(super) fn settle_labels(&mut self) {
        match self {
            Self::Centerlines(lines) => lines.labels.rename(label),
            Self::Vessels(network) | Self::Graph(network) => {
                (0..network.vessel_count()).for_each(|row| network.vessel_mut(row).label = label(&network.vessel(row).label));
                (0..network.node_count()).for_each(|row| network.node_mut(row).label = label(&network.node(row).label));
            }
        }
    }

    /// Makes a network of centerlines, or of ready vessels; `default_radius` (m) is for vessels without any radius.
    ///
    /// # Errors
    ///
    /// No vessel, one without length, or one without a radius where no default is given.
    pub fn into_network(self, rule: RadiusRule, default_radius: Option<f64>) -> Result<BuiltNetwork, Fault> {
        let mut notes = Vec::new();
        let mut note = |count: usize, noun: &str, what: &str| notes.extend(counted(count, noun, what));
        let taken = default_radius.map_or(String::new(), |r| millimetres(r).to_string());
        let defaulted = format!("without any radius: took `default_radius`, {taken} mm");
        let (mut network, lines) = match self {
            Self::Centerlines(mut lines) => {
                note(lines.weld(WELD_TOLERANCE), "point", "coinciding with another: merged with it");
                let made = contract(&lines, rule, default_radius)?;
                note(made.repaired_radii, "point", "without a positive finite radius: interpolated along the vessel");
                note(made.mixed_labels, "vessel", "with more than one label along them: took that of the longest part");
                note(made.default_radii, "vessel", &defaulted);
                (made.network, Some(lines))
            }
            Self::Vessels(mut network) | Self::Graph(mut network) => {
                let without: Vec<usize> = (0..network.vessel_count()).filter(|v| network.vessel(*v).radius.is_nan()).collect();
                for row in &without {
                    let accepted = "expected a positive radius, or `default_radius`";
                    let lacking = || Fault::item(format!("vessel {row}"), "no valid radius", accepted);
                    network.vessel_mut(*row).radius = default_radius.ok_or_else(lacking)?;
                }
                note(without.len(), "vessel", &defaulted);
                (network, None)
            }
        };
        if network.vessel_count() == 0 {
            return Err(Fault::file("no vessel", "expected centerlines with at least two linked points, or edges"));
        }
        network.shrink_to_fit();
        Ok(BuiltNetwork { network, lines, notes })
    }
}
