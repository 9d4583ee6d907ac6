//! Whether the arteries called left and right lie on the sides that they should, as far as positions alone can tell.

use std::collections::BTreeMap;

use super::arteries::{Artery, BodySide};
use willis_core::support::geometry::{Point, centroid, cross, dot, lerp, sub, unit};

/// The arteries that lie aside of the midline, so that one alone shows its side.
const ASIDE: [fn(BodySide) -> Artery; 5] = [Artery::M1, Artery::Mca, Artery::P2, Artery::Pca, Artery::PComm];
/// The others whose left one lies to the left of the right one. Two A2 may run side by side.
const PAIRED: [fn(BodySide) -> Artery; 2] = [Artery::A1, Artery::P1];
/// The right one of a pair must lie so far to the left of the left one, m.
const EXCHANGED: f64 = 0.003;
/// One alone must lie so far beyond the midline, m.
const BEYOND: f64 = 0.005;

/// The arteries that lie on the other side than the carotids of their name, or than M1 or A1 where the carotids are not both known: both of a
/// pair, or one whose other is not known. Empty where no such pair is known.
///
/// A mirrored file has none: its carotids lie on the other side too, which [`sides_look_exchanged`] looks at.
pub(crate) fn on_the_wrong_side(at: &BTreeMap<Artery, Point>) -> Vec<Artery> {
    let pair = |artery: fn(BodySide) -> Artery| Some([*at.get(&artery(BodySide::Left))?, *at.get(&artery(BodySide::Right))?]);
    let reference = [Artery::Ica, Artery::M1, Artery::Mca, Artery::A1].into_iter().find_map(pair);
    let Some([left, right]) = reference else { return Vec::new() };
    let (rightward, middle) = (unit(sub(right, left)), lerp(left, right, 0.5));
    let mut wrong = Vec::new();
    for (row, artery) in ASIDE.into_iter().chain(PAIRED).enumerate() {
        match pair(artery) {
            Some([left, right]) if dot(sub(right, left), rightward) < -EXCHANGED => wrong.extend(BodySide::BOTH.map(artery)),
            None if row < ASIDE.len() => {
                let is_beyond = |side: BodySide, p: &Point| {
                    let away = dot(sub(*p, middle), rightward);
                    if side == BodySide::Left { away > BEYOND } else { away < -BEYOND }
                };
                let one = BodySide::BOTH.into_iter().find_map(|side| Some((side, at.get(&artery(side))?)));
                wrong.extend(one.filter(|(side, p)| is_beyond(*side, p)).map(|(side, _)| artery(side)));
            }
            _ => {}
        }
    }
    wrong.sort_unstable();
    wrong
}

const LOOKS_EXCHANGED: &str = "left and right look exchanged, unless the axes of the input are left-handed (as LAS): front, top and right do not fit together";

/// What to tell of sides that look exchanged, of all arteries or of some, given the mean positions of arteries (m).
pub(crate) fn side_notes(at: &BTreeMap<Artery, Point>) -> Vec<String> {
    let mut notes: Vec<String> =
        (sides_look_exchanged(at) == Some(true)).then(|| LOOKS_EXCHANGED.to_owned()).into_iter().collect();
    let wrong: Vec<String> = on_the_wrong_side(at).iter().map(ToString::to_string).collect();
    if !wrong.is_empty() {
        let lies = if wrong.len() == 1 { "lies" } else { "lie" };
        notes.push(format!(
            "{} {lies} on the other side than the carotids: left and right look exchanged there",
            wrong.join(", ")
        ));
    }
    notes
}

/// Below this product of unit vectors the arteries are too nearly in one plane for a decision.
const TOO_FLAT: f64 = 0.05;

/// Whether left and right look exchanged in right-handed axes: rightward · (forward x upward) is negative.
///
/// Rightward is from the left artery of every pair to the right one, forward from P2 or the basilar artery to A2, upward from the
/// carotid to M1 and A1. `None` where too few arteries are known.
pub(crate) fn sides_look_exchanged(at: &BTreeMap<Artery, Point>) -> Option<bool> {
    let mean = |arteries: &[Artery]| -> Option<Point> {
        let points: Vec<Point> = arteries.iter().filter_map(|artery| at.get(artery).copied()).collect();
        (!points.is_empty()).then(|| centroid(points))
    };
    let both = |artery: fn(BodySide) -> Artery| BodySide::BOTH.map(artery);
    let mut rightward = [0.0; 3];
    for artery in Artery::PAIRED {
        if let [Some(left), Some(right)] = both(*artery).map(|artery| at.get(&artery)) {
            let step = sub(*right, *left);
            rightward = [rightward[0] + step[0], rightward[1] + step[1], rightward[2] + step[2]];
        }
    }
    let front = [both(Artery::A2), both(Artery::Aca), both(Artery::A1)].into_iter().find_map(|pair| mean(&pair))?;
    let back = [both(Artery::P2), both(Artery::Pca), [Artery::Ba; 2]].into_iter().find_map(|pair| mean(&pair))?;
    let top = [both(Artery::M1), both(Artery::Mca), both(Artery::A1)].into_iter().find_map(|pair| mean(&pair))?;
    let bottom = mean(&both(Artery::Ica))?;
    let (ahead, up) = (unit(sub(front, back)), unit(sub(top, bottom)));
    let product = dot(unit(rightward), cross(ahead, up));
    (product.abs() > TOO_FLAT).then_some(product < 0.0)
}
