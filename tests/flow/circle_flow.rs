//! Flow in the published Circle of Willis and its variants as shipped, against an independent dense calculation in double precision
//! (NumPy; 3.5 cP, 100 mmHg at both internal carotids and both vertebrals), to the digits that it was noted with.

use std::path::Path;

use crate::networks::{MMHG, VISCOSITY};
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::state::State;
use willis::internals::flow::{Boundary, FoundOutlets, Tube};
use willis::internals::formats::{ReadOptions, read_graphml};
use willis::internals::network::units::ml_per_min;
use willis::internals::network::{Condition, Network, Role};
use willis::internals::phantom::without;

/// A shipped network.
fn shipped(name: &str) -> Network {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/circle-of-willis").join(name).with_extension("graphml");
    read_graphml(&std::fs::read(path).unwrap()[..], &ReadOptions::default()).unwrap().0
}

/// The same with zero pressure at every outlet.
fn grounded(mut network: Network) -> Network {
    for row in 0..network.node_count() {
        let node = network.node_mut(row);
        if node.role == Some(Role::Outlet) {
            node.condition = Some(Condition::Pressure(0.0));
        }
    }
    network
}

/// The left carotid at half its diameter, the left posterior communicating artery occluded.
fn perturbed(network: &Network) -> Network {
    let mut network = without(network, &["L-PComm"]).unwrap();
    let carotid = row(&network, "L-ICA I");
    network.vessel_mut(carotid).radius /= 2.0;
    network
}

fn row(network: &Network, label: &str) -> usize {
    network.vessels().position(|(_, vessel)| vessel.label == label).unwrap()
}

struct Flow {
    network: Network,
    state: State,
}

fn solved(network: Network) -> Flow {
    let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground).unwrap();
    assert!(boundary.found_inlets.is_empty() && boundary.found_outlets.is_empty());
    let tubes: Vec<Tube> = network.vessels().map(|(_, vessel)| Tube::of(vessel, VISCOSITY)).collect();
    let state = State::solve(&network, &boundary, &tubes, VISCOSITY).unwrap();
    Flow { network, state }
}

impl Flow {
    /// mL/min, positive from the first node of the table's row to the second.
    fn of(&self, label: &str) -> f64 {
        ml_per_min(self.state.vessels[row(&self.network, label)].flow)
    }

    /// Flows noted in whole mL/min.
    fn check(&self, noted: &[(&str, f64)]) {
        for (label, noted) in noted {
            assert!((self.of(label) - noted).abs() <= 0.5, "{label}: {} for {noted}", self.of(label));
        }
    }

    /// Total in whole mL/min; ρ_G in W/m³ to half a unit of its last digit.
    fn check_sums(&self, total: f64, resilience: f64, digit: f64) {
        let (inflow, rho) = (ml_per_min(self.state.inflow), self.state.network_resilience);
        assert!((inflow - total).abs() <= 0.5, "total {inflow} for {total}");
        assert!((rho - resilience).abs() <= digit / 2.0, "rho_G {rho} for {resilience}");
    }
}

#[test]
fn terminal_resistances_leave_a_brains_flow() {
    let flow = solved(shipped("complete"));
    flow.check_sums(555.0, 1230.0, 10.0);
    for side in ["L", "R"] {
        let name = |stem: &str| format!("{side}-{stem}");
        let noted = [("ICA I", 223.0), ("M1", 125.0), ("A2", 87.0), ("P2", 66.0), ("PComm", -11.0)];
        for (stem, q) in noted {
            flow.check(&[(&name(stem), q)]);
        }
    }
    let vertebrals = flow.of("L-VA") + flow.of("R-VA");
    assert!((vertebrals - 110.0).abs() <= 0.5, "{vertebrals}");
    assert!((flow.of("BA") - vertebrals).abs() < 1e-9);
}

/// The communicating arteries carry next to nothing while the circle is whole; by symmetry the anterior one carries nothing at all.
#[test]
fn grounded_outlets_and_what_the_anterior_artery_takes_over() {
    let complete = grounded(shipped("complete"));
    let flow = solved(complete.clone());
    flow.check_sums(7366.0, 1.811e5, 100.0);
    flow.check(&[("L-ICA II", 2940.0), ("L-PComm", -73.0), ("L-A1", 990.0), ("L-P1", 670.0)]);
    assert_eq!(flow.of("AComm"), 0.0);

    let flow = solved(perturbed(&complete));
    flow.check_sums(5333.0, 4.529e5, 100.0);
    flow.check(&[("L-ICA II", 369.0), ("AComm", -1041.0), ("L-A1", -487.0), ("L-P1", 712.0)]);
}

#[test]
fn grounded_outlets_without_the_anterior_artery() {
    let variant = grounded(shipped("without-AComm"));
    let flow = solved(variant.clone());
    flow.check_sums(7366.0, 1.907e5, 100.0);
    flow.check(&[("L-ICA II", 2940.0), ("L-PComm", -73.0), ("L-A1", 990.0), ("L-P1", 670.0)]);

    let flow = solved(perturbed(&variant));
    flow.check_sums(4852.0, 1.487e5, 100.0);
    flow.check(&[("L-ICA II", 457.0), ("L-A1", 154.0), ("L-P1", 728.0)]);
}

/// Every variant carries blood to all six territories; mean arterial pressure bounds every pressure.
#[test]
fn every_variant_supplies_all_six_territories() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/circle-of-willis");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned();
        let flow = solved(shipped(&name));
        let ends = ["L-M1", "R-M1", "L-A2", "R-A2", "L-P2", "R-P2"].map(|label| flow.of(label));
        assert!(ends.iter().all(|q| *q > 30.0), "{name}: {ends:?}");
        assert!((ends.iter().sum::<f64>() / ml_per_min(flow.state.inflow) - 1.0).abs() < 1e-9, "{name}");
        assert!(flow.state.pressure.iter().flatten().all(|p| *p > 0.0 && *p <= 100.0 * MMHG * (1.0 + 1e-12)), "{name}");
    }
}
