//! The hemodynamic state of a network: what flows where, and how much energy it dissipates.
//!
//! Pressure drops with all of their digits: what Kirchhoff's current law lacks at the pressures found is solved for again.
//!
//! A drop P_a - P_b has as many digits as the two pressures differ in. In a wide vessel in series with a narrow one, or beside a high
//! pressure, these are few or none, and the flow C (P_a - P_b) is not what the neighbours carry. The same equations with the lack of flow as
//! sources give the change of the pressures; its differences are small numbers of their own, and are added to the drops (iterative refinement, with
//! the drop as an unevaluated sum).

use std::{collections::BTreeMap, f64::consts::PI};

use super::{BatchSolver, Boundary, Circuit, Tube, boundary_conditions::Provisional, is_diffused, resilience};
use crate::{error::Result, network::Network};

/// Density of blood, kg/m³.
pub const BLOOD_DENSITY: f64 = 1060.0;
/// Reynolds number above which flow in a tube need not be laminar, so that Poiseuille's law no longer holds.
pub const LAMINAR_LIMIT: f64 = 2000.0;

/// The flow in one vessel. Signed figures are positive from its first node to its second; all are zero in a vessel that
/// is not diffused.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VesselState {
    /// Pa s/m³; infinite for an occluded vessel.
    pub resistance: f64,
    /// Of the lumen, m³.
    pub volume: f64,
    /// Pressure at the first node less that at the second, Pa.
    pub drop: f64,
    /// Q, m³/s.
    pub flow: f64,
    /// Mean velocity Q/(πr²) where the vessel is narrowest, m/s.
    pub velocity: f64,
    /// Wall shear stress 4µ|Q|/(πr³) where the vessel is narrowest, Pa; ΔP r/(2l) for a uniform tube under Poiseuille's law.
    pub wall_shear: f64,
    /// Reynolds number 2 r |v| times density over viscosity, where the vessel is narrowest.
    pub reynolds: f64,
    /// ρ = ΔP·Q over the volume of the lumen, W/m³ (Moriconi et al. 2019).
    pub resilience: f64,
    /// Whether blood flows at all.
    pub diffused: bool,
}

/// The flow in a network.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Per node, Pa; `None` in floating components.
    pub pressure: Vec<Option<f64>>,
    /// Per vessel.
    pub vessels: Vec<VesselState>,
    /// ρ_G: Σ ρ over the number of open vessels, W/m³.
    pub network_resilience: f64,
    /// What flows in through the nodes with a boundary condition, m³/s.
    pub inflow: f64,
}

impl State {
    /// Solves a network whose vessels are `tubes`.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance no double can hold, or a breakdown of the solver.
    pub fn solve(network: &Network, boundary: &Boundary, tubes: &[Tube], viscosity: f64) -> Result<Self> {
        let circuit = Circuit::with(network, boundary, &Provisional::new(), tubes)?;
        let solver = BatchSolver::for_few(&circuit)?;
        let above_level = solver.above_level(&circuit, |row| tubes[row].is_open())?;
        Ok(Self::at_pressures(&circuit, boundary, tubes, viscosity, &above_level, Some(&solver)))
    }

    /// The state of `tubes` between the nodes of a circuit at the pressures that a solver found, Pa above its level. Where flows do not
    /// balance at these to 1e-12, they are refined. The circuit's conditions are those that hold ([`Circuit::in_sample`]). The `solver` of this
    /// circuit, where there is one, need not be compiled again.
    pub fn at_pressures(
        circuit: &Circuit,
        boundary: &Boundary,
        tubes: &[Tube],
        viscosity: f64,
        above: &[Option<f64>],
        solver: Option<&BatchSolver>,
    ) -> Self {
        let conductance: Vec<f64> = tubes.iter().map(|tube| if tube.is_open() { 1.0 / tube.resistance } else { 0.0 }).collect();
        let Balanced { above_level, drop } = Balanced::of(circuit, &conductance, above, solver);
        let through = |(row, drop): (usize, &f64)| if tubes[row].is_open() { (drop / tubes[row].resistance).abs() } else { 0.0 };
        let is_beyond_rounding = |row: usize| match circuit.ends[row].map(|node| above_level[node]) {
            [Some(a), Some(b)] => is_diffused(drop[row], a + circuit.level, b + circuit.level),
            _ => false,
        };
        let flow: Vec<f64> = drop.iter().enumerate().map(through).collect();
        let carries = carrying(circuit, &flow, (0..flow.len()).map(is_beyond_rounding).collect());
        let vessel = |(row, tube): (usize, &Tube)| {
            if carries[row] && tube.is_open() { VesselState::at(drop[row], tube, viscosity) } else { VesselState::at_rest(tube) }
        };
        let vessels: Vec<VesselState> = tubes.iter().enumerate().map(vessel).collect();
        let open = tubes.iter().filter(|tube| tube.is_open()).count();
        let total: f64 = vessels.iter().map(|v| v.resilience).sum();
        let mut out = vec![0.0; above_level.len()];
        for (vessel, [a, b]) in vessels.iter().zip(&circuit.ends) {
            out[*a] += vessel.flow;
            out[*b] -= vessel.flow;
        }
        let inflow = boundary.conditions.iter().map(|(node, _)| out[*node].max(0.0)).sum();
        let network_resilience = if open > 0 { total / open as f64 } else { 0.0 };
        Self { pressure: circuit.pressures(&above_level), vessels, network_resilience, inflow }
    }

    /// How many vessels carry blood.
    pub fn diffused(&self) -> usize {
        self.vessels.iter().filter(|vessel| vessel.diffused).count()
    }

    /// The vessels whose Reynolds number is above [`LAMINAR_LIMIT`], by row, with that number.
    pub fn beyond_laminar(&self) -> impl Iterator<Item = (usize, f64)> {
        let numbers = self.vessels.iter().map(|vessel| vessel.reynolds).enumerate();
        numbers.filter(|(_, reynolds)| *reynolds > LAMINAR_LIMIT)
    }
}

impl VesselState {
    /// A vessel in which nothing flows.
    fn at_rest(tube: &Tube) -> Self {
        Self { resistance: tube.resistance, volume: tube.volume, ..Self::default() }
    }

    /// A vessel along which the pressure drops so much, Pa.
    fn at(drop: f64, tube: &Tube, viscosity: f64) -> Self {
        let flow = drop / tube.resistance;
        let velocity = flow / (PI * tube.radius * tube.radius);
        Self {
            resistance: tube.resistance,
            volume: tube.volume,
            drop,
            flow,
            velocity,
            wall_shear: 4.0 * viscosity * flow.abs() / (PI * tube.radius.powi(3)),
            reynolds: 2.0 * tube.radius * velocity.abs() * BLOOD_DENSITY / viscosity,
            resilience: resilience(drop, flow, tube.volume),
            diffused: true,
        }
    }
}

/// Imbalances below this share of what flows through a node are rounding.
const ENOUGH: f64 = 1e-13;
/// A node through which less than this share of the largest flow passes is at rest, unless a vessel there carries what little it is.
pub const AT_REST: f64 = 1e-12;
/// Each round gains about the digits of a double.
const ROUNDS: usize = 4;

/// Pressures above the level of a circuit by node, Pa, and drops by vessel, Pa.
#[derive(Debug, Clone)]
pub struct Balanced {
    /// By node; `None` in floating components.
    pub above_level: Vec<Option<f64>>,
    /// By vessel, from its first node to its second; zero in floating components.
    pub drop: Vec<f64>,
}

impl Balanced {
    /// The pressures that a solver found for vessels of these conductances (m³/(Pa s), zero where closed), refined where flows do not balance
    /// to 1e-12 of what passes a node; elsewhere they stay as they are, bit for bit. The circuit is that of one sample: its conditions hold.
    /// `solver` is one of that circuit, whatever its conductances.
    pub fn of(circuit: &Circuit, conductance: &[f64], above_level: &[Option<f64>], solver: Option<&BatchSolver>) -> Self {
        debug_assert!(circuit.fixes.is_empty(), "a condition that may not hold");
        let drop = |[a, b]: &[usize; 2]| above_level[*a].zip(above_level[*b]).map_or(0.0, |(a, b)| a - b);
        let mut best = Self { above_level: above_level.to_vec(), drop: circuit.ends.iter().map(drop).collect() };
        let (mut lacking, mut worst) = best.imbalance(circuit, conductance);
        if worst <= 10.0 * ENOUGH {
            return best;
        }
        let total = |lacking: &[f64]| lacking.iter().map(|lack| lack.abs()).sum::<f64>();
        // What is lacking is injected, and the pressures that conditions hold do not change. Compiled once: from round to round only what is injected
        // changes.
        let mut of_changes = Circuit {
            conductance: conductance.to_vec(),
            fixed: circuit.fixed.iter().map(|fixed| fixed.map(|_| 0.0)).collect(),
            level: 0.0,
            ..circuit.clone()
        };
        let solver = solver.map_or_else(|| BatchSolver::for_few(&of_changes), |solver| solver.of_same_graph(&of_changes));
        let Ok(mut solver) = solver else { return best };
        for _ in 0..ROUNDS {
            let before = total(&lacking);
            of_changes.source = lacking;
            solver.inject_as(&of_changes);
            let Ok(change) = solver.above_level(&of_changes, |vessel| conductance[vessel] > 0.0) else { break };
            if !change.iter().flatten().all(|change| change.is_finite()) {
                break;
            }
            let next = best.plus(circuit, &change);
            let (left, now) = next.imbalance(circuit, conductance);
            // In a vessel at rest all of the flow is lacking, so the worst share stays 1 until rounding is gone: the sum tells progress. What small
            // flows lack is lost in the sum beside the rounding of large ones: then the worst share does.
            if total(&left) >= before && now >= worst {
                break;
            }
            (best, lacking, worst) = (next, left, now);
            if worst <= ENOUGH {
                break;
            }
        }
        best
    }

    /// By node what flows in less what flows out, m³/s, zero where the pressure is fixed; and the largest of these over what passes the node.
    fn imbalance(&self, circuit: &Circuit, conductance: &[f64]) -> (Vec<f64>, f64) {
        let (mut lacking, mut through) = (circuit.source.clone(), vec![0.0; circuit.node_count()]);
        let (mut flows, mut known) = (vec![0.0; self.drop.len()], vec![false; self.drop.len()]);
        for (node, pressure) in self.above_level.iter().enumerate() {
            lacking[node] -= circuit.shunt[node] * pressure.unwrap_or(0.0);
            through[node] = f64::abs(lacking[node]);
        }
        let vessels = self.drop.iter().zip(conductance).zip(&circuit.ends).enumerate();
        for (row, ((drop, conductance), [a, b])) in vessels.filter(|(_, (_, [a, b]))| a != b) {
            let flow = drop * conductance;
            lacking[*a] -= flow;
            lacking[*b] += flow;
            through[*a] += flow.abs();
            through[*b] += flow.abs();
            let pressures = [*a, *b].map(|node| self.above_level[node].unwrap_or(0.0) + circuit.level);
            flows[row] = flow.abs();
            known[row] = *conductance > 0.0 && is_diffused(*drop, pressures[0], pressures[1]);
        }
        for (node, lacking) in lacking.iter_mut().enumerate() {
            if circuit.fixed[node].is_some() || self.above_level[node].is_none() {
                *lacking = 0.0;
            }
        }
        let least = AT_REST * largest(&flows, &known).unwrap_or_else(|| through.iter().copied().fold(0.0, f64::max));
        let mut counts: Vec<bool> = through.iter().map(|through| *through > least).collect();
        for (carries, [a, b]) in carrying(circuit, &flows, known).into_iter().zip(&circuit.ends) {
            (counts[*a], counts[*b]) = (counts[*a] || carries, counts[*b] || carries);
        }
        let counted = (0..through.len()).filter(|node| counts[*node]);
        let worst = counted.map(|node| lacking[node].abs() / through[node]).fold(0.0, f64::max);
        (lacking, worst)
    }

    fn plus(&self, circuit: &Circuit, change: &[Option<f64>]) -> Self {
        let pressure = |(pressure, change): (&Option<f64>, &Option<f64>)| pressure.map(|p| p + change.unwrap_or(0.0));
        let drop = |(drop, [a, b]): (&f64, &[usize; 2])| change[*a].zip(change[*b]).map_or(*drop, |(a, b)| drop + (a - b));
        Self {
            above_level: self.above_level.iter().zip(change).map(pressure).collect(),
            drop: self.drop.iter().zip(&circuit.ends).map(drop).collect(),
        }
    }
}

/// The largest finite flow of the vessels that are `known` to carry blood; `None` where nothing is known to flow.
fn largest(flow: &[f64], known: &[bool]) -> Option<f64> {
    let flows = flow.iter().zip(known).filter(|(flow, known)| **known && flow.is_finite()).map(|(flow, _)| *flow);
    Some(flows.fold(0.0, f64::max)).filter(|most| *most > 0.0)
}

/// Which vessels carry blood: those that are `known` to, because the drop along them is beyond rounding; those that carry as much as what is
/// rounding beside the largest known flow, because a wide vessel may carry it along a drop that is rounding; and those that pass on what
/// these carry. Where blood flows at a node, what flows in another vessel there is no rounding if it is not so much less, however little that
/// is beside the largest flow elsewhere; a node whose pressure is fixed tells nothing, because there flows need not balance.
fn carrying(circuit: &Circuit, flow: &[f64], known: Vec<bool>) -> Vec<bool> {
    let rest = largest(flow, &known).map_or(f64::INFINITY, |most| AT_REST * most);
    let mut carries: Vec<bool> = known.into_iter().zip(flow).map(|(known, flow)| known || *flow > rest).collect();
    let doubtful: Vec<usize> = (0..flow.len()).filter(|row| !carries[*row] && flow[*row] > 0.0).collect();
    if doubtful.is_empty() {
        return carries;
    }
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &row in &doubtful {
        for node in circuit.ends[row] {
            at.entry(node).or_default().push(row);
        }
    }
    let mut largest: Vec<f64> = circuit.source.iter().map(|source| source.abs()).collect();
    for row in (0..flow.len()).filter(|row| carries[*row]) {
        for node in circuit.ends[row] {
            largest[node] = largest[node].max(flow[row]);
        }
    }
    let mut next: Vec<usize> = at.keys().rev().copied().collect();
    while let Some(node) = next.pop() {
        let passed = if circuit.fixed[node].is_some() { 0.0 } else { largest[node] };
        for &row in at.get(&node).into_iter().flatten() {
            if passed > 0.0 && !carries[row] && flow[row] > AT_REST * passed {
                carries[row] = true;
                for end in circuit.ends[row] {
                    largest[end] = largest[end].max(flow[row]);
                    next.push(end);
                }
            }
        }
    }
    carries
}
