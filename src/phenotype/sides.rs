//! Whether left and right are what they are called, by the handedness of what is anterior and superior.

use std::collections::BTreeMap;

use super::artery::{Artery, Side};
use crate::geometry::{Point, cross, dot, sub, unit};

/// Below this product of unit vectors the arteries lie too flat to tell.
const TOO_FLAT: f64 = 0.05;

/// Whether left and right look exchanged in right-handed axes: (from left to right) · (to the front x upward) is negative.
///
/// Right is from the left artery of every pair to the right one, the front from P2 or the basilar artery to A2, upward from the
/// carotid to M1 and A1. `None` where too little is known.
pub(super) fn are_exchanged(at: &BTreeMap<Artery, Point>) -> Option<bool> {
    let mean = |arteries: &[Artery]| -> Option<Point> {
        let points: Vec<Point> = arteries.iter().filter_map(|artery| at.get(artery).copied()).collect();
        let sum = points.iter().fold([0.0; 3], |sum, p| [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]]);
        (!points.is_empty()).then(|| sum.map(|x| x / points.len() as f64))
    };
    let both = |artery: fn(Side) -> Artery| Side::BOTH.map(artery);
    let mut rightward = [0.0; 3];
    for artery in Artery::PAIRED {
        if let [Some(left), Some(right)] = both(artery).map(|artery| at.get(&artery)) {
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
