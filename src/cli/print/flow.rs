//! Prints what came out of `willis simulate`: resilience, inflow, and what a perturbation did to them.

use super::{TextTerminal, brief, count, listed, plural};
use crate::internals::network::units::{millimetres, milliseconds, ml_per_min};
use crate::internals::simulation::{FlowChange, Perturbation, gains, reversals};
use crate::{
    Change, Network, SimulationRun, Stenosis, internals::flow::state::LAMINAR_LIMIT, internals::flow::state::State,
    internals::network::Condition, internals::report::MOST_COLLATERALS, internals::report::end_name,
    internals::report::page::lead::change, internals::simulation::ClosedVessel, internals::simulation::pulse::Pulse,
    internals::simulation::pulse::fourier::Indices, internals::simulation::transport::Transport,
    internals::support::ties::largest_first,
};

/// The least share of an outlet's blood that is named.
const LEAST_SHARE: f64 = 0.005;
/// Vessels named in a warning.
const NAMED: usize = 6;

/// The flow as it is, and what the perturbations change.
pub fn say_simulated(terminal: TextTerminal, simulated: &SimulationRun<'_>) {
    let (network, before) = (&*simulated.network, &simulated.result.unperturbed);
    terminal.say("resilience", format!("rho_G {} W/m³", brief(before.network_resilience)));
    let diffused = format!("{} of {} diffused", count(before.diffused() as u64), plural(network.vessel_count(), "vessel"));
    terminal.say("inflow", format!("{} mL/min in all, {diffused}", brief(ml_per_min(before.inflow))));
    let transport = simulated.transports.as_ref().map(|found| &found.unperturbed);
    let pulse = simulated.pulses.as_ref().map(|(found, _)| &found.both.unperturbed);
    say_state(terminal, simulated, (before, transport, pulse), "");
    if let Some(closures) = &simulated.closures {
        // In single precision, so that rounding does not choose between equal vessels; of these the first.
        let costs = |(_, closure): &(usize, &ClosedVessel)| closure.lost_share as f32;
        let most = closures.iter().enumerate().rev().max_by(|a, b| costs(a).total_cmp(&costs(b)));
        if let Some((row, closure)) = most {
            let (name, lost) = (network.vessel_name(row), 100.0 * closure.lost_share);
            terminal
                .say("occluded", format!("each vessel in turn; most is lost without {name}: {lost:.1} % of the outlets' flow"));
        }
    }
    let Some(after) = &simulated.result.perturbed else { return };

    for one in &simulated.perturbations {
        terminal.say("perturbed", words(network, &simulated.perturbations, one));
    }
    let (b, a) = (before.network_resilience, after.network_resilience);
    terminal.say("resilience", format!("rho_G {} -> {} W/m³{}", brief(b), brief(a), relative(b, a)));
    let (b, a) = (ml_per_min(before.inflow), ml_per_min(after.inflow));
    let diffused = format!("{} -> {} diffused", count(before.diffused() as u64), plural(after.diffused(), "vessel"));
    terminal.say("inflow", format!("{} -> {} mL/min in all{}, {diffused}", brief(b), brief(a), relative(b, a)));
    let transport = simulated.transports.as_ref().and_then(|found| found.perturbed.as_ref());
    let pulse = simulated.pulses.as_ref().and_then(|(found, _)| found.both.perturbed.as_ref());
    say_state(terminal, simulated, (after, transport, pulse), " after the perturbation");
    let floating = |state: &State| state.pressure.iter().filter(|p| p.is_none()).count();
    let lost = floating(after).saturating_sub(floating(before));
    if lost > 0 {
        terminal.say("cut off", format!("{}, joined to no pressure any more", plural(lost, "node")));
    }
    let gained = gains(before, after, &simulated.perturbations);
    say_changes(terminal, network, "collateral", "more flow in", &gained);
    let turned = reversals(before, after, &simulated.perturbations);
    say_changes(terminal, network, "reversed", "flow turned round in", &turned);
}

/// What is worth knowing of one state, beside its resilience and inflow.
fn say_state(
    terminal: TextTerminal,
    simulated: &SimulationRun<'_>,
    (state, transport, pulse): (&State, Option<&Transport>, Option<&Pulse>),
    when: &str,
) {
    let network = &simulated.network;
    let vessels = listed(state.beyond_laminar().map(|(row, re)| format!("{} ({re:.0})", name(network, row))), NAMED);
    if !vessels.is_empty() {
        let above = format!("above {}{when} in {vessels}", count(LAMINAR_LIMIT as u64));
        terminal.say("warning", format!("Reynolds number {above}: Poiseuille's law no longer holds there"));
    }
    // Fixed flows into a part that nothing joins to a pressure.
    for (node, condition) in &simulated.boundary.conditions {
        if matches!(condition, Condition::Flow(_)) && state.pressure[*node].is_none() {
            let id = &simulated.network.node(*node).id;
            terminal.say("warning", format!("the fixed flow at {id} has no way on{when}; it is taken as 0"));
        }
    }
    if let Some(transport) = transport {
        say_transport(terminal, &simulated.network, transport, when);
    }
    if let Some(pulse) = pulse {
        say_pulse(terminal, simulated, pulse, when);
    }
}

fn say_changes(terminal: TextTerminal, network: &Network, heading: &str, what: &str, changes: &[FlowChange]) {
    if changes.is_empty() {
        terminal.say(heading, format!("{what} no other vessel"));
        return;
    }
    let flows = |c: &FlowChange| {
        let [before, after] = [c.before, c.after].map(|q| brief(ml_per_min(q)));
        format!("{} ({before} -> {after} mL/min)", name(network, c.vessel))
    };
    terminal.say(heading, format!("{what} {}", listed(changes.iter().map(flows), MOST_COLLATERALS)));
    changes.iter().skip(MOST_COLLATERALS).for_each(|change| terminal.detail(heading, flows(change)));
}

/// The outlets of each inlet's territory, and when blood reaches them.
fn say_transport(terminal: TextTerminal, network: &Network, transport: &Transport, when: &str) {
    for (at, source) in transport.sources.iter().enumerate() {
        let fed = transport.exits.iter().filter_map(|(exit, _)| {
            let share = transport.nodes[*exit].as_ref()?.supply[at];
            (share >= LEAST_SHARE).then(|| (end_name(network, *exit), share))
        });
        let fed = largest_first(fed, |(_, share)| *share);
        let words = |(name, share): &(String, f64)| format!("{name} {:.0} %", 100.0 * share);
        let fed = if fed.is_empty() {
            format!("less than {} % of the blood of any outlet", 100.0 * LEAST_SHARE)
        } else {
            listed(fed.iter().map(words), NAMED)
        };
        terminal.say("feeds", format!("{}{when}: {fed}", end_name(network, *source)));
    }
    let arrivals = transport.exits.iter().filter_map(|(exit, _)| Some((*exit, transport.nodes[*exit].as_ref()?.mean)));
    let arrivals = largest_first(arrivals, |(_, mean)| -mean);
    if let (Some(first), Some(last)) = (arrivals.first(), arrivals.last()) {
        let words = |(exit, mean): &(usize, f64)| format!("{} ({:.0} ms)", end_name(network, *exit), milliseconds(*mean));
        terminal.say("arrival", format!("first at {}, last at {}{when}", words(first), words(last)));
    }
}

/// The pulsatility of the vessels of largest flow, and those in which blood turns round within the cycle.
fn say_pulse(terminal: TextTerminal, simulated: &SimulationRun<'_>, pulse: &Pulse, when: &str) {
    let network = &*simulated.network;
    let vessels = (0..pulse.vessels.len()).map(|row| (row, pulse.flow_indices(row)));
    let found = largest_first(vessels, |(_, of)| of.mean.abs());
    let defined = found.iter().filter(|(_, of)| of.pulsatility.is_finite());
    let words = |(row, of): &(usize, Indices)| format!("{} {:.2}", name(network, *row), of.pulsatility);
    let first: Vec<String> = defined.take(NAMED).map(words).collect();
    let period = (1e3 * pulse.period).round() / 1e3;
    let pulsates = match &first[..] {
        // Blood that flows to and fro has no pulsatility either.
        [] if found.iter().any(|(_, of)| of.max > of.min) => format!("the mean flow is 0{when}"),
        [] => format!("no blood flows{when}"),
        _ => format!("pulsatility{when} {}", first.join(", ")),
    };
    terminal.say("pulse", format!("period {period} s, {} harmonics; {pulsates}", pulse.harmonics));
    let turning = found.iter().filter(|(_, of)| of.reversed_share >= LEAST_SHARE);
    let back = largest_first(turning, |(_, of)| of.reversed_share);
    if !back.is_empty() {
        let words = |(row, of): &&(usize, Indices)| format!("{} ({:.0} %)", name(network, *row), 100.0 * of.reversed_share);
        let vessels = listed(back.iter().map(words), NAMED);
        terminal.say("turns", format!("flow turns round within the cycle{when} in {vessels}"));
    }
    if simulated.transports.is_some() {
        let ratio = |(row, of): &&(usize, Indices)| of.reversed / pulse.walls[*row].volume;
        let filled = found.iter().filter(|found| ratio(found) > 1.0);
        let filled = filled.map(|found| format!("{} ({:.1})", name(network, found.0), ratio(&found)));
        let which = filled.take(NAMED).collect::<Vec<_>>().join(", ");
        if !which.is_empty() {
            let why = "in a cycle more blood goes back than the vessel holds, so supply by the mean flow is less sure";
            terminal.say("note", format!("{which}: {why}"));
        }
    }
}

fn words(network: &Network, all: &[Perturbation], Perturbation { vessel, change }: &Perturbation) -> String {
    let what = match change {
        Change::Occlusion => "occluded".to_owned(),
        Change::Tortuosity(factor) => format!("lengthened to {factor} times its length"),
        Change::Stenosis(Stenosis { open_diameter, stretch, .. }) => {
            let mm = |length: f64| format!("{} mm", brief(millimetres(length)));
            let longer = |one: &Perturbation| if let Change::Tortuosity(factor) = one.change { factor } else { 1.0 };
            let length =
                all.iter().filter(|one| one.vessel == *vessel).map(longer).product::<f64>() * network.vessel(*vessel).length;
            let whole = || format!("all of its {} (@mid:10mm narrows a stretch)", mm(length));
            let over = format!(" over {}", stretch.map_or_else(whole, mm));
            format!("diameter narrowed by {} %{over}", brief(100.0 * (1.0 - open_diameter)))
        }
    };
    format!("{}: {what}", name(network, *vessel))
}

fn name(network: &Network, row: usize) -> String {
    let label = &network.vessel(row).label;
    if label.is_empty() { format!("edge {row}") } else { label.clone() }
}

/// The change as a share of what was before, with a minus sign that every terminal has.
fn relative(before: f64, after: f64) -> String {
    change(before, after).replace('\u{2212}', "-")
}
