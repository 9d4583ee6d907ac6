//! How crowded vessels are: contacts and handles per length. Where they are more than a model was calibrated on, its probabilities may be off.

use serde::{Deserialize, Serialize};

use super::branches::Branches;
use willis_core::network::{Network, Origin, Vessel, fragments};
use willis_core::support::statistics::median;

/// Figures are per so many radii of length.
const RADII: f64 = 1e3;
/// More than so many times the most of the calibration is told: subjects differ.
const TOLD: f64 = 1.5;

/// Contacts and handles per 1,000 radii of the length of observed vessels, the radius being the median of branches.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crowding {
    /// Contacts, kept or cut.
    pub contacts: f64,
    /// Independent cycles of the observed vessels before anything is cut.
    pub handles: f64,
}

impl Crowding {
    /// That of a network in which so many contacts were found; zeros without a branch.
    pub fn new(network: &Network, branches: &Branches, contacts: usize) -> Self {
        let is_observed = |vessel: &Vessel| vessel.origin == Origin::Observed;
        let lengths: Vec<f64> = network.vessels().filter(|(_, v)| is_observed(v)).map(|(_, vessel)| vessel.length).collect();
        let handles = lengths.len() + fragments(network, |_, v| is_observed(v)).count - network.node_count();
        let length: f64 = lengths.iter().sum();
        let radius = median(&branches.branches.iter().map(|branch| branch.radius).collect::<Vec<f64>>());
        let per = |count: usize| radius.filter(|_| length > 0.0).map_or(0.0, |radius| count as f64 * RADII * radius / length);
        Self { contacts: per(contacts), handles: per(handles) }
    }

    /// The larger of both figures of two cases.
    #[must_use]
    pub fn most(self, other: Self) -> Self {
        Self { contacts: self.contacts.max(other.contacts), handles: self.handles.max(other.handles) }
    }

    /// What to tell a person of vessels more crowded than the `most` crowded that a model was calibrated on; `None` where they are not.
    pub fn unlike(self, most: Self) -> Option<String> {
        let figures = [("contacts", self.contacts, most.contacts), ("handles", self.handles, most.handles)];
        let beyond: Vec<String> = figures
            .into_iter()
            .filter(|(_, here, most)| *here > TOLD * most)
            .map(|(name, here, most)| format!("{here:.1} {name} (at most {most:.1})"))
            .collect();
        (!beyond.is_empty()).then(|| {
            format!(
                "the vessels are unlike those that P of contacts was calibrated on: {} per 1,000 radii of length; read P as a rank, not as a share",
                beyond.join(" and ")
            )
        })
    }
}
