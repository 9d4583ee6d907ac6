//! The labels of vessels and landmarks: which arteries a label means, and where a label changes along a vessel.

use std::collections::{BTreeSet, HashMap};

use BodySide::{Left, Right};

use super::arteries::{Artery, BodySide};
use willis_core::error::Fault;
use willis_core::network::path_places::PathPlace;
use willis_core::network::{Network, Node, PathPoint, RadiusRule, Vessel, centerlines::Centerlines};
use willis_core::support::distinct;
use willis_core::support::geometry::{Point, onto};
use willis_io::formats::ICAFE_ARTERIES;

/// The network with every vessel split where the labels of its centerline change. A junction that lost a branch (carotid and M1
/// without A1) is not a node, so that without the split the label of the longest piece would be that of the whole vessel.
///
/// `lines` are the welded centerlines, in any unit, from which the network was contracted; vessels may have been divided since, at places
/// without a number, and candidates added. The nodes keep their rows, and the new ones follow. Pieces stand in the place of their vessel.
pub fn split_where_labels_change(network: &Network, lines: &Centerlines, rule: RadiusRule) -> Network {
    let (mut name_of, mut beside) = (HashMap::new(), HashMap::<u64, Vec<u64>>::new());
    for (row, link) in lines.links.iter().enumerate() {
        let [a, b] = link.map(|point| lines.ids[point as usize]);
        name_of.insert((a.min(b), a.max(b)), lines.labels.of(row));
        beside.entry(a).or_default().push(b);
        beside.entry(b).or_default().push(a);
    }
    let points = network.vessels().flat_map(|(_, vessel)| &vessel.path);
    let place_of: HashMap<u64, Point> = points.filter_map(|point| Some((point.id?, point.position))).collect();
    let name_between = |a: u64, b: u64| name_of.get(&(a.min(b), a.max(b))).copied();
    // Where a vessel was divided: the name of the link of the point beside it on which it lies.
    let name_towards = |a: u64, at: Point| {
        let away = |b: &u64| place_of.get(b).map_or(f64::INFINITY, |to| onto(at, place_of[&a], *to).1);
        let on = beside.get(&a)?.iter().min_by(|x, y| away(x).total_cmp(&away(y)))?;
        name_between(a, *on)
    };
    let name = |pair: &[PathPoint]| match [pair[0].id, pair[1].id] {
        [Some(a), Some(b)] => name_between(a, b),
        [Some(a), None] => name_towards(a, pair[1].position),
        [None, Some(b)] => name_towards(b, pair[0].position),
        [None, None] => None,
    };
    let (mut split, _) = network.subgraph(|_| false);
    for (ends, vessel) in network.vessels() {
        let known: Vec<Option<&str>> = vessel.path.windows(2).map(name).collect();
        // A part of one link between two such places has the name of what is beside it.
        let mut last = known.iter().copied().flatten().next().unwrap_or(&vessel.label);
        let mut names = Vec::with_capacity(known.len());
        for name in known {
            last = name.unwrap_or(last);
            names.push(last);
        }
        let cuts: Vec<usize> = (1..names.len()).filter(|at| names[*at] != names[at - 1]).collect();
        if cuts.is_empty() {
            split.add_vessel(
                ends,
                Vessel { label: names.first().map_or(&*vessel.label, |name| name).to_owned(), ..vessel.clone() },
            );
            continue;
        }
        let places = cuts.iter().map(|point| PathPlace { point: *point, share: 0.0 });
        let parts = vessel.parts(ends, &vessel.path, places, rule, |_, at| {
            split.add_node(Node::at(at.id.map_or_else(String::new, |id| id.to_string()), at))
        });
        for ((ends, part), first) in parts.into_iter().zip([0].iter().chain(&cuts)) {
            split.add_vessel(ends, Vessel { label: names[*first].to_owned(), ..part });
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
        // In the order of the variants.
        ["names", "icafe", "topcow"][self as usize]
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

/// Whether the classes of a mask are those of TopCoW: nothing else, and both carotid arteries and a middle cerebral one among them; a
/// patient may lack the other. iCafe, which has the same numbers, has no masks.
pub fn are_topcow_classes<'a>(labels: impl IntoIterator<Item = &'a str>) -> bool {
    let codes: BTreeSet<&str> = labels.into_iter().map(str::trim).filter(|label| !names_no_artery(label)).collect();
    codes.iter().all(|code| code.parse::<u32>().is_ok() && artery_of_label(code, LabelScheme::TopCow).is_some())
        && ["4", "6"].iter().all(|code| codes.contains(code))
        && ["5", "7"].iter().any(|code| codes.contains(code))
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
    for word in words_of(label) {
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

/// The meaning of the label of a landmark: its arteries, sorted, each once, and whether they meet there; M1 and M2 do, and count as one.
pub(crate) type MeantArteries = (Vec<Artery>, bool);

/// Words for the far end of an artery, where it divides.
const FORKS: [&str; 12] =
    ["bifurcation", "bif", "bifurc", "junction", "jn", "fork", "terminus", "terminal", "termination", "t", "tip", "apex"];
/// Words for the near end of an artery.
const ORIGINS: [&str; 3] = ["origin", "ostium", "takeoff"];
/// What stands between the names of arteries that meet.
const BETWEEN: [char; 4] = ['/', '+', '&', ','];

/// What a label means; `None` where it names no artery of the circle, or no place where its arteries meet.
///
/// `L-ICA`, `ICA left` and `left internal carotid artery inlet` are an end. `L-ICA/L-M1/L-A1`, `A1/A2 L`, `M1-M2 bifurcation left`,
/// `ICA-T L`, `BA tip`, `left PComm origin` are places where arteries meet; a side that stands once holds for all of them.
pub(crate) fn meaning_of(label: &str) -> Option<MeantArteries> {
    let label = label.to_lowercase();
    let parts: Vec<&str> = label.split(BETWEEN).flat_map(|part| part.split(" and ")).collect();
    let words: Vec<&str> = words_of(&label).collect();
    if matches!(words[..], ["vbj"] | ["vertebrobasilar", "junction"] | ["vertebro", "basilar", "junction"]) {
        return Some(met(vec![Artery::Ba, Artery::Va(BodySide::Left), Artery::Va(BodySide::Right)]));
    }
    if parts.len() > 1 {
        let arteries: Option<Vec<Artery>> = parts.iter().map(|part| artery_of_part(part, &words)).collect();
        return arteries.map(met);
    }
    let is_fork = words.iter().any(|word| FORKS.contains(word));
    let is_origin = words.iter().any(|word| ORIGINS.contains(word));
    if !is_fork && !is_origin {
        let named = |artery| (vec![artery], false);
        return artery_of_label(&label, LabelScheme::Names).map(named).or_else(|| several(&words));
    }
    let rest: Vec<&str> = words.iter().copied().filter(|word| !FORKS.contains(word) && !ORIGINS.contains(word)).collect();
    match artery_of_label(&rest.join(" "), LabelScheme::Names) {
        Some(artery) if is_origin => Some(met(at_origin_of(artery)?)),
        Some(artery) => Some(met(at_fork_of(artery)?)),
        None => several(&rest),
    }
}

/// Several names of one side with nothing but a hyphen or a blank between them: `A1-A2 left`.
fn several(words: &[&str]) -> Option<MeantArteries> {
    let names = words.iter().filter(|word| side_of(word).is_none());
    let arteries: Option<Vec<Artery>> = names.map(|name| artery_of_part(name, words)).collect();
    arteries.filter(|arteries| arteries.len() > 1).map(met)
}

/// The artery of a part of a label, with the side that the whole label states once where the part states none.
fn artery_of_part(part: &str, whole: &[&str]) -> Option<Artery> {
    let named = |text: &str| artery_of_label(text, LabelScheme::Names);
    let plain: Vec<&str> = words_of(part).filter(|word| side_of(word).is_none() && !FORKS.contains(word)).collect();
    let plain = plain.join(" ");
    let sides = distinct(whole.iter().filter_map(|word| side_of(word)));
    let with_side = || match sides[..] {
        [side] => named(&format!("{} {plain}", side.name())),
        _ => None,
    };
    named(part).or_else(with_side).or_else(|| named(&plain))
}

fn words_of(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty())
}

fn met(arteries: Vec<Artery>) -> MeantArteries {
    (distinct(arteries), true)
}

/// The arteries that meet where one divides.
fn at_fork_of(artery: Artery) -> Option<Vec<Artery>> {
    Some(match artery {
        Artery::Ica(s) => vec![artery, Artery::M1(s), Artery::A1(s)],
        Artery::M1(s) | Artery::Mca(s) => vec![Artery::M1(s)],
        Artery::A1(s) | Artery::Aca(s) => vec![Artery::A1(s), Artery::A2(s)],
        Artery::P1(s) | Artery::Pca(s) => vec![Artery::P1(s), Artery::P2(s)],
        Artery::Ba => vec![artery, Artery::P1(BodySide::Left), Artery::P1(BodySide::Right)],
        Artery::Va(_) => vec![Artery::Ba, Artery::Va(BodySide::Left), Artery::Va(BodySide::Right)],
        Artery::M2(_) | Artery::A2(_) | Artery::P2(_) | Artery::PComm(_) | Artery::AComm | Artery::ThirdA2 => return None,
    })
}

/// The arteries that meet where one begins: where the one before it divides.
fn at_origin_of(artery: Artery) -> Option<Vec<Artery>> {
    at_fork_of(match artery {
        Artery::M1(s) | Artery::Mca(s) | Artery::A1(s) | Artery::Aca(s) => Artery::Ica(s),
        Artery::M2(s) => Artery::M1(s),
        Artery::A2(s) => Artery::A1(s),
        Artery::P1(_) | Artery::Pca(_) => Artery::Ba,
        Artery::P2(s) => Artery::P1(s),
        Artery::PComm(s) => return Some(vec![Artery::Ica(s), artery]),
        Artery::Ba => Artery::Va(BodySide::Left),
        Artery::Ica(_) | Artery::Va(_) | Artery::AComm | Artery::ThirdA2 => return None,
    })
}
