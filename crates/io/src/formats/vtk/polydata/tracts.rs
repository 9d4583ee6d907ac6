//! Joins the pieces into which `vmtkbranchextractor` cuts lines, by the ids that it gives them.
//!
//! `CenterlineIds` and `TractIds` say which pieces make a line and in which order. `GroupIds` say which pieces of several lines are the
//! same branch, or the same bifurcation: from the sphere before it, where the lines begin to separate, to where each has left the
//! tube around the others. So a group is there once for every line through it, and its pieces are up to a radius apart.
//!
//! The first piece of a group is taken as it is and stands for all. What follows it in another line is hung on where that begins to
//! leave it. So the length is that of every group once, and at each bifurcation some radius more from the axis to the branch that
//! is hung on there.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::data::{PolyData, PolyLine, PolyLines, numbers};
use super::overlap::{COMMON_END, ONE_JUNCTION, arc, without_gaps};
use crate::formats::{Point, box_diagonal, distance, millimetres, plural};

const CENTERLINE: &str = "CenterlineIds";
const TRACT: &str = "TractIds";
const GROUP: &str = "GroupIds";
/// The arrays that number the pieces.
pub(super) const IDS: [&str; 3] = [CENTERLINE, TRACT, GROUP];
/// Points that are one, as a fraction of the bounding box.
const TOUCH: f64 = 1e-6;
/// Consecutive pieces follow each other over a gap of this many radii at most, or of the step between their points there.
const GAP: f64 = 0.4;
/// A piece that is more than this many radii away from another one is no copy of it, whatever its group.
const COPY: f64 = 2.0;
/// A branch is hung on no further away than this many times the distance to the nearest point.
const HARDLY_FURTHER: f64 = 1.2;
/// Points of the other piece that are looked at for the next point of a copy.
const AHEAD: usize = 8;
/// Different vessels that a group may stand for, where its number means something else.
const MOST_OF_A_GROUP: usize = 8;

/// A piece of a line.
pub(super) struct Tract {
    centerline: i64,
    order: i64,
    group: i64,
    line: usize,
}

/// The tracts of a piece of the file whose lines start at `from`; none without VMTK's arrays.
pub(super) fn tracts_of_lines(piece: &PolyData, from: usize) -> Vec<Tract> {
    let [Some(lines), Some(tracts), Some(groups)] = IDS.map(|name| numbers(&piece.line_data, name)) else { return Vec::new() };
    let rows = lines.iter().zip(tracts).zip(groups).enumerate();
    rows.map(|(row, ((c, t), g))| Tract { centerline: *c as i64, order: *t as i64, group: *g as i64, line: from + row }).collect()
}

/// The first points of the lines, if there are several and all start at one place: the source from which VMTK traced them.
pub(super) fn common_start(all: &PolyLines, starts: Vec<u32>) -> Vec<u32> {
    let radii = without_gaps(all);
    let at = |point: u32| all.at[point as usize];
    let Some(first) = starts.first().copied() else { return starts };
    let is_near = |point: &u32| distance(at(first), at(*point)) <= COMMON_END * radii[first as usize].max(radii[*point as usize]);
    if starts.iter().all(is_near) { starts } else { Vec::new() }
}

/// Where the lines start of which the file has pieces, if that is one place.
pub(super) fn source(all: &PolyLines, tracts: &[Tract]) -> Vec<u32> {
    if tracts.iter().all(|tract| tract.centerline == tracts[0].centerline) {
        return Vec::new();
    }
    let first = tracts.iter().filter(|tract| tract.order == 0);
    common_start(all, first.filter_map(|tract| all.each[tract.line].points.first().copied()).collect())
}

/// A piece in the direction of its line.
struct Piece {
    line: PolyLine,
    group: i64,
    /// The gap to the piece before it, m.
    gap: f64,
    /// Whether it follows that piece.
    follows: bool,
}

/// Joins the pieces again when a group occurs in several lines (`vmtkcenterlinemerge` leaves each once); a note says how many.
pub(super) fn join(all: &mut PolyLines, mut tracts: Vec<Tract>) -> Option<String> {
    tracts.sort_by_key(|t| (t.group, t.centerline));
    if !tracts.windows(2).any(|t| t[0].group == t[1].group && t[0].centerline != t[1].centerline) {
        return None;
    }
    tracts.sort_by_key(|t| (t.centerline, t.order, t.line));
    let radii = without_gaps(all);
    let touch = TOUCH * box_diagonal(all.each.iter().flat_map(|l| &l.points).map(|p| all.at[*p as usize]));
    let lines = tracts.chunk_by(|a, b| a.centerline == b.centerline).map(|line| in_order(all, &radii, touch, line));
    let lines: Vec<Vec<Piece>> = lines.collect();
    let pieces = lines.iter().flatten();
    let closed: Vec<f64> = pieces.clone().filter(|p| p.follows && p.gap > touch).map(|p| p.gap).collect();
    let mut said = vec![format!("{} pieces are {} lines by their {CENTERLINE} and {TRACT}", pieces.count(), lines.len())];
    let mut groups = Groups { at: &all.at, radii: &radii, touch, ..Groups::default() };
    for line in lines {
        groups.add(line);
    }
    let Groups { each, merged, shared, open, .. } = groups;
    let longest = |gaps: &mut dyn Iterator<Item = f64>| brief_millimetres(gaps.fold(0.0, f64::max));
    if shared > 0.0 {
        said.push(format!("those of one {GROUP} are one vessel, over {:.1} mm in all", millimetres(shared)));
    }
    if !closed.is_empty() {
        let widest = longest(&mut closed.iter().copied());
        said.push(format!("{} between them closed, of {widest} mm at most", plural(closed.len(), "gap")));
    }
    if !open.is_empty() {
        let widest = longest(&mut open.values().copied());
        let count = plural(open.len(), "gap");
        said.push(format!("{count} of up to {widest} mm left open, wider than the step between points and {GAP} radii"));
    }
    all.each.retain(|line| !line.points.is_empty());
    all.each.extend(each);
    all.merged = merged;
    Some(said.join("; "))
}

/// A length with two significant digits.
fn brief_millimetres(length: f64) -> String {
    let length = millimetres(length);
    let digits = (1.0 - length.max(1e-9).log10().floor()).clamp(0.0, 9.0);
    format!("{length:.*}", digits as usize)
}

/// Takes the pieces of a line out of the file's lines, each turned to follow the one before it.
fn in_order(all: &mut PolyLines, radii: &[f64], touch: f64, tracts: &[Tract]) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::with_capacity(tracts.len());
    let mut is_turned = false;
    for tract in tracts {
        let mut line = std::mem::take(&mut all.each[tract.line]);
        if line.points.is_empty() {
            continue;
        }
        let gap = |a: &[u32], b: &[u32]| gap_between(&all.at, radii, touch, a, b);
        let backwards = |line: &PolyLine| line.points.iter().rev().copied().collect::<Vec<u32>>();
        let (mut width, mut follows) = (0.0, false);
        if let Some(before) = out.last_mut() {
            let meets = |points: &[u32]| gap(points, &line.points).1 || gap(points, &backwards(&line)).1;
            let turned = backwards(&before.line);
            if !is_turned && !meets(&before.line.points) && meets(&turned) {
                reverse(&mut before.line);
            }
            let turned = backwards(&line);
            if !gap(&before.line.points, &line.points).1 && gap(&before.line.points, &turned).1 {
                reverse(&mut line);
            }
            (width, follows) = gap(&before.line.points, &line.points);
        }
        // What follows another piece has its direction.
        is_turned = follows;
        out.push(Piece { line, group: tract.group, gap: width, follows });
    }
    out
}

/// How far apart the end of a piece and the start of another one are, and whether that is near enough to follow it.
fn gap_between(at: &[Point], radii: &[f64], touch: f64, a: &[u32], b: &[u32]) -> (f64, bool) {
    let (Some(end), Some(start)) = (a.last(), b.first()) else { return (0.0, false) };
    let far = |a: u32, b: u32| distance(at[a as usize], at[b as usize]);
    let width = far(*end, *start);
    let steps = [a.len().checked_sub(2).and_then(|n| a.get(n..)), b.get(..2)];
    let step = steps.into_iter().flatten().map(|pair| far(pair[0], pair[1])).fold(0.0, f64::max);
    let reach = touch.max(step).max(GAP * radii[*end as usize].max(radii[*start as usize]));
    (width, width <= reach)
}

fn reverse(line: &mut PolyLine) {
    line.points.reverse();
    line.names.reverse();
}

/// Which vessel a piece is: its group, and the number among those that the group stands for.
type GroupVessel = (i64, usize);

/// The vessels found so far, by group, and how they are connected.
#[derive(Default)]
struct Groups<'a> {
    at: &'a [Point],
    radii: &'a [f64],
    touch: f64,
    /// The points of the piece that stands for a vessel.
    points: HashMap<GroupVessel, Vec<u32>>,
    /// The points of a vessel at which others are hung on.
    junctions: HashMap<GroupVessel, Vec<u32>>,
    linked: HashSet<[GroupVessel; 2]>,
    /// Vessels of which one follows the other over a gap that is too wide, m.
    open: BTreeMap<[GroupVessel; 2], f64>,
    each: Vec<PolyLine>,
    merged: Vec<[u32; 2]>,
    /// The length of the pieces for which others stand, m.
    shared: f64,
}

impl Groups<'_> {
    /// Adds a line, piece after piece.
    fn add(&mut self, pieces: Vec<Piece>) {
        // The vessel of the piece before, its last point, and whether it is of this line.
        let mut before: Option<(GroupVessel, u32, bool)> = None;
        for Piece { line, group, gap, follows } in pieces {
            let [first, last] = [line.points[0], line.points[line.points.len() - 1]];
            let (vessel, is_new) = self.vessel_of(group, &line.points);
            let pair = before.map(|(from, _, _)| [from, vessel]).filter(|[from, to]| from != to);
            let is_link = follows && pair.is_some_and(|pair| self.linked.insert(pair));
            if let Some(pair) = pair.filter(|pair| !follows && !self.linked.contains(pair)) {
                self.open.insert(pair, gap);
            }
            if let (Some(pair), Some((from, end, is_own))) = (pair.filter(|_| is_link), before) {
                self.open.remove(&pair);
                if !is_own {
                    let start = self.hang(from, first, false);
                    self.each.push(PolyLine { points: vec![start], names: Vec::new() });
                }
                if is_new {
                    // Where the two touch, the point of the piece before stands for both.
                    let start = self.go_on(line);
                    if let Some(point) = self.points.get_mut(&vessel).and_then(|points| points.first_mut()) {
                        *point = start;
                    }
                } else {
                    let to = self.hang(vessel, end, true);
                    self.go_on(PolyLine { points: vec![to], names: Vec::new() });
                }
            } else if is_new {
                self.each.push(line);
            }
            before = Some((vessel, last, is_new));
        }
    }

    /// Continues the last line; returns its point at which that begins.
    fn go_on(&mut self, next: PolyLine) -> u32 {
        let start = next.points[0];
        let Some(line) = self.each.last_mut() else { return start };
        let end = line.points[line.points.len() - 1];
        let touch = distance(self.at[end as usize], self.at[start as usize]) <= self.touch && next.points.len() > 1;
        if touch {
            self.merged.push([start, end]);
            line.points.extend(&next.points[1..]);
        } else {
            line.names.push(next.names.first().or(line.names.last()).copied().unwrap_or_default());
            line.points.extend(&next.points);
        }
        line.names.extend(next.names);
        if touch { end } else { start }
    }

    /// The vessel that a piece is, and whether it is the first piece of it.
    fn vessel_of(&mut self, group: i64, points: &[u32]) -> (GroupVessel, bool) {
        for number in 0..MOST_OF_A_GROUP {
            let Some(standing) = self.points.get(&(group, number)) else {
                self.points.insert((group, number), points.to_vec());
                return ((group, number), true);
            };
            if let Some(replacements) = self.copy(points, standing) {
                self.merged.extend(points.iter().zip(replacements).map(|(gone, stays)| [*gone, stays]));
                self.shared += arc(self.at, points);
                return ((group, number), false);
            }
        }
        let number = self.points.len();
        self.points.insert((group, MOST_OF_A_GROUP + number), points.to_vec());
        ((group, MOST_OF_A_GROUP + number), true)
    }

    /// Per point of a piece the point of another one beside it, if the piece runs along the other all the way.
    fn copy(&self, points: &[u32], other: &[u32]) -> Option<Vec<u32>> {
        let far = |a: u32, b: u32| distance(self.at[a as usize], self.at[b as usize]);
        let mut here = 0;
        let beside = points.iter().map(|point| {
            let ahead = here..other.len().min(here + AHEAD);
            here = ahead.min_by(|a, b| far(other[*a], *point).total_cmp(&far(other[*b], *point)))?;
            let step = |from: usize| other.get(from..from + 2).map_or(0.0, |pair| far(pair[0], pair[1]));
            let step = step(here).max(here.checked_sub(1).map_or(0.0, step));
            let radius = self.radii[*point as usize].max(self.radii[other[here] as usize]);
            (far(other[here], *point) <= COPY * radius + step).then_some(other[here])
        });
        beside.collect()
    }

    /// The point of a vessel where another one is hung on whose point next to it is given: of those hardly further away than the
    /// nearest one the first, or where the other one comes before it, the last. There the two begin to separate.
    fn hang(&mut self, on: GroupVessel, next: u32, comes_before: bool) -> u32 {
        let far = |a: u32, b: u32| distance(self.at[a as usize], self.at[b as usize]);
        let points = self.points.get(&on).map_or(&[][..], Vec::as_slice);
        let nearest = points.iter().map(|point| far(*point, next)).fold(f64::INFINITY, f64::min);
        let mut near = points.iter().copied().filter(|point| far(*point, next) <= HARDLY_FURTHER * nearest);
        let point = if comes_before { near.next_back() } else { near.next() }.unwrap_or(next);
        let junctions = self.junctions.entry(on).or_default();
        let reach = ONE_JUNCTION * self.radii[point as usize];
        let other = junctions.iter().copied().min_by(|a, b| far(*a, point).total_cmp(&far(*b, point)));
        if let Some(other) = other.filter(|other| far(*other, point) <= reach) {
            return other;
        }
        junctions.push(point);
        point
    }
}
