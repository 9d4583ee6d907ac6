//! The published network of the Circle of Willis and its feeding arteries, as one table.
//!
//! Alastruey, Parker, Peiró, Byrd, Sherwin, *Modelling the circle of Willis to assess the effects of anatomical
//! variations and occlusions on cerebral flows*, J Biomech 40:1794-1805 (2007), table 1: 33 vessels between 30 nodes,
//! one inlet (the aortic root) and 11 outlets with a terminal resistance each. The radius is constant along a vessel.

use super::curve::Bow;
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
}

/// How many nodes the table has.
pub const NODES: usize = 30;

/// The table's number of the aortic root, the inlet.
pub const ROOT: usize = 1;

/// The 33 vessels in the order of the table.
pub const TABLE: [ArteryRow; 33] = [
    inner("Ascending aorta", 1, 2, 0.04, 0.012),
    inner("Aortic arch I", 2, 3, 0.02, 0.0112),
    inner("Brachiocephalic", 2, 4, 0.034, 0.0062),
    inner("Aortic arch II", 3, 5, 0.039, 0.0107),
    inner("L-CCA", 3, 6, 0.208, 0.0025),
    inner("R-CCA", 4, 7, 0.177, 0.0025),
    inner("R-SCA", 4, 8, 0.034, 0.00423),
    end("Thoracic aorta", 5, 9, 0.156, 0.00999, 1.8e8),
    inner("L-SCA", 5, 10, 0.034, 0.00423),
    end("L-ECA", 6, 11, 0.177, 0.0015, 5.43e9),
    inner("L-ICA I", 6, 12, 0.177, 0.002),
    inner("R-ICA I", 7, 13, 0.177, 0.002),
    end("R-ECA", 7, 14, 0.177, 0.0015, 5.43e9),
    inner("R-VA", 8, 15, 0.148, 0.00136),
    end("R-Brachial", 8, 16, 0.422, 0.00403, 2.68e9),
    end("L-Brachial", 10, 17, 0.422, 0.00403, 2.68e9),
    inner("L-VA", 10, 15, 0.148, 0.00136),
    inner("L-ICA II", 12, 18, 0.005, 0.002),
    inner("L-PComm", 19, 12, 0.015, 0.00073),
    inner("R-PComm", 20, 13, 0.015, 0.00073),
    inner("R-ICA II", 13, 21, 0.005, 0.002),
    inner("BA", 15, 22, 0.029, 0.00162),
    end("L-M1", 18, 23, 0.119, 0.00143, 5.97e9),
    end("R-M1", 21, 24, 0.119, 0.00143, 5.97e9),
    inner("L-A1", 18, 25, 0.012, 0.00117),
    inner("R-A1", 21, 26, 0.012, 0.00117),
    inner("L-P1", 22, 19, 0.005, 0.00107),
    inner("R-P1", 22, 20, 0.005, 0.00107),
    end("L-A2", 25, 27, 0.103, 0.0012, 8.48e9),
    end("R-A2", 26, 28, 0.103, 0.0012, 8.48e9),
    inner("AComm", 25, 26, 0.003, 0.00074),
    end("L-P2", 19, 29, 0.086, 0.00105, 1.108e10),
    end("R-P2", 20, 30, 0.086, 0.00105, 1.108e10),
];

const fn inner(label: &'static str, from: usize, to: usize, length: f64, radius: f64) -> ArteryRow {
    ArteryRow { label, nodes: [from, to], length, radius, terminal: None }
}

const fn end(label: &'static str, from: usize, to: usize, length: f64, radius: f64, resistance: f64) -> ArteryRow {
    ArteryRow { label, nodes: [from, to], length, radius, terminal: Some(resistance) }
}

/// The positions of the table's nodes 1 to 30, mm.
const POSITIONS: [Point; NODES] = [
    [-6.0, 20.0, -42.0],   // 1 aortic root
    [11.0, 16.0, -8.0],    // 2 arch, brachiocephalic
    [-3.0, 6.0, 1.5],      // 3 arch, left common carotid
    [18.0, 6.0, 23.0],     // 4 end of the brachiocephalic
    [-18.0, -27.0, 8.0],   // 5 arch, left subclavian
    [-44.0, 16.0, 112.0],  // 6 left carotid bifurcation
    [44.0, 16.0, 112.0],   // 7 right carotid bifurcation
    [42.0, -8.0, 41.0],    // 8 right subclavian, vertebral
    [-6.0, -40.0, -142.0], // 9 end of the thoracic aorta
    [-33.0, -16.0, 36.0],  // 10 left subclavian, vertebral
    [-72.0, 22.0, 268.0],  // 11 end of the left external carotid
    [-9.0, 5.0, 197.5],    // 12 left internal carotid, posterior communicating
    [9.0, 5.0, 197.5],     // 13 right internal carotid, posterior communicating
    [72.0, 22.0, 268.0],   // 14 end of the right external carotid
    [0.0, -17.0, 172.0],   // 15 vertebrobasilar junction
    [185.0, 0.0, -300.0],  // 16 end of the right brachial
    [-185.0, 0.0, -300.0], // 17 end of the left brachial
    [-10.5, 6.8, 201.7],   // 18 end of the left internal carotid
    [-4.5, -6.5, 199.5],   // 19 left posterior cerebral, posterior communicating
    [4.5, -6.5, 199.5],    // 20 right posterior cerebral, posterior communicating
    [10.5, 6.8, 201.7],    // 21 end of the right internal carotid
    [0.0, -8.0, 198.5],    // 22 basilar tip
    [-62.0, -56.0, 242.5], // 23 end of the left middle cerebral
    [62.0, -56.0, 242.5],  // 24 end of the right middle cerebral
    [-1.45, 12.8, 204.5],  // 25 left anterior cerebral, anterior communicating
    [1.45, 12.8, 204.5],   // 26 right anterior cerebral, anterior communicating
    [-4.0, -32.0, 264.5],  // 27 end of the left anterior cerebral
    [4.0, -32.0, 264.5],   // 28 end of the right anterior cerebral
    [-14.0, -74.0, 206.5], // 29 end of the left posterior cerebral
    [14.0, -74.0, 206.5],  // 30 end of the right posterior cerebral
];

/// The position (m) of a node by its number in the table, from 1.
pub(crate) fn position(number: usize) -> Point {
    POSITIONS[number - 1].map(willis_core::network::units::metres)
}

/// How a vessel of the table curves between its nodes.
pub(crate) fn bow(label: &str) -> Bow {
    let (mirror, name) = match label.split_once('-') {
        Some(("L", name)) => (-1.0, name),
        Some(("R", name)) => (1.0, name),
        _ => (1.0, label),
    };
    let (side, swings) = match name {
        "Ascending aorta" => ([1.0, 1.0, 0.0], 1),
        "Brachiocephalic" | "ICA II" => ([1.0, 0.0, 0.0], 1),
        "Aortic arch II" => ([-0.3, 0.0, 1.0], 1),
        "CCA" => ([1.0, 0.5, 0.0], 3),
        "ICA I" => ([1.0, 1.0, 0.0], 3),
        "ECA" => ([1.0, 0.5, 0.0], 1),
        "VA" => ([1.0, -0.6, 0.0], 1),
        "Brachial" => ([1.0, 0.0, 0.5], 1),
        "Thoracic aorta" => ([-1.0, 0.0, 0.0], 1),
        "PComm" => ([1.0, 0.0, -1.0], 1),
        "BA" | "AComm" => ([0.0, 1.0, 0.0], 1),
        "M1" => ([0.3, 0.5, 1.0], 1),
        "A2" => ([0.0, 1.0, 0.3], 1),
        "P2" => ([1.0, 0.0, -0.3], 1),
        _ => ([0.0, 0.0, 1.0], 1), // arch I, the subclavians, A1, P1
    };
    Bow { side: [mirror * side[0], side[1], side[2]], swings }
}
