//! The point of a tube nearest to another, for children that do not say where they hang.

use std::collections::HashMap;
use std::ops::Range;

use super::scene::{Cursor, Object};
use crate::error::Fault;
use crate::support::geometry::{Point, distance};

/// Tubes whose points have been sorted along their longest axis.
#[derive(Default)]
pub struct Nearest {
    sorted: HashMap<usize, (usize, Vec<usize>)>,
}

impl Nearest {
    /// The point of the parent and the end of the child that are nearest to one another.
    pub fn pair(&mut self, points: &[Point], parent: Range<usize>, ends: [usize; 2]) -> [usize; 2] {
        let (axis, sorted) = self.sorted.entry(parent.start).or_insert_with(|| sort(points, parent));
        let x = |row: usize| points[row][*axis];
        let mut best = (f64::INFINITY, [sorted[0], ends[0]]);
        for end in ends {
            let (left, right) = sorted.split_at(sorted.partition_point(|row| x(*row) < x(end)));
            let mut consider = |row: &usize| {
                let apart = distance(points[*row], points[end]);
                if apart < best.0 || (apart == best.0 && end == best.1[1] && *row < best.1[0]) {
                    best = (apart, [*row, end]);
                }
                (x(*row) - x(end)).abs() <= best.0
            };
            let _ = left.iter().rev().all(&mut consider);
            let _ = right.iter().all(consider);
        }
        best.1
    }
}

/// The axis along which points extend the most, and their rows in its order.
fn sort(points: &[Point], range: Range<usize>) -> (usize, Vec<usize>) {
    let extent = |axis: usize| {
        let x = || points[range.clone()].iter().map(|p| p[axis]);
        x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
    };
    let axis = (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(0);
    let mut rows: Vec<usize> = range.collect();
    rows.sort_by(|a, b| points[*a][axis].total_cmp(&points[*b][axis]));
    (axis, rows)
}

/// Names of the radius, as MetaIO knows them.
const RADIUS: [&str; 7] = ["r", "R", "radius", "Radius", "rad", "Rad", "s"];
/// The columns of files that do not name them.
const USUAL: &str = "x y z r";

/// A point as the file has it.
#[derive(Clone, Copy)]
pub struct Sample {
    /// In units of the tube's spacing.
    pub position: Point,
    /// NaN where there is none.
    pub radius: f64,
    /// The point's own number; NaN where there is none.
    pub id: f64,
}

/// Which columns of a point are read.
struct Columns {
    width: usize,
    position: [Option<usize>; 3],
    radius: Option<usize>,
    id: Option<usize>,
}

impl Columns {
    fn of(object: &Object, width: Option<usize>) -> Result<Self, Fault> {
        let (line, names) = object.field("PointDim").unwrap_or((object.line, USUAL));
        let names: Vec<&str> = names.split_whitespace().collect();
        let at = |wanted: &[&str]| names.iter().position(|name| wanted.contains(name));
        let flat = object.field("NDims").is_some_and(|(_, n)| n == "2");
        let position = [at(&["x", "X"]), at(&["y", "Y"]), at(&["z", "Z"])];
        if position[..if flat { 2 } else { 3 }].contains(&None) {
            let found = format!("PointDim \"{}\"", names.join(" "));
            return Err(Fault::line(line, found, "expected the names of the columns, x, y, z and r among them"));
        }
        Ok(Self { width: width.unwrap_or(names.len()), position, radius: at(&RADIUS), id: at(&["id"]) })
    }

    /// A point from its numbers.
    fn sample(&self, mut number: impl FnMut(usize) -> Result<f64, Fault>, line: usize) -> Result<Sample, Fault> {
        let mut sample = Sample { position: [0.0; 3], radius: f64::NAN, id: f64::NAN };
        for (axis, column) in self.position.iter().enumerate() {
            let Some(column) = column else { continue };
            sample.position[axis] = number(*column)?;
            if !sample.position[axis].is_finite() {
                let found = format!("{} {}", ["x", "y", "z"][axis], sample.position[axis]);
                return Err(Fault::line(line, found, "expected a finite number"));
            }
        }
        if let Some(column) = self.radius {
            sample.radius = number(column)?;
        }
        if let Some(column) = self.id {
            sample.id = number(column)?;
        }
        Ok(sample)
    }
}

/// Reads the points that follow the line `Points =` of a tube.
pub fn read_points(object: &Object, cursor: &mut Cursor<'_>, line: usize) -> Result<Vec<Sample>, Fault> {
    let missing = || Fault::line(line, format!("{}: no NPoints before its Points", object.name()), "expected how many there are");
    let count = object.index("NPoints")?.ok_or_else(missing)? as usize;
    if !object.is_true("BinaryData") {
        return read_text(object, cursor, line, count);
    }
    let columns = Columns::of(object, None)?;
    if object.is_true("CompressedData") {
        return Err(Fault::line(
            line,
            format!("{}: CompressedData = True", object.name()),
            "expected points without compression",
        ));
    }
    let size = match object.field("ElementType") {
        None | Some((_, "MET_FLOAT")) => 4,
        Some((_, "MET_DOUBLE")) => 8,
        Some((line, other)) => {
            return Err(Fault::line(line, format!("ElementType {other}"), "expected MET_FLOAT or MET_DOUBLE"));
        }
    };
    let big = object.is_true("BinaryDataByteOrderMSB") || object.is_true("ElementByteOrderMSB");
    let needed = count.saturating_mul(columns.width).saturating_mul(size);
    let bytes = cursor.bytes(needed).map_err(|left| {
        let found = format!("{}: {left} bytes of points, {count} points need {needed}", object.name());
        Fault::line(line, found, "expected them all; is the file cut off?")
    })?;
    let number = |at: usize, row: &[u8]| {
        let bytes = &row[at * size..];
        match (size, big) {
            (4, false) => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            (4, true) => f64::from(f32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            (_, big) => {
                let mut word = [0; 8];
                word.copy_from_slice(&bytes[..8]);
                if big { f64::from_be_bytes(word) } else { f64::from_le_bytes(word) }
            }
        }
    };
    let rows = bytes.chunks_exact(columns.width * size);
    rows.map(|row| columns.sample(|column| Ok(number(column, row)), line)).collect()
}

/// Points as text, one a line.
fn read_text(object: &Object, cursor: &mut Cursor<'_>, line: usize, count: usize) -> Result<Vec<Sample>, Fault> {
    let named = object.field("PointDim").is_some();
    let mut columns = if named { Some(Columns::of(object, None)?) } else { None };
    let mut samples = Vec::new();
    while samples.len() < count {
        let Some((at, text)) = cursor.peek().filter(|(_, text)| !text.contains(&b'=')) else { break };
        cursor.line();
        if text.is_empty() {
            continue;
        }
        let text = String::from_utf8_lossy(text);
        let words: Vec<&str> = text.split_whitespace().collect();
        let columns = match &columns {
            Some(columns) => columns,
            None => columns.insert(Columns::of(object, Some(words.len().max(4)))?),
        };
        if words.len() != columns.width {
            let accepted = if named { format!("expected {}, as in PointDim", columns.width) } else { "expected x y z r".into() };
            return Err(Fault::line(at, format!("{} columns", words.len()), accepted));
        }
        let number = |column: usize| {
            let word = words[column];
            word.parse().map_err(|_| Fault::line(at, format!("\"{word}\""), "expected a number"))
        };
        samples.push(columns.sample(number, at)?);
    }
    if samples.len() < count {
        let found = format!("{}: {} points, NPoints says {count}", object.name(), samples.len());
        return Err(Fault::line(line, found, "expected them all; is the file cut off?"));
    }
    Ok(samples)
}
