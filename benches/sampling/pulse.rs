//! Times the pulse of a network: all harmonics of one cycle on one thread, and on all threads.

use std::time::Instant;

use num_complex::Complex64;
use willis::internals::flow::{Tube, WallLaw};
use willis::internals::network::waveform::Quantity;
use willis::internals::network::{Condition, Network, Windkessel};
use willis::internals::simulation::pulse::womersley::Fluid;
use willis::internals::simulation::pulse::{Drive, Friction, Pulse, Setting, terminals, walled};

use crate::Result;
use crate::case::Case;

/// Solves are repeated for so long, s; the least time counts.
const BUDGET: f64 = 2.0;

/// Prints vessels, harmonics, and milliseconds a cycle on one thread and on all: Olufsen's walls, outlets with RC = 0.69 s, a pressure at
/// every inlet.
pub fn print(case: &Case, harmonics: usize) -> Result<()> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (network, single) = (&case.network, one.install(|| milliseconds(case, harmonics).map_err(|why| why.to_string())));
    println!("{} {harmonics} {:.4} {:.4}", network.vessel_count(), single?, milliseconds(case, harmonics)?);
    Ok(())
}

fn milliseconds(case: &Case, harmonics: usize) -> Result<f64> {
    let (network, boundary): (&Network, _) = (&case.network, &case.boundary);
    let fluid = Fluid { viscosity: 3.5e-3, density: 1060.0, friction: Friction::Womersley, wall_viscosity: 0.0 };
    let steady = willis::internals::simulation::simulate(network, boundary, fluid.viscosity, &[])?;
    let vessels = walled(network, &Tube::at_rest(network, fluid.viscosity), &[], &WallLaw::OLUFSEN, &fluid)?;
    let stated = vec![Windkessel::default(); network.node_count()];
    let terminals = terminals(network, boundary, &stated, &vessels, &fluid, Some(0.69));
    let wave = |mean: f64| (0..=harmonics).map(|n| Complex64::new(mean / (1 + n) as f64, 0.0)).collect();
    let inlets = boundary.conditions.iter().filter_map(|(node, condition)| match condition {
        Condition::Pressure(p) if *p > 0.0 => Some(Drive { node: *node, quantity: Quantity::Pressure, coefficients: wave(*p) }),
        _ => None,
    });
    let drives: Vec<Drive> = inlets.collect();
    let setting = Setting { fluid: &fluid, period: 1.0, harmonics, vessels: &vessels, drives: &drives, terminals: &terminals };
    let (begun, mut least) = (Instant::now(), f64::INFINITY);
    while begun.elapsed().as_secs_f64() < BUDGET {
        let start = Instant::now();
        std::hint::black_box(Pulse::of(network, boundary, &steady.unperturbed, &setting)?);
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(1e3 * least)
}
