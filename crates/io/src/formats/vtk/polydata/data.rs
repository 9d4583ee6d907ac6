//! The polylines and named arrays of a VTK file, as they are read and while they are joined; which array holds the radius.

use crate::formats::{Fault, Point, ReadOptions, is_radius, radius_of};
use willis_core::support::{numbered::marked, suggestions::did_you_mean};

/// The most points, cells or indices of a file: one that announces more is broken.
pub(crate) const LIMIT: usize = 1 << 26;

/// A named array with one value for each point, or for each line.
pub(crate) struct NamedValues {
    /// Its name, trimmed.
    pub(crate) name: String,
    /// Its values.
    pub(crate) values: ArrayValues,
}

/// The numbers of the first of some arrays that has this name and holds numbers.
pub(super) fn numbers<'a>(arrays: &'a [NamedValues], wanted: &str) -> Option<&'a Vec<f64>> {
    arrays.iter().find_map(|NamedValues { name, values }| match values {
        ArrayValues::Numbers(values) if name == wanted => Some(values),
        _ => None,
    })
}

/// The values of an array.
pub(crate) enum ArrayValues {
    /// Numbers, one for each point or line.
    Numbers(Vec<f64>),
    /// Texts, one for each point or line.
    Texts(Vec<String>),
    /// Not read.
    Unread,
}

/// Polylines with the arrays of their points and of the lines.
#[derive(Default)]
pub(crate) struct PolyData {
    /// How many points and lines of the file come before these.
    pub(crate) before: [usize; 2],
    /// Positions in the file's unit.
    pub(crate) points: Vec<[f64; 3]>,
    /// Per line where it ends in `cells`.
    pub(crate) ends: Vec<i64>,
    /// The points of the lines, one line after the other.
    pub(crate) cells: Vec<i64>,
    /// One value for each point.
    pub(crate) point_data: Vec<NamedValues>,
    /// One value for each line.
    pub(crate) line_data: Vec<NamedValues>,
}

/// A line of the file, or the rest of it after merging.
#[derive(Clone, Default)]
pub(crate) struct PolyLine {
    /// The rows of its points.
    pub(super) points: Vec<u32>,
    /// Per link the row of its label; 0 for none.
    pub(super) names: Vec<u32>,
}

/// The lines of all pieces together, in m.
#[derive(Default)]
pub(crate) struct PolyLines {
    pub(super) at: Vec<Point>,
    pub(super) radii: Vec<f64>,
    /// The labels of links, those of each line that has one; the first one is empty.
    pub(super) names: Vec<String>,
    /// With each of these the radius that the line states, m; NaN where points state theirs.
    pub(super) line_radii: Vec<f64>,
    pub(super) each: Vec<PolyLine>,
    /// Points that were merged away, each with the one that replaces it.
    pub(super) merged: Vec<[u32; 2]>,
    /// The points at which all lines of the file start.
    pub(super) sources: Vec<u32>,
}

/// Cross-section areas: VMTK's and SimVascular's, and what others call the same.
const AREAS: [&str; 6] =
    ["CenterlineSectionArea", "SectionArea", "CrossSectionArea", "CrossSectionalArea", "ce_area", "cross_section_area"];
/// The radius of the circle with the area of the cross-section.
const EQUIVALENT: [&str; 1] = ["ce_radius"];
/// The usual names of the radius, the first one first; of the inscribed sphere mostly.
const RADII: [&str; 6] = ["MaximumInscribedSphereRadius", "Radius", "radius", "mis_radius", "radius_avg", "avgRadius"];
/// Names of `RADII` that a message lists.
const NAMED: usize = 3;
/// Zero where VMTK cut a vessel that it could not close: its area is none.
const CLOSED: &str = "CenterlineSectionClosed";

/// Whether an array may hold radii: the one that is asked for, or one with a usual name.
pub(super) fn is_of_radii(name: &str, options: &ReadOptions) -> bool {
    let named = options.radius_array.as_deref().is_some_and(|wanted| wanted.trim() == name);
    named || name == CLOSED || AREAS.iter().chain(&EQUIVALENT).chain(&RADII).any(|usual| *usual == name)
}

/// An array with a value for each point; one with a value for each line is averaged onto the points.
struct Found {
    name: String,
    of_lines: bool,
    values: Vec<f64>,
}

impl Found {
    fn title(&self) -> String {
        let kind = if self.of_lines { "cell" } else { "point" };
        format!("{kind} array \"{}\"", self.name)
    }
}

/// The radius of every point in the file's unit (NaN, zero and negative values are missing ones), whether lines state it, and a note for the user.
///
/// Areas give r = sqrt(a / pi), the radius of Moriconi et al. 2019, eq. 1, before any radius of an inscribed sphere; where an
/// area or an equivalent radius is missing, the inscribed sphere's stands in. The array that the options name holds areas when
/// its name says "area"; no array at all is an error unless the radius is optional. An array with one value for each line gives
/// each point the mean of the lines that it is on.
pub(super) fn radii(
    piece: &PolyData,
    cells: &[Vec<usize>],
    options: &ReadOptions,
) -> Result<(Vec<f64>, bool, Option<String>), Fault> {
    let find = |names: &[&str]| names.iter().find_map(|name| find(piece, cells, name));
    let named = options.radius_array.as_deref().map(str::trim);
    let (mut first, is_area) = if let Some(name) = named {
        (find(&[name]).ok_or_else(|| missing(piece, named))?, name.to_ascii_lowercase().contains("area"))
    } else {
        match (find(&AREAS), find(&EQUIVALENT).or_else(|| find(&RADII))) {
            (Some(area), _) => (area, true),
            (None, Some(radius)) => (radius, false),
            (None, None) if options.is_radius_optional() => return Ok((vec![f64::NAN; piece.points.len()], false, None)),
            (None, None) => return Err(missing(piece, None)),
        }
    };
    if is_area {
        let closed = find(&[CLOSED]);
        let closed = |point: usize| closed.as_ref().is_none_or(|c| c.values[point] != 0.0);
        for (point, value) in first.values.iter_mut().enumerate() {
            *value = if closed(point) { radius_of(*value) } else { f64::NAN };
        }
    }
    let mut note = if is_area {
        format!("radius from the areas of {}: r = sqrt(a / pi)", first.title())
    } else if EQUIVALENT.contains(&first.name.as_str()) || (first.of_lines && named.is_none()) {
        format!("radius from {}", first.title())
    } else {
        let note = first.of_lines.then(|| format!("each point has the mean \"{}\" of its cells", first.name));
        return Ok((first.values, first.of_lines, note));
    };
    let used = marked(piece.points.len(), cells.iter().flatten().copied());
    let holes: Vec<usize> = (0..first.values.len()).filter(|p| used[*p] && !is_radius(first.values[*p])).collect();
    let spare = if is_area { find(&EQUIVALENT).or_else(|| find(&RADII)) } else { find(&RADII) };
    if let Some(spare) = spare.filter(|spare| spare.name != first.name && !holes.is_empty()) {
        for point in &holes {
            first.values[*point] = spare.values[*point];
        }
        note = format!("{note}; at {} points without one from {}", holes.len(), spare.title());
    }
    if first.of_lines {
        note += "; a point has the mean of its cells";
    }
    Ok((first.values, first.of_lines, Some(note)))
}

/// The radius of every line, as if each had a point of its own.
pub(super) fn radii_of_lines(piece: &mut PolyData, options: &ReadOptions) -> Result<Vec<f64>, Fault> {
    let line_data = std::mem::take(&mut piece.line_data);
    let alone = PolyData { points: vec![[0.0; 3]; piece.ends.len()], line_data, ..PolyData::default() };
    let each: Vec<Vec<usize>> = (0..alone.points.len()).map(|line| vec![line]).collect();
    let found = radii(&alone, &each, options)?.0;
    piece.line_data = alone.line_data;
    Ok(found)
}

fn find(piece: &PolyData, cells: &[Vec<usize>], name: &str) -> Option<Found> {
    if let Some(values) = numbers(&piece.point_data, name) {
        return Some(Found { name: name.to_owned(), of_lines: false, values: values.clone() });
    }
    let of_line = numbers(&piece.line_data, name)?.iter().copied();
    let mut sum = vec![(0.0, 0.0); piece.points.len()];
    for (cell, value) in cells.iter().zip(of_line) {
        if is_radius(value) {
            for p in cell {
                sum[*p] = (sum[*p].0 + value, sum[*p].1 + 1.0);
            }
        }
    }
    let values = sum.into_iter().map(|(sum, n)| if n > 0.0 { sum / n } else { f64::NAN }).collect();
    Some(Found { name: name.to_owned(), of_lines: true, values })
}

fn missing(piece: &PolyData, name: Option<&str>) -> Fault {
    let names = |arrays: &[NamedValues]| arrays.iter().map(|a| format!("\"{}\"", a.name)).collect::<Vec<_>>().join(", ");
    let (points, lines) = (names(&piece.point_data), names(&piece.line_data));
    let lines = if lines.is_empty() { lines } else { format!("the cell arrays {lines}") };
    let all = [points, lines].into_iter().filter(|names| !names.is_empty()).collect::<Vec<_>>().join(" and ");
    let has = if all.is_empty() { "there are none".to_owned() } else { format!("there are {all}") };
    match name {
        Some(name) => {
            let known = || piece.point_data.iter().chain(&piece.line_data).map(|a| a.name.as_str());
            if known().any(|known| known == name) {
                return Fault::file(
                    format!("array \"{name}\" of texts or vectors"),
                    "expected one number for each point or line",
                );
            }
            Fault::file(format!("no point array \"{name}\""), format!("{}{has}", did_you_mean(name, known())))
        }
        None => Fault::file(
            format!("no point array {}", RADII[..NAMED].join(", ")),
            format!("{has}; name one with `radius_array`, or give `default_radius`"),
        ),
    }
}
