//! Makes one vessel of stretches that several lines share.
//!
//! `vmtkcenterlines` traces a line from each target back to a source, each for itself: the trunk is there once for every outlet.
//! The lines coincide exactly or nearly (numerical noise, smoothing and resampling move them by a fraction of the
//! radius), separate slowly where their vessels branch, and share no points.
//!
//! The first line is taken as it is. Every next one (those that have an end in common with a line before them first) is followed
//! along those taken so far, from a common end, a source or a target, stored forwards or backwards, to where it leaves them for
//! good ([`Tree`]); only what is left of it is hung on there. So the shared stretch keeps the points and radii of the line
//! that came first. All tolerances are fractions of the local radius:
//!
//! - a common end: within 0.4 radii. Without one lines are never merged, however near they pass;
//! - the same vessel: together until one radius from the common end, 0.12 radii apart on the mean, or coincident in their first
//!   three points; three points of the line at least. Two vessels that leave a junction under more than some 14 degrees are thus
//!   two from its first point;
//! - left for good: more than 0.4 radii away and not back within two radii; more than one radius away;
//! - one junction: leaving within a radius of a junction, or one step of the line, is leaving at it, so that a trifurcation is
//!   one.
//!
//! A file in which lines end at a point of another line, but share no link with it, states already how its lines are connected:
//! it is a network already (`vmtkcenterlinemerge`, skeletons, tracings), and nothing in it is merged.
//!
//! The place on the tree moves along it with the line and never jumps, so a vessel that turns back close to itself is not cut
//! short.

use std::collections::HashMap;

use super::data::{PolyLine, PolyLines};
use crate::formats::{Point, distance, dot, is_radius, lerp, millimetres, norm_squared, sub};

/// More lines than a source has outlets: such a file holds pieces of a network, each of them once.
const MOST: usize = 4096;
/// Between two places on the tree a remainder this many radii long is no vessel.
const WOBBLE: f64 = 2.0;

/// Merges stretches that several lines share; a note says over which length.
pub(crate) fn merge(all: &mut PolyLines) -> Option<String> {
    if all.each.len() < 2 || all.each.len() > MOST || knows_its_nodes(&all.each) {
        return None;
    }
    let radii = without_gaps(all);
    let mut tree = Tree { at: &all.at, radii: &radii, links_at: vec![Vec::new(); all.at.len()], ..Tree::default() };
    let mut kept: Vec<Option<PolyLine>> = vec![None; all.each.len()];
    let mut all_merged = Vec::new();
    let (mut merged, mut length) = (0, 0.0);
    for row in order(all, &radii) {
        let line = &all.each[row];
        let backwards: Vec<u32> = line.points.iter().rev().copied().collect();
        let [front, back] = [&line.points, &backwards].map(|points| {
            let (shared, replacements) = tree.follow(points)?;
            all_merged.extend(points.iter().zip(replacements).map(|(gone, stays)| [*gone, stays]));
            Some(shared)
        });
        for (shared, end) in [(front, line.points.first()), (back, line.points.last())] {
            if let (None, Some(end)) = (shared, end) {
                tree.ends.push(*end);
            }
        }
        let is_merged = front.is_some() || back.is_some();
        let rest = if is_merged { rest(all, &radii, line, front, back) } else { Some(line.clone()) };
        if is_merged {
            merged += 1;
            length += arc(&all.at, &line.points) - rest.as_ref().map_or(0.0, |rest| arc(&all.at, &rest.points));
        }
        if let Some(rest) = rest {
            tree.add(&rest.points);
            kept[row] = Some(rest);
        }
    }
    if merged == 0 {
        return None;
    }
    all.merged.extend(all_merged);
    let all_lines = all.each.len();
    all.each = kept.into_iter().flatten().collect();
    let length = millimetres(length);
    Some(format!(
        "{merged} of {all_lines} lines run together with others, over {length:.1} mm in all: each shared stretch became one vessel"
    ))
}

/// Whether the lines share points already: one ends at a point of another, by a link that no other line has.
fn knows_its_nodes(lines: &[PolyLine]) -> bool {
    let (mut points, mut links) = (HashMap::new(), HashMap::new());
    let link = |a: u32, b: u32| [a.min(b), a.max(b)];
    for (row, line) in lines.iter().enumerate() {
        // Per point and link the first line that uses it, and whether another one does.
        for point in &line.points {
            let (first, shared) = points.entry(*point).or_insert((row, false));
            *shared |= *first != row;
        }
        for pair in line.points.windows(2) {
            let (first, shared) = links.entry(link(pair[0], pair[1])).or_insert((row, false));
            *shared |= *first != row;
        }
    }
    let meets = |pair: &[u32; 2], at: usize| points[&pair[at]].1 && !links[&link(pair[0], pair[1])].1;
    let begins = |line: &PolyLine| line.points.first_chunk().is_some_and(|pair| meets(pair, 0));
    let ends = |line: &PolyLine| line.points.last_chunk().is_some_and(|pair| meets(pair, 1));
    lines.iter().any(|line| begins(line) || ends(line))
}

/// The lines in an order in which each has an end in common with one before it, where there is such a one.
fn order(all: &PolyLines, radii: &[f64]) -> Vec<usize> {
    let ends = |line: &PolyLine| line.points.first().zip(line.points.last()).map(|(a, b)| [*a as usize, *b as usize]);
    let meet = |a: usize, b: usize| distance(all.at[a], all.at[b]) <= COMMON_END * radii[a].max(radii[b]);
    let mut left: Vec<usize> = (0..all.each.len()).collect();
    let mut order: Vec<usize> = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let mut at = order.len();
        order.push(left.remove(0));
        while let Some(here) = order.get(at).and_then(|row| ends(&all.each[*row])) {
            let common = |row: &usize| ends(&all.each[*row]).is_some_and(|e| e.iter().any(|e| here.iter().any(|h| meet(*h, *e))));
            let (next, others) = left.into_iter().partition::<Vec<usize>, _>(common);
            left = others;
            order.extend(next);
            at += 1;
        }
    }
    order
}

/// The part of a line that it shares with no other, with the points of the tree to which it is attached.
fn rest(all: &PolyLines, radii: &[f64], line: &PolyLine, front: Option<Shared>, back: Option<Shared>) -> Option<PolyLine> {
    let n = line.points.len();
    let first = front.map_or(0, |f| f.last + 1);
    let last = back.map_or(n, |b| n - 1 - b.last);
    if first >= last {
        return None;
    }
    let mut points: Vec<u32> = front.iter().map(|f| f.from).collect();
    points.extend(&line.points[first..last]);
    points.extend(back.iter().map(|b| b.from));
    if front.is_some() && back.is_some() && arc(&all.at, &points) <= WOBBLE * radii[line.points[first] as usize] {
        return None;
    }
    let names = line.names[first - usize::from(front.is_some())..last - usize::from(back.is_none())].to_vec();
    Some(PolyLine { points, names })
}

/// The length of a line.
pub(super) fn arc(at: &[Point], points: &[u32]) -> f64 {
    points.windows(2).map(|p| distance(at[p[0] as usize], at[p[1] as usize])).sum()
}

/// The radii; a missing one is that of the point before, or else the first valid one of the line.
pub(super) fn without_gaps(all: &PolyLines) -> Vec<f64> {
    let mut radii = all.radii.clone();
    for line in &all.each {
        let valid = line.points.iter().map(|p| radii[*p as usize]).find(|r| is_radius(*r));
        let mut before = valid.unwrap_or(0.0);
        for point in &line.points {
            let radius = &mut radii[*point as usize];
            if is_radius(*radius) {
                before = *radius;
            } else {
                *radius = before;
            }
        }
    }
    radii
}

/// Two lines have a common end if their ends are at most this many radii apart.
pub(crate) const COMMON_END: f64 = 0.4;
/// A line has left the tree if it is this many radii away from it,
const LEAVES: f64 = 0.4;
/// and has left for good if it is this many away,
const LOST: f64 = 1.0;
/// or when it has not returned within this many radii of its own length.
const WITHOUT: f64 = 2.0;
/// Two lines are the same vessel when they stay together until this many radii from their common end,
const STRETCH: f64 = 1.0;
/// with at most this many radii between them on average;
const CLOSE: f64 = 0.12;
/// or, where the trunk is shorter, when this many points of one
const SAME_POINTS: usize = 3;
/// are no further than this many radii from points of the other.
const SAME: f64 = 1e-6;
/// The fewest points that show that a line was traced twice: one link of a voxel grid coincides with another by chance.
const LEAST_POINTS: usize = 3;
/// A line that leaves within this many radii of a junction, or within the step to its next point, leaves at the junction.
pub(super) const ONE_JUNCTION: f64 = 1.0;
/// A line is compared with the tree at least once per this many radii,
const BETWEEN: f64 = 0.5;
/// but at most this many times between two of its points.
const MOST_BETWEEN: f64 = 16.0;
/// Points walked in search of one: a ring without length has no end.
const MOST_STEPS: usize = 10_000;

/// The lines merged so far, as links between points.
#[derive(Default)]
struct Tree<'a> {
    at: &'a [Point],
    /// Without gaps, zero on a line that has none.
    radii: &'a [f64],
    links: Vec<[u32; 2]>,
    /// Per point its links.
    links_at: Vec<Vec<u32>>,
    /// The ends of the lines as they were in the file.
    ends: Vec<u32>,
    /// Per link when it was last looked at.
    seen: Vec<u32>,
    now: u32,
}

/// The stretch that a line has in common with the tree, from its first point on.
#[derive(Clone, Copy)]
struct Shared {
    /// The last point of the line that is still on the tree, counted from its first.
    last: usize,
    /// The point of the tree where it leaves.
    from: u32,
}

/// A place on the tree that is near another one.
struct Foot {
    link: u32,
    gap: f64,
    /// The radius there.
    radius: f64,
    /// The nearer end of the link.
    end: u32,
}

impl Tree<'_> {
    /// Adds a line.
    fn add(&mut self, line: &[u32]) {
        for pair in line.windows(2).filter(|pair| pair[0] != pair[1]) {
            for end in pair {
                self.links_at[*end as usize].push(self.links.len() as u32);
            }
            self.links.push([pair[0], pair[1]]);
            self.seen.push(0);
        }
    }

    /// The stretch that a line has in common with the tree, if it begins where a line of the tree begins or ends; and for each of
    /// its points there the point of the tree that replaces it.
    fn follow(&mut self, line: &[u32]) -> Option<(Shared, Vec<u32>)> {
        let (first, start) = (*line.first()?, self.at[*line.first()? as usize]);
        let reach = COMMON_END * self.radii[first as usize];
        let common = self.ends.iter().filter(|end| distance(self.at[**end as usize], start) <= reach);
        let mut on: Vec<u32> = common.flat_map(|end| &self.links_at[*end as usize]).copied().collect();
        if on.is_empty() {
            return None;
        }
        let (mut shared, mut replacements) = (None, Vec::new());
        let (mut is_one, mut sum, mut length, mut same, mut away) = (false, 0.0, 0.0, 0, 0.0);
        let mut before = start;
        for (here, own, n) in self.samples(line) {
            let step = distance(before, here);
            before = here;
            let Some(foot) = self.foot(&on, here, step + LOST * own) else { break };
            let radius = own.min(foot.radius);
            let gap = foot.gap / radius;
            // Not a number where there is no radius.
            if gap.is_nan() || gap > LOST {
                break;
            }
            if gap > LEAVES {
                away += step;
                if away > WITHOUT * radius || !is_one {
                    break;
                }
            } else {
                away = 0.0;
                if let Some(last) = n {
                    shared = Some(Shared { last, from: foot.end });
                    replacements.resize(last + 1, foot.end);
                }
            }
            on = vec![foot.link];
            (sum, length) = (sum + gap * step, length + step);
            if n == Some(same) && distance(here, self.at[foot.end as usize]) <= SAME * radius {
                same += 1;
            }
            is_one |= same >= SAME_POINTS && length > 0.0;
            is_one |= sum <= CLOSE * length && distance(start, here) >= STRETCH * radius;
        }
        let shared = shared.filter(|shared| is_one && shared.last + 1 >= LEAST_POINTS)?;
        let step =
            line.get(shared.last + 1).map_or(0.0, |next| distance(self.at[line[shared.last] as usize], self.at[*next as usize]));
        let reach = step.max(ONE_JUNCTION * self.radii[shared.from as usize]);
        let from = self.junction_near(shared.from, reach);
        replacements[shared.last] = from;
        Some((Shared { from, ..shared }, replacements))
    }

    /// Places along a line with their radii, close enough together to miss nothing between its points; with the number of the
    /// point where it is one.
    fn samples(&self, line: &[u32]) -> Vec<(Point, f64, Option<usize>)> {
        let mut out: Vec<(Point, f64, Option<usize>)> = Vec::with_capacity(line.len());
        for (n, point) in line.iter().enumerate() {
            let (here, own) = (self.at[*point as usize], self.radii[*point as usize]);
            if let Some((before, radius, _)) = out.last().copied() {
                let steps = (distance(before, here) / (BETWEEN * own)).ceil().clamp(1.0, MOST_BETWEEN);
                for step in 1..steps as usize {
                    let share = step as f64 / steps;
                    out.push((lerp(before, here, share), radius + share * (own - radius), None));
                }
            }
            out.push((here, own, Some(n)));
        }
        out
    }

    /// The place nearest to `p` on the links that are connected to `on` within a distance of `reach`.
    fn foot(&mut self, on: &[u32], p: Point, reach: f64) -> Option<Foot> {
        self.now += 1;
        let mut open: Vec<u32> = Vec::new();
        let mut best: Option<Foot> = None;
        let mut next: Vec<u32> = on.to_vec();
        loop {
            for link in next.drain(..) {
                if std::mem::replace(&mut self.seen[link as usize], self.now) == self.now {
                    continue;
                }
                let ends = self.links[link as usize];
                let ([a, b], [from, to]) = (ends.map(|end| self.at[end as usize]), ends.map(|end| self.radii[end as usize]));
                let along = sub(b, a);
                let share = if norm_squared(along) > 0.0 { dot(sub(p, a), along) / norm_squared(along) } else { 0.0 };
                let share = share.clamp(0.0, 1.0);
                let gap = distance(p, lerp(a, b, share));
                if gap <= reach {
                    open.push(link);
                    if best.as_ref().is_none_or(|best| gap < best.gap) {
                        best = Some(Foot { link, gap, radius: from + share * (to - from), end: ends[usize::from(share > 0.5)] });
                    }
                }
            }
            let Some(link) = open.pop() else { return best };
            next.extend(self.links[link as usize].iter().flat_map(|end| &self.links_at[*end as usize]));
        }
    }

    /// The nearest junction along the tree, where one is near; else the point itself.
    fn junction_near(&self, point: u32, reach: f64) -> u32 {
        let mut best: (f64, u32) = (f64::INFINITY, point);
        // Between junctions the tree has no branches, so each direction is walked once.
        if self.links_at[point as usize].len() > 2 {
            return point;
        }
        for link in &self.links_at[point as usize] {
            let (mut link, mut here, mut length) = (*link, point, 0.0);
            for _ in 0..MOST_STEPS {
                let [a, b] = self.links[link as usize];
                let there = if a == here { b } else { a };
                length += distance(self.at[here as usize], self.at[there as usize]);
                if length > reach {
                    break;
                }
                let links_at = &self.links_at[there as usize];
                if links_at.len() > 2 {
                    if length < best.0 {
                        best = (length, there);
                    }
                    break;
                }
                let Some(next) = links_at.iter().find(|next| **next != link) else { break };
                (link, here) = (*next, there);
            }
        }
        best.1
    }
}
