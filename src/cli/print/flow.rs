//! Prints what came out of `willis simulate`: resilience, inflow, and what a perturbation did to them.

use crate::internals::flow::state::{LAMINAR_LIMIT, State};
use crate::internals::network::Condition;
use crate::internals::network::units::{millimetres, ml_per_min};
use crate::internals::report::{MOST_COLLATERALS, Simulated};
use crate::internals::simulation::{FlowChange, Perturbation, gains, reversals};
use crate::{Change, Network, Stenosis};

use super::{Terminal, brief, count, plural};

/// Vessels named in a warning.
const NAMED: usize = 6;

/// The flow as it is, and what the perturbations change.
pub fn say_simulated(terminal: Terminal, simulated: &Simulated<'_>) {
    let (network, before) = (simulated.network, &simulated.result.unperturbed);
    terminal.say("resilience", format!("rho_G {} W/m³", brief(before.network_resilience)));
    let diffused = format!("{} of {} diffused", count(before.diffused() as u64), plural(network.vessel_count(), "vessel"));
    terminal.say("inflow", format!("{} mL/min in all, {diffused}", brief(ml_per_min(before.inflow))));
    say_beyond_laminar(terminal, network, before, "");
    say_stranded(terminal, simulated, before, "");
    let Some(after) = &simulated.result.perturbed else { return };

    for perturbation in simulated.perturbations {
        terminal.say("perturbed", words(network, perturbation));
    }
    let (b, a) = (before.network_resilience, after.network_resilience);
    terminal.say("resilience", format!("rho_G {} -> {} W/m³{}", brief(b), brief(a), relative(b, a)));
    let (b, a) = (ml_per_min(before.inflow), ml_per_min(after.inflow));
    let diffused = format!("{} -> {} diffused", count(before.diffused() as u64), plural(after.diffused(), "vessel"));
    terminal.say("inflow", format!("{} -> {} mL/min in all{}, {diffused}", brief(b), brief(a), relative(b, a)));
    say_beyond_laminar(terminal, network, after, " after the perturbation");
    say_stranded(terminal, simulated, after, " after the perturbation");
    let floating = |state: &State| state.pressure.iter().filter(|p| p.is_none()).count();
    let lost = floating(after).saturating_sub(floating(before));
    if lost > 0 {
        terminal.say("cut off", format!("{}, joined to no pressure any more", plural(lost, "node")));
    }
    let gained = gains(before, after, simulated.perturbations);
    say_changes(terminal, network, "collateral", "more flow in", &gained);
    let turned = reversals(before, after, simulated.perturbations);
    say_changes(terminal, network, "reversed", "flow turned round in", &turned);
}

fn say_changes(terminal: Terminal, network: &Network, heading: &str, what: &str, changes: &[FlowChange]) {
    if changes.is_empty() {
        terminal.say(heading, format!("{what} no other vessel"));
        return;
    }
    let flows = |c: &FlowChange| {
        let [before, after] = [c.before, c.after].map(|q| brief(ml_per_min(q)));
        format!("{} ({before} -> {after} mL/min)", name(network, c.vessel))
    };
    let first: Vec<String> = changes.iter().take(MOST_COLLATERALS).map(flows).collect();
    terminal.say(heading, format!("{what} {}{}", first.join(", "), more(changes.len(), MOST_COLLATERALS)));
    for change in changes.iter().skip(MOST_COLLATERALS) {
        terminal.detail(heading, flows(change));
    }
}

fn say_beyond_laminar(terminal: Terminal, network: &Network, state: &State, when: &str) {
    let vessels: Vec<String> = state.beyond_laminar().map(|(row, re)| format!("{} ({re:.0})", name(network, row))).collect();
    if !vessels.is_empty() {
        let first = vessels.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
        let rest = more(vessels.len(), NAMED);
        terminal.say(
            "warning",
            format!(
                "Reynolds number above {}{when} in {first}{rest}: Poiseuille's law no longer holds there",
                count(LAMINAR_LIMIT as u64)
            ),
        );
    }
}

/// Fixed flows into a part that nothing joins to a pressure.
fn say_stranded(terminal: Terminal, simulated: &Simulated<'_>, state: &State, when: &str) {
    for (node, condition) in &simulated.boundary.conditions {
        if matches!(condition, Condition::Flow(_)) && state.pressure[*node].is_none() {
            let id = &simulated.network.node(*node).id;
            terminal.say("warning", format!("the fixed flow at {id} has no way on{when}; it is taken as 0"));
        }
    }
}

fn words(network: &Network, Perturbation { vessel, change }: &Perturbation) -> String {
    let what = match change {
        Change::Occlusion => "occluded".to_owned(),
        Change::Tortuosity(factor) => format!("lengthened to {factor} times its length"),
        Change::Stenosis(Stenosis { open_diameter, stretch }) => {
            let over = stretch.map_or(String::new(), |length| format!(" over {} mm", brief(millimetres(length))));
            format!("diameter narrowed by {} %{over}", brief(100.0 * (1.0 - open_diameter)))
        }
    };
    format!("{}: {what}", name(network, *vessel))
}

fn name(network: &Network, row: usize) -> String {
    match network.vessel(row).label.as_str() {
        "" => format!("edge {row}"),
        label => label.to_owned(),
    }
}

/// The change as a share of what was before.
fn relative(before: f64, after: f64) -> String {
    if before == 0.0 { String::new() } else { format!(" ({:+.1} %)", 100.0 * (after / before - 1.0)) }
}

fn more(all: usize, shown: usize) -> String {
    if all > shown { format!(" and {} more", count((all - shown) as u64)) } else { String::new() }
}
