//! Vessels divided where their label changes along them.

use std::collections::HashMap;

use Side::{Left, Right};

use super::arteries::{Artery, Side};
use crate::error::Fault;
use crate::network::centerlines::Centerlines;
use crate::network::{Network, Node, PathPoint, RadiusRule, Vessel};

/// The network with every vessel divided where the labels of its centerline change: a junction that lost a branch (M1 behind the
/// carotid where there is no A1) is no node, and the name of the longest part is that of the whole otherwise.
///
/// `lines` are the centerlines, welded, that the network was contracted from, whatever their unit. The nodes keep their rows, those
/// between two parts follow; parts stand in the place of their vessel.
pub fn divide(network: &Network, lines: &Centerlines, rule: RadiusRule) -> Network {
    let mut name_of = HashMap::new();
    for (row, link) in lines.links.iter().enumerate() {
        let [a, b] = link.map(|point| lines.ids[point as usize]);
        name_of.insert((a.min(b), a.max(b)), lines.labels.of(row));
    }
    let name = |pair: &[PathPoint]| {
        let (a, b) = (pair[0].id?, pair[1].id?);
        name_of.get(&(a.min(b), a.max(b))).copied()
    };
    let mut divided = Network::new();
    for node in network.nodes() {
        divided.add_node(node.clone());
    }
    for (ends, vessel) in network.vessels() {
        let names: Option<Vec<&str>> = vessel.path.windows(2).map(name).collect();
        let names = names.unwrap_or_default();
        let cuts: Vec<usize> = (1..names.len()).filter(|at| names[*at] != names[at - 1]).collect();
        if cuts.is_empty() {
            divided.add_vessel(ends, vessel.clone());
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
                divided.add_node(at)
            };
            let part = Vessel::along(vessel.path[from..=cut].to_vec(), rule);
            divided.add_vessel([node, next], Vessel { label: names[from].to_owned(), ..part });
            (from, node) = (cut, next);
        }
    }
    divided
}

/// What the labels of a network are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Names in letters: `L-A1`, `A1 L`, `left A1`, `AComm`, `ACoA`, `left posterior cerebral artery`.
    Names,
    /// The `VesselType` of iCafe, 1 to 22.
    ICafe,
    /// The classes of the TopCoW challenge, 1 to 12 and 15, as CoW_Centerline_Extraction writes them.
    TopCow,
}

/// iCafe's `VesselType` from 1 on.
const ICAFE: [Artery; 22] = [
    Artery::Ica(Left),
    Artery::Ica(Right),
    Artery::M1(Left),
    Artery::M1(Right),
    Artery::M1(Left), // M2
    Artery::M1(Right),
    Artery::A1(Left),
    Artery::A1(Right),
    Artery::A2(Left),
    Artery::A2(Right),
    Artery::AComm,
    Artery::M1(Left), // M3
    Artery::M1(Right),
    Artery::Va(Left),
    Artery::Va(Right),
    Artery::Ba,
    Artery::P1(Left),
    Artery::P1(Right),
    Artery::P2(Left),
    Artery::P2(Right),
    Artery::PComm(Left),
    Artery::PComm(Right),
];

/// TopCoW's classes from 1 on; 13 and 14 are none.
const TOPCOW: [Option<Artery>; 15] = [
    Some(Artery::Ba),
    Some(Artery::Pca(Right)),
    Some(Artery::Pca(Left)),
    Some(Artery::Ica(Right)),
    Some(Artery::Mca(Right)),
    Some(Artery::Ica(Left)),
    Some(Artery::Mca(Left)),
    Some(Artery::PComm(Right)),
    Some(Artery::PComm(Left)),
    Some(Artery::AComm),
    Some(Artery::Aca(Right)),
    Some(Artery::Aca(Left)),
    None,
    None,
    Some(Artery::ThirdA2),
];

/// Words that say nothing more about which artery it is.
const FILLERS: [&str; 14] = [
    "artery", "arteries", "arteria", "segment", "part", "the", "of", "i", "ii", "t", "terminus", "terminal", "proximal", "distal",
];

impl Scheme {
    /// What a person calls it on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Names => "names",
            Self::ICafe => "icafe",
            Self::TopCow => "topcow",
        }
    }

    /// The scheme of a set of labels: names where any has a letter, else the one whose codes they all are.
    ///
    /// # Errors
    ///
    /// All are numbers that either list of codes has, or that neither has.
    pub fn of<'a>(labels: impl IntoIterator<Item = &'a str>) -> Result<Self, Fault> {
        let mut codes: Vec<&str> = labels.into_iter().map(str::trim).filter(|l| !is_none(l)).collect();
        if codes.iter().any(|label| label.parse::<u32>().is_err()) || codes.is_empty() {
            return Ok(Self::Names);
        }
        codes.sort_by_key(|code| code.parse::<u32>().unwrap_or(u32::MAX));
        codes.dedup();
        let all = |scheme: Self| codes.iter().all(|code| artery(code, scheme).is_some());
        match (all(Self::ICafe), all(Self::TopCow)) {
            (true, false) => Ok(Self::ICafe),
            (false, true) => Ok(Self::TopCow),
            (both, _) => {
                let why = if both { "codes that iCafe and TopCoW both have" } else { "codes of neither iCafe nor TopCoW" };
                Err(Fault::file(
                    format!("the labels are the numbers {}, {why}", codes.join(" ")),
                    "expected names of arteries, or give --labels icafe|topcow",
                ))
            }
        }
    }
}

/// Whether a label stands for no artery at all.
pub fn is_none(label: &str) -> bool {
    matches!(label.trim(), "" | "0")
}

/// The artery that a label means; `None` for one that is none of those around the circle.
///
/// Case, punctuation and the words artery, segment, proximal, ... do not count. A side is `l`, `left`, `lt`, `r`, `right`, `rt`, before or
/// behind; without one only `AComm`, `BA` and the third A2 are understood.
pub fn artery(label: &str, scheme: Scheme) -> Option<Artery> {
    let label = label.trim();
    match scheme {
        Scheme::ICafe => ICAFE.get(label.parse::<usize>().ok()?.checked_sub(1)?).copied(),
        Scheme::TopCow => TOPCOW.get(label.parse::<usize>().ok()?.checked_sub(1)?).copied().flatten(),
        Scheme::Names => named(&label.to_lowercase()),
    }
}

fn named(label: &str) -> Option<Artery> {
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
    let name = words.concat();
    match (side, midline(&name)) {
        (None, Some(artery)) => return Some(artery),
        // A side says nothing of an artery in the midline; which was meant is anybody's guess.
        (Some(_), Some(_)) => return None,
        _ => {}
    }
    if let Some(side) = side {
        return sided(&name, side);
    }
    // Written in one word: lA1, A1left, rightMCA.
    let ways = [("left", Left), ("right", Right), ("l", Left), ("r", Right)];
    ways.into_iter().find_map(|(word, side)| {
        let rest = name.strip_prefix(word).and_then(|rest| sided(rest, side));
        rest.or_else(|| name.strip_suffix(word).and_then(|rest| sided(rest, side)))
    })
}

fn side_of(word: &str) -> Option<Side> {
    match word {
        "l" | "left" | "lt" => Some(Left),
        "r" | "right" | "rt" => Some(Right),
        _ => None,
    }
}

fn midline(name: &str) -> Option<Artery> {
    match name {
        "acomm" | "acom" | "acoa" | "anteriorcommunicating" | "antcomm" | "antcommunicating" => Some(Artery::AComm),
        "ba" | "basilar" | "bas" => Some(Artery::Ba),
        "3rda2" | "thirda2" | "a23rd" | "a2third" | "mediana2" => Some(Artery::ThirdA2),
        _ => None,
    }
}

fn sided(name: &str, side: Side) -> Option<Artery> {
    let whole = [
        (&["mca", "middlecerebral"][..], Artery::Mca as fn(Side) -> Artery),
        (&["aca", "anteriorcerebral"], Artery::Aca),
        (&["pca", "posteriorcerebral"], Artery::Pca),
        (&["ica", "internalcarotid"], Artery::Ica),
        (&["va", "vertebral", "vert"], Artery::Va),
        (&["pcomm", "pcom", "pcoa", "posteriorcommunicating", "postcomm", "postcommunicating"], Artery::PComm),
    ];
    for (names, artery) in whole {
        for other in names.iter().filter(|other| name.starts_with(**other) || name.ends_with(**other)) {
            let rest = name.strip_prefix(*other).or_else(|| name.strip_suffix(*other)).unwrap_or_default();
            let part = segment(rest, side);
            match (rest, artery(side), part) {
                ("", whole, _) => return Some(whole),
                (_, Artery::Mca(_), Some(part @ Artery::M1(_)))
                | (_, Artery::Aca(_), Some(part @ (Artery::A1(_) | Artery::A2(_))))
                | (_, Artery::Pca(_), Some(part @ (Artery::P1(_) | Artery::P2(_)))) => return Some(part),
                (_, whole @ (Artery::Ica(_) | Artery::Va(_)), None) if is_stage(rest) => return Some(whole),
                _ => {}
            }
        }
    }
    segment(name, side)
}

fn segment(name: &str, side: Side) -> Option<Artery> {
    match name {
        "m1" | "m2" | "m3" | "m4" => Some(Artery::M1(side)),
        "a1" => Some(Artery::A1(side)),
        "a2" | "a3" | "a4" | "a5" => Some(Artery::A2(side)),
        "p1" => Some(Artery::P1(side)),
        "p2" | "p3" | "p4" | "p2a" | "p2p" => Some(Artery::P2(side)),
        _ => None,
    }
}

/// A stretch of a carotid or vertebral artery: `c7`, `v4`, `1`, `supraclinoid`.
fn is_stage(rest: &str) -> bool {
    let number = rest.trim_start_matches(['c', 'v']);
    number.len() == 1 && number.as_bytes()[0].is_ascii_digit() || matches!(rest, "supraclinoid" | "cavernous" | "iii" | "iv")
}
