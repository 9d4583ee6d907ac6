//! The output folder of a forward simulation.

use std::collections::BTreeMap;
use std::path::Path;

use super::flow_record::FlowRecord;
use super::flow_tables::{node_columns, vessel_columns};
use super::json::write_record;
use super::names::{EDGES, NODES, PAGE, TOPOLOGY};
use super::page::{Figure, simulation_page, write_page};
use super::plots::{VesselFlow, flow_bars};
use super::staged::write_file;
use crate::error::Result;
use crate::formats::{write_csv, write_vtp};
use crate::hemodynamics::Boundary;
use crate::network::Network;
use crate::simulation::{Perturbation, Simulation};
use crate::units::ml_per_min;

/// A simulation and everything its files are made of.
#[derive(Debug)]
pub struct Simulated<'a> {
    /// The vessels.
    pub network: &'a Network,
    /// Their boundary conditions.
    pub boundary: &'a Boundary,
    /// What was done to them.
    pub perturbations: &'a [Perturbation],
    /// The flow before and after.
    pub result: &'a Simulation,
    /// Blood viscosity, Pa s.
    pub viscosity: f64,
}

/// Writes every file of a simulation into a folder and returns what a person should know about files left out.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_simulated(folder: &Path, simulated: &Simulated<'_>, record: &FlowRecord, dpi: u32) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    let vessels = vessel_columns(simulated);
    write_file(&folder.join(EDGES), |out| write_csv(out, &vessels))?;
    let nodes = node_columns(simulated);
    write_file(&folder.join(NODES), |out| write_csv(out, &nodes))?;
    if simulated.network.has_positions() {
        write_file(&folder.join(format!("{TOPOLOGY}.vtp")), |out| write_vtp(out, simulated.network, &vessels))?;
    } else {
        notes.push("topology.vtp is left out: the nodes have no coordinates".to_owned());
    }
    let bars = flow_bars(&flows(simulated))?;
    bars.write(folder, dpi)?;
    let says = "The flow of every vessel, and beside it the flow in the perturbed network where there is one.";
    let figures = vec![Figure::new("Flow", says, &bars)?];
    write_record(folder, record)?;
    let page = simulation_page(simulated, record, vessels, nodes, figures);
    write_file(&folder.join(PAGE), |out| write_page(out, &page))?;
    Ok(notes)
}

/// The flow of every vessel under its label; its row is added where it has none, or others have the same.
fn flows(simulated: &Simulated<'_>) -> Vec<VesselFlow> {
    let mut carried = BTreeMap::new();
    for (_, vessel) in simulated.network.vessels() {
        *carried.entry(vessel.label.as_str()).or_insert(0_usize) += 1;
    }
    let result = simulated.result;
    let flow = |(row, (_, vessel)): (usize, (_, &crate::network::Vessel))| VesselFlow {
        name: match vessel.label.as_str() {
            "" => format!("edge {row}"),
            label if carried[label] > 1 => format!("{label} (edge {row})"),
            label => label.to_owned(),
        },
        unperturbed: ml_per_min(result.unperturbed.vessels[row].flow),
        perturbed: result.perturbed.as_ref().map(|state| ml_per_min(state.vessels[row].flow)),
    };
    simulated.network.vessels().enumerate().map(flow).collect()
}
