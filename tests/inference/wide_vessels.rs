//! Wide vessels in series with narrow ones, whose pressure drop rounding hides, against means over all samples in rational numbers
//! (`wide_vessels/reference.py`).

use serde::Deserialize;
use willis::internals::network::{Condition, Network};
use willis::internals::sampling::{Likelihood, SamplingOptions, Solver, Uncertain};

use crate::draw::Draw;
use crate::figure::Figure;
use crate::networks::{pressure, run};
use crate::vessels::{network, tube};

/// A drop that is 1e-11 of the pressure is off by 8 ε of the pressure (tests/flow/accuracy.rs), and its square by twice as much; smaller
/// drops are found with all digits.
const TOLERANCE: f64 = 16.0 * f64::EPSILON / 1e-11;

/// A graph and the means over all patterns of its open vessels.
#[derive(Debug, Deserialize)]
struct Reference {
    nodes: usize,
    /// Two nodes, length and radius in mm.
    vessels: Vec<(usize, usize, Figure, Figure)>,
    /// Node and pressure, Pa.
    fixed: Vec<(usize, Figure)>,
    /// Node, resistance in Pa s/m³, and venous pressure in Pa.
    terminals: Vec<(usize, Figure, Figure)>,
    likelihood: Vec<Figure>,
    frequency: Vec<Figure>,
    network_resilience: Figure,
}

impl Reference {
    fn network(&self) -> Network {
        network(self.nodes, self.vessels.iter().map(|(a, b, length, radius)| ([*a, *b], tube(length.0, radius.0))))
    }

    fn conditions(&self) -> Vec<(usize, Condition)> {
        let fixed = self.fixed.iter().map(|(node, pressure)| (*node, Condition::Pressure(pressure.0)));
        let terminals = self
            .terminals
            .iter()
            .map(|(node, resistance, venous)| (*node, Condition::Resistance { resistance: resistance.0, venous: venous.0 }));
        fixed.chain(terminals).collect()
    }
}

fn every_pattern(solver: Solver) -> SamplingOptions {
    SamplingOptions { solver, exact: true, epsilon: 0.5, samples: 1, uncertain: Uncertain::All, ..SamplingOptions::default() }
}

fn is_near(found: f64, exactly: f64) -> bool {
    (found - exactly).abs() <= TOLERANCE * exactly
}

#[test]
fn every_mean_is_that_of_rational_numbers() {
    let references: Vec<Reference> = serde_json::from_str(include_str!("wide_vessels/reference.json")).expect("reference.json");
    assert_eq!(references.len(), 48);
    for (graph, reference) in references.iter().enumerate() {
        let found = run(&reference.network(), &reference.conditions(), &every_pattern(Solver::Lanes));
        for row in 0..reference.vessels.len() {
            let (likelihood, frequency) = (reference.likelihood[row].0, reference.frequency[row].0);
            assert!(
                (found.frequency[row] - frequency).abs() < 1e-12,
                "graph {graph}, vessel {row}: frequency {}, exactly {frequency}",
                found.frequency[row]
            );
            assert!(
                is_near(found.likelihood[row], likelihood),
                "graph {graph}, vessel {row}: L {}, exactly {likelihood}",
                found.likelihood[row]
            );
        }
        assert!(is_near(found.network_resilience, reference.network_resilience.0), "graph {graph}");
    }
}

/// In series both vessels carry one flow, in the quarter of the samples in which both are open. With 100 mmHg along resistances
/// R = 8µl/(πr⁴) the flow is 100 mmHg/(R₁ + R₂), and ρ = 8µQ²/(π²r⁶).
#[test]
fn a_wide_vessel_before_a_narrow_one_flows_by_every_solver() {
    let series = network(3, [([0, 1], tube(10.0, 10.0)), ([1, 2], tube(10.0, 0.005))]);
    let drop = 100.0 * crate::networks::MMHG;
    let resistance = |radius: f64| 8.0 * crate::networks::VISCOSITY * 0.01 / (std::f64::consts::PI * radius.powi(4));
    let flow = drop / (resistance(0.01) + resistance(5e-6));
    for conditions in [[(0, pressure(100.0)), (2, pressure(0.0))], [(2, pressure(100.0)), (0, pressure(0.0))]] {
        for solver in [Solver::Lanes, Solver::Reference] {
            let found = run(&series, &conditions, &every_pattern(solver));
            assert_eq!(found.frequency, [0.25, 0.25], "{solver:?}");
            for (row, radius) in [0.01_f64, 5e-6].into_iter().enumerate() {
                let rho = 8.0 * crate::networks::VISCOSITY * flow * flow / (std::f64::consts::PI.powi(2) * radius.powi(6));
                assert!(
                    (found.likelihood[row] / (0.25 * rho) - 1.0).abs() < 1e-12,
                    "{solver:?} {row}: {}",
                    found.likelihood[row]
                );
            }
        }
    }
}

/// Two equal halves and a wide bridge between their middles: by symmetry nothing flows in the bridge, however wide. A wide vessel that
/// leads nowhere carries nothing either.
#[test]
fn nothing_flows_where_flows_cancel_or_a_vessel_leads_nowhere() {
    let mut draw = Draw::new(8);
    for _ in 0..200 {
        let (up, down) = (draw.within(0.003, 2.0), draw.within(0.003, 2.0));
        let vessels = [
            ([0, 1], tube(7.3, up)),
            ([0, 2], tube(7.3, up)),
            ([1, 3], tube(11.7, down)),
            ([2, 3], tube(11.7, down)),
            ([1, 2], tube(3.1, 10.0)),
            ([1, 4], tube(5.0, 10.0)),
            ([4, 5], tube(5.0, 9.0)),
            ([5, 1], tube(5.0, 8.0)),
        ];
        let mut graph = network(6, vessels);
        (0..8).for_each(|row| graph.vessel_mut(row).certain = true);
        let of = |solver| -> Likelihood {
            let options = SamplingOptions { solver, samples: 1, ..SamplingOptions::default() };
            run(&graph, &[(0, pressure(100.0)), (3, pressure(0.0))], &options)
        };
        let found = of(Solver::Lanes);
        assert_eq!(found.frequency[4..], [0.0; 4], "{up} {down}");
    }
}
