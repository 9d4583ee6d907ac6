//! The labels of arteries and the states of the atlas: 4 mm pieces along each artery, and one state for what is no artery of the circle.

use crate::circle_of_willis::{Artery, AtlasArtery, BodySide, Direction, IN_ATLAS};

/// An artery of the circle, or [`OTHER`]: sided arteries left then right, then the basilar and the anterior communicating artery.
pub type ArteryLabel = usize;
/// A piece of an artery, or [`NOWHERE`].
pub type AtlasState = usize;

/// The length of a state along its artery, mm.
pub const BIN: f64 = 4.0;

/// The sided arteries that the atlas holds.
const SIDED: usize = IN_ATLAS.len() - 2;

/// How many labels there are, [`OTHER`] included.
pub const LABELS: usize = 2 * SIDED + 3;
/// No artery of the circle.
pub const OTHER: ArteryLabel = LABELS - 1;
/// The basilar artery.
pub const BA: ArteryLabel = 2 * SIDED;
/// How many states there are, [`NOWHERE`] included.
pub const STATES: usize = {
    let (mut states, mut family) = (1, 0);
    while family < IN_ATLAS.len() {
        states += if family < SIDED { 2 } else { 1 } * IN_ATLAS[family].bins;
        family += 1;
    }
    states
};
/// The state of what is no artery of the circle.
pub const NOWHERE: AtlasState = STATES - 1;

/// The label of an artery; [`OTHER`] of one that the atlas does not hold.
pub fn label_of(artery: Artery) -> ArteryLabel {
    (0..OTHER).find(|label| artery_of(*label) == Some(artery)).unwrap_or(OTHER)
}

/// The artery of a label; `None` of [`OTHER`].
pub fn artery_of(label: ArteryLabel) -> Option<Artery> {
    let side = BodySide::BOTH[if label < 2 * SIDED { label % 2 } else { 0 }];
    (label != OTHER).then(|| (in_atlas(label).artery)(side))
}

/// The label under which M2 counts as M1.
pub fn as_one_with_m1(of: ArteryLabel) -> ArteryLabel {
    if let Some(Artery::M2(side)) = artery_of(of) { label_of(Artery::M1(side)) } else { of }
}

/// The label of the highest probability, the first of equals.
pub fn most_probable(p: &[f64; LABELS]) -> ArteryLabel {
    (0..LABELS).fold(0, |best, label| if p[label] > p[best] { label } else { best })
}

/// The artery of a label without its side.
fn in_atlas(label: ArteryLabel) -> &'static AtlasArtery {
    &IN_ATLAS[if label < 2 * SIDED { label / 2 } else { label - SIDED }]
}

/// The name that willis writes: `L-M2`, `BA`, `other`.
pub fn name_of(label: ArteryLabel) -> String {
    artery_of(label).map_or_else(|| "other".to_owned(), |artery| artery.to_string())
}

/// The label of a name that willis writes.
pub fn label_named(name: &str) -> Option<ArteryLabel> {
    (0..LABELS).find(|label| name_of(*label) == name)
}

/// The label on the other side.
pub fn mirrored(label: ArteryLabel) -> ArteryLabel {
    artery_of(label).map_or(label, |artery| label_of(artery.opposite()))
}

/// The first state of a label.
pub fn first_state(label: ArteryLabel) -> AtlasState {
    (0..label).map(bins_of).sum()
}

/// How many states a label has.
pub fn bins_of(label: ArteryLabel) -> usize {
    if label == OTHER { 1 } else { in_atlas(label).bins }
}

/// The states of a label.
pub fn states_of(label: ArteryLabel) -> std::ops::Range<AtlasState> {
    first_state(label)..first_state(label) + bins_of(label)
}

/// The state at a distance (mm) along an artery from its reference end.
pub fn state_at(label: ArteryLabel, along: f64) -> AtlasState {
    first_state(label) + ((along / BIN) as usize).min(bins_of(label) - 1)
}

/// Whether the reference end of the first label is where the second one begins or ends.
pub fn begins_at(label: ArteryLabel, other: ArteryLabel) -> bool {
    let begins = |artery: Artery| in_atlas(label).begins_at.iter().any(|at| BodySide::BOTH.map(at).contains(&artery));
    label != OTHER && artery_of(other).is_some_and(begins)
}

/// Where the reference end of a label lies if no artery at it is traced.
pub fn begins(label: ArteryLabel) -> Direction {
    if label == OTHER { Direction::Up } else { in_atlas(label).begins }
}

/// Tables over the states.
#[derive(Debug, Clone)]
pub struct StateTables {
    /// The label of each state.
    pub label: Vec<ArteryLabel>,
    /// The state's number within its label.
    pub bin: Vec<usize>,
    /// The state on the other side.
    pub mirrored: Vec<AtlasState>,
    /// Whether only one stretch of a patient's arteries can be in the state: not M2, of which there are several, and not a last state,
    /// which has no end.
    pub once: Vec<bool>,
}

impl Default for StateTables {
    /// The tables.
    fn default() -> Self {
        let all: Vec<(ArteryLabel, usize)> =
            (0..LABELS).flat_map(|label| (0..bins_of(label)).map(move |bin| (label, bin))).collect();
        Self {
            label: all.iter().map(|(label, _)| *label).collect(),
            bin: all.iter().map(|(_, bin)| *bin).collect(),
            mirrored: all.iter().map(|(label, bin)| first_state(mirrored(*label)) + bin).collect(),
            once: all
                .iter()
                .map(|(label, bin)| match artery_of(*label) {
                    None | Some(Artery::M2(_)) => false,
                    Some(artery) => artery == Artery::AComm || bin + 1 < bins_of(*label),
                })
                .collect(),
        }
    }
}

impl StateTables {
    /// Two neighbours in either order, and their mirror images.
    pub fn alike(&self, a: AtlasState, b: AtlasState) -> [(AtlasState, AtlasState); 4] {
        let (ma, mb) = (self.mirrored[a], self.mirrored[b]);
        [(a, b), (b, a), (ma, mb), (mb, ma)]
    }

    /// The mirror image of a bifurcation, whose arms are in order.
    pub fn mirrored_bifurcation(&self, arms: [AtlasState; 3], middle: AtlasState) -> ([AtlasState; 3], AtlasState) {
        let mut arms = arms.map(|state| self.mirrored[state]);
        arms.sort_unstable();
        (arms, self.mirrored[middle])
    }

    /// The state so many bins further along the same artery, or none.
    pub fn step(&self, state: AtlasState, bins: isize) -> Option<AtlasState> {
        let to = state.checked_add_signed(bins)?;
        (to < STATES && self.label[to] == self.label[state]).then_some(to)
    }
}
