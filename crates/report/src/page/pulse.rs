//! The pulse on the page: the flow of every vessel at even times of the cycle, by which a slider colours the vessels.

use super::content::{ColourScale, Colouring, PageTable};
use crate::simulation::SimulationRun;
use crate::simulation::pulse::flows_by_time;
use willis_core::network::units::milliseconds;
use willis_core::simulation::pulse::Pulses;
use willis_io::formats::Column;

/// At how many times of the cycle the slider stops, and up to how many figures in all the page holds.
const STOPS: usize = 40;
const MOST_FIGURES: usize = 400_000;

/// The name of the figure by which the page knows that its variants are times.
pub const OVER_THE_CYCLE: &str = "flow over the cycle";

/// The table of flows by time, and the colouring that it gives, where the table is number `at`; none of a large network.
pub fn cycle(simulated: &SimulationRun<'_>, pulses: &Pulses, at: usize) -> Option<(PageTable, Colouring)> {
    let network = &*simulated.network;
    if network.vessel_count() * STOPS > MOST_FIGURES {
        return None;
    }
    let shown = pulses.perturbed.as_ref().unwrap_or(&pulses.unperturbed);
    let mut columns = vec![
        Column::whole("edge", 0..network.vessel_count()),
        Column::text("label", network.vessels().map(|(_, vessel)| vessel.label.clone())),
    ];
    let name = |stop: usize| format!("{:.0} ms", milliseconds(shown.period * stop as f64 / STOPS as f64));
    for (stop, flows) in flows_by_time(shown, STOPS).into_iter().enumerate() {
        columns.push(Column::real(name(stop), flows.into_iter()));
    }
    let title = if pulses.perturbed.is_some() { "Flow over the cycle, perturbed" } else { "Flow over the cycle" };
    let variants = (0..STOPS).map(|stop| (name(stop), at, name(stop))).collect();
    let colouring = Colouring::new(OVER_THE_CYCLE, "mL/min", ColourScale::Linear, variants);
    Some((PageTable::new(title, columns, true), colouring))
}
