//! What the label of a landmark means: an artery that enters or leaves, or the arteries that meet there.

use super::arteries::{Artery, BodySide};
use super::labels::{LabelScheme, artery_of_label, side_of};

/// The meaning of a label.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct NamedArteries {
    /// Sorted, each once.
    pub arteries: Vec<Artery>,
    /// Whether arteries meet there; M1 and M2 do, and count as one.
    pub meet: bool,
}

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
pub(crate) fn meaning_of(label: &str) -> Option<NamedArteries> {
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
        let named = |artery| NamedArteries { arteries: vec![artery], meet: false };
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
fn several(words: &[&str]) -> Option<NamedArteries> {
    let names = words.iter().filter(|word| side_of(word).is_none());
    let arteries: Option<Vec<Artery>> = names.map(|name| artery_of_part(name, words)).collect();
    arteries.filter(|arteries| arteries.len() > 1).map(met)
}

/// The artery of a part of a label, with the side that the whole label states once where the part states none.
fn artery_of_part(part: &str, whole: &[&str]) -> Option<Artery> {
    let named = |text: &str| artery_of_label(text, LabelScheme::Names);
    let plain: Vec<&str> = words_of(part).filter(|word| side_of(word).is_none() && !FORKS.contains(word)).collect();
    let plain = plain.join(" ");
    let mut sides: Vec<BodySide> = whole.iter().filter_map(|word| side_of(word)).collect();
    sides.sort_unstable();
    sides.dedup();
    let with_side = || match sides[..] {
        [side] => named(&format!("{} {plain}", side.name())),
        _ => None,
    };
    named(part).or_else(with_side).or_else(|| named(&plain))
}

fn words_of(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty())
}

fn met(mut arteries: Vec<Artery>) -> NamedArteries {
    arteries.sort_unstable();
    arteries.dedup();
    NamedArteries { arteries, meet: true }
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

/// The arteries that meet where one begins.
fn at_origin_of(artery: Artery) -> Option<Vec<Artery>> {
    Some(match artery {
        Artery::M1(s) | Artery::Mca(s) | Artery::A1(s) | Artery::Aca(s) => vec![Artery::Ica(s), Artery::M1(s), Artery::A1(s)],
        Artery::M2(s) => vec![Artery::M1(s)],
        Artery::A2(s) => vec![Artery::A1(s), Artery::A2(s)],
        Artery::P1(_) | Artery::Pca(_) => vec![Artery::Ba, Artery::P1(BodySide::Left), Artery::P1(BodySide::Right)],
        Artery::P2(s) => vec![Artery::P1(s), Artery::P2(s)],
        Artery::PComm(s) => vec![Artery::Ica(s), artery],
        Artery::Ba => vec![artery, Artery::Va(BodySide::Left), Artery::Va(BodySide::Right)],
        Artery::Ica(_) | Artery::Va(_) | Artery::AComm | Artery::ThirdA2 => return None,
    })
}
