//! A bridge as the features see it: its two ends, its gap, and its rivals.

use super::extraction::Extraction;
use super::smoothing::{compare, steady};
use crate::candidates::search::by_evidence::FoundBridge;
use crate::candidates::search::directions::Frame;
use crate::support::geometry::{Point, cross, distance, dot, norm_squared, sub, unit};

/// No gap is shorter than this, in spacings.
const LEAST_GAP: f64 = 1e-6;
/// A path saves at most so many gaps.
const MOST_DETOUR: f64 = 200.0;
/// A bridge without rival has one so many gaps away.
const LONE: f64 = 8.0;

/// A bridge between a free end, the *child*, and a point of the vessel it may hang on, the *parent*.
pub struct Span<'a> {
    /// The extraction that it bridges.
    pub extraction: &'a Extraction,
    /// The free end.
    pub child: &'a Frame,
    /// The parent's free end where it is met there; `None` where it is met on its way.
    pub parent_end: Option<&'a Frame>,
    /// The point of the parent.
    pub point: usize,
    /// Length of the gap, m, positive.
    pub gap: f64,
    /// Unit vector across the gap, from the child.
    pub across: Point,
    /// The parent's radius at the meeting point, m: that of its free end, else the smoothed one.
    pub parent_radius: f64,
    /// Branches nearer to the child.
    pub rank: usize,
    /// Gap of the best other branch from the child, m.
    pub rival_gap: f64,
    /// Whether the free end it reaches has its own shortest bridge to the child.
    pub mutual: bool,
    /// Path along the vessels over the gap, at most 200, for a bridge within a fragment.
    pub detour: Option<f64>,
}

impl Span<'_> {
    /// Width of the child as an extraction shows it, m: its diameter and a spacing.
    pub fn width(&self) -> f64 {
        2.0 * self.child.radius + self.extraction.spacing
    }

    /// Whether the parent is met on its way, not at a free end: 1 or 0.
    pub fn on_the_way(&self) -> f64 {
        if self.parent_end.is_some() { 0.0 } else { 1.0 }
    }
}

/// The angle between two vectors, rad; a zero vector is across everything.
pub fn angle(a: Point, b: Point) -> f64 {
    if a == [0.0; 3] || b == [0.0; 3] { std::f64::consts::FRAC_PI_2 } else { norm_squared(cross(a, b)).sqrt().atan2(dot(a, b)) }
}

/// The bridges of one search as spans, in their order.
pub fn spans<'a>(extraction: &'a Extraction, bridges: &[FoundBridge]) -> Vec<Span<'a>> {
    let mut spans: Vec<Span<'a>> = bridges.iter().map(|b| span(extraction, *b)).collect();
    let mut of_end = vec![Vec::new(); extraction.ends.len()];
    for (row, bridge) in bridges.iter().enumerate() {
        of_end[bridge.end].push(row);
    }
    // Per free end the points that its shortest bridges reach.
    let mut first: Vec<Vec<usize>> = vec![Vec::new(); extraction.ends.len()];
    for (end, rows) in of_end.iter_mut().enumerate() {
        let order = |row: usize, spans: &[Span]| {
            let s = &spans[row];
            let bend = 2.0 - dot(s.child.direction, s.across);
            [s.gap / extraction.spacing, bend, extraction.smooth.radius[s.point] / extraction.spacing].map(steady)
        };
        rows.sort_by(|a, b| compare(&order(*a, &spans), &order(*b, &spans)).then(a.cmp(b)));
        let mut near: Vec<(usize, f64)> = Vec::new();
        for row in rows.iter() {
            let (branch, gap) = (extraction.branch[spans[*row].point], spans[*row].gap);
            let rank = near.iter().position(|(b, _)| *b == branch).unwrap_or_else(|| {
                near.push((branch, gap));
                near.len() - 1
            });
            spans[*row].rank = rank;
            if order(*row, &spans)[0] == order(rows[0], &spans)[0] {
                first[end].push(spans[*row].point);
            }
        }
        for row in rows.iter() {
            let other = if spans[*row].rank > 0 { near.first() } else { near.get(1) };
            spans[*row].rival_gap = other.map_or(LONE * spans[*row].gap, |(_, gap)| *gap);
        }
    }
    for (span, bridge) in spans.iter_mut().zip(bridges) {
        let there = extraction.end_at[span.point];
        span.mutual = there.is_some_and(|end| first[end].contains(&extraction.ends[bridge.end].point));
    }
    add_detours(extraction, bridges, &mut spans);
    spans
}

fn span(extraction: &Extraction, bridge: FoundBridge) -> Span<'_> {
    let child = &extraction.ends[bridge.end];
    let parent_end = extraction.end_at[bridge.point].map(|end| &extraction.ends[end]);
    let (from, to) = (extraction.position[child.point], extraction.position[bridge.point]);
    Span {
        extraction,
        child,
        parent_end,
        point: bridge.point,
        gap: distance(from, to).max(LEAST_GAP * extraction.spacing),
        across: unit(sub(to, from)),
        parent_radius: parent_end.map_or(extraction.smooth.radius[bridge.point], |end| end.radius),
        rank: 0,
        rival_gap: 0.0,
        mutual: false,
        detour: None,
    }
}

/// The detours of the bridges within a fragment.
fn add_detours(extraction: &Extraction, bridges: &[FoundBridge], spans: &mut [Span]) {
    let mut reached = extraction.roads.room();
    let mut from = None;
    for (row, bridge) in bridges.iter().enumerate().filter(|(_, b)| b.inside) {
        if from != Some(bridge.end) {
            let same = bridges.iter().zip(spans.iter()).skip(row).take_while(|(b, _)| b.end == bridge.end);
            let longest = same.map(|(_, s)| s.gap).fold(0.0, f64::max);
            extraction.roads.reach(&[spans[row].child.point], MOST_DETOUR * longest, &mut reached);
            from = Some(bridge.end);
        }
        let path = extraction.roads.to_point(&reached, bridge.point);
        spans[row].detour = Some((path / spans[row].gap).min(MOST_DETOUR));
    }
}
