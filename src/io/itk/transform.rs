//! Where an object lies: its own transform, then those of its parents, as ITK composes them.

use std::collections::HashMap;

use super::scene::Object;
use crate::error::Fault;
use crate::support::geometry::Point;

/// x -> M x + b; MetaIO's CenterOfRotation is of no account where the offset is stated (ITK's MatrixOffsetTransformBase).
#[derive(Clone, Copy)]
pub struct Affine {
    matrix: [[f64; 3]; 3],
    offset: Point,
}

impl Affine {
    /// The image of a point.
    pub fn apply(&self, p: Point) -> Point {
        let turned = self.matrix.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
        [turned[0] + self.offset[0], turned[1] + self.offset[1], turned[2] + self.offset[2]]
    }

    /// How lengths change: the cube root of the volume's ratio, exactly 1 for rotations and reflections.
    pub fn stretch(&self) -> f64 {
        let volume = self.determinant().abs();
        if (volume - 1.0).abs() < 1e-6 { 1.0 } else { volume.cbrt() }
    }

    fn determinant(&self) -> f64 {
        let [a, b, c] = self.matrix;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    /// This one, then `outer`.
    fn then(&self, outer: &Self) -> Self {
        let column = |j: usize| [0, 1, 2].map(|i| (0..3).map(|k| outer.matrix[i][k] * self.matrix[k][j]).sum::<f64>());
        let columns = [column(0), column(1), column(2)];
        Self { matrix: [0, 1, 2].map(|i| columns.map(|c| c[i])), offset: outer.apply(self.offset) }
    }

    /// An object's own transform; `None` where it is the identity.
    fn of(object: &Object) -> Result<Option<Self>, Fault> {
        let size = if object.field("NDims").is_some_and(|(_, n)| n == "2") { 2 } else { 3 };
        let numbers = |keys: [&str; 3], count: usize| {
            keys.iter().find(|key| object.field(key).is_some()).map_or(Ok(None), |key| object.numbers(key, count))
        };
        let mut affine = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], offset: [0.0; 3] };
        let identity = affine.matrix;
        for (at, x) in numbers(["TransformMatrix", "Orientation", "Rotation"], size * size)?.into_iter().flatten().enumerate() {
            affine.matrix[at / size][at % size] = x;
        }
        for (axis, x) in numbers(["Offset", "Position", "Origin"], size)?.into_iter().flatten().enumerate() {
            affine.offset[axis] = x;
        }
        if affine.determinant().abs() <= 0.0 || !affine.determinant().is_finite() {
            let (line, matrix) = object.field("TransformMatrix").unwrap_or((object.line, ""));
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
pub fn to_scene(objects: &[Object], parents: &[Option<usize>]) -> Result<Vec<Option<Affine>>, Fault> {
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        New,
        Open,
        Done,
    }
    let (mut state, mut out) = (vec![State::New; objects.len()], vec![None; objects.len()]);
    for start in 0..objects.len() {
        let (mut way, mut at) = (Vec::new(), Some(start));
        while let Some(row) = at.filter(|row| state[*row] != State::Done) {
            if state[row] == State::Open {
                let found = format!("{} is its own ancestor", objects[row].name());
                return Err(Fault::line(objects[row].line, found, "expected ParentID to lead to a root"));
            }
            state[row] = State::Open;
            way.push(row);
            at = parents[row];
        }
        for row in way.into_iter().rev() {
            let outer = parents[row].and_then(|parent| out[parent]);
            out[row] = match (Affine::of(&objects[row])?, outer) {
                (Some(own), Some(outer)) => Some(own.then(&outer)),
                (own, outer) => own.or(outer),
            };
            state[row] = State::Done;
        }
    }
    Ok(out)
}
