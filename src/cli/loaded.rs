//! An input that has been read: a network, and what is known of where it comes from.

use std::path::Path;

use willis::error::{Error, Result};
use willis::internals::circle_of_willis::split_where_labels_change;
use willis::internals::io::{Content, Document, Format, Made, read};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::millimetres;
use willis::internals::network::{Network, Origin, RadiusRule, fragments};
use willis::internals::report::Provenance;

use super::reading::ReadingArgs;
use super::terminal::{Terminal, brief, count, plural};

/// An input that has been read.
pub struct Loaded {
    pub network: Network,
    /// The centerlines that it was made of.
    lines: Option<Centerlines>,
    pub format: Format,
    pub provenance: Provenance,
    /// Whether candidates are to be built around its vessels.
    pub fragments: bool,
    pub radius_rule: RadiusRule,
}

impl Loaded {
    /// Reads an input and says what was found in it; `command` is the line that repeats the run.
    pub fn read(input: &Path, reading: &ReadingArgs, command: String, terminal: Terminal) -> Result<Self> {
        let (scale, default_radius, radius_rule) = (reading.scale()?, reading.default_radius()?, reading.radius_rule());
        let Document { format, content, mut notes, sha256 } = read(input, &reading.options(input)?)?;
        let kind = Kind::of(&content);
        reading.check_for(kind)?;
        if let Some([x, y, z]) = scale.spacing.filter(|[x, y, z]| x != y || y != z) {
            notes.push(format!("unequal spacing {x}, {y}, {z} mm: radii are scaled by the smallest"));
        }
        let made = content.into_network(radius_rule, default_radius).map_err(|fault| fault.in_file(input))?;
        let assumed = if reading.units.is_none() { " assumed" } else { "" };
        let heading = format!("{}, {}{assumed}", format.name(), scale.unit.symbol());
        terminal.say("read", format!("{}: {heading}: {}", input.display(), kind.size(&made)));
        notes.extend(made.notes);
        for note in &notes {
            terminal.say("note", note);
        }
        let (ready, observed) = (matches!(kind, Kind::Graph), reading.observed);
        let provenance = Provenance {
            command,
            input: input.display().to_string(),
            format: format.name().to_owned(),
            sha256,
            units: scale.unit.symbol().to_owned(),
            notes,
        };
        let network = if ready && observed { all_observed(made.network) } else { made.network };
        Ok(Self { network, lines: made.lines, format, provenance, fragments: !ready || observed, radius_rule })
    }

    /// Divides the vessels where their labels change along the centerlines.
    pub fn divide_by_labels(&mut self) {
        if let Some(lines) = &self.lines {
            self.network = split_where_labels_change(&self.network, lines, self.radius_rule);
        }
    }
}

/// What a file held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// So many points.
    Centerlines(usize),
    Vessels,
    Graph,
}

impl Kind {
    fn of(content: &Content) -> Self {
        match content {
            Content::Centerlines(lines) => Self::Centerlines(lines.points.len()),
            Content::Vessels(_) => Self::Vessels,
            Content::Graph(_) => Self::Graph,
        }
    }

    /// How large it is, in words.
    fn size(self, Made { network, .. }: &Made) -> String {
        let (nodes, vessels) = (plural(network.node_count(), "node"), plural(network.vessel_count(), "vessel"));
        let size = match self {
            Self::Centerlines(points) => {
                let parts = plural(fragments(network, |_, _| true).count, "fragment");
                format!("{parts}, {vessels}, {}", plural(points, "point"))
            }
            Self::Vessels => format!("{nodes}, {vessels}"),
            Self::Graph => {
                let observed = network.vessels().filter(|(_, v)| v.origin == Origin::Observed).count();
                let candidates = network.vessel_count() - observed;
                format!("{nodes}, {} observed and {} candidate vessels", count(observed as u64), count(candidates as u64))
            }
        };
        size + &radii(network)
    }
}

impl ReadingArgs {
    /// Refuses options that do not go with what the file holds.
    fn check_for(&self, kind: Kind) -> Result<()> {
        let is_lines = matches!(kind, Kind::Centerlines(_));
        if let Some(name) = self.radius_array.as_ref().filter(|_| !is_lines) {
            let why = "goes with centerlines; the vessels of this input state their radii";
            return Err(Error::parameter("--radius-array", name, why));
        }
        if self.observed && kind != Kind::Graph {
            return Err(Error::parameter("--observed", "", "goes with a candidate graph; these vessels are observed anyway"));
        }
        Ok(())
    }
}

/// The same network with every vessel observed.
fn all_observed(mut network: Network) -> Network {
    for row in 0..network.vessel_count() {
        network.vessel_mut(row).origin = Origin::Observed;
    }
    network
}

/// The range of the radii, after a comma.
fn radii(network: &Network) -> String {
    let radii = || network.vessels().map(|(_, v)| millimetres(v.radius));
    let [low, high] = [radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max)].map(brief);
    if network.vessel_count() == 0 {
        String::new()
    } else if low == high {
        format!(", radius {low} mm")
    } else {
        format!(", radius {low} - {high} mm")
    }
}
