//! Reads a MetaIO scene: objects as their fields, tubes with their points.

use std::collections::HashMap;
use std::ops::Range;

use crate::formats::binary::NumberType;
use crate::formats::header_fields::{HeaderFields, HeaderLines, shown};
use willis_core::error::Fault;
use willis_core::support::geometry::{Point, bounds, distance, sub};

/// An object of a scene.
#[derive(Default)]
pub struct Object {
    /// The line where it begins, from 1.
    pub line: usize,
    /// Its `ObjectType`; empty where the file leaves it out.
    pub kind: String,
    /// Its points, of a tube.
    pub points: Vec<Sample>,
    /// Its fields.
    pub(super) fields: HeaderFields,
}

impl Object {
    /// Whether it is a tube; an object without a type counts as one.
    pub fn is_tube(&self) -> bool {
        self.kind == "Tube" || self.kind.is_empty()
    }

    /// A whole number; `None` where it is absent or negative.
    pub fn index(&self, key: &str) -> Result<Option<u64>, Fault> {
        Ok(self.fields.whole(key)?.and_then(|number| u64::try_from(number).ok()))
    }

    /// As many numbers as are asked for, of the first of some fields that is there.
    pub fn numbers(&self, keys: &[&str], count: usize) -> Result<Option<Vec<f64>>, Fault> {
        self.fields.first_numbers(keys, count, "finite numbers", |x| x.is_finite())
    }

    /// Its name in errors.
    pub fn name(&self) -> String {
        self.fields.get("ID").map_or_else(|| "the tube without ID".into(), |(_, id)| format!("tube {id}"))
    }
}

/// The objects of a file in their order, without the scene itself.
pub fn read_scene(bytes: &[u8]) -> Result<Vec<Object>, Fault> {
    let mut cursor = HeaderLines::new(bytes);
    let (mut objects, mut stated) = (Vec::new(), None);
    let mut open: Option<Object> = None;
    while let Some((line, key, value)) = cursor.entry()? {
        let begun = open.as_ref().is_some_and(|object| !object.kind.is_empty());
        if key == "ObjectType" && begun {
            objects.extend(open.take());
        }
        let object = open.get_or_insert_with(|| Object { line, ..Object::default() });
        match key.as_str() {
            "ObjectType" if is_kind(&value) => object.kind = value,
            "ObjectType" => {
                let found = format!("ObjectType \"{}\"", shown(&value));
                return Err(Fault::line(line, found, "expected Scene, Group, Tube or another type of MetaIO"));
            }
            "NObjects" if object.kind == "Scene" => {
                let wrong = || Fault::line(line, format!("NObjects \"{value}\""), "expected a whole number");
                stated = Some((line, value.parse::<usize>().map_err(|_| wrong())?));
                open = None;
            }
            "Points" if object.is_tube() => {
                object.points = read_points(object, &mut cursor, line)?;
                object.fields.insert(&key, line, &value);
                objects.extend(open.take());
            }
            "Points" => {
                while cursor.peek().is_some_and(|(_, line)| !line.starts_with(b"ObjectType")) {
                    cursor.line();
                }
                objects.extend(open.take());
            }
            "EndGroup" => objects.extend(open.take()),
            _ => object.fields.insert(&key, line, &value),
        }
    }
    objects.extend(open.filter(|object| object.kind != "Scene"));
    let unfinished = objects.iter().find(|object| object.is_tube() && object.fields.get("Points").is_none());
    if let Some(object) = unfinished {
        let accepted = "expected PointDim, NPoints and Points; is the file cut off?";
        return Err(Fault::line(object.line, "a tube without Points", accepted));
    }
    match stated {
        Some((line, stated)) if stated != objects.len() => {
            let found = format!("NObjects = {stated}, but {} are there", objects.len());
            Err(Fault::line(line, found, "expected as many objects as are stated; is the file cut off?"))
        }
        _ => Ok(objects),
    }
}

/// Whether MetaIO knows a type of objects.
fn is_kind(name: &str) -> bool {
    let containers = matches!(name, "Scene" | "Group" | "AffineTransform" | "Transform" | "Image");
    let shapes = matches!(name, "Tube" | "TubeGraph" | "Line" | "Contour" | "Surface" | "Mesh" | "FEMObject" | "Landmark");
    containers || shapes || matches!(name, "Blob" | "Ellipse" | "Gaussian" | "Arrow")
}

/// Tubes whose points have been sorted along their longest axis.
#[derive(Default)]
pub struct Nearest {
    sorted: HashMap<usize, (usize, Vec<usize>)>,
}

impl Nearest {
    /// The point of the parent and the end of the child that are closest.
    pub fn pair(&mut self, points: &[Point], parent: Range<usize>, ends: [usize; 2]) -> [usize; 2] {
        let (axis, sorted) = self.sorted.entry(parent.start).or_insert_with(|| sort(points, parent));
        let x = |row: usize| points[row][*axis];
        let mut best = (f64::INFINITY, [sorted[0], ends[0]]);
        for end in ends {
            let (left, right) = sorted.split_at(sorted.partition_point(|row| x(*row) < x(end)));
            let mut consider = |row: &usize| {
                let gap = distance(points[*row], points[end]);
                if gap < best.0 || (gap == best.0 && end == best.1[1] && *row < best.1[0]) {
                    best = (gap, [*row, end]);
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
    let [low, high] = bounds(points[range.clone()].iter().copied());
    let extent = sub(high, low);
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
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

/// The columns of a point that are read.
struct Columns {
    width: usize,
    position: [Option<usize>; 3],
    radius: Option<usize>,
    id: Option<usize>,
}

impl Columns {
    fn of(object: &Object, width: Option<usize>) -> Result<Self, Fault> {
        let (line, names) = object.fields.get("PointDim").unwrap_or((object.line, USUAL));
        let names: Vec<&str> = names.split_whitespace().collect();
        let at = |wanted: &[&str]| names.iter().position(|name| wanted.contains(name));
        let flat = object.fields.get("NDims").is_some_and(|(_, n)| n == "2");
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
pub fn read_points(object: &Object, cursor: &mut HeaderLines<'_>, line: usize) -> Result<Vec<Sample>, Fault> {
    let missing = || Fault::line(line, format!("{}: no NPoints before its Points", object.name()), "expected how many there are");
    let count = object.index("NPoints")?.ok_or_else(missing)? as usize;
    if !object.fields.is_true("BinaryData") {
        return read_text(object, cursor, line, count);
    }
    let columns = Columns::of(object, None)?;
    if object.fields.is_true("CompressedData") {
        let found = format!("{}: CompressedData = True", object.name());
        return Err(Fault::line(line, found, "expected points without compression"));
    }
    let size = match object.fields.get("ElementType") {
        None | Some((_, "MET_FLOAT")) => 4,
        Some((_, "MET_DOUBLE")) => 8,
        Some(_) => return Err(object.fields.wrong("ElementType", "expected MET_FLOAT or MET_DOUBLE")),
    };
    let big = object.fields.is_true("BinaryDataByteOrderMSB") || object.fields.is_true("ElementByteOrderMSB");
    let needed = count.saturating_mul(columns.width).saturating_mul(size);
    let bytes = cursor.bytes(needed).map_err(|left| {
        let found = format!("{}: {left} bytes of points, {count} points need {needed}", object.name());
        Fault::line(line, found, "expected them all; is the file cut off?")
    })?;
    let rows = bytes.chunks_exact(columns.width * size);
    rows.map(|row| columns.sample(|column| Ok(NumberType::Real.value(&row[column * size..][..size], big)), line)).collect()
}

/// Points as text, one a line.
fn read_text(object: &Object, cursor: &mut HeaderLines<'_>, line: usize, count: usize) -> Result<Vec<Sample>, Fault> {
    let named = object.fields.get("PointDim").is_some();
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
