//! The published network of the Circle of Willis and its feeding arteries, as one table.
//!
//! Alastruey, Parker, Peiró, Byrd, Sherwin, *Modelling the circle of Willis to assess the effects of anatomical
//! variations and occlusions on cerebral flows*, J Biomech 40:1794-1805 (2007), table 1: 33 vessels between 30 nodes,
//! one inlet (the aortic root) and 11 outlets with a terminal resistance each. The radius is constant along a vessel.

use std::str::FromStr;
use std::sync::LazyLock;

use super::curve::Bow;
use willis_core::network::units::metres;
use willis_core::support::geometry::Point;

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArteryRow {
    /// The usual name with its side. The whole middle cerebral artery is called M1.
    pub label: &'static str,
    /// The table's numbers of the two nodes, counted from 1.
    pub nodes: [usize; 2],
    /// Length, m.
    pub length: f64,
    /// Radius, m.
    pub radius: f64,
    /// Peripheral resistance at the second node, Pa s/m³, if the vessel ends there.
    pub terminal: Option<f64>,
    /// How it curves between its nodes, which the table does not say.
    pub bow: Bow,
}

/// The table's number of the aortic root, the inlet.
pub const ROOT: usize = 1;

/// The 33 vessels in the order of the table.
pub static TABLE: LazyLock<Vec<ArteryRow>> = LazyLock::new(|| {
    let row = |line: &'static str| {
        let columns: Vec<&str> = line.split(',').collect();
        ArteryRow {
            label: columns[0],
            nodes: [number(columns[1]), number(columns[2])],
            length: number(columns[3]),
            radius: number(columns[4]),
            terminal: (!columns[5].is_empty()).then(|| number(columns[5])),
            bow: Bow { side: [number(columns[6]), number(columns[7]), number(columns[8])], swings: number(columns[9]) },
        }
    };
    include_str!("alastruey_vessels.csv").lines().skip(1).map(row).collect()
});

/// The positions of the table's nodes 1 to 30, m.
pub(crate) static POSITIONS: LazyLock<Vec<Point>> = LazyLock::new(|| {
    let row = |line: &str| {
        let columns: Vec<f64> = line.split(',').take(3).map(number).collect();
        [0, 1, 2].map(|axis| metres(columns[axis]))
    };
    include_str!("alastruey_nodes.csv").lines().skip(1).map(row).collect()
});

/// A number of a table. The tables are part of the program, and every row of them is read with the first phantom: nothing that a user gives gets here.
fn number<T: FromStr>(word: &str) -> T {
    word.parse().unwrap_or_else(|_| panic!("{word} is no number"))
}
