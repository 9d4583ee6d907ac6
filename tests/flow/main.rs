//! Blood flow: boundary conditions, solvers, simulation and modulation.

#[path = "../support/draw.rs"]
mod draw;
#[path = "../support/figure.rs"]
mod figure;
#[path = "../support/networks.rs"]
mod networks;
#[path = "../support/pulse.rs"]
mod pulse_case;
#[path = "../support/oracle.rs"]
mod python_oracle;
#[path = "../support/shuffle.rs"]
mod shuffle;
#[path = "../support/vessels.rs"]
mod vessels;

mod accuracy;
mod boundary;
mod circle_flow;
mod circuits;
mod merged_vessels;
mod modulation;
mod morphometry;
mod peel;
mod properties;
mod pulse;
mod pulse_numpy;
mod pulse_references;
mod simulate;
mod svzerod;
mod svzerod_reads;
mod transport;
