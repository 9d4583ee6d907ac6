//! The labels of arteries and the states of the atlas: 4 mm pieces along each artery, and one state for what is no artery of the circle.

use crate::circle_of_willis::{Artery, BodySide, RING};

/// An artery of the circle, or [`OTHER`]: sided arteries left then right, then the basilar and the anterior communicating artery.
pub type ArteryLabel = usize;
/// A piece of an artery, or [`NOWHERE`].
pub type AtlasState = usize;

/// The length of a state along its artery, mm.
pub const BIN: f64 = 4.0;

/// How an artery is cut into states, and where its first state lies.
struct Family {
    name: &'static str,
    /// How many states it has; the last one takes all that is further.
    bins: usize,
    /// Arteries at its reference end, from which distances along it are counted.
    begins_at: &'static [&'static str],
    /// Where the reference end lies if none of them is traced: up, down, in front, towards the middle, or to the side.
    begins: Direction,
}

/// A direction in the head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Superior.
    Up,
    /// Inferior.
    Down,
    /// Anterior.
    Front,
    /// Towards the midline.
    Medial,
    /// Away from the midline.
    Lateral,
}

const fn family(name: &'static str, bins: usize, begins_at: &'static [&'static str], begins: Direction) -> Family {
    Family { name, bins, begins_at, begins }
}

/// Sided arteries first.
const FAMILIES: [Family; 10] = [
    family("ICA", 12, &["M1", "A1"], Direction::Up),
    family("M1", 6, &["ICA", "A1"], Direction::Medial),
    family("M2", 8, &["M1"], Direction::Medial),
    family("A1", 5, &["ICA", "M1"], Direction::Lateral),
    family("A2", 6, &["A1", "AComm"], Direction::Down),
    family("P1", 4, &["BA"], Direction::Medial),
    family("P2", 7, &["P1", "PComm"], Direction::Front),
    family("PComm", 4, &["ICA"], Direction::Front),
    family("BA", 7, &["P1"], Direction::Up),
    family("AComm", 1, &[], Direction::Up),
];
const SIDED: usize = 8;

/// How many labels there are, [`OTHER`] included.
pub const LABELS: usize = 2 * SIDED + 3;
/// No artery of the circle.
pub const OTHER: ArteryLabel = LABELS - 1;
/// The basilar artery.
pub const BA: ArteryLabel = 2 * SIDED;
/// The anterior communicating artery.
pub const ACOMM: ArteryLabel = BA + 1;
/// How many states there are, [`NOWHERE`] included.
pub const STATES: usize = 2 * (12 + 6 + 8 + 5 + 6 + 4 + 7 + 4) + 7 + 1 + 1;
/// The state of what is no artery of the circle.
pub const NOWHERE: AtlasState = STATES - 1;

/// The sided arteries, in the order of their labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sided {
    /// Internal carotid artery.
    Ica,
    /// Middle cerebral artery up to its bifurcation.
    M1,
    /// Middle cerebral artery beyond it.
    M2,
    /// Anterior cerebral artery up to the anterior communicating artery.
    A1,
    /// Anterior cerebral artery beyond it.
    A2,
    /// Posterior cerebral artery up to the posterior communicating artery.
    P1,
    /// Posterior cerebral artery beyond it.
    P2,
    /// Posterior communicating artery.
    PComm,
}

impl Sided {
    /// Its label on a side.
    pub const fn on(self, side: BodySide) -> ArteryLabel {
        2 * self as usize + side as usize
    }

    /// Whether a label is this artery of either side.
    pub fn is(self, label: ArteryLabel) -> bool {
        label < BA && label / 2 == self as usize
    }
}

/// The label of a segment of [`RING`].
pub fn label_of_segment(segment: usize) -> ArteryLabel {
    match RING[segment] {
        Artery::A1(side) => Sided::A1.on(side),
        Artery::PComm(side) => Sided::PComm.on(side),
        Artery::P1(side) => Sided::P1.on(side),
        _ => ACOMM,
    }
}

/// The label of the highest probability, the first of equals.
pub fn most_probable(p: &[f64; LABELS]) -> ArteryLabel {
    (0..LABELS).fold(0, |best, label| if p[label] > p[best] { label } else { best })
}

/// The arteries that a segment of the ring joins, at either end.
pub fn joined_by(segment: usize) -> [Vec<ArteryLabel>; 2] {
    match RING[segment] {
        Artery::A1(side) => [vec![Sided::Ica.on(side)], vec![Sided::A2.on(side)]],
        Artery::PComm(side) => [vec![Sided::Ica.on(side)], vec![Sided::P2.on(side), Sided::P1.on(side)]],
        Artery::P1(side) => [vec![BA, Sided::P1.on(side.other())], vec![Sided::P2.on(side)]],
        _ => BodySide::BOTH.map(|side| vec![Sided::A1.on(side), Sided::A2.on(side)]),
    }
}

/// The artery of a label without its side.
fn family_of(label: ArteryLabel) -> &'static Family {
    &FAMILIES[if label < 2 * SIDED { label / 2 } else { label - SIDED }]
}

/// The side of a label; `None` in the midline and for [`OTHER`].
pub fn side_of(label: ArteryLabel) -> Option<BodySide> {
    (label < 2 * SIDED).then(|| BodySide::BOTH[label % 2])
}

/// The name that willis writes: `L-M2`, `BA`, `other`.
pub fn name_of(label: ArteryLabel) -> String {
    match side_of(label) {
        _ if label == OTHER => "other".to_owned(),
        Some(BodySide::Left) => format!("L-{}", family_of(label).name),
        Some(BodySide::Right) => format!("R-{}", family_of(label).name),
        None => family_of(label).name.to_owned(),
    }
}

/// The label of a name that willis writes.
pub fn label_of(name: &str) -> Option<ArteryLabel> {
    (0..LABELS).find(|label| name_of(*label) == name)
}

/// The label on the other side.
pub fn mirrored(label: ArteryLabel) -> ArteryLabel {
    if label < 2 * SIDED { label ^ 1 } else { label }
}

/// The first state of a label.
pub fn first_state(label: ArteryLabel) -> AtlasState {
    (0..label).map(bins_of).sum()
}

/// How many states a label has.
pub fn bins_of(label: ArteryLabel) -> usize {
    if label == OTHER { 1 } else { family_of(label).bins }
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
    label != OTHER && other != OTHER && family_of(label).begins_at.contains(&family_of(other).name)
}

/// Where the reference end of a label lies if no artery at it is traced.
pub fn begins(label: ArteryLabel) -> Direction {
    if label == OTHER { Direction::Up } else { family_of(label).begins }
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
                .map(|(label, bin)| *label == ACOMM || *label != OTHER && !Sided::M2.is(*label) && bin + 1 < bins_of(*label))
                .collect(),
        }
    }
}

impl StateTables {
    /// The state so many bins further along the same artery, or none.
    pub fn step(&self, state: AtlasState, bins: isize) -> Option<AtlasState> {
        let to = state.checked_add_signed(bins)?;
        (to < STATES && self.label[to] == self.label[state]).then_some(to)
    }
}
