//! Makes one vessel of stretches that several lines share.
//!
//! `vmtkcenterlines` traces a line from each target back to a source, each for itself: the trunk is there once for every outlet.
//! The lines lie on each other to the last bit or nearly (numerical noise, smoothing and resampling move them by a fraction of the
//! radius), run apart slowly where their vessels part, and no point of one is a point of another.
//!
//! The first line is taken as it is. Every next one (those that have an end in common with a line before them first) is followed
//! along those taken so far, from a common end, a source or a target, stored forwards or backwards, to where it leaves them for
//! good ([`super::tree`]); only what is left of it is hung on there. So the shared stretch keeps the points and radii of the line
//! that came first. All tolerances are fractions of the local radius:
//!
//! - a common end: within 0.4 radii. Without one lines are never merged, however near they pass;
//! - the same vessel: together until one radius from the common end, 0.12 radii apart on the mean, or coincident in their first
//!   three points; three points of the line at least. Two vessels that leave a junction under more than some 14 degrees are thus
//!   two from its first point;
//! - left for good: more than 0.4 radii away and not back within two radii; more than one radius away;
//! - one junction: leaving within a radius of a junction, or one step of the line, is leaving at it, so that a trifurcation is one.
//!
//! A file in which lines end at a point that another line uses too, without the link beside it, knows how its lines hang together:
//! it is a network already (`vmtkcenterlinemerge`, skeletons, tracings), and nothing in it is merged.
//!
//! The place on the tree moves along it with the line, never by a jump: a vessel that turns back beside itself is not cut short.

use std::collections::HashMap;

use super::tree::{COMMON_END, Shared, Tree};
use super::{Line, Lines};
use crate::network::centerlines::is_radius;
use crate::network::units::millimetres;
use crate::support::geometry::distance;

/// More lines than a source has outlets: such a file holds pieces of a network, each of them once.
const MOST: usize = 4096;
/// Between two places on the tree a remainder this many radii long is no vessel.
const WOBBLE: f64 = 2.0;

/// Merges the lines; says over which length, if at all.
pub(crate) fn merge(all: &mut Lines) -> Option<String> {
    if all.each.len() < 2 || all.each.len() > MOST || knows_its_nodes(&all.each) {
        return None;
    }
    let radii = without_gaps(all);
    let mut tree = Tree::new(&all.at, &radii);
    let mut kept: Vec<Option<Line>> = vec![None; all.each.len()];
    let mut all_merged = Vec::new();
    let (mut merged, mut length) = (0, 0.0);
    for row in order(all, &radii) {
        let line = &all.each[row];
        let backwards: Vec<u32> = line.points.iter().rev().copied().collect();
        let [front, back] = [&line.points, &backwards].map(|points| {
            let (shared, stands) = tree.follow(points)?;
            all_merged.extend(points.iter().zip(stands).map(|(gone, stays)| [*gone, stays]));
            Some(shared)
        });
        for (shared, end) in [(front, line.points.first()), (back, line.points.last())] {
            if let (None, Some(end)) = (shared, end) {
                tree.add_end(*end);
            }
        }
        let rest = match (front, back) {
            (None, None) => Some(line.clone()),
            _ => rest(all, &radii, line, front, back),
        };
        if front.is_some() || back.is_some() {
            merged += 1;
            length += arc(all, &line.points) - rest.as_ref().map_or(0.0, |rest| arc(all, &rest.points));
        }
        if let Some(rest) = rest {
            tree.add(&rest.points);
            kept[row] = Some(rest);
        }
    }
    if merged == 0 {
        return None;
    }
    all.merged = all_merged;
    let all_lines = all.each.len();
    all.each = kept.into_iter().flatten().collect();
    let length = millimetres(length);
    Some(format!("{merged} of {all_lines} lines run together with others, over {length:.1} mm in all: made one vessel each time"))
}

/// Whether a line ends at a point that another line uses too, by a link that no other line has.
fn knows_its_nodes(lines: &[Line]) -> bool {
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
    lines.iter().any(|line| {
        let ends = [line.points.get(..2), line.points.len().checked_sub(2).and_then(|n| line.points.get(n..))];
        let at = [0, 1];
        ends.into_iter()
            .zip(at)
            .any(|(pair, at)| pair.is_some_and(|pair| points[&pair[at]].1 && !links[&link(pair[0], pair[1])].1))
    })
}

/// The lines in an order in which each has an end in common with one before it, where there is such a one.
fn order(all: &Lines, radii: &[f64]) -> Vec<usize> {
    let ends = |line: &Line| line.points.first().zip(line.points.last()).map(|(a, b)| [*a as usize, *b as usize]);
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

/// What a line has for itself, with the points of the tree that it hangs on.
fn rest(all: &Lines, radii: &[f64], line: &Line, front: Option<Shared>, back: Option<Shared>) -> Option<Line> {
    let n = line.points.len();
    let first = front.map_or(0, |f| f.last + 1);
    let last = back.map_or(n, |b| n - 1 - b.last);
    if first >= last {
        return None;
    }
    let mut points: Vec<u32> = front.iter().map(|f| f.from).collect();
    points.extend(&line.points[first..last]);
    points.extend(back.iter().map(|b| b.from));
    if front.is_some() && back.is_some() && arc(all, &points) <= WOBBLE * radii[line.points[first] as usize] {
        return None;
    }
    let names = line.names[first - usize::from(front.is_some())..last - usize::from(back.is_none())].to_vec();
    Some(Line { points, names, strand: line.strand })
}

fn arc(all: &Lines, points: &[u32]) -> f64 {
    points.windows(2).map(|p| distance(all.at[p[0] as usize], all.at[p[1] as usize])).sum()
}

/// The radii with those of the point before, or else the first valid one of the line, where they are missing.
fn without_gaps(all: &Lines) -> Vec<f64> {
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
