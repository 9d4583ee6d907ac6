//! ITK tubes (TRE): a MetaIO scene of tubes, as ITK and TubeTK write blood vessels, read as linked points; writes a network as tubes.

use std::collections::{HashMap, HashSet};
use std::io::{self, Write};
use std::ops::Range;

use crate::formats::header_fields::{HeaderFields, HeaderLines, shown};
use crate::formats::{Fault, NumberType, ReadOptions, ensure, figures, listed, parents_first, stated_unit, steps_from_inlets};
use willis_core::network::{Centerlines, Frame, LengthUnit, Network, PathPoint, Scale, is_radius};
use willis_core::support::geometry::{Point, bounds, cross, distance, dot, sub};

/// Reads the tubes of an ITK scene; returns also notes for the user.
///
/// Points and radii are multiplied by `ElementSpacing` (the radius by its first number, as in ITK), then moved by
/// `TransformMatrix` and `Offset` of the tube and of its parents. A tube whose `ParentID` is a tube is linked with its first
/// point to the parent's point number `ParentPoint`, counted from 0, as TubeTK's ConvertTubesToTubeTree writes it; without that
/// number, its nearer end to the parent's nearest point. The label of a link is the `Name` of its tube, its strand the number of
/// the tube. Points keep their ids where these are whole and all different; otherwise they are numbered from 0.
///
/// # Errors
///
/// A scene that is cut off or miscounts its objects or points, values that are no numbers, a coordinate that is not finite, a
/// parent point that does not exist, a tube that is its own ancestor, tubes without a column for the radius unless
/// radii are optional, no tube.
pub fn read_tre(bytes: &[u8], options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let objects = read_scene(bytes)?;
    let mut row_of = HashMap::new();
    let mut twice = 0;
    for (row, object) in objects.iter().enumerate() {
        if let Some(id) = object.index("ID")? {
            twice += usize::from(*row_of.entry(id).or_insert(row) != row);
        }
    }
    // The parent of every object: the one that `ParentID` names, else the group that comes first in the file, as in ITK.
    let first = objects.first().filter(|object| !object.is_tube()).map(|_| 0);
    let parent = |(row, object): (usize, &Object)| {
        let named = object.index("ParentID")?.and_then(|id| row_of.get(&id).copied());
        Ok(named.or_else(|| first.filter(|first| *first != row)))
    };
    let parents: Vec<Option<usize>> = objects.iter().enumerate().map(parent).collect::<Result<_, Fault>>()?;
    let to_scene = to_scene(&objects, &parents)?;
    let mut lines = Centerlines { frame: frame(&objects), ..Centerlines::default() };
    let mut ids = Vec::new();
    let mut span = vec![0..0; objects.len()];
    for (row, object) in objects.iter().enumerate().filter(|(_, object)| object.is_tube()) {
        let has_radius = object.points.is_empty() || object.points.iter().any(|point| !point.radius.is_nan());
        let (line, _) = object.fields.get("PointDim").unwrap_or((object.line, ""));
        let found = || format!("{} has no radius", object.name());
        let wrong = || Fault::line(line, found(), "expected a column r in PointDim, or give `default_radius`");
        ensure(has_radius || options.is_radius_optional(), wrong)?;
        let spacing = spacing(object)?;
        let unit = unit(object, &options.scale)?;
        let scale = options.scale.in_unit(unit);
        lines.unit = lines.unit.or(unit);
        let stretch = to_scene[row].map_or(1.0, |transform| transform.stretch());
        let label = object.fields.get("Name").map_or("", |(_, name)| name);
        let first = lines.points.len();
        for TubePoint { at: [x, y, z], radius, id } in object.points.iter().copied() {
            let own = [x * spacing[0], y * spacing[1], z * spacing[2]];
            let position = scale.position(to_scene[row].map_or(own, |transform| transform.apply(own)));
            let found = || format!("{}: a point that is not finite", object.name());
            ensure(position.iter().all(|x| x.is_finite()), || Fault::line(object.line, found(), "expected finite numbers"))?;
            let radius = scale.length(radius * spacing[0] * stretch);
            let at = lines.add_point(position, if is_radius(radius) { radius } else { f64::NAN }, 0, row as u32);
            ids.push(id);
            if at as usize > first {
                lines.add_link([at - 1, at], label);
            }
        }
        span[row] = first..lines.points.len();
    }
    ensure(!lines.points.is_empty(), || Fault::file("no points in any tube", "expected objects of type Tube with points"))?;
    number(&mut lines, &ids);
    let (mut lost, mut sorted) = (0, SortedTubes::new());
    for (row, object) in objects.iter().enumerate().filter(|(row, _)| !span[*row].is_empty()) {
        let Some(id) = object.index("ParentID")? else { continue };
        let Some(parent) = row_of.get(&id).copied() else {
            lost += 1;
            continue;
        };
        if !objects[parent].is_tube() || span[parent].is_empty() {
            continue;
        }
        let ends = match object.index("ParentPoint")? {
            Some(at) if at < span[parent].len() as u64 => [span[parent].start + at as usize, span[row].start],
            Some(at) => {
                let (line, _) = object.fields.get("ParentPoint").unwrap_or((object.line, ""));
                let accepted = format!("expected 0 to {}: tube {id} has {} points", span[parent].len() - 1, span[parent].len());
                return Err(Fault::line(line, format!("ParentPoint {at}"), accepted));
            }
            None => nearest_pair(&mut sorted, &lines.points, span[parent].clone(), [span[row].start, span[row].end - 1]),
        };
        lines.add_link(ends.map(|p| p as u32), object.fields.get("Name").map_or("", |(_, name)| name));
    }
    let others = objects.iter().filter(|o| !o.is_tube() && o.kind != "Group" && o.kind != "AffineTransform").count();
    let notes = listed([
        (twice, "objects that repeat the ID of an earlier object, which keeps the children"),
        (lost, "tubes whose parent is missing, read as roots"),
        (others, "objects that are no tubes, left out"),
    ]);
    Ok((lines, notes.collect()))
}

/// An object of a scene.
#[derive(Default)]
struct Object {
    /// The line where it begins, from 1.
    line: usize,
    /// Its `ObjectType`; empty where the file leaves it out.
    kind: String,
    /// Its points, of a tube.
    points: Vec<TubePoint>,
    /// Its fields.
    fields: HeaderFields,
}

impl Object {
    /// Whether it is a tube; an object without a type counts as one.
    fn is_tube(&self) -> bool {
        self.kind == "Tube" || self.kind.is_empty()
    }

    /// A whole number; `None` where it is absent or negative.
    fn index(&self, key: &str) -> Result<Option<u64>, Fault> {
        Ok(self.fields.whole(key)?.and_then(|number| u64::try_from(number).ok()))
    }

    /// As many numbers as are asked for, of the first of some fields that is there.
    fn numbers(&self, keys: &[&str], count: usize) -> Result<Option<Vec<f64>>, Fault> {
        self.fields.first_numbers(keys, count, "finite numbers", |x| x.is_finite())
    }

    /// Of how many dimensions its positions are: two where it says so.
    fn dimensions(&self) -> usize {
        if self.fields.get("NDims").is_some_and(|(_, n)| n == "2") { 2 } else { 3 }
    }

    /// Its name in errors.
    fn name(&self) -> String {
        self.fields.get("ID").map_or_else(|| "the tube without ID".into(), |(_, id)| format!("tube {id}"))
    }
}

/// The objects of a file in their order, without the scene itself.
fn read_scene(bytes: &[u8]) -> Result<Vec<Object>, Fault> {
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

/// By the first point of a tube the axis along which it extends the most, and its points in the order of that axis.
type SortedTubes = HashMap<usize, (usize, Vec<usize>)>;

/// The point of the parent and the end of the child that are closest.
fn nearest_pair(all: &mut SortedTubes, points: &[Point], parent: Range<usize>, ends: [usize; 2]) -> [usize; 2] {
    let (axis, sorted) = all.entry(parent.start).or_insert_with(|| sort(points, parent));
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
struct TubePoint {
    /// In units of the tube's spacing; a coordinate that the tube has not is 0.
    at: Point,
    /// NaN where there is none.
    radius: f64,
    /// Its own number, NaN where there is none.
    id: f64,
}

/// How many columns a point has, and which of them are read.
struct Columns {
    width: usize,
    at: [Option<usize>; 3],
    radius: Option<usize>,
    id: Option<usize>,
}

impl Columns {
    fn of(object: &Object) -> Result<Self, Fault> {
        let (line, names) = object.fields.get("PointDim").unwrap_or((object.line, USUAL));
        let names: Vec<&str> = names.split_whitespace().collect();
        let find = |wanted: &[&str]| names.iter().position(|name| wanted.contains(name));
        let at = [find(&["x", "X"]), find(&["y", "Y"]), find(&["z", "Z"])];
        let found = || format!("PointDim \"{}\"", names.join(" "));
        let wrong = || Fault::line(line, found(), "expected the names of the columns, x, y, z and r among them");
        ensure(!at[..object.dimensions()].contains(&None), wrong)?;
        Ok(Self { width: names.len(), at, radius: find(&RADIUS), id: find(&["id"]) })
    }

    /// A point from its numbers.
    fn point(&self, mut number: impl FnMut(usize) -> Result<f64, Fault>, line: usize) -> Result<TubePoint, Fault> {
        let mut at = [0.0; 3];
        for (axis, column) in self.at.iter().enumerate().filter_map(|(axis, column)| Some((axis, (*column)?))) {
            at[axis] = number(column)?;
            let found = || format!("{} {}", ["x", "y", "z"][axis], at[axis]);
            ensure(at[axis].is_finite(), || Fault::line(line, found(), "expected a finite number"))?;
        }
        let radius = self.radius.map_or(Ok(f64::NAN), &mut number)?;
        let id = self.id.map_or(Ok(f64::NAN), number)?;
        Ok(TubePoint { at, radius, id })
    }
}

/// Reads the points that follow the line `Points =` of a tube.
fn read_points(object: &Object, cursor: &mut HeaderLines<'_>, line: usize) -> Result<Vec<TubePoint>, Fault> {
    let missing = || match object.fields.get("NPoints") {
        Some(_) => object.fields.wrong("NPoints", "expected a whole number from 0 on"),
        None => Fault::line(line, format!("{}: no NPoints before its Points", object.name()), "expected how many there are"),
    };
    let count = object.index("NPoints")?.ok_or_else(missing)? as usize;
    if !object.fields.is_true("BinaryData") {
        return read_text(object, cursor, line, count);
    }
    let columns = Columns::of(object)?;
    let found = || format!("{}: CompressedData = True", object.name());
    ensure(!object.fields.is_true("CompressedData"), || Fault::line(line, found(), "expected points without compression"))?;
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
    rows.map(|row| columns.point(|column| Ok(NumberType::Real.value(&row[column * size..][..size], big)), line)).collect()
}

/// Points as text, one a line.
fn read_text(object: &Object, cursor: &mut HeaderLines<'_>, line: usize, count: usize) -> Result<Vec<TubePoint>, Fault> {
    let named = object.fields.get("PointDim").is_some();
    let mut columns = Columns::of(object)?;
    let mut points = Vec::new();
    while points.len() < count {
        let Some((at, text)) = cursor.peek().filter(|(_, text)| !text.contains(&b'=')) else { break };
        cursor.line();
        if text.is_empty() {
            continue;
        }
        let text = String::from_utf8_lossy(text);
        let words: Vec<&str> = text.split_whitespace().collect();
        if !named && points.is_empty() {
            columns.width = words.len().max(4);
        }
        let accepted = || if named { format!("expected {}, as in PointDim", columns.width) } else { "expected x y z r".into() };
        ensure(words.len() == columns.width, || Fault::line(at, format!("{} columns", words.len()), accepted()))?;
        let number = |column: usize| {
            let word = words[column];
            word.parse().map_err(|_| Fault::line(at, format!("\"{word}\""), "expected a number"))
        };
        points.push(columns.point(number, at)?);
    }
    let found = || format!("{}: {} points, NPoints says {count}", object.name(), points.len());
    ensure(points.len() >= count, || Fault::line(line, found(), "expected them all; is the file cut off?"))?;
    Ok(points)
}

/// The frame that all tubes state. `AnatomicalOrientation` names the side where each axis begins.
fn frame(objects: &[Object]) -> Frame {
    let of = |object: &Object| match object.fields.get("AnatomicalOrientation").map(|(_, letters)| letters.trim()) {
        Some("RAI") => Frame::Lps,
        Some("LPI") => Frame::Ras,
        _ => Frame::Unknown,
    };
    let mut all = objects.iter().filter(|object| object.is_tube()).map(of);
    let first = all.next().unwrap_or_default();
    if all.all(|frame| frame == first) { first } else { Frame::Unknown }
}

/// The spacing by which a tube's numbers are multiplied.
fn spacing(object: &Object) -> Result<[f64; 3], Fault> {
    let mut spacing = [1.0; 3];
    for (axis, x) in object.numbers(&["ElementSpacing"], object.dimensions())?.into_iter().flatten().enumerate() {
        ensure(x > 0.0, || object.fields.wrong("ElementSpacing", "expected positive numbers"))?;
        spacing[axis] = x;
    }
    Ok(spacing)
}

/// The unit that a tube states; MetaIO writes `?` where it knows none.
fn unit(object: &Object, given: &Scale) -> Result<Option<LengthUnit>, Fault> {
    let Some((line, word)) = object.fields.get("DistanceUnits").filter(|(_, word)| *word != "?") else { return Ok(None) };
    stated_unit(Some(word), given, || Fault::line(line, format!("DistanceUnits {word}"), "expected mm, um, cm or m"))
}

/// Gives points their own ids where these are whole and all different, else numbers from 0.
fn number(lines: &mut Centerlines, ids: &[f64]) {
    let mut seen = HashSet::with_capacity(ids.len());
    let own = ids.iter().all(|id| *id >= 0.0 && id.fract() == 0.0 && *id < 9e15 && seen.insert(*id as u64));
    for (row, id) in lines.ids.iter_mut().enumerate() {
        *id = if own { ids[row] as u64 } else { row as u64 };
    }
}

/// Names of the matrix of a transform.
const MATRIX: [&str; 3] = ["TransformMatrix", "Orientation", "Rotation"];

/// x -> M x + b. MetaIO's CenterOfRotation does not count, since the offset is stated (ITK's MatrixOffsetTransformBase).
#[derive(Clone, Copy)]
struct TubeTransform {
    matrix: [[f64; 3]; 3],
    offset: Point,
}

impl TubeTransform {
    /// The image of a point.
    fn apply(&self, p: Point) -> Point {
        [0, 1, 2].map(|axis| dot(self.matrix[axis], p) + self.offset[axis])
    }

    /// How lengths change: the cube root of the volume's ratio, exactly 1 for rotations and reflections.
    fn stretch(&self) -> f64 {
        let volume = self.determinant().abs();
        if (volume - 1.0).abs() < 1e-6 { 1.0 } else { volume.cbrt() }
    }

    fn determinant(&self) -> f64 {
        let [a, b, c] = self.matrix;
        dot(a, cross(b, c))
    }

    /// This one, then `outer`.
    fn then(&self, outer: &Self) -> Self {
        let column = |j: usize| [0, 1, 2].map(|i| (0..3).map(|k| outer.matrix[i][k] * self.matrix[k][j]).sum::<f64>());
        let columns = [column(0), column(1), column(2)];
        Self { matrix: [0, 1, 2].map(|i| columns.map(|c| c[i])), offset: outer.apply(self.offset) }
    }

    /// An object's own transform; `None` where it is the identity.
    fn of(object: &Object) -> Result<Option<Self>, Fault> {
        let size = object.dimensions();
        let mut affine = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], offset: [0.0; 3] };
        let identity = affine.matrix;
        for (at, x) in object.numbers(&MATRIX, size * size)?.into_iter().flatten().enumerate() {
            affine.matrix[at / size][at % size] = x;
        }
        for (axis, x) in object.numbers(&["Offset", "Position", "Origin"], size)?.into_iter().flatten().enumerate() {
            affine.offset[axis] = x;
        }
        let name = MATRIX.into_iter().find(|name| object.fields.get(name).is_some()).unwrap_or(MATRIX[0]);
        let wrong = || object.fields.wrong(name, "expected one that can be inverted");
        ensure(affine.determinant().abs() > 0.0 && affine.determinant().is_finite(), wrong)?;
        Ok((affine.matrix != identity || affine.offset != [0.0; 3]).then_some(affine))
    }
}

/// From each object's own coordinates to those of the scene; `None` where nothing changes.
fn to_scene(objects: &[Object], parents: &[Option<usize>]) -> Result<Vec<Option<TubeTransform>>, Fault> {
    let order = parents_first(parents).map_err(|row| {
        let found = format!("{} is its own ancestor", objects[row].name());
        Fault::line(objects[row].line, found, "expected ParentID to lead to a root")
    })?;
    let mut out = vec![None; objects.len()];
    for row in order {
        let outer: Option<TubeTransform> = parents[row].and_then(|parent| out[parent]);
        out[row] = match (TubeTransform::of(&objects[row])?, outer) {
            (Some(own), Some(outer)) => Some(own.then(&outer)),
            (own, outer) => own.or(outer),
        };
    }
    Ok(out)
}

const IDENTITY: &str = "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nCenterOfRotation = 0 0 0\nElementSpacing = 1 1 1";

/// The parent of a tube: its row, and whether the tube begins at the parent's last point.
type TubeParent = (usize, bool);

/// Writes every vessel as a tube, in the order of the vessels and with ids from 1; millimetres.
///
/// The tubes of a connected part are linked by `ParentID` and `ParentPoint`, from its inlets, else from its first node, breadth
/// first, each with its first point at its parent; a tube that closes a loop meets its other node by its coordinates only. The
/// label is the name of the tube, without line breaks. A network in RAS is turned to LPS, the frame of ITK. A vessel without a path is straight, a missing radius 0.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_tre(mut out: impl Write, network: &Network) -> io::Result<()> {
    let network = &*network.in_frame(Frame::Lps);
    let orientation = if network.frame.is_known() { "AnatomicalOrientation = RAI\n" } else { "" };
    let mut tubes = super::polylines::polylines(network)?;
    let parents = orient_and_link(network, &mut tubes);
    writeln!(out, "ObjectType = Scene\nNDims = 3\nNObjects = {}", tubes.len() + 1)?;
    writeln!(out, "ObjectType = Group\nNDims = 3\nID = 0\nBinaryData = False\n{IDENTITY}\nEndGroup = ")?;
    for (row, tube) in tubes.iter().enumerate() {
        writeln!(out, "ObjectType = Tube\nNDims = 3")?;
        let name = super::swc::single_line(&network.vessel(row).label);
        if !name.is_empty() {
            writeln!(out, "Name = {name}")?;
        }
        writeln!(out, "ID = {}", row + 1)?;
        if let Some((parent, _)) = parents[row] {
            writeln!(out, "ParentID = {}", parent + 1)?;
        }
        writeln!(out, "BinaryData = False\n{orientation}{IDENTITY}")?;
        if let Some((parent, at_last)) = parents[row] {
            writeln!(out, "ParentPoint = {}", if at_last { tubes[parent].len() - 1 } else { 0 })?;
        }
        let root = if parents[row].is_none() { "True" } else { "False" };
        writeln!(out, "Root = {root}\nArtery = True\nPointDim = x y z r\nNPoints = {}\nPoints = ", tube.len())?;
        tube.iter().try_for_each(|point| writeln!(out, "{}", figures(point, "0").join(" ")))?;
    }
    out.flush()
}

/// Turns every tube so that it begins at its parent, and finds the parent of each; roots have none.
fn orient_and_link(network: &Network, tubes: &mut [Vec<PathPoint>]) -> Vec<Option<TubeParent>> {
    let mut parents = vec![None; tubes.len()];
    let mut parent_at = vec![None; network.node_count()];
    for (by, to, is_new) in steps_from_inlets(network, false) {
        let Some((row, from)) = by else { continue };
        if network.ends(row)[0] != from {
            tubes[row].reverse();
        }
        parents[row] = parent_at[from];
        parent_at[from].get_or_insert((row, false));
        if is_new {
            parent_at[to] = Some((row, true));
        }
    }
    parents
}
