//! MetaIO scenes: objects as their fields, the points of tubes beside them.

use std::collections::HashMap;

use super::points::{Sample, read_points};
use crate::error::Fault;

const ENTRY: &str = "expected a line Key = value";
/// The types of objects that MetaIO knows.
const KINDS: [&str; 17] = [
    "Scene",
    "Group",
    "AffineTransform",
    "Transform",
    "Tube",
    "TubeGraph",
    "Line",
    "Contour",
    "Surface",
    "Mesh",
    "FEMObject",
    "Landmark",
    "Blob",
    "Ellipse",
    "Gaussian",
    "Arrow",
    "Image",
];
/// How much of a wrong line an error shows.
const SHOWN: usize = 40;

/// A place in a file that mixes lines and binary data.
pub struct Cursor<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Cursor<'a> {
    /// The next line without blanks around it, and its number; the cursor stays before it.
    pub fn peek(&self) -> Option<(usize, &'a [u8])> {
        let end = self.rest.iter().position(|b| *b == b'\n').unwrap_or(self.rest.len());
        (!self.rest.is_empty()).then(|| (self.line, self.rest[..end].trim_ascii()))
    }

    /// The next line, and its number.
    pub fn line(&mut self) -> Option<(usize, &'a [u8])> {
        let line = self.peek()?;
        let end = self.rest.iter().position(|b| *b == b'\n').map_or(self.rest.len(), |at| at + 1);
        self.rest = &self.rest[end..];
        self.line += 1;
        Some(line)
    }

    /// The next bytes, or how many there are when these are fewer.
    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8], usize> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(self.rest.len())?;
        self.line += taken.split(|b| *b == b'\n').count() - 1;
        self.rest = rest;
        Ok(taken)
    }

    /// Goes to the next line that begins an object.
    fn skip_to_object(&mut self) {
        while let Some((_, line)) = self.peek() {
            if line.starts_with(b"ObjectType") {
                return;
            }
            self.line();
        }
    }
}

/// An object of a scene.
#[derive(Default)]
pub struct Object {
    /// The line where it begins, from 1.
    pub line: usize,
    /// Its `ObjectType`; empty where the file leaves it out.
    pub kind: String,
    /// Its points, of a tube.
    pub points: Vec<Sample>,
    fields: HashMap<String, (usize, String)>,
}

impl Object {
    /// Whether it is a tube; objects without a type in a scene of tubes are.
    pub fn is_tube(&self) -> bool {
        self.kind == "Tube" || self.kind.is_empty()
    }

    /// The line and the text of a field.
    pub fn field(&self, key: &str) -> Option<(usize, &str)> {
        self.fields.get(key).map(|(line, value)| (*line, value.as_str()))
    }

    /// A yes or no; no where it is absent. MetaIO looks at the first letter only.
    pub fn is_true(&self, key: &str) -> bool {
        self.field(key).is_some_and(|(_, value)| value.starts_with(['T', 't', '1']))
    }

    /// A whole number; `None` where it is absent or negative.
    pub fn index(&self, key: &str) -> Result<Option<u64>, Fault> {
        let Some((line, value)) = self.field(key) else { return Ok(None) };
        let number: i64 =
            value.parse().map_err(|_| Fault::line(line, format!("{key} \"{value}\""), "expected a whole number"))?;
        Ok(u64::try_from(number).ok())
    }

    /// As many numbers as are asked for; `None` where the field is absent.
    pub fn numbers(&self, key: &str, count: usize) -> Result<Option<Vec<f64>>, Fault> {
        let Some((line, value)) = self.field(key) else { return Ok(None) };
        let numbers: Option<Vec<f64>> =
            value.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        match numbers.filter(|numbers| numbers.len() == count) {
            Some(numbers) => Ok(Some(numbers)),
            None => Err(Fault::line(line, format!("{key} \"{value}\""), format!("expected {count} finite numbers"))),
        }
    }

    /// What an error calls it.
    pub fn name(&self) -> String {
        self.field("ID").map_or_else(|| "the tube without ID".into(), |(_, id)| format!("tube {id}"))
    }
}

/// The objects of a file in their order, without the scene itself.
pub fn read_scene(bytes: &[u8]) -> Result<Vec<Object>, Fault> {
    let mut cursor = Cursor { rest: bytes, line: 1 };
    let (mut objects, mut stated) = (Vec::new(), None);
    let mut open: Option<Object> = None;
    while let Some((line, text)) = cursor.line() {
        if text.is_empty() {
            continue;
        }
        let Some((key, value)) = entry(text) else {
            return Err(Fault::line(line, format!("\"{}\"", shown(text)), ENTRY));
        };
        let begun = open.as_ref().is_some_and(|object| !object.kind.is_empty());
        if key == "ObjectType" && begun {
            objects.extend(open.take());
        }
        let object = open.get_or_insert_with(|| Object { line, ..Object::default() });
        match key.as_str() {
            "ObjectType" if KINDS.contains(&value.as_str()) => object.kind = value,
            "ObjectType" => {
                let found = format!("ObjectType \"{}\"", shown(value.as_bytes()));
                return Err(Fault::line(line, found, "expected Scene, Group, Tube or another type of MetaIO"));
            }
            "NObjects" if object.kind == "Scene" => {
                let wrong = || Fault::line(line, format!("NObjects \"{value}\""), "expected a whole number");
                stated = Some((line, value.parse::<usize>().map_err(|_| wrong())?));
                open = None;
            }
            "Points" if object.is_tube() => {
                object.points = read_points(object, &mut cursor, line)?;
                object.fields.insert(key, (line, value));
                objects.extend(open.take());
            }
            "Points" => {
                cursor.skip_to_object();
                objects.extend(open.take());
            }
            "EndGroup" => objects.extend(open.take()),
            _ => _ = object.fields.insert(key, (line, value)),
        }
    }
    objects.extend(open.filter(|object| object.kind != "Scene"));
    let unfinished = objects.iter().find(|object| object.is_tube() && object.field("Points").is_none());
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

fn entry(text: &[u8]) -> Option<(String, String)> {
    let at = text.iter().position(|b| *b == b'=')?;
    let word = |part: &[u8]| String::from_utf8_lossy(part.trim_ascii()).into_owned();
    let key = word(&text[..at]);
    (!key.is_empty()).then(|| (key, word(&text[at + 1..])))
}

/// The beginning of a line, fit for one line of an error.
fn shown(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    text.chars().take(SHOWN).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
