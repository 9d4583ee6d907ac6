//! Thins a mask to a skeleton of the same topology.
//!
//! Border voxels go from one of six directions after the other, as long as they are simple (their removal changes no component, no
//! tunnel and no cavity of 26-connected vessels in a 6-connected background) and no ends of a line. The order of directions and of
//! voxels is that of scikit-image on the array that nibabel makes of a file in RAS. As there, a voxel is tested again right before it
//! goes. Unlike there, this second test is for all that makes a voxel simple, and of voxels that follow each other and have become
//! ends only two go: no line is undone from its end, and none of more than one voxel becomes a point. Source: Lee, Kashyap and Chu,
//! "Building skeleton models via 3-D medial surface/axis thinning algorithms", CVGIP 56 (1994); simple voxels: Malandain and Bertrand,
//! "Fast characterization of 3D simple points" (1992).

use super::foreground::{Foreground, neighbours};

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

    /// Whether these neighbours are two that touch.
    fn is_pair(&self, neighbours: u32) -> bool {
        neighbours.count_ones() == 2 && self.touching[neighbours.trailing_zeros() as usize] & neighbours != 0
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

/// The bit of a voxel's state that says it is there; the six lowest say for which directions it has to be tested.
const THERE: u8 = 1 << 7;
const ALL: u8 = (1 << DIRECTIONS.len()) - 1;
/// Voxels that have become ends and go in one pass, one after the other. A voxel that is gone keeps their number until the pass is over.
const MOST_ENDS: u8 = 2;

/// The rows of the voxels that make the skeleton, in their order.
///
/// A voxel is tested for a direction once, and again only after one of its neighbours went: the cost goes with the voxels that go.
pub fn thin(vessels: &Foreground) -> Vec<u32> {
    let tables = Neighbourhoods::new();
    let strides = vessels.strides();
    let around = neighbours(strides);
    let mut state = vec![0_u8; vessels.box_size()];
    vessels.places().for_each(|place| state[place] = THERE);
    let bits_at = |state: &[u8], place: usize| {
        let mut bits = 0;
        for z in 0..3 {
            for y in 0..3 {
                let line = place + z * strides[2] + y * strides[1] - strides[2] - strides[1] - 1;
                for (x, state) in state[line..line + 3].iter().enumerate() {
                    bits |= u32::from(state >> 7) << (x + 3 * y + 9 * z);
                }
            }
        }
        bits & !SELF
    };
    // The places of the voxels that have to be tested for some direction, rising. At first those with background beside them.
    let is_border =
        |place: &usize| strides.iter().any(|stride| !vessels.contains(place + stride) || !vessels.contains(place - stride));
    let mut open: Vec<u32> = vessels.places().filter(is_border).map(|place| place as u32).collect();
    for place in &open {
        state[*place as usize] |= ALL;
    }
    let (mut candidates, mut fresh, mut marked) = (Vec::new(), Vec::new(), Vec::new());
    while !open.is_empty() {
        for (direction, (axis, forward)) in DIRECTIONS.into_iter().enumerate() {
            candidates.clear();
            for place in open.iter().map(|place| *place as usize) {
                if state[place] >> direction & 1 == 0 {
                    continue;
                }
                state[place] &= !(1 << direction);
                let beside = if forward { place + strides[axis] } else { place - strides[axis] };
                let bits = bits_at(&state, place);
                if state[beside] & THERE == 0 && !bits.is_power_of_two() && tables.is_simple(bits) {
                    candidates.push(place);
                }
            }
            for place in &candidates {
                let bits = bits_at(&state, *place);
                let near = around.map(|(step, _)| (*place as isize + step) as usize);
                // The marks of what went in this pass beside it: 0 for most.
                let before = near.iter().map(|next| state[*next]).filter(|mark| mark & THERE == 0).max().unwrap_or(0);
                let is_end = bits.is_power_of_two();
                // The end of a line, or the last voxel across the end of a band of them.
                let is_tip = is_end || tables.is_pair(bits);
                let is_last = || near.iter().any(|next| state[*next] & THERE != 0 && bits_at(&state, *next).is_power_of_two());
                if tables.is_simple(bits) && !(is_tip && before == MOST_ENDS || is_end && is_last()) {
                    let mark = before + u8::from(is_tip);
                    state[*place] = mark;
                    marked.extend((mark > 0).then_some(*place));
                    for next in near {
                        if state[next] & THERE != 0 {
                            if state[next] & ALL == 0 {
                                fresh.push(next as u32);
                            }
                            state[next] |= ALL;
                        }
                    }
                }
            }
            marked.drain(..).for_each(|place| state[place] = 0);
            // Those done with leave, those that a neighbour left behind enter. One may be in both lists: tested for the last direction,
            // then opened again.
            open.retain(|place| state[*place as usize] & ALL != 0);
            if !fresh.is_empty() {
                open.append(&mut fresh);
                open.sort_unstable();
                open.dedup();
            }
        }
    }
    (0_u32..).zip(vessels.places()).filter(|(_, place)| state[*place] != 0).map(|(row, _)| row).collect()
}
