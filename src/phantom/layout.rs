//! Where the vessels of the published table lie: node positions and bows, ours, within the table's lengths.
//!
//! Axes as in NIfTI (RAS): +x right, +y anterior, +z superior; mm. The heart is near the origin,
//! the circle at the skull base 20 cm above. The table gives lengths only: its route by the carotids (38 cm from the arch to
//! the circle) is far longer than that by the vertebrals (25 cm), so the carotids meander. The two sides are mirror
//! images from the carotid bifurcations up.

use super::curve::Bow;
use crate::geometry::Point;

/// The positions of the table's nodes 1 to 30, mm.
const NODES: [Point; super::alastruey::NODES] = [
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

/// The position (m) of a node by the table's number, counted from 1.
pub(super) fn position(number: usize) -> Point {
    NODES[number - 1].map(crate::units::metres)
}

/// How a vessel of the table bows out between its nodes.
pub(super) fn bow(label: &str) -> Bow {
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
