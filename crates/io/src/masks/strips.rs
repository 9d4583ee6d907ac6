//! Small pictures of the image along a vessel, as a radiologist looks at one: straightened, and across it at two places.

use super::scene::Scene;
use willis_core::support::geometry::{Point, cross, distance, dot, lerp, sub, unit};

/// Pixels of the straightened picture along the vessel.
pub const ALONG: usize = 48;
/// Pixels of every picture across the vessel, to both sides together.
pub const ACROSS: usize = 17;
/// The straightened picture goes so many spacings beyond both ends.
const BEYOND: f64 = 4.0;
/// The pictures reach so many radii and spacings to either side.
const SIDE: [f64; 2] = [1.5, 3.0];
/// Black and white are so many typical contrasts below and above the background.
const BLACK: f64 = -0.5;
const WHITE: f64 = 1.5;
/// The pictures across lie at these shares of the vessel.
const CUTS: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// The pictures of one vessel; a pixel is a grey from 0 to 255.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Sizes of the straightened picture along and across the vessel, m.
    pub size: [f64; 2],
    /// [`ACROSS`] rows of [`ALONG`] pixels, then two pictures of [`ACROSS`] rows of [`ACROSS`] pixels each.
    pub pixels: Vec<u8>,
}

impl Strip {
    /// The pictures of a vessel with this path (m), at least two points that are apart, and radius (m).
    pub fn new(scene: &Scene, path: &[Point], radius: f64) -> Option<Self> {
        let first = path.first()?;
        let mut line = vec![*first];
        line.extend(path.windows(2).filter(|w| distance(w[0], w[1]) > 0.0).map(|w| w[1]));
        let [start, end] = [[line.first()?, line.get(1)?], [line.last()?, line.get(line.len().checked_sub(2)?)?]];
        let beyond = |[tip, before]: [&Point; 2]| {
            let away = unit(sub(*tip, *before));
            [0, 1, 2].map(|k| tip[k] + BEYOND * scene.spacing * away[k])
        };
        let (before, after) = (beyond(start), beyond(end));
        line.insert(0, before);
        line.push(after);
        let mut arc = vec![0.0];
        for w in line.windows(2) {
            arc.push(arc[arc.len() - 1] + distance(w[0], w[1]));
        }
        let length = arc[arc.len() - 1];
        let half = SIDE[0] * radius + SIDE[1] * scene.spacing;
        let frames = frames(&line, &arc, length);
        let level = scene.level(line[line.len() / 2]);
        let grey = |p: Point| {
            let Some(x) = scene.brightness(p) else { return 0 };
            let share = ((x - level.background) / scene.typical - BLACK) / (WHITE - BLACK);
            // Vessels that are dark in the image are shown dark.
            let share = if scene.sign < 0.0 { 1.0 - share } else { share };
            (255.0 * share.clamp(0.0, 1.0)).round() as u8
        };
        let off = |n: usize| half * (2.0 * n as f64 / (ACROSS - 1) as f64 - 1.0);
        let at = |frame: &StripFrame, u: f64, v: f64| -> Point {
            [0, 1, 2].map(|k| frame.place[k] + u * frame.across[0][k] + v * frame.across[1][k])
        };
        let mut pixels = Vec::with_capacity(ACROSS * (ALONG + 2 * ACROSS));
        for row in 0..ACROSS {
            pixels.extend(frames.iter().map(|frame| grey(at(frame, off(row), 0.0))));
        }
        let inner = BEYOND * scene.spacing / length;
        for cut in CUTS {
            let share = inner + cut * (1.0 - 2.0 * inner);
            let frame = &frames[(share * (ALONG - 1) as f64).round() as usize];
            for row in 0..ACROSS {
                pixels.extend((0..ACROSS).map(|column| grey(at(frame, off(row), off(column)))));
            }
        }
        Some(Self { size: [length, 2.0 * half], pixels })
    }
}

/// A place on a line, and two unit vectors across it.
struct StripFrame {
    place: Point,
    across: [Point; 2],
}

/// Places at even steps along a line; the vectors across turn no more than the line does.
fn frames(line: &[Point], arc: &[f64], length: f64) -> Vec<StripFrame> {
    let mut out: Vec<StripFrame> = Vec::with_capacity(ALONG);
    let mut segment = 0;
    for n in 0..ALONG {
        let s = length * n as f64 / (ALONG - 1) as f64;
        while segment + 2 < arc.len() && arc[segment + 1] < s {
            segment += 1;
        }
        let along = unit(sub(line[segment + 1], line[segment]));
        let place = lerp(line[segment], line[segment + 1], (s - arc[segment]) / (arc[segment + 1] - arc[segment]));
        let other = if along[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let last = out.last().map_or(other, |frame| frame.across[0]);
        let flat = |v: Point| [0, 1, 2].map(|k| v[k] - dot(v, along) * along[k]);
        // A line that turns by a right angle at once leaves nothing of the last vector.
        let u = if dot(flat(last), flat(last)) > 1e-6 { unit(flat(last)) } else { unit(flat(other)) };
        out.push(StripFrame { place, across: [u, cross(along, u)] });
    }
    out
}
