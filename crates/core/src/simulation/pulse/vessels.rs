//! The vessels as the pulse meets them: their lumen in stretches of one radius, cut in the middle, with and without perturbations.

use super::womersley::{Fluid, TubeSegment};
use crate::error::Result;
use crate::flow::{Tube, WallLaw};
use crate::network::Network;
use crate::perturbation::stenosis::StretchPlace;
use crate::simulation::{Change, Perturbation};
use crate::support::numbered::grouped;

/// A vessel with its wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Walled {
    /// From the first node to the middle, and from there to the second; empty where the vessel is closed.
    pub halves: [Vec<TubeSegment>; 2],
    /// The radius where it is narrowest, m.
    pub narrowest: f64,
    /// The volume of the lumen, m³.
    pub volume: f64,
}

impl Walled {
    /// Whether blood can pass.
    pub fn is_open(&self) -> bool {
        !self.halves[0].is_empty()
    }
}

/// The vessels of a network with all `changes`, whose figures at rest are `tubes`.
///
/// The law of the wall holds for a narrowed lumen as for any other of its radius. A stated resistance is spread over the length.
///
/// # Errors
///
/// A wall that [`WallLaw::compliance`] refuses.
pub fn walled(network: &Network, tubes: &[Tube], changes: &[Perturbation], law: &WallLaw, fluid: &Fluid) -> Result<Vec<Walled>> {
    let changes = grouped(network.vessel_count(), changes.iter().map(|p| (p.vessel, &p.change)));
    let vessel = |row: usize| {
        let (vessel, tube) = (network.vessel(row), &tubes[row]);
        let (narrowest, volume) = (tube.radius, tube.volume);
        if !tube.is_open() {
            return Ok(Walled { halves: Default::default(), narrowest, volume });
        }
        let stated = vessel.resistance.map(|r| r / vessel.length - TubeSegment::poiseuille(vessel.radius, fluid.viscosity));
        let segment = |length: f64, open: f64| {
            let radius = vessel.radius * open;
            let compliance = law.compliance(radius, vessel.wall, fluid.density, &network.vessel_name(row))?;
            Ok::<_, crate::error::Error>(TubeSegment { length, radius, compliance, excess: stated.unwrap_or(0.0) / open.powi(4) })
        };
        let longer = changes[row].iter().find_map(|c| if let Change::Tortuosity(factor) = c { Some(*factor) } else { None });
        let length = vessel.length * longer.unwrap_or(1.0);
        let stenosis = changes[row].iter().find_map(|c| if let Change::Stenosis(s) = c { Some(s) } else { None });
        let segments = match stenosis {
            None => vec![segment(length, 1.0)?],
            Some(stenosis) => {
                let stretch = stenosis.stretch.unwrap_or(length).min(length);
                let rest = length - stretch;
                let before = match stenosis.place {
                    StretchPlace::Start => 0.0,
                    StretchPlace::Middle => rest / 2.0,
                    StretchPlace::End => rest,
                };
                let all = [segment(before, 1.0)?, segment(stretch, stenosis.open_diameter)?, segment(rest - before, 1.0)?];
                all.into_iter().filter(|segment| segment.length > 0.0).collect()
            }
        };
        Ok(Walled { halves: halves(&segments, length / 2.0), narrowest, volume })
    };
    (0..network.vessel_count()).map(vessel).collect()
}

/// Segments, cut at a length from their beginning.
fn halves(segments: &[TubeSegment], at: f64) -> [Vec<TubeSegment>; 2] {
    let (mut first, mut last, mut left) = (Vec::new(), Vec::new(), at);
    for segment in segments {
        let here = segment.length.min(left);
        left -= here;
        for (part, length) in [(&mut first, here), (&mut last, segment.length - here)] {
            if length > 0.0 {
                part.push(TubeSegment { length, ..*segment });
            }
        }
    }
    [first, last]
}
