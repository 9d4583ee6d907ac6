//! ITK tubes (TRE): reads a scene as linked points, writes a network as tubes.

use std::collections::{HashMap, HashSet, VecDeque};
use std::io::{self, Write};

use crate::formats::itk::scene::{Nearest, Object, read_scene};
use crate::formats::options::ReadOptions;
use crate::formats::polylines::{parents_first, polylines};
use crate::formats::swc::single_line;
use crate::formats::tables::reader::listed;
use crate::formats::tables::write::figures;
use willis_core::error::Fault;
use willis_core::network::walks::{other_end, vessels_at};
use willis_core::network::{Centerlines, Frame, LengthUnit, Network, PathPoint, Role, Scale, is_radius};
use willis_core::support::geometry::{Point, cross, dot};

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
    let parents = parents(&objects, &row_of)?;
    let to_scene = to_scene(&objects, &parents)?;
    let mut lines = Centerlines { frame: frame(&objects), ..Centerlines::default() };
    let mut ids = Vec::new();
    let mut span = vec![0..0; objects.len()];
    for (row, object) in objects.iter().enumerate().filter(|(_, object)| object.is_tube()) {
        if !options.is_radius_optional() && !object.points.is_empty() && object.points.iter().all(|p| p.radius.is_nan()) {
            let (line, _) = object.fields.get("PointDim").unwrap_or((object.line, ""));
            let found = format!("{} has no radius", object.name());
            return Err(Fault::line(line, found, "expected a column r in PointDim, or give `default_radius`"));
        }
        let spacing = spacing(object)?;
        let scale = unit(object, &options.scale)?;
        let stretch = to_scene[row].map_or(1.0, |transform| transform.stretch());
        let label = object.fields.get("Name").map_or("", |(_, name)| name);
        let first = lines.points.len();
        for sample in &object.points {
            let own = [0, 1, 2].map(|axis| sample.position[axis] * spacing[axis]);
            let position = scale.position(to_scene[row].map_or(own, |transform| transform.apply(own)));
            if position.iter().any(|x| !x.is_finite()) {
                let found = format!("{}: a point that is not finite", object.name());
                return Err(Fault::line(object.line, found, "expected finite numbers"));
            }
            let radius = scale.length(sample.radius * spacing[0] * stretch);
            let at = lines.add_point(position, if is_radius(radius) { radius } else { f64::NAN }, 0, row as u32);
            ids.push(sample.id);
            if at as usize > first {
                lines.add_link([at - 1, at], label);
            }
        }
        span[row] = first..lines.points.len();
    }
    if lines.points.is_empty() {
        return Err(Fault::file("no points in any tube", "expected objects of type Tube with points"));
    }
    number(&mut lines, &ids);
    let (mut lost, mut nearest) = (0, Nearest::default());
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
            None => nearest.pair(&lines.points, span[parent].clone(), [span[row].start, span[row].end - 1]),
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
    let flat = object.fields.get("NDims").is_some_and(|(_, n)| n == "2");
    let mut spacing = [1.0; 3];
    for (axis, x) in object.numbers(&["ElementSpacing"], if flat { 2 } else { 3 })?.into_iter().flatten().enumerate() {
        if x <= 0.0 {
            return Err(object.fields.wrong("ElementSpacing", "expected positive numbers"));
        }
        spacing[axis] = x;
    }
    Ok(spacing)
}

/// The unit of a tube: the one that the user gave if it is not mm, else the one that the tube states.
fn unit(object: &Object, scale: &Scale) -> Result<Scale, Fault> {
    let unit = match object.fields.get("DistanceUnits") {
        None | Some((_, "mm" | "?" | "")) => return Ok(*scale),
        Some((_, "um")) => LengthUnit::Micrometre,
        Some((_, "cm")) => LengthUnit::Centimetre,
        Some((line, other)) => return Err(Fault::line(line, format!("DistanceUnits {other}"), "expected um, mm or cm")),
    };
    Ok(if scale.unit == LengthUnit::Millimetre { Scale { unit, ..*scale } } else { *scale })
}

/// Gives points their own ids where these are whole and all different, else numbers from 0.
fn number(lines: &mut Centerlines, ids: &[f64]) {
    let mut seen = HashSet::with_capacity(ids.len());
    let own = ids.iter().all(|id| *id >= 0.0 && id.fract() == 0.0 && *id < 9e15 && seen.insert(*id as u64));
    for (row, id) in lines.ids.iter_mut().enumerate() {
        *id = if own { ids[row] as u64 } else { row as u64 };
    }
}

/// x -> M x + b. MetaIO's CenterOfRotation does not count, since the offset is stated (ITK's MatrixOffsetTransformBase).
#[derive(Clone, Copy)]
pub struct TubeTransform {
    matrix: [[f64; 3]; 3],
    offset: Point,
}

impl TubeTransform {
    /// The image of a point.
    pub fn apply(&self, p: Point) -> Point {
        [0, 1, 2].map(|axis| dot(self.matrix[axis], p) + self.offset[axis])
    }

    /// How lengths change: the cube root of the volume's ratio, exactly 1 for rotations and reflections.
    pub fn stretch(&self) -> f64 {
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
        let size = if object.fields.get("NDims").is_some_and(|(_, n)| n == "2") { 2 } else { 3 };
        let mut affine = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], offset: [0.0; 3] };
        let identity = affine.matrix;
        for (at, x) in
            object.numbers(&["TransformMatrix", "Orientation", "Rotation"], size * size)?.into_iter().flatten().enumerate()
        {
            affine.matrix[at / size][at % size] = x;
        }
        for (axis, x) in object.numbers(&["Offset", "Position", "Origin"], size)?.into_iter().flatten().enumerate() {
            affine.offset[axis] = x;
        }
        if affine.determinant().abs() <= 0.0 || !affine.determinant().is_finite() {
            let (line, matrix) = object.fields.get("TransformMatrix").unwrap_or((object.line, ""));
            return Err(Fault::line(line, format!("TransformMatrix \"{matrix}\""), "expected one that can be inverted"));
        }
        Ok((affine.matrix != identity || affine.offset != [0.0; 3]).then_some(affine))
    }
}

/// The parent of every object: the one that `ParentID` names, else the group that comes first in the file, as in ITK.
pub fn parents(objects: &[Object], row_of: &HashMap<u64, usize>) -> Result<Vec<Option<usize>>, Fault> {
    let first = objects.first().filter(|object| !object.is_tube()).map(|_| 0);
    let parent = |(row, object): (usize, &Object)| {
        let named = object.index("ParentID")?.and_then(|id| row_of.get(&id).copied());
        Ok(named.or_else(|| first.filter(|first| *first != row)))
    };
    objects.iter().enumerate().map(parent).collect()
}

/// From each object's own coordinates to those of the scene; `None` where nothing changes.
pub fn to_scene(objects: &[Object], parents: &[Option<usize>]) -> Result<Vec<Option<TubeTransform>>, Fault> {
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
#[derive(Clone, Copy)]
struct Link {
    parent: usize,
    at_last: bool,
}

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
    let mut tubes = polylines(network)?;
    let links = orient_and_link(network, &mut tubes);
    writeln!(out, "ObjectType = Scene\nNDims = 3\nNObjects = {}", tubes.len() + 1)?;
    writeln!(out, "ObjectType = Group\nNDims = 3\nID = 0\nBinaryData = False\n{IDENTITY}\nEndGroup = ")?;
    for (row, tube) in tubes.iter().enumerate() {
        writeln!(out, "ObjectType = Tube\nNDims = 3")?;
        let name = single_line(&network.vessel(row).label);
        if !name.is_empty() {
            writeln!(out, "Name = {name}")?;
        }
        writeln!(out, "ID = {}", row + 1)?;
        if let Some(link) = links[row] {
            writeln!(out, "ParentID = {}", link.parent + 1)?;
        }
        writeln!(out, "BinaryData = False\n{orientation}{IDENTITY}")?;
        if let Some(link) = links[row] {
            writeln!(out, "ParentPoint = {}", if link.at_last { tubes[link.parent].len() - 1 } else { 0 })?;
        }
        let root = if links[row].is_none() { "True" } else { "False" };
        writeln!(out, "Root = {root}\nArtery = True\nPointDim = x y z r\nNPoints = {}\nPoints = ", tube.len())?;
        tube.iter().try_for_each(|point| writeln!(out, "{}", figures(point, "0").join(" ")))?;
    }
    out.flush()
}

/// Turns every tube so that it begins at its parent, and finds the parent of each; roots have none.
fn orient_and_link(network: &Network, tubes: &mut [Vec<PathPoint>]) -> Vec<Option<Link>> {
    let vessels_at = vessels_at(network, |_| true);
    let mut links = vec![None; tubes.len()];
    let mut done = vec![false; tubes.len()];
    let mut reached = vec![false; network.node_count()];
    let inlets = (0..network.node_count()).filter(|n| network.node(*n).role == Some(Role::Inlet));
    for root in inlets.chain(0..network.node_count()) {
        if std::mem::replace(&mut reached[root], true) {
            continue;
        }
        let mut open = VecDeque::from([(root, None)]);
        while let Some((node, mut from)) = open.pop_front() {
            for row in &vessels_at[node] {
                if std::mem::replace(&mut done[*row], true) {
                    continue;
                }
                if network.ends(*row)[0] != node {
                    tubes[*row].reverse();
                }
                links[*row] = from;
                from.get_or_insert(Link { parent: *row, at_last: false });
                let next = other_end(network, *row, node);
                if !std::mem::replace(&mut reached[next], true) {
                    open.push_back((next, Some(Link { parent: *row, at_last: true })));
                }
            }
        }
    }
    links
}
