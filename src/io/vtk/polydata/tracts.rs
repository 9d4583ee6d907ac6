//! Puts the lines together again that `vmtkbranchextractor` cut into pieces, each shared piece once for every line.

use super::{Array, Line, Lines, PolyData, Values};
use crate::support::geometry::{box_diagonal, distance};

const CENTERLINE: &str = "CenterlineIds";
const TRACT: &str = "TractIds";
const GROUP: &str = "GroupIds";
/// Consecutive pieces share a position; within this fraction of the bounding box.
const TOUCH: f64 = 1e-6;

/// Which stretch of which line a piece is.
pub(crate) struct Tract {
    centerline: i64,
    order: i64,
    group: i64,
    line: usize,
}

pub(crate) fn is_wanted(name: &str) -> bool {
    [CENTERLINE, TRACT, GROUP].contains(&name)
}

/// The tracts of a piece of the file whose lines start at `from`; none where it does not say.
pub(crate) fn of_lines(piece: &PolyData, from: usize) -> Vec<Tract> {
    let numbers = |name: &str| {
        piece.line_data.iter().find_map(|Array { name: found, values }| match values {
            Values::Numbers(values) if found == name => Some(values),
            _ => None,
        })
    };
    let (Some(lines), Some(tracts), Some(groups)) = (numbers(CENTERLINE), numbers(TRACT), numbers(GROUP)) else {
        return Vec::new();
    };
    let rows = lines.iter().zip(tracts).zip(groups).enumerate();
    rows.map(|(row, ((c, t), g))| Tract { centerline: *c as i64, order: *t as i64, group: *g as i64, line: from + row }).collect()
}

/// Joins pieces when a group occurs in several lines (`vmtkcenterlinemerge` leaves each once); says how many were joined.
pub(crate) fn join(all: &mut Lines, mut tracts: Vec<Tract>) -> Option<String> {
    tracts.sort_by_key(|t| (t.group, t.centerline));
    if !tracts.windows(2).any(|t| t[0].group == t[1].group && t[0].centerline != t[1].centerline) {
        return None;
    }
    tracts.sort_by_key(|t| (t.centerline, t.order, t.line));
    let reach = TOUCH * box_diagonal(all.each.iter().flat_map(|l| &l.points).map(|p| all.at[*p as usize]));
    let near = |a: Option<&u32>, b: Option<&u32>| {
        a.zip(b).is_some_and(|(a, b)| distance(all.at[*a as usize], all.at[*b as usize]) <= reach)
    };
    let mut joined: Vec<Line> = Vec::new();
    let pieces = tracts.len();
    let mut first_of_line = true;
    for (n, tract) in tracts.iter().enumerate() {
        let mut next = std::mem::replace(&mut all.each[tract.line], Line { points: Vec::new(), names: Vec::new(), strand: 0 });
        let fresh = n == 0 || tracts[n - 1].centerline != tract.centerline;
        if let Some(line) = joined.last_mut().filter(|_| !fresh) {
            let meets = |p: Option<&u32>, next: &Line| near(p, next.points.first()) || near(p, next.points.last());
            if first_of_line && !meets(line.points.last(), &next) && meets(line.points.first(), &next) {
                reverse(line);
            }
            if !near(line.points.last(), next.points.first()) && near(line.points.last(), next.points.last()) {
                reverse(&mut next);
            }
            if near(line.points.last(), next.points.first()) {
                line.points.extend(&next.points[1..]);
                line.names.extend(next.names);
                first_of_line = false;
                continue;
            }
        }
        first_of_line = true;
        joined.push(next);
    }
    let note = format!("{pieces} pieces are {} lines by their {CENTERLINE} and {TRACT}", joined.len());
    all.each.retain(|line| !line.points.is_empty());
    all.each.extend(joined);
    Some(note)
}

fn reverse(line: &mut Line) {
    line.points.reverse();
    line.names.reverse();
}
