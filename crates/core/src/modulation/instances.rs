//! The instances of one class: the pressures, flows and other figures of each.

use std::f64::consts::PI;

use crate::flow::state::State;
use crate::flow::{Factors, Tube};
use crate::support::Distribution;

/// The figures of the instances of a class. A table has one row per instance; a row has one figure per node or vessel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Instances {
    /// By node, Pa; NaN in floating components.
    pub pressure: Vec<f64>,
    /// Pressure drop by vessel, Pa, positive from its first node to its second.
    pub drop: Vec<f64>,
    /// Flow by vessel, m³/s, with the sign of the drop.
    pub flow: Vec<f64>,
    /// Resilience by vessel, W/m³.
    pub resilience: Vec<f64>,
    /// Hypertension force by vessel, Pa/m²; NaN in floating components.
    pub force: Vec<f64>,
    /// The factor that multiplied the resistance, by vessel.
    pub resistance_factor: Vec<f64>,
    /// The factor that multiplied the radius, by vessel.
    pub radius_factor: Vec<f64>,
    /// The factor that multiplied the length, by vessel.
    pub length_factor: Vec<f64>,
    /// ρ_G by instance, W/m³.
    pub network_resilience: Vec<f64>,
    /// The total inflow through the nodes with a boundary condition, by instance, m³/s.
    pub inflow: Vec<f64>,
}

impl Instances {
    /// Adds an instance.
    pub fn push(&mut self, state: &State, tubes: &[Tube], factors: &[Factors], ends: &[[usize; 2]]) {
        self.pressure.extend(state.pressure.iter().map(|p| p.unwrap_or(f64::NAN)));
        self.drop.extend(state.vessels.iter().map(|v| v.drop));
        self.flow.extend(state.vessels.iter().map(|v| v.flow));
        self.resilience.extend(state.vessels.iter().map(|v| v.resilience));
        self.force
            .extend(tubes.iter().zip(ends).map(|(tube, ends)| hypertension_force(ends.map(|n| state.pressure[n]), tube.radius)));
        self.resistance_factor.extend(factors.iter().map(|f| f.resistance));
        self.radius_factor.extend(factors.iter().map(|f| f.radius));
        self.length_factor.extend(factors.iter().map(|f| f.length));
        self.network_resilience.push(state.network_resilience);
        self.inflow.push(state.inflow);
    }

    /// Adds the instances of a later block.
    pub fn append(&mut self, mut later: Self) {
        for (table, later) in self.tables().into_iter().zip(later.tables()) {
            table.append(later);
        }
    }

    fn tables(&mut self) -> [&mut Vec<f64>; 10] {
        let Self { pressure, drop, flow, resilience, force, .. } = self;
        let Self { resistance_factor, radius_factor, length_factor, network_resilience, inflow, .. } = self;
        [pressure, drop, flow, resilience, force, resistance_factor, radius_factor, length_factor, network_resilience, inflow]
    }

    /// How many instances there are.
    pub fn count(&self) -> usize {
        self.inflow.len()
    }

    /// The distribution of one column of a table with `width` figures per instance, over the instances; `unit` converts each figure.
    pub fn column(table: &[f64], width: usize, at: usize, unit: impl Fn(f64) -> f64) -> Distribution {
        Distribution::of(table.iter().skip(at).step_by(width).map(|x| unit(*x)).collect())
    }

    /// For each instance of a table with `width` figures per instance, the mean of `figure` over the columns that `counts` selects;
    /// NaN figures are left out.
    pub fn means(table: &[f64], width: usize, counts: &[bool], figure: impl Fn(f64) -> f64) -> Vec<f64> {
        let mean = |row: &[f64]| mean_of(row.iter().zip(counts).filter(|(_, counts)| **counts).map(|(x, _)| figure(*x)));
        table.chunks_exact(width).map(mean).collect()
    }
}

/// The hypertension force of a vessel, Pa/m²: the mean of the pressures (Pa) at its two ends divided by its cross-section π r², with
/// the radius r (m) where it is narrowest. The paper calls it a force; it is large in a thin vessel. NaN without pressures.
pub fn hypertension_force(ends: [Option<f64>; 2], radius: f64) -> f64 {
    match ends {
        [Some(a), Some(b)] => f64::midpoint(a, b) / (PI * radius * radius),
        _ => f64::NAN,
    }
}

/// The mean without NaN figures; NaN when all are.
fn mean_of(figures: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = figures.filter(|x| !x.is_nan()).fold((0.0, 0.0), |(sum, n), x| (sum + x, n + 1.0));
    sum / n
}
