//! What no node and no vessel can have: a program may make a network that holds it, readers let none of it pass.

use std::collections::HashSet;

use super::units::MOST_METRES;
use super::{Condition, Network, Node, Vessel, Wall, is_radius};
use crate::error::{Error, Result, ensure};

/// A figure (SI) with its name, and what it has to be, in words too.
type CheckedFigure = (&'static str, Option<f64>, (fn(f64) -> bool, &'static str));

const FINITE: (fn(f64) -> bool, &str) = (f64::is_finite, "expected a finite number");
const WITHIN_REACH: (fn(f64) -> bool, &str) = (|x| x.abs() <= MOST_METRES, "expected one within 1e9 m");
const POSITIVE: (fn(f64) -> bool, &str) = (is_radius, "expected a positive number");
const NOT_NEGATIVE: (fn(f64) -> bool, &str) = (|x| x.is_finite() && x >= 0.0, "expected zero or a positive number");
const SHARE: (fn(f64) -> bool, &str) = (|x| (0.0..=1.0).contains(&x), "expected a number from 0 to 1");

impl Network {
    /// Refuses what no network of a file has: figures that are not finite or not positive where they have to be, priors and probabilities
    /// beyond 1, an id that two nodes have. Every function that takes an input does so.
    ///
    /// # Errors
    ///
    /// Names the node or the vessel, the figure in SI units, and what is accepted.
    pub fn validate(&self) -> Result<()> {
        let mut ids = HashSet::with_capacity(self.node_count());
        for (row, node) in self.nodes().enumerate() {
            let name = || format!("node {row} ({})", node.id);
            let accepted = "an earlier node has this id; expected one of its own";
            ensure(ids.insert(&node.id), || Error::parameter(name(), "", accepted))?;
            refuse(of_node(node).into_iter().chain(places(node.position)), name)?;
        }
        for (row, ([a, b], vessel)) in self.vessels().enumerate() {
            let along = vessel
                .path
                .iter()
                .flat_map(|point| places(Some(point.position)).chain([("radius of a point", Some(point.radius), POSITIVE)]));
            refuse(of_vessel(vessel, a == b).into_iter().chain(along), || self.vessel_name(row))?;
        }
        Ok(())
    }
}

/// Refuses the first figure that is not what it has to be.
fn refuse(mut figures: impl Iterator<Item = CheckedFigure>, name: impl Fn() -> String) -> Result<()> {
    let wrong = figures.find_map(|(of, x, (is_right, accepted))| Some((of, x.filter(|x| !is_right(*x))?, accepted)));
    wrong.map_or(Ok(()), |(of, x, accepted)| Err(Error::parameter(name(), format!("{of} {x}"), accepted)))
}

fn places(at: Option<[f64; 3]>) -> impl Iterator<Item = CheckedFigure> {
    at.into_iter().flatten().map(|x| ("coordinate", Some(x), WITHIN_REACH))
}

fn of_node(node: &Node) -> [CheckedFigure; 6] {
    let [resistance, level] = match node.condition {
        Some(Condition::Pressure(x) | Condition::Flow(x)) => [None, Some(x)],
        Some(Condition::Resistance { resistance, venous }) => [Some(resistance), Some(venous)],
        None => [None; 2],
    };
    let windkessel = node.windkessel();
    [
        ("radius", node.radius, POSITIVE),
        ("condition", level, FINITE),
        ("resistance", resistance, POSITIVE),
        ("proximal resistance", windkessel.proximal, NOT_NEGATIVE),
        ("compliance", windkessel.compliance, POSITIVE),
        ("root_score", node.root_score, NOT_NEGATIVE),
    ]
}

fn of_vessel(vessel: &Vessel, is_loop: bool) -> [CheckedFigure; 11] {
    let wall = match vessel.wall {
        Some(Wall::Speed(speed)) => [Some(speed), None],
        Some(Wall::Elastic { young, thickness }) => [Some(young), Some(thickness)],
        None => [None; 2],
    };
    let evidence = vessel.evidence.as_deref();
    let [attached, odds] = [evidence.map(|e| e.attached), evidence.map(|e| e.continuation_odds)];
    [
        ("length", Some(vessel.length), if is_loop { NOT_NEGATIVE } else { POSITIVE }),
        ("radius", Some(vessel.radius), POSITIVE),
        ("resistance", vessel.resistance, POSITIVE),
        ("prior", Some(vessel.prior), SHARE),
        ("wall", wall[0], POSITIVE),
        ("wall", wall[1], POSITIVE),
        ("probability", evidence.map(|e| e.probability), SHARE),
        ("attached", attached.map(|of| of[0]), SHARE),
        ("attached", attached.map(|of| of[1]), SHARE),
        ("continuation_odds", odds.map(|of| of[0]), NOT_NEGATIVE),
        ("continuation_odds", odds.map(|of| of[1]), NOT_NEGATIVE),
    ]
}
