//! What is written of a pulse: columns of edges.csv and nodes.csv, the waveforms by time and by harmonic, and their picture.

use std::f64::consts::TAU;
use std::path::Path;

use num_complex::Complex64;

use super::simulated::{SimulationRun, picture_names};
use crate::figures::{ArteryWaveform, Figure, waveform_panels};
use willis_core::error::Result;
use willis_core::network::units::{milliseconds, ml_per_min, mmhg};
use willis_core::simulation::pulse::fourier::Indices;
use willis_core::simulation::pulse::fourier::samples;
use willis_core::simulation::pulse::womersley::womersley_number;
use willis_core::simulation::pulse::{Pulse, Pulses};
use willis_io::formats::{Column, NamedArray, write_arrays, write_csv};
use willis_io::output::names::{HARMONICS, WAVEFORM_TABLE, WAVEFORMS};
use willis_io::output::write_file;

/// The largest number of vessels whose waveforms are written as a table.
const MOST_IN_TABLE: usize = 1000;

/// What edges.csv gains: figures in the middle of every vessel.
pub fn pulse_vessel_columns(pulses: &Pulses) -> Vec<Column> {
    let mut columns = Vec::new();
    for (pulse, suffix) in pulses.states() {
        let (period, largest) = (pulse.period, pulse.largest_flow());
        let rows = 0..pulse.vessels.len();
        let flows: Vec<Indices> = rows.clone().map(|row| pulse.flow_indices_beside(row, largest)).collect();
        let pressures: Vec<Option<Indices>> =
            pulse.vessels.iter().map(|v| v.pressure.as_ref().map(|p| Indices::of(p, period, 0.0))).collect();
        let shears: Vec<[f64; 3]> = rows.clone().map(|row| shear(pulses, pulse, row)).collect();
        let speed = |row: usize, of: &dyn Fn(&willis_core::simulation::pulse::womersley::TubeSegment) -> f64| {
            pulse.walls[row].halves[0].first().map_or(f64::NAN, of)
        };
        let frequency = TAU / period;
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
    for (pulse, suffix) in pulses.states() {
        let found: Vec<Option<Indices>> = (0..pulse.pressure.len()).map(|node| pulse.node_indices(node)).collect();
        let mut push = |name: &str, of: &dyn Fn(&Indices) -> f64| {
            columns.push(Column::real(format!("{name}{suffix}"), found.iter().map(|p| p.as_ref().map_or(f64::NAN, of))));
        };
        push("pressure_mean_mmHg", &|p| mmhg(p.mean));
        push("pressure_max_mmHg", &|p| mmhg(p.max));
        push("pressure_min_mmHg", &|p| mmhg(p.min));
        push("delay_ms", &|p| milliseconds(pulses.delay(p.phase, pulse.period)));
        let arrivals = &pulse.arrivals;
        let mut push = |name: &str, of: &dyn Fn(f64) -> f64| {
            columns.push(Column::real(format!("{name}{suffix}"), arrivals.nodes.iter().map(|foot| milliseconds(of(*foot)))));
        };
        push("foot_ms", &|foot| foot.rem_euclid(pulse.period));
        push("pulse_arrival_ms", &|foot| foot - arrivals.first);
    }
    columns
}

/// The pressure in the middle of a vessel in mmHg and the flow in mL/min at even times.
fn middle(pulse: &Pulse, row: usize, times: usize) -> [Vec<f64>; 2] {
    let vessel = &pulse.vessels[row];
    let pressure = vessel.pressure.as_ref().map_or_else(|| vec![f64::NAN; times], |p| samples(p, times));
    [pressure.into_iter().map(mmhg).collect(), samples(&vessel.flow[1], times).into_iter().map(ml_per_min).collect()]
}

/// The flow in the middle of every vessel at even times, mL/min, by time; for the page.
pub fn flows_by_time(pulse: &Pulse, times: usize) -> Vec<Vec<f64>> {
    let flows: Vec<Vec<f64>> = (0..pulse.vessels.len()).map(|row| middle(pulse, row, times)[1].clone()).collect();
    (0..times).map(|at| flows.iter().map(|flow| flow[at]).collect()).collect()
}

/// The arrays of waveforms.npz: the times (s), and by vessel and time the pressure (mmHg) and the flow (mL/min) at its first end, in its
/// middle and at its second end.
pub fn waveform_arrays(simulated: &SimulationRun<'_>, pulses: &Pulses) -> Vec<NamedArray> {
    let (times, period) = (pulses.times, pulses.unperturbed.period);
    let time = (0..times).map(|k| k as f64 * period / times as f64).collect();
    let mut arrays = vec![NamedArray { name: "time_s".into(), shape: vec![times], values: time }];
    for (pulse, suffix) in pulses.states() {
        let rows = pulse.vessels.len();
        let mut push = |name: &str, of: &dyn Fn(usize) -> Vec<f64>| {
            let values = (0..rows).flat_map(of).collect();
            arrays.push(NamedArray { name: format!("{name}{suffix}"), shape: vec![rows, times], values });
        };
        let at_node = |node: usize| {
            let pressure = pulse.pressure[node].as_ref();
            pressure.map_or_else(|| vec![f64::NAN; times], |p| samples(p, times).into_iter().map(mmhg).collect())
        };
        let flow = |row: usize, place: usize| {
            samples(&pulse.vessels[row].flow[place], times).into_iter().map(ml_per_min).collect::<Vec<f64>>()
        };
        push("pressure_a_mmHg", &|row| at_node(simulated.network.ends(row)[0]));
        push("pressure_mmHg", &|row| middle(pulse, row, times)[0].clone());
        push("pressure_b_mmHg", &|row| at_node(simulated.network.ends(row)[1]));
        push("flow_a_mL_per_min", &|row| flow(row, 0));
        push("flow_mL_per_min", &|row| flow(row, 1));
        push("flow_b_mL_per_min", &|row| flow(row, 2));
    }
    arrays
}

fn harmonics(pulses: &Pulses) -> Vec<NamedArray<Complex64>> {
    let mut arrays = Vec::new();
    for (pulse, suffix) in pulses.states() {
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
fn table(pulses: &Pulses) -> Vec<Column> {
    let (times, period) = (pulses.times, pulses.unperturbed.period);
    let rows = pulses.unperturbed.vessels.len();
    let cells = || (0..rows).flat_map(|row| (0..times).map(move |at| (row, at)));
    let mut columns = vec![
        Column::real("time_s", cells().map(|(_, at)| at as f64 * period / times as f64)),
        Column::whole("edge", cells().map(|(row, _)| row)),
    ];
    for (pulse, suffix) in pulses.states() {
        let all: Vec<[Vec<f64>; 2]> = (0..rows).map(|row| middle(pulse, row, times)).collect();
        columns.push(Column::real(format!("pressure_mmHg{suffix}"), cells().map(|(row, at)| all[row][0][at])));
        columns.push(Column::real(format!("flow_mL_per_min{suffix}"), cells().map(|(row, at)| all[row][1][at])));
    }
    columns
}

/// The arteries as a picture, a panel each.
fn picture(simulated: &SimulationRun<'_>, pulses: &Pulses) -> Figure {
    let network = &*simulated.network;
    let names = picture_names(network);
    let artery = |row: usize| {
        let state = |(pulse, _): (&Pulse, &str)| {
            let found = pulse.flow_indices(row);
            let flow = samples(&pulse.vessels[row].flow[1], pulses.times).into_iter().map(ml_per_min).collect();
            (flow, ml_per_min(found.mean), found.pulsatility)
        };
        let (name, states) = (names[row].clone(), pulses.states().map(state).collect());
        ArteryWaveform { name, is_named: !network.vessel(row).label.is_empty(), states }
    };
    let arteries: Vec<ArteryWaveform> = (0..network.vessel_count()).map(artery).collect();
    waveform_panels(&arteries, pulses.unperturbed.period)
}

/// Writes waveforms.npz, harmonics.npz and, of a network that is not large, waveforms.csv; and returns the picture.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_pulses(folder: &Path, simulated: &SimulationRun<'_>, pulses: &Pulses) -> Result<Figure> {
    write_file(&folder.join(WAVEFORMS), |out| write_arrays(out, waveform_arrays(simulated, pulses)))?;
    write_file(&folder.join(HARMONICS), |out| write_arrays(out, harmonics(pulses)))?;
    if simulated.network.vessel_count() <= MOST_IN_TABLE {
        let table = table(pulses);
        write_file(&folder.join(WAVEFORM_TABLE), |out| write_csv(out, &table))?;
    }
    Ok(picture(simulated, pulses))
}
