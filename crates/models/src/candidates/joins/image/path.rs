//! The cheapest path through an image between two places, among those that go forward along the straight line between them.

use willis_core::support::geometry::{Point, cross, distance, lerp, smooth, sub, unit};
use willis_io::masks::Scene;

/// Paths go through places on cross-sections of the line: cross-sections and places on them lie about so many spacings apart.
const STEP: f64 = 0.7;
/// A path stays so near to the line: a share of the gap, at least and at most so many spacings.
const WIDTH: f64 = 0.35;
const WIDTHS: [f64; 2] = [2.0, 4.0];
/// Added to the contrast in the denominator of the cost.
const FLOOR: f64 = 0.08;
/// There are no more cross-sections than this.
const MOST_SECTIONS: f64 = 400.0;

/// What a path goes between, and how the image is read there.
pub struct Between {
    /// The ends, m.
    pub ends: [Point; 2],
    /// No vessel counts as another one so near (m) to each end.
    pub own: [f64; 2],
    /// The brightness of background.
    pub background: f64,
    /// The contrast of a vessel, positive.
    pub contrast: f64,
    /// The distance between points of the extraction, m.
    pub spacing: f64,
}

/// The cheapest path between two places.
#[derive(Debug, Clone)]
pub struct CheapestPath {
    /// Its points, m, from end to end.
    pub points: Vec<Point>,
    /// Its cost in spacings: its length where the image shows nothing, less than a hundredth of that along a vessel of full contrast.
    pub cost: f64,
}

/// The cheapest path; `None` where the image is not known.
///
/// The cost of a step is its length times (f/(c + f))², where c is the contrast as a share of that of the vessels, from 0 to 1, and f
/// is 0.08. Inside other vessels c is 0. From one cross-section of the line to the next a path moves by one place along each of two
/// directions at most; among all such paths the cheapest is found, by the Viterbi algorithm.
pub fn cheapest_path(scene: &Scene, between: &Between) -> Option<CheapestPath> {
    let ([a, b], h) = (between.ends, between.spacing);
    let gap = distance(a, b);
    let sections = (gap / (STEP * h)).round().clamp(2.0, MOST_SECTIONS);
    let (ahead, step) = (gap / sections, STEP * h);
    let sections = sections as usize;
    let reach = ((WIDTH * gap).clamp(WIDTHS[0] * h, WIDTHS[1] * h) / step).round() as usize;
    let side = 2 * reach + 1;
    let [e1, e2] = across(unit(sub(b, a)));
    let offset = |at: usize| [at % side, at / side].map(|offset| step * (offset as f64 - reach as f64));
    let place = |section: usize, at: usize| -> Point {
        let (along, [u, v]) = (lerp(a, b, section as f64 / sections as f64), offset(at));
        [0, 1, 2].map(|k| along[k] + u * e1[k] + v * e2[k])
    };
    // The same in indices of the image, which are linear too: one step along the line and along both directions.
    let origin = scene.index(a);
    let to = |p: Point, by: f64| -> [f64; 3] {
        let there = scene.index([0, 1, 2].map(|k| a[k] + by * p[k]));
        [0, 1, 2].map(|axis| there[axis] - origin[axis])
    };
    let (forward, right, up) = (to(sub(b, a), 1.0 / sections as f64), to(e1, step), to(e2, step));
    let price = |section: usize, u: usize, v: usize| -> f32 {
        let (s, u, v) = (section as f64, u as f64 - reach as f64, v as f64 - reach as f64);
        let index = [0, 1, 2].map(|axis| origin[axis] + s * forward[axis] + u * right[axis] + v * up[axis]);
        let Some(x) = scene.brightness_at(index) else { return f32::INFINITY };
        let c = ((x - between.background) / between.contrast).clamp(0.0, 1.0);
        let squared = step * step * (u * u + v * v);
        let away = |along: f64, own: f64| along * along + squared > own * own;
        let is_other = || away(s * ahead, between.own[0]) && away(gap - s * ahead, between.own[1]);
        let c = if c > 0.0 && scene.is_inside_at(index) && is_other() { 0.0 } else { c };
        price(c)
    };
    // Sections have a rim of places that no path goes through.
    let (wide, rim) = (side + 2, side + 3);
    let row = |u: usize, v: usize| v * wide + u + rim;
    let size = wide * wide;
    let moves: Vec<(isize, f32)> = (0..9)
        .map(|n| (n % 3 - 1, n / 3 - 1))
        .map(|(du, dv): (isize, isize)| {
            let length = ahead.hypot(step * (du as f64).hypot(dv as f64));
            (dv * wide as isize + du, (0.5 * length / h) as f32)
        })
        .collect();
    let middle = row(reach, reach);
    // Per place of a section the least cost so far, the price there, and by which move it was reached.
    let mut least = vec![f32::INFINITY; size];
    let mut here = vec![0.0_f32; size];
    (least[middle], here[middle]) = (0.0, price(0, reach, reach));
    let mut from = vec![u8::MAX; (sections + 1) * size];
    let (mut next_least, mut next_here) = (vec![f32::INFINITY; size], vec![0.0_f32; size]);
    for section in 1..=sections {
        next_least.fill(f32::INFINITY);
        // No further out than moves lead from the one end and to the other.
        let reached = section.min(sections - section).min(reach);
        for v in reach - reached..=reach + reached {
            for u in reach - reached..=reach + reached {
                let at = row(u, v);
                let own = price(section, u, v);
                let (mut best, mut by) = (f32::INFINITY, u8::MAX);
                for (way, (move_by, half)) in (0_u8..).zip(&moves) {
                    let before = (at as isize + move_by) as usize;
                    let sum = least[before] + half * (here[before] + own);
                    if sum < best {
                        (best, by) = (sum, way);
                    }
                }
                (next_least[at], next_here[at], from[section * size + at]) = (best, own, by);
            }
        }
        std::mem::swap(&mut least, &mut next_least);
        std::mem::swap(&mut here, &mut next_here);
    }
    if least[middle].is_infinite() {
        return None;
    }
    let (mut points, mut at) = (vec![b], middle);
    for section in (1..=sections).rev() {
        at = at.checked_add_signed(moves[usize::from(from[section * size + at])].0)?;
        let inner = at - rim;
        points.push(place(section - 1, inner / wide * side + inner % wide));
    }
    points.reverse();
    Some(CheapestPath { points: smooth(&points, 2), cost: f64::from(least[middle]) })
}

/// The cost of a step as a share of its length, by the contrast as a share of that of the vessels.
pub(super) fn price(contrast: f64) -> f32 {
    let share = (FLOOR / (contrast + FLOOR)) as f32;
    share * share
}

/// Two directions across a unit vector.
pub(super) fn across(d: Point) -> [Point; 2] {
    let other = if d[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let e1 = unit(cross(d, other));
    [e1, cross(d, e1)]
}
