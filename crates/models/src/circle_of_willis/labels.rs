//! The labels of vessels: which artery a label means, and where a label changes along a vessel.

use std::collections::{BTreeSet, HashMap};

use BodySide::{Left, Right};

use super::arteries::{Artery, BodySide};
use willis_core::error::Fault;
use willis_core::network::centerlines::Centerlines;
use willis_core::network::{Network, Node, PathPoint, RadiusRule, Vessel};
use willis_io::formats::ICAFE_ARTERIES;

/// The network with every vessel split where the labels of its centerline change. A junction that lost a branch (carotid and M1
/// without A1) is not a node, so that without the split the label of the longest piece would be that of the whole vessel.
///
/// `lines` are the welded centerlines, in any unit, from which the network was contracted. The nodes keep their rows, and the new ones
/// follow. Pieces stand in the place of their vessel.
pub fn split_where_labels_change(network: &Network, lines: &Centerlines, rule: RadiusRule) -> Network {
    let mut name_of = HashMap::new();
    for (row, link) in lines.links.iter().enumerate() {
        let [a, b] = link.map(|point| lines.ids[point as usize]);
        name_of.insert((a.min(b), a.max(b)), lines.labels.of(row));
    }
    let name = |pair: &[PathPoint]| {
        let (a, b) = (pair[0].id?, pair[1].id?);
        name_of.get(&(a.min(b), a.max(b))).copied()
    };
    let (mut split, _) = network.subgraph(|_| false);
    for (ends, vessel) in network.vessels() {
        let names: Option<Vec<&str>> = vessel.path.windows(2).map(name).collect();
        let names = names.unwrap_or_default();
        let cuts: Vec<usize> = (1..names.len()).filter(|at| names[*at] != names[at - 1]).collect();
        if cuts.is_empty() {
            split.add_vessel(ends, vessel.clone());
            continue;
        }
        let (mut from, mut node) = (0, ends[0]);
        for cut in cuts.into_iter().chain([names.len()]) {
            let point = &vessel.path[cut];
            let next = if cut == names.len() {
                ends[1]
            } else {
                let id = point.id.map_or_else(String::new, |id| id.to_string());
                let at = Node { id, position: Some(point.position), radius: Some(point.radius), ..Node::default() };
                split.add_node(at)
            };
            let piece = Vessel::along(vessel.path[from..=cut].to_vec(), rule);
            split.add_vessel([node, next], Vessel { label: names[from].to_owned(), ..piece });
            (from, node) = (cut, next);
        }
    }
    split
}

/// The kind of labels of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LabelScheme {
    /// Names in letters: `L-A1`, `A1 L`, `left A1`, `AComm`, `ACoA`, `left posterior cerebral artery`.
    Names,
    /// The `VesselType` of iCafe, 1 to 22.
    ICafe,
    /// The classes of the TopCoW challenge, 1 to 12 and 15, as CoW_Centerline_Extraction writes them.
    TopCow,
}

/// The names of TopCoW's classes from 1 on; 13 and 14 do not exist.
const TOPCOW: [&str; 15] = [
    "BA", "R-PCA", "L-PCA", "R-ICA", "R-MCA", "L-ICA", "L-MCA", "R-PComm", "L-PComm", "AComm", "R-ACA", "L-ACA", "", "", "3rd-A2",
];

/// Words that do not change which artery is meant.
const FILLERS: [&str; 22] = [
    "artery", "arteries", "arteria", "segment", "part", "the", "of", "i", "ii", "t", "terminus", "terminal", "proximal",
    "distal", "tip", "apex", "inlet", "outlet", "inflow", "outflow", "end", "side",
];

impl LabelScheme {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Names => "names",
            Self::ICafe => "icafe",
            Self::TopCow => "topcow",
        }
    }

    /// The scheme of a set of labels: names if any label is not a number, otherwise the scheme whose codes they all are.
    ///
    /// # Errors
    ///
    /// All are numbers, and both schemes have these codes, or neither has.
    pub fn of<'a>(labels: impl IntoIterator<Item = &'a str>) -> Result<Self, Fault> {
        let mut codes: Vec<&str> = labels.into_iter().map(str::trim).filter(|l| !names_no_artery(l)).collect();
        if codes.iter().any(|label| label.parse::<u32>().is_err()) || codes.is_empty() {
            return Ok(Self::Names);
        }
        codes.sort_by_key(|code| code.parse::<u32>().unwrap_or(u32::MAX));
        codes.dedup();
        let all = |scheme: Self| codes.iter().all(|code| artery_of_label(code, scheme).is_some());
        match (all(Self::ICafe), all(Self::TopCow)) {
            (true, false) => Ok(Self::ICafe),
            (false, true) => Ok(Self::TopCow),
            (both, _) => {
                let why = if both { "codes that iCafe and TopCoW both have" } else { "codes of neither iCafe nor TopCoW" };
                Err(Fault::file(
                    format!("the labels are the numbers {}, {why}", codes.join(" ")),
                    "expected names of arteries, or give `labels=icafe|topcow`",
                ))
            }
        }
    }
}

/// Whether the classes of a mask are those of TopCoW: nothing else, and both carotid and both middle cerebral arteries among them. iCafe,
/// which has the same numbers, has no masks.
pub fn are_topcow_classes<'a>(labels: impl IntoIterator<Item = &'a str>) -> bool {
    let codes: BTreeSet<&str> = labels.into_iter().map(str::trim).filter(|label| !names_no_artery(label)).collect();
    codes.iter().all(|code| code.parse::<u32>().is_ok() && artery_of_label(code, LabelScheme::TopCow).is_some())
        && ["4", "5", "6", "7"].iter().all(|code| codes.contains(code))
}

/// Whether a label is empty or 0.
pub fn names_no_artery(label: &str) -> bool {
    matches!(label.trim(), "" | "0")
}

/// The artery that a label means; `None` for a label that means no artery around the circle.
///
/// Case, punctuation and words such as artery, segment or proximal do not matter. The side is `l`, `left`, `lt`, `r`, `right` or `rt`,
/// before or after the name. Only `AComm`, `BA` and the third A2 are understood without a side.
pub fn artery_of_label(label: &str, scheme: LabelScheme) -> Option<Artery> {
    let label = label.trim();
    match scheme {
        LabelScheme::ICafe => artery_of_code(label, &ICAFE_ARTERIES[1..]),
        LabelScheme::TopCow => artery_of_code(label, &TOPCOW),
        LabelScheme::Names => artery_of_name(&label.to_lowercase()),
    }
}

fn artery_of_code(code: &str, names: &[&str]) -> Option<Artery> {
    artery_of_name(&names.get(code.parse::<usize>().ok()?.checked_sub(1)?)?.to_lowercase())
}

fn artery_of_name(label: &str) -> Option<Artery> {
    let mut side = None;
    let mut words = Vec::new();
    for word in label.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()) {
        match (side_of(word), side) {
            (Some(new), None) => side = Some(new),
            (Some(_), Some(_)) => return None,
            (None, _) if FILLERS.contains(&word) => {}
            (None, _) => words.push(word),
        }
    }
    // Without the word artery in one that is not divided: leftInternalCarotidArtery, BasilarArtery.
    let name = words.concat().replace("artery", "");
    match (side, midline(&name)) {
        (None, Some(artery)) => return Some(artery),
        // An artery in the midline has no side, so the label is ambiguous.
        (Some(_), Some(_)) => return None,
        _ => {}
    }
    if let Some(side) = side {
        return sided(&name, side);
    }
    // Side and name in one word: lA1, A1left, rightMCA.
    let sides = [("left", Left), ("right", Right), ("l", Left), ("r", Right)];
    sides.into_iter().find_map(|(word, side)| {
        let rest = name.strip_prefix(word).and_then(|rest| sided(rest, side));
        rest.or_else(|| name.strip_suffix(word).and_then(|rest| sided(rest, side)))
    })
}

/// The side that a word means.
pub(crate) fn side_of(word: &str) -> Option<BodySide> {
    match word {
        "l" | "left" | "lt" => Some(Left),
        "r" | "right" | "rt" => Some(Right),
        _ => None,
    }
}

fn midline(name: &str) -> Option<Artery> {
    let names = [
        ("acomm acom acoa acoma acomma anteriorcommunicating anteriorcomm antcomm antcommunicating", Artery::AComm),
        ("ba basilar bas", Artery::Ba),
        ("3rda2 thirda2 a23rd a2third mediana2", Artery::ThirdA2),
    ];
    names.into_iter().find(|(names, _)| names.split(' ').any(|other| other == name)).map(|(_, artery)| artery)
}

fn sided(name: &str, side: BodySide) -> Option<Artery> {
    let families = [
        ("mca middlecerebral", Artery::Mca as fn(BodySide) -> Artery),
        ("aca anteriorcerebral", Artery::Aca),
        ("pca posteriorcerebral", Artery::Pca),
        ("ica internalcarotid carotid", Artery::Ica),
        ("va vertebral vert", Artery::Va),
        ("pcomma pcoma pcomm pcom pcoa posteriorcommunicating posteriorcomm postcomm postcommunicating", Artery::PComm),
    ];
    for (names, artery) in families {
        for other in names.split(' ').filter(|other| name.starts_with(*other) || name.ends_with(*other)) {
            let rest = name.strip_prefix(other).or_else(|| name.strip_suffix(other)).unwrap_or_default();
            let undivided = artery(side);
            match segment(rest, side) {
                _ if rest.is_empty() => return Some(undivided),
                Some(segment) if segment.undivided() == undivided => return Some(segment),
                None if matches!(undivided, Artery::Ica(_) | Artery::Va(_)) && is_carotid_or_vertebral_segment(rest) => {
                    return Some(undivided);
                }
                _ => {}
            }
        }
    }
    segment(name, side)
}

fn segment(name: &str, side: BodySide) -> Option<Artery> {
    match name {
        "m1" | "m2" | "m3" | "m4" => Some(Artery::M1(side)),
        "a1" => Some(Artery::A1(side)),
        "a2" | "a3" | "a4" | "a5" => Some(Artery::A2(side)),
        "p1" => Some(Artery::P1(side)),
        "p2" | "p3" | "p4" | "p2a" | "p2p" => Some(Artery::P2(side)),
        _ => None,
    }
}

/// Whether a word is a segment of a carotid or vertebral artery: `c7`, `v4`, `1`, `supraclinoid`.
fn is_carotid_or_vertebral_segment(rest: &str) -> bool {
    let number = rest.trim_start_matches(['c', 'v']);
    number.len() == 1 && number.as_bytes()[0].is_ascii_digit() || matches!(rest, "supraclinoid" | "cavernous" | "iii" | "iv")
}
