//! The conditions of a simulation put into a network for a solver in time: pulse, Windkessels, walls, and blood.

use std::f64::consts::PI;

use super::pulse::{Waves, fluid, law};
use super::simulate::Solved;
use super::{FlowOptions, Follow, Input};
use willis_core::error::Result;
use willis_core::flow::{Thickness, Tube, Unfed, WallLaw};
use willis_core::network::{Network, Wall, Windkessel};
use willis_core::simulation::pulse::{terminals, walled};
use willis_io::formats::SolverSetting;

/// The network of an input with the conditions that [`simulate`](crate::simulate) would give it, for a solver in time: at its ends the Windkessels,
/// in its vessels the walls, and beside it the courses of inlets and the blood. Vessels that no blood enters stay.
///
/// # Errors
///
/// As [`simulate`](crate::simulate) of the same options.
pub fn solver_model(input: &Input, options: &FlowOptions, progress: &mut dyn Follow) -> Result<(Network, SolverSetting)> {
    options.validate()?;
    let Solved { network, mut boundary, .. } = Solved::of(input, &options.boundary, Unfed::Keep, progress)?;
    let mut setting = SolverSetting { viscosity: options.viscosity, ..SolverSetting::default() };
    let mut windkessels = options.boundary.windkessels(&network)?;
    let mut walls: Vec<Option<Wall>> = network.vessels().map(|(_, vessel)| vessel.wall).collect();
    if let Some(pulse) = &options.pulse {
        let waves = Waves::load(&network, &boundary, pulse, progress)?;
        boundary = waves.steady(&boundary)?;
        let steady = willis_core::simulation::simulate(&network, &boundary, options.viscosity, &[])?.unperturbed;
        (setting.period, setting.courses, setting.density) = (waves.period, waves.courses(&network, &steady), pulse.density);
        let (fluid, law) = (fluid(pulse, options.viscosity), law(pulse, &network));
        let vessels = walled(&network, &Tube::at_rest(&network, options.viscosity), &[], &law, &fluid)?;
        for (node, found) in
            terminals(&network, &boundary, &windkessels, &vessels, &fluid, pulse.time_constant).into_iter().enumerate()
        {
            if let Some(found) = found.filter(|found| found.compliance > 0.0) {
                windkessels[node] = Windkessel { proximal: Some(found.proximal), compliance: Some(found.compliance) };
            }
        }
        for (row, (_, vessel)) in network.vessels().enumerate() {
            let radius = vessel.radius;
            let compliance = law.compliance(radius, vessel.wall, pulse.density, &network.vessel_name(row))?;
            walls[row] = match law {
                WallLaw::Stated => vessel.wall,
                WallLaw::Elastic { young, thickness: Thickness::Length(thickness) } => Some(Wall::Elastic { young, thickness }),
                WallLaw::Elastic { young, thickness: Thickness::OfRadius(share) } => {
                    Some(Wall::Elastic { young, thickness: share * radius })
                }
                // The speed that gives this compliance.
                _ => Some(Wall::Speed((PI * radius * radius / (pulse.density * compliance)).sqrt())),
            };
        }
    }
    let mut model = boundary.stated_in(network.into_owned());
    (0..model.node_count()).for_each(|node| model.node_mut(node).windkessel = windkessels[node].stated());
    (0..model.vessel_count()).for_each(|row| model.vessel_mut(row).wall = walls[row]);
    Ok((model, setting))
}
