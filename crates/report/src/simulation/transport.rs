//! territories.csv and transit.csv: who feeds what, and when blood arrives; beside it the same in the perturbed network.

use std::path::Path;

use super::simulated::SimulationRun;
use crate::figures::colour::{EACH, GREEN, GREY, KEPT, PRUNED, PURPLE, Rgb, WHOLE, YELLOW};
use crate::figures::{Figure, OutletSupply, supply_bars};
use willis_core::error::Result;
use willis_core::network::Network;
use willis_core::network::units::{milliseconds, ml_per_min};
use willis_core::simulation::transport::{Blood, Transport, Transports};
use willis_io::formats::{Column, write_csv};
use willis_io::output::names::{TERRITORIES, TRANSIT};
use willis_io::output::write_file;

/// What an end is called: its label, that of the only vessel there, or its id.
pub fn end_name(network: &Network, node: usize) -> String {
    let own = &network.node(node).label;
    if !own.is_empty() {
        return own.clone();
    }
    let mut there = network.vessels().filter(|(ends, _)| ends.contains(&node));
    match (there.next(), there.next()) {
        (Some((_, vessel)), None) if !vessel.label.is_empty() => vessel.label.clone(),
        _ => network.node(node).id.clone(),
    }
}

/// A figure for each row in one state.
fn figure<'a, T>(name: &str, suffix: &str, rows: &'a [T], of: impl Fn(&'a T) -> f64) -> Column {
    Column::real(format!("{name}{suffix}"), rows.iter().map(of))
}

/// What drains a row of territories.csv: a vessel or an outlet.
#[derive(Clone, Copy)]
enum Drain {
    Vessel(usize),
    Outlet(usize),
}

/// The columns of territories.csv: a row for every vessel that carries blood and every outlet, and every inlet.
pub fn territory_columns(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<Column> {
    let network = &*simulated.network;
    let sources = transports.sources();
    let carries = |row: &usize| transports.states().any(|(state, _)| state.of_vessel(*row).is_some());
    let vessels = (0..network.vessel_count()).filter(carries).map(Drain::Vessel);
    let places = vessels.chain(transports.exits().into_iter().map(Drain::Outlet));
    let rows: Vec<(Drain, usize)> = places.flat_map(|place| sources.iter().map(move |source| (place, *source))).collect();
    let text = |name: &'static str, of: &dyn Fn(&(Drain, usize)) -> String| Column::text(name, rows.iter().map(of));
    let mut columns = vec![
        text("kind", &|(place, _)| if matches!(place, Drain::Vessel(_)) { "vessel" } else { "outlet" }.to_owned()),
        Column::whole("row", rows.iter().map(|(Drain::Vessel(row) | Drain::Outlet(row), _)| *row)),
        text("label", &|(place, _)| match place {
            Drain::Vessel(row) => network.vessel(*row).label.clone(),
            Drain::Outlet(node) => end_name(network, *node),
        }),
        text("inlet", &|(_, source)| end_name(network, *source)),
        text("inlet_id", &|(_, source)| network.node(*source).id.clone()),
    ];
    for (state, suffix) in transports.states() {
        let share = |(place, source): &(Drain, usize)| {
            let through = |row: usize| simulated.state(suffix).map_or(0.0, |state| state.vessels[row].flow.abs());
            let (blood, flow) = match place {
                Drain::Vessel(row) => (state.of_vessel(*row), through(*row)),
                Drain::Outlet(node) => (state.nodes[*node].as_ref(), state.leaving(*node)),
            };
            blood.map(|blood| (state.of_source(blood, *source), flow))
        };
        columns.push(figure("supply", suffix, &rows, |row| share(row).map_or(f64::NAN, |((share, _), _)| share)));
        columns.push(figure("flow_mL_per_min", suffix, &rows, |row| {
            share(row).map_or(f64::NAN, |((share, _), flow)| ml_per_min(share * flow))
        }));
        columns.push(figure("mean_ms", suffix, &rows, |row| share(row).map_or(f64::NAN, |((_, mean), _)| milliseconds(mean))));
    }
    columns
}

/// The columns of transit.csv: a row a node.
pub fn transit_columns(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<Column> {
    let (network, nodes) = (&*simulated.network, (0..simulated.network.node_count()).collect::<Vec<usize>>());
    let text = |name: &'static str, of: &dyn Fn(usize) -> String| Column::text(name, nodes.iter().map(|node| of(*node)));
    let mut columns = vec![
        Column::whole("node", nodes.iter().copied()),
        text("id", &|node| network.node(node).id.clone()),
        text("label", &|node| network.node(node).label.clone()),
        text("role", &|node| simulated.boundary.roles[node].name().to_owned()),
    ];
    for (state, suffix) in transports.states() {
        let of = |name: &str, figure_of: &dyn Fn(&Blood) -> f64| {
            figure(name, suffix, &nodes, |node| state.nodes[*node].as_ref().map_or(f64::NAN, figure_of))
        };
        columns.push(of("through_mL_per_min", &|blood| ml_per_min(blood.through)));
        columns.push(of("mean_ms", &|blood| milliseconds(blood.mean)));
        columns.push(of("sd_ms", &|blood| milliseconds(blood.variance.sqrt())));
        columns.push(of("first_ms", &|blood| milliseconds(blood.first)));
        let territory = |node: &usize| {
            state.nodes[*node].as_ref().map_or_else(String::new, |blood| end_name(network, state.sources[blood.territory().0]))
        };
        columns.push(Column::text(format!("territory{suffix}"), nodes.iter().map(territory)));
        columns.push(of("territory_share", &|blood| blood.territory().1));
    }
    columns
}

/// What edges.csv gains, by the blood at the upstream end of each vessel.
pub fn transport_columns(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<Column> {
    let rows: Vec<usize> = (0..simulated.network.vessel_count()).collect();
    let mut columns = Vec::new();
    for (state, suffix) in transports.states() {
        let of = |name: &str, of: &dyn Fn(&Blood) -> f64| {
            figure(name, suffix, &rows, |row| state.of_vessel(*row).map_or(f64::NAN, of))
        };
        let territory = |row: &usize| {
            let blood = state.of_vessel(*row);
            blood.map_or_else(String::new, |blood| end_name(&simulated.network, state.sources[blood.territory().0]))
        };
        columns.push(Column::text(format!("territory{suffix}"), rows.iter().map(territory)));
        columns.push(of("territory_share", &|blood| blood.territory().1));
        columns.push(of("arrival_ms", &|blood| milliseconds(blood.mean)));
        columns.push(figure("transit_ms", suffix, &rows, |row| {
            state.vessels[*row].map_or(f64::NAN, |(_, time)| milliseconds(time))
        }));
    }
    columns
}

/// The column of colours that are mixed of those of the inlets.
pub const MIXED: &str = "mixed_colour";
/// The colours of inlets, those of the largest inflow first; further ones are grey.
const INLETS: [Rgb; 7] = [KEPT, PRUNED, GREEN, WHOLE, EACH, PURPLE, YELLOW];

/// The colour of every inlet.
pub fn inlet_colours(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<(String, Rgb)> {
    let inflow = |source: &usize| {
        let of = |state: &Transport| state.sources.binary_search(source).map_or(0.0, |at| state.inflow[at]);
        transports.states().map(|(state, _)| of(state)).fold(0.0, f64::max)
    };
    let sources = transports.sources();
    // In single precision, so that rounding does not change the order of equal inlets.
    let rank = |source: &usize| {
        let more = |other: &&usize| (inflow(other) as f32, source) > (inflow(source) as f32, *other);
        sources.iter().filter(more).count()
    };
    let colour = |source: &usize| INLETS.get(rank(source)).copied().unwrap_or(GREY);
    sources.iter().map(|source| (end_name(&simulated.network, *source), colour(source))).collect()
}

/// The blood at the upstream end of every vessel: its share from each inlet, and these mixed as a colour.
pub fn supply_columns(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<Column> {
    let (network, sources) = (&*simulated.network, transports.sources());
    let colours = inlet_colours(simulated, transports);
    let rows: Vec<usize> = (0..network.vessel_count()).collect();
    let mut columns = vec![
        Column::whole("edge", rows.iter().copied()),
        Column::text("label", network.vessels().map(|(_, vessel)| vessel.label.clone())),
    ];
    for (state, suffix) in transports.states() {
        let share = |row: usize, source: usize| state.of_vessel(row).map(|blood| state.of_source(blood, source).0);
        for (source, (name, _)) in sources.iter().zip(&colours) {
            columns.push(figure(&format!("from {name}"), suffix, &rows, |row| share(*row, *source).unwrap_or(f64::NAN)));
        }
        let mixed = |row: &usize| {
            let channel = |at: usize| {
                let parts =
                    sources.iter().zip(&colours).map(|(source, (_, colour))| Some(share(*row, *source)? * f64::from(colour[at])));
                parts.sum::<Option<f64>>().map(f64::round)
            };
            let [red, green, blue] = [0, 1, 2].map(channel);
            red.zip(green).zip(blue).map_or(f64::NAN, |((red, green), blue)| (red * 256.0 + green) * 256.0 + blue)
        };
        columns.push(figure(MIXED, suffix, &rows, mixed));
    }
    columns
}

/// Whose blood every outlet gets, as a picture.
fn supply_picture(simulated: &SimulationRun<'_>, transports: &Transports) -> Figure {
    let sources = transports.sources();
    let supply = |exit: &usize| {
        let state = |(state, _): (&Transport, &str)| {
            let blood = state.nodes[*exit].as_ref()?;
            let shares = sources.iter().map(|source| state.of_source(blood, *source).0);
            Some((shares.collect(), milliseconds(blood.mean)))
        };
        let flow = transports.states().map(|(state, _)| ml_per_min(state.leaving(*exit))).fold(0.0, f64::max);
        let (name, states) = (end_name(&simulated.network, *exit), transports.states().map(state).collect());
        OutletSupply { name, flow, states }
    };
    let outlets: Vec<OutletSupply> = transports.exits().iter().map(supply).collect();
    supply_bars(&outlets, &inlet_colours(simulated, transports))
}

/// Writes territories.csv and transit.csv, and returns the territories as a picture.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_transports(folder: &Path, simulated: &SimulationRun<'_>, transports: &Transports) -> Result<Figure> {
    let territories = territory_columns(simulated, transports);
    write_file(&folder.join(TERRITORIES), |out| write_csv(out, &territories))?;
    let transit = transit_columns(simulated, transports);
    write_file(&folder.join(TRANSIT), |out| write_csv(out, &transit))?;
    Ok(supply_picture(simulated, transports))
}
