//! A simulation with everything that its files need, and what is written of its transport and its pulse, in each state: as it is and perturbed.

use std::borrow::Cow;

use num_complex::Complex64;

use crate::figures::{
    ArteryWaveform, EACH, Figure, GREEN, GREY, KEPT, OutletSupply, PRUNED, PURPLE, Rgb, WHOLE, YELLOW, supply_bars,
    waveform_panels,
};
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::units::{milliseconds, ml_per_min, mmhg};
use willis_core::network::{Network, RadiusRule, Vessel};
use willis_core::simulation::pulse::fourier::Indices;
use willis_core::simulation::pulse::fourier::samples;
use willis_core::simulation::pulse::womersley::{TubeSegment, womersley_number};
use willis_core::simulation::pulse::{Pulse, Pulses};
use willis_core::simulation::transport::{Blood, Transport, Transports};
use willis_core::simulation::{Perturbation, Simulation};
use willis_io::formats::{Column, NamedArray};

/// The flow of an input, before and after the changes, with everything that its files need.
#[derive(Debug)]
pub struct SimulationRun<'a> {
    /// The vessels.
    pub network: Cow<'a, Network>,
    /// Their boundary conditions.
    pub boundary: Boundary,
    /// The condition of outlets without one.
    pub outlets: FoundOutlets,
    /// The command and input of the run.
    pub provenance: Cow<'a, crate::run_record::Provenance>,
    /// Which radius stands for a vessel.
    pub radius_rule: RadiusRule,
    /// The changes.
    pub perturbations: Vec<Perturbation>,
    /// The flow before and after the changes.
    pub result: Simulation,
    /// Blood viscosity, Pa s.
    pub viscosity: f64,
    /// Where the blood comes from and when, if it was asked for.
    pub transports: Option<Transports>,
    /// What each closed vessel does, if that was asked for.
    pub closures: Option<Vec<willis_core::simulation::ClosedVessel>>,
    /// The pulse, if it was asked for, and its record.
    pub pulses: Option<(Pulses, serde_json::Value)>,
}

/// What each vessel is called in pictures: its label; where this is empty or not unique the name has the row.
pub(super) fn picture_names(network: &Network) -> Vec<String> {
    let mut uses = std::collections::BTreeMap::new();
    network.vessels().for_each(|(_, vessel)| *uses.entry(vessel.label.as_str()).or_insert(0_usize) += 1);
    let name = |(row, (_, vessel)): (usize, (_, &Vessel))| match vessel.label.as_str() {
        "" => format!("edge {row}"),
        label if uses[label] > 1 => format!("{label} (edge {row})"),
        label => label.to_owned(),
    };
    network.vessels().enumerate().map(name).collect()
}

/// What an end is called: its label, that of the only vessel there, or its id.
pub fn end_name(network: &Network, node: usize) -> String {
    let own = &network.node(node).label;
    if !own.is_empty() {
        return own.clone();
    }
    let mut there = network.vessels_of(node);
    match (there.next(), there.next()) {
        (Some(vessel), None) if !vessel.label.is_empty() => vessel.label.clone(),
        _ => network.node(node).id.clone(),
    }
}

/// A figure for each row in one state, where it has one.
fn figure<'a, T>(name: &str, suffix: &str, rows: &'a [T], of: impl Fn(&'a T) -> Option<f64>) -> Column {
    Column::real(format!("{name}{suffix}"), rows.iter().map(|row| of(row).unwrap_or(f64::NAN)))
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
    for ((state, suffix), (flows, _)) in transports.states().zip(simulated.result.states()) {
        let share = |(place, source): &(Drain, usize)| {
            let (blood, flow) = match place {
                Drain::Vessel(row) => (state.of_vessel(*row), flows.vessels[*row].flow.abs()),
                Drain::Outlet(node) => (state.nodes[*node].as_ref(), state.leaving(*node)),
            };
            blood.map(|blood| (state.of_source(blood, *source), flow))
        };
        columns.push(figure("supply", suffix, &rows, |row| share(row).map(|((share, _), _)| share)));
        columns
            .push(figure("flow_mL_per_min", suffix, &rows, |row| share(row).map(|((share, _), flow)| ml_per_min(share * flow))));
        columns.push(figure("mean_ms", suffix, &rows, |row| share(row).map(|((_, mean), _)| milliseconds(mean))));
    }
    columns
}

/// The inlet from which most of the blood at some places comes, and its share.
fn most_from(network: &Network, (state, suffix): (&Transport, &str), places: &[Option<&Blood>]) -> [Column; 2] {
    let inlet = |blood: &Blood| end_name(network, state.sources[blood.territory().0]);
    let inlets = places.iter().map(|blood| blood.map_or_else(String::new, inlet));
    let share = figure("territory_share", suffix, places, |blood| blood.map(|blood| blood.territory().1));
    [Column::text(format!("territory{suffix}"), inlets), share]
}

/// The columns of transit.csv: a row a node.
pub fn transit_columns(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<Column> {
    let network = &*simulated.network;
    let mut columns = vec![
        Column::whole("node", 0..network.node_count()),
        Column::text("id", network.nodes().map(|node| &node.id)),
        Column::text("label", network.nodes().map(|node| &node.label)),
        Column::text("role", simulated.boundary.roles.iter().map(|role| role.name())),
    ];
    for (state, suffix) in transports.states() {
        let blood: Vec<Option<&Blood>> = state.nodes.iter().map(Option::as_ref).collect();
        let of = |name: &str, figure_of: &dyn Fn(&Blood) -> f64| figure(name, suffix, &blood, |blood| blood.map(figure_of));
        columns.push(of("through_mL_per_min", &|blood| ml_per_min(blood.through)));
        columns.push(of("mean_ms", &|blood| milliseconds(blood.mean)));
        columns.push(of("sd_ms", &|blood| milliseconds(blood.variance.sqrt())));
        columns.push(of("first_ms", &|blood| milliseconds(blood.first)));
        columns.extend(most_from(network, (state, suffix), &blood));
    }
    columns
}

/// What edges.csv gains, by the blood at the upstream end of each vessel.
pub fn transport_columns(simulated: &SimulationRun<'_>, transports: &Transports) -> Vec<Column> {
    let mut columns = Vec::new();
    for (state, suffix) in transports.states() {
        let blood: Vec<Option<&Blood>> = (0..state.vessels.len()).map(|row| state.of_vessel(row)).collect();
        columns.extend(most_from(&simulated.network, (state, suffix), &blood));
        columns.push(figure("arrival_ms", suffix, &blood, |blood| blood.map(|blood| milliseconds(blood.mean))));
        columns.push(figure("transit_ms", suffix, &state.vessels, |vessel| vessel.map(|(_, time)| milliseconds(time))));
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
            columns.push(figure(&format!("from {name}"), suffix, &rows, |row| share(*row, *source)));
        }
        let mixed = |row: &usize| {
            let channel = |at: usize| {
                let parts =
                    sources.iter().zip(&colours).map(|(source, (_, colour))| Some(share(*row, *source)? * f64::from(colour[at])));
                parts.sum::<Option<f64>>().map(f64::round)
            };
            let [red, green, blue] = [0, 1, 2].map(channel);
            red.zip(green).zip(blue).map(|((red, green), blue)| (red * 256.0 + green) * 256.0 + blue)
        };
        columns.push(figure(MIXED, suffix, &rows, mixed));
    }
    columns
}

/// Whose blood every outlet gets, as a picture.
pub fn supply_picture(simulated: &SimulationRun<'_>, transports: &Transports) -> Figure {
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

/// What edges.csv gains: figures in the middle of every vessel.
pub fn pulse_vessel_columns(pulses: &Pulses) -> Vec<Column> {
    let mut columns = Vec::new();
    for (pulse, suffix) in pulses.both.states() {
        let period = pulse.period;
        let rows = 0..pulse.vessels.len();
        let flows: Vec<Indices> = rows.clone().map(|row| pulse.flow_indices(row)).collect();
        let pressures: Vec<Option<Indices>> =
            pulse.vessels.iter().map(|v| v.pressure.as_ref().map(|p| Indices::of(p, period, 0.0))).collect();
        let shears: Vec<[f64; 3]> = rows.clone().map(|row| shear(pulses, pulse, row)).collect();
        let speed = |row: usize, of: &dyn Fn(&TubeSegment) -> f64| pulse.walls[row].halves[0].first().map_or(f64::NAN, of);
        let frequency = std::f64::consts::TAU / period;
        let mut push = |name: &str, of: &dyn Fn(usize) -> f64| {
            columns.push(Column::real(format!("{name}{suffix}"), rows.clone().map(of)));
        };
        let pressure = |row: usize, of: &dyn Fn(&Indices) -> f64| pressures[row].as_ref().map_or(f64::NAN, of);
        push("flow_mean_mL_per_min", &|row| ml_per_min(flows[row].mean));
        push("flow_max_mL_per_min", &|row| ml_per_min(flows[row].max));
        push("flow_min_mL_per_min", &|row| ml_per_min(flows[row].min));
        push("pulsatility_index", &|row| flows[row].pulsatility);
        push("resistive_index", &|row| flows[row].resistive);
        push("reversed_share", &|row| flows[row].reversed_share);
        push("reversed_volume_ratio", &|row| flows[row].reversed / pulse.walls[row].volume);
        push("delay_ms", &|row| milliseconds(pulses.delay(flows[row].phase, period)));
        push("pressure_mean_mmHg", &|row| pressure(row, &|p| mmhg(p.mean)));
        push("pressure_max_mmHg", &|row| pressure(row, &|p| mmhg(p.max)));
        push("pressure_min_mmHg", &|row| pressure(row, &|p| mmhg(p.min)));
        push("pressure_delay_ms", &|row| pressure(row, &|p| milliseconds(pulses.delay(p.phase, period))));
        push("pulse_arrival_ms", &|row| milliseconds(pulse.arrivals.vessels[row] - pulse.arrivals.first));
        push("wave_speed_m_per_s", &|row| speed(row, &|s| s.wave_speed(&pulses.fluid)));
        push("phase_speed_m_per_s", &|row| speed(row, &|s| s.phase_speed(&pulses.fluid, frequency)));
        push("womersley", &|row| speed(row, &|s| womersley_number(&pulses.fluid, frequency, s.radius)));
        push("wall_shear_mean_Pa", &|row| shears[row][0]);
        push("wall_shear_max_Pa", &|row| shears[row][1]);
        push("oscillatory_shear_index", &|row| shears[row][2]);
    }
    columns
}

/// Even times at which the wall shear stress is looked at.
const SHEAR_TIMES: usize = 1000;

/// The mean and the largest magnitude of the wall shear stress over a cycle (Pa), and the oscillatory shear index
/// (1 - |mean of it|/mean of its magnitude)/2.
fn shear(pulses: &Pulses, pulse: &Pulse, row: usize) -> [f64; 3] {
    let harmonics = pulse.wall_shear(row, &pulses.fluid);
    let values = samples(&harmonics, SHEAR_TIMES);
    let mean = values.iter().map(|x| x.abs()).sum::<f64>() / SHEAR_TIMES as f64;
    let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    [mean, largest, if mean > 0.0 { (0.5 * (1.0 - harmonics[0].re.abs() / mean)).max(0.0) } else { f64::NAN }]
}

/// What nodes.csv gains.
pub fn pulse_node_columns(pulses: &Pulses) -> Vec<Column> {
    let mut columns = Vec::new();
    for (pulse, suffix) in pulses.both.states() {
        let found: Vec<Option<Indices>> = (0..pulse.pressure.len()).map(|node| pulse.node_indices(node)).collect();
        let mut push =
            |name: &str, of: &dyn Fn(&Indices) -> f64| columns.push(figure(name, suffix, &found, |p| p.as_ref().map(of)));
        push("pressure_mean_mmHg", &|p| mmhg(p.mean));
        push("pressure_max_mmHg", &|p| mmhg(p.max));
        push("pressure_min_mmHg", &|p| mmhg(p.min));
        push("delay_ms", &|p| milliseconds(pulses.delay(p.phase, pulse.period)));
        let arrivals = &pulse.arrivals;
        let foot = |name: &str, of: &dyn Fn(f64) -> f64| figure(name, suffix, &arrivals.nodes, |at| Some(milliseconds(of(*at))));
        columns.extend([foot("foot_ms", &|at| at.rem_euclid(pulse.period)), foot("pulse_arrival_ms", &|at| at - arrivals.first)]);
    }
    columns
}

/// A pressure in mmHg at even times from its harmonics; no numbers where there is none.
fn pressures(harmonics: Option<&Vec<Complex64>>, times: usize) -> Vec<f64> {
    harmonics.map_or_else(|| vec![f64::NAN; times], |p| samples(p, times).into_iter().map(mmhg).collect())
}

/// A flow in mL/min at even times from its harmonics.
pub fn flow_samples(harmonics: &[Complex64], times: usize) -> Vec<f64> {
    samples(harmonics, times).into_iter().map(ml_per_min).collect()
}

/// The arrays of waveforms.npz: the times (s), and by vessel and time the pressure (mmHg) and the flow (mL/min) at its first end, in its
/// middle and at its second end.
pub fn waveform_arrays(simulated: &SimulationRun<'_>, pulses: &Pulses) -> Vec<NamedArray> {
    let (times, period) = (pulses.times, pulses.both.unperturbed.period);
    let time = (0..times).map(|k| k as f64 * period / times as f64).collect();
    let mut arrays = vec![NamedArray { name: "time_s".into(), shape: vec![times], values: time }];
    for (pulse, suffix) in pulses.both.states() {
        let rows = pulse.vessels.len();
        let mut push = |name: &str, of: &dyn Fn(usize) -> Vec<f64>| {
            let values = (0..rows).flat_map(of).collect();
            arrays.push(NamedArray { name: format!("{name}{suffix}"), shape: vec![rows, times], values });
        };
        let at_end = |row: usize, end: usize| pressures(pulse.pressure[simulated.network.ends(row)[end]].as_ref(), times);
        push("pressure_a_mmHg", &|row| at_end(row, 0));
        push("pressure_mmHg", &|row| pressures(pulse.vessels[row].pressure.as_ref(), times));
        push("pressure_b_mmHg", &|row| at_end(row, 1));
        for (place, name) in ["flow_a_mL_per_min", "flow_mL_per_min", "flow_b_mL_per_min"].into_iter().enumerate() {
            push(name, &|row| flow_samples(&pulse.vessels[row].flow[place], times));
        }
    }
    arrays
}

/// The arrays of harmonics.npz, complex: by node P, and by vessel Pm, Qa, Qm and Qb.
pub fn harmonics(pulses: &Pulses) -> Vec<NamedArray<Complex64>> {
    let mut arrays = Vec::new();
    for (pulse, suffix) in pulses.both.states() {
        let count = pulse.harmonics + 1;
        let undefined = vec![Complex64::new(f64::NAN, f64::NAN); count];
        let mut push = |name: &str, rows: usize, of: &dyn Fn(usize) -> Vec<Complex64>| {
            let values = (0..rows).flat_map(of).collect();
            arrays.push(NamedArray { name: format!("{name}{suffix}"), shape: vec![rows, count], values });
        };
        push("P", pulse.pressure.len(), &|node| pulse.pressure[node].clone().unwrap_or_else(|| undefined.clone()));
        push("Pm", pulse.vessels.len(), &|row| pulse.vessels[row].pressure.clone().unwrap_or_else(|| undefined.clone()));
        for (place, name) in ["Qa", "Qm", "Qb"].into_iter().enumerate() {
            push(name, pulse.vessels.len(), &|row| pulse.vessels[row].flow[place].clone());
        }
    }
    arrays
}

/// The columns of waveforms.csv: a row for every vessel and time, in the middle of the vessel.
pub fn waveform_columns(pulses: &Pulses) -> Vec<Column> {
    let (times, period) = (pulses.times, pulses.both.unperturbed.period);
    let rows = pulses.both.unperturbed.vessels.len();
    let cells = || (0..rows).flat_map(|row| (0..times).map(move |at| (row, at)));
    let mut columns = vec![
        Column::real("time_s", cells().map(|(_, at)| at as f64 * period / times as f64)),
        Column::whole("edge", cells().map(|(row, _)| row)),
    ];
    for (pulse, suffix) in pulses.both.states() {
        let mut push = |name: &str, all: Vec<Vec<f64>>| {
            columns.push(Column::real(format!("{name}{suffix}"), cells().map(|(row, at)| all[row][at])));
        };
        push("pressure_mmHg", pulse.vessels.iter().map(|vessel| pressures(vessel.pressure.as_ref(), times)).collect());
        push("flow_mL_per_min", pulse.vessels.iter().map(|vessel| flow_samples(&vessel.flow[1], times)).collect());
    }
    columns
}

/// The arteries as a picture, a panel each.
pub fn waveform_picture(simulated: &SimulationRun<'_>, pulses: &Pulses) -> Figure {
    let network = &*simulated.network;
    let names = picture_names(network);
    let artery = |row: usize| {
        let state = |(pulse, _): (&Pulse, &str)| {
            let found = pulse.flow_indices(row);
            let flow = flow_samples(&pulse.vessels[row].flow[1], pulses.times);
            (flow, ml_per_min(found.mean), found.pulsatility)
        };
        let (name, states) = (names[row].clone(), pulses.both.states().map(state).collect());
        ArteryWaveform { name, is_named: !network.vessel(row).label.is_empty(), states }
    };
    let arteries: Vec<ArteryWaveform> = (0..network.vessel_count()).map(artery).collect();
    waveform_panels(&arteries, pulses.both.unperturbed.period)
}
