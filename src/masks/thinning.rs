//! Thins a mask to a skeleton of the same topology.
//!
//! Border voxels go from one of six directions after the other, as long as they are simple (their removal changes no component, no
//! tunnel and no cavity of 26-connected vessels in a 6-connected background) and no ends of a line. The order of directions and of
//! voxels is that of scikit-image, on an image whose last axis is x. Unlike there, a voxel is tested for all of this again right
//! before it goes. Source: Lee, Kashyap and Chu, "Building skeleton models via 3-D medial surface/axis thinning algorithms", CVGIP
//! 56 (1994); simple voxels: Malandain and Bertrand, "Fast characterization of 3D simple points" (1992).

use super::foreground::Foreground;

/// The bit of the voxel itself in a neighbourhood of 27.
const SELF: u32 = 1 << 13;
/// The directions in which the background is looked for: an axis, and whether forward.
const DIRECTIONS: [(usize, bool); 6] = [(1, false), (1, true), (0, true), (0, false), (2, true), (2, false)];

/// Neighbourhoods as 27 bits: voxel (x, y, z) of -1, 0, 1 is bit x + 1 + 3 (y + 1) + 9 (z + 1).
struct Neighbourhoods {
    /// Bits that touch a bit by a face, an edge or a corner.
    touching: [u32; 27],
    /// Bits that touch a bit by a face, among those that touch the centre by a face or an edge.
    beside: [u32; 27],
    /// The six that touch the centre by a face.
    faces: u32,
    /// The eighteen that touch the centre by a face or an edge.
    eighteen: u32,
}

impl Neighbourhoods {
    fn new() -> Self {
        let at = |bit: usize| [bit % 3, bit / 3 % 3, bit / 9].map(|x| x as i32 - 1);
        let apart = |a: usize, b: usize| {
            let by = [0, 1, 2].map(|axis| (at(a)[axis] - at(b)[axis]).abs());
            (by.iter().copied().max().unwrap_or(0), by.iter().sum::<i32>())
        };
        let those = |is: &dyn Fn(usize) -> bool| (0..27).filter(|bit| *bit != 13 && is(*bit)).fold(0, |all, bit| all | 1 << bit);
        let eighteen = those(&|bit| apart(bit, 13).1 <= 2);
        Self {
            touching: std::array::from_fn(|a| those(&|b| b != a && apart(a, b).0 == 1)),
            beside: std::array::from_fn(|a| those(&|b| apart(a, b).1 == 1) & eighteen),
            faces: those(&|bit| apart(bit, 13).1 == 1),
            eighteen,
        }
    }

    /// Whether a voxel with these neighbours is simple.
    fn is_simple(&self, neighbours: u32) -> bool {
        let background = !neighbours & self.eighteen;
        let open = background & self.faces;
        neighbours != 0
            && open != 0
            && reached(neighbours, neighbours, &self.touching) == neighbours
            && reached(open, background, &self.beside) & open == open
    }
}

/// The bits that the lowest of `start` reaches within `allowed`.
fn reached(start: u32, allowed: u32, next_to: &[u32; 27]) -> u32 {
    let mut found = start & start.wrapping_neg();
    let mut fresh = found;
    while fresh != 0 {
        let bit = fresh.trailing_zeros() as usize;
        fresh &= fresh - 1;
        let more = next_to[bit] & allowed & !found;
        found |= more;
        fresh |= more;
    }
    found
}

/// The rows of the voxels that make the skeleton, in their order.
pub fn thin(vessels: &Foreground) -> Vec<u32> {
    let tables = Neighbourhoods::new();
    let strides = vessels.strides();
    let mut there = vec![false; vessels.box_size()];
    vessels.places.iter().for_each(|place| there[*place as usize] = true);
    let neighbours = |there: &[bool], place: usize| {
        let mut bits = 0;
        for z in 0..3 {
            for y in 0..3 {
                let line = place + z * strides[2] + y * strides[1] - strides[2] - strides[1] - 1;
                for (x, is) in there[line..line + 3].iter().enumerate() {
                    bits |= u32::from(*is) << (x + 3 * y + 9 * z);
                }
            }
        }
        bits & !SELF
    };
    let may_go = |bits: u32| bits.count_ones() != 1 && tables.is_simple(bits);
    let mut left: Vec<u32> = (0..vessels.len() as u32).collect();
    let mut candidates = Vec::new();
    loop {
        let before = left.len();
        for (axis, forward) in DIRECTIONS {
            candidates.clear();
            for row in &left {
                let place = vessels.places[*row as usize] as usize;
                let beside = if forward { place + strides[axis] } else { place - strides[axis] };
                if !there[beside] && may_go(neighbours(&there, place)) {
                    candidates.push(place);
                }
            }
            for place in &candidates {
                if may_go(neighbours(&there, *place)) {
                    there[*place] = false;
                }
            }
            if !candidates.is_empty() {
                left.retain(|row| there[vessels.places[*row as usize] as usize]);
            }
        }
        if left.len() == before {
            return left;
        }
    }
}
