//! The polylines and named arrays of a VTK file, as they are read and while they are joined.

use willis_core::support::geometry::Point;

/// The most points, cells or indices of a file: one that announces more is broken.
pub(crate) const LIMIT: usize = 1 << 26;

/// A named array with one value for each point, or for each line.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ArrayValues {
    /// Numbers, one for each point or line.
    Numbers(Vec<f64>),
    /// Texts, one for each point or line.
    Texts(Vec<String>),
    /// Not read.
    Unread,
}

/// Polylines with the arrays of their points and of the lines.
#[derive(Debug, Clone, Default, PartialEq)]
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
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PolyLine {
    /// The rows of its points.
    pub(super) points: Vec<u32>,
    /// Per link the row of its label; 0 for none.
    pub(super) names: Vec<u32>,
    /// Its number in the file.
    pub(super) strand: u32,
}

/// The lines of all pieces together, in m.
#[derive(Debug, Default)]
pub(crate) struct PolyLines {
    pub(super) at: Vec<Point>,
    pub(super) radii: Vec<f64>,
    /// The labels of links; the first one is empty.
    pub(super) names: Vec<String>,
    pub(super) each: Vec<PolyLine>,
    /// Points that were merged away, each with the one that replaces it.
    pub(super) merged: Vec<[u32; 2]>,
    /// The points at which all lines of the file start.
    pub(super) sources: Vec<u32>,
}
