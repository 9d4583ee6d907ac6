//! The SpatialGraph of Amira and Avizo (`.am`): vertices, edges between them, and the points of every edge with their thickness, which is the radius.
//!
//! Read as text and as the binary files that the programs write; written as text. Source: the Amira Reference Guide, "AmiraMesh format" and
//! "HxSpatialGraph".

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Read, Write};

use flate2::read::ZlibDecoder;

use crate::formats::ensure;
use crate::formats::{
    Fault, NumberType, Point, ReadOptions, UnpackLimit, box_diagonal, cells, centerlines, distance, figures, find, radius_of,
    stated_unit,
};
use willis_core::network::{Centerlines, Network, Vessel, WELD_TOLERANCE, is_radius};

/// No header is longer.
const MOST_HEADER: usize = 1 << 20;
/// Groups of parameters within one another.
const MOST_DEPTH: usize = 32;
/// The usual names of the radius, in any case of letters.
const RADIUS: [&str; 4] = ["thickness", "radius", "radii", "MeanRadius"];
/// What labels are called that this program writes.
const LABELS: &str = "Labels";
const ACCEPTED: &str = "expected a SpatialGraph of Amira or Avizo; export an image as NIfTI, NRRD or TIFF";

/// Whether a file begins as those of Amira and Avizo do.
pub(crate) fn is_amira(bytes: &[u8]) -> bool {
    ["# AmiraMesh", "# Avizo"].iter().any(|signature| bytes.starts_with(signature.as_bytes()))
}

/// The groups that a parameter is in, its name, its value.
type Parameter = (Vec<String>, String, String);

/// An array that the header declares, such as `POINT { float thickness } @5`.
struct Declared {
    line: usize,
    /// Of what it has one row each.
    of: String,
    name: String,
    kind: NumberType,
    /// Bytes of a number, and numbers of a row.
    size: usize,
    row: usize,
    /// The number of its section.
    section: u32,
    /// How it is packed, and its bytes then.
    packed: Option<(String, usize)>,
}

/// The header, and where the sections begin.
struct AmiraHeader {
    /// Whether the most significant byte of a number is first; `None` where numbers are text.
    big: Option<bool>,
    counts: HashMap<String, usize>,
    arrays: Vec<Declared>,
    parameters: Vec<Parameter>,
    end: usize,
}

/// Reads a SpatialGraph: every edge as a line of points between its two vertices, also where several edges have the same. Returns notes too.
///
/// The unit is the one that the file states, unless the options have one other than mm. The radius of a vertex is the mean of those that the edges
/// have there. Whole numbers of edges that a group of parameters names, or that are called labels, are labels.
///
/// # Errors
///
/// A file that is cut, or of another content; vertices that do not exist; radii that are missing where they are not optional.
pub fn read_amira(bytes: &[u8], options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let header = AmiraHeader::read(bytes)?;
    let kind = header.parameter(&[], "ContentType").unwrap_or("HxSpatialGraph");
    ensure(kind == "HxSpatialGraph", || Fault::file(format!("an Amira file of {kind}"), ACCEPTED))?;
    let word = header.parameter(&["Units"], "Coordinates");
    let unit = stated_unit(word, &options.scale, || {
        let found = format!("Units: Coordinates \"{}\"", word.unwrap_or_default().escape_debug());
        Fault::file(found, "expected mm, um, cm or m, or give `units`")
    })?;
    let scale = options.scale.in_unit(unit);
    let data = header.sections(bytes)?;
    let array = |of: &str, name: &str, row: usize| -> Result<Vec<f64>, Fault> {
        let declared = header.arrays.iter().find(|array| array.of == of && array.name == name);
        let declared = declared.ok_or_else(|| Fault::file(format!("no {name} of {of}"), ACCEPTED))?;
        let found = || format!("{name} has {} numbers each", declared.row);
        ensure(declared.row == row, || Fault::line(declared.line, found(), format!("expected {row} numbers each")))?;
        header.values(declared, &data, options.max_input)
    };
    let places = |name: &str, values: &[f64]| -> Result<Vec<Point>, Fault> {
        let place = |(row, place): (usize, &[f64])| {
            let wrong = || Fault::item(name, format!("row {row} is {place:?}"), "expected finite numbers");
            ensure(place.iter().all(|x| x.is_finite()), wrong)?;
            Ok(scale.position([place[0], place[1], place[2]]))
        };
        values.chunks_exact(3).enumerate().map(place).collect()
    };
    let mut points = places("VertexCoordinates", &array("VERTEX", "VertexCoordinates", 3)?)?;
    let vertices = points.len();
    let ends = array("EDGE", "EdgeConnectivity", 2)?;
    let counts = array("EDGE", "NumEdgePoints", 1)?;
    let course = places("EdgePointCoordinates", &array("POINT", "EdgePointCoordinates", 3)?)?;
    let total: f64 = counts.iter().sum();
    let accepted = || format!("expected as many as there are points, {}", course.len());
    let is_right = total == course.len() as f64 && counts.iter().all(|n| *n >= 0.0 && n.fract() == 0.0);
    ensure(is_right, || Fault::item("NumEdgePoints", format!("{total} in all"), accepted()))?;
    ensure(!counts.is_empty(), || Fault::file("no edges", "expected a SpatialGraph with edges"))?;
    let (sizes, of_edges) = header.radii(&data, options, &counts)?.unwrap_or_else(|| (vec![f64::NAN; course.len()], false));
    let sizes: Vec<f64> = sizes.into_iter().map(|radius| scale.length(radius)).collect();
    let names = header.labels(&data, options.max_input)?;
    let mut radii = vec![f64::NAN; vertices];
    let mut at_vertex = vec![(0.0, 0.0); vertices];
    let reach = WELD_TOLERANCE * box_diagonal(points.iter().chain(&course).copied());
    let (mut links, mut link_radii, mut labels, mut first) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for (edge, count) in counts.iter().map(|count| *count as usize).enumerate() {
        let own = first..first + count;
        first += count;
        let mut line = Vec::with_capacity(count + 2);
        let vertex = |end: usize| {
            let row = ends[2 * edge + end];
            let wrong =
                || Fault::item(format!("edge {edge}"), format!("vertex {row}"), format!("expected one of {vertices}, from 0"));
            if row >= 0.0 && row < vertices as f64 && row.fract() == 0.0 { Ok(row as usize) } else { Err(wrong()) }
        };
        let (a, b) = (vertex(0)?, vertex(1)?);
        line.push(a as u32);
        for row in own.clone() {
            let is_end = |vertex: usize| distance(points[vertex], course[row]) <= reach;
            let mut tips = [(row == own.start, a), (row + 1 == own.end, b)].into_iter();
            if let Some((_, vertex)) = tips.find(|(is_here, vertex)| *is_here && is_end(*vertex)) {
                if is_radius(sizes[row]) {
                    at_vertex[vertex].0 += sizes[row];
                    at_vertex[vertex].1 += 1.0;
                }
                continue;
            }
            line.push(points.len() as u32);
            points.push(course[row]);
            radii.push(sizes[row]);
        }
        line.push(b as u32);
        links.extend(line.windows(2).map(|pair| [pair[0], pair[1]]));
        labels.resize(links.len(), edge);
        if of_edges {
            link_radii.resize(links.len(), sizes.get(own.start).copied().filter(|_| count > 0).unwrap_or(f64::NAN));
        }
    }
    for (radius, (sum, of)) in radii.iter_mut().zip(at_vertex) {
        *radius = if of > 0.0 { sum / of } else { f64::NAN };
    }
    let label = |link: usize| names.as_ref().map_or(String::new(), |names| names[labels[link]].clone());
    Ok((Centerlines { unit, ..centerlines(&points, &radii, &links, &link_radii, label) }, header.notes()))
}

impl AmiraHeader {
    fn read(bytes: &[u8]) -> Result<Self, Fault> {
        let head = &bytes[..bytes.len().min(MOST_HEADER)];
        let end = find(head, b"\n@").map(|at| at + 1);
        let end = end.ok_or_else(|| Fault::file("no section @1 after the header", ACCEPTED))?;
        let text = String::from_utf8_lossy(&head[..end]);
        let first = text.lines().next().unwrap_or_default();
        let kinds = [("BINARY-LITTLE-ENDIAN", Some(false)), ("BINARY", Some(true)), ("ASCII", None)];
        let unknown = || Fault::line(1, format!("\"{first}\""), "expected ASCII, BINARY or BINARY-LITTLE-ENDIAN");
        let (_, big) = kinds.into_iter().find(|(word, _)| first.contains(word)).ok_or_else(unknown)?;
        let (mut counts, mut arrays, mut parameters) = (HashMap::new(), Vec::new(), Vec::new());
        let mut groups: Vec<String> = Vec::new();
        for (row, line) in text.lines().enumerate().skip(1) {
            let (number, line) = (row + 1, line.trim());
            if line.starts_with('#') {
                continue;
            }
            if groups.is_empty() {
                let words: Vec<&str> = line.split_whitespace().collect();
                if let ["define", name, count] = words[..] {
                    let wrong = || Fault::line(number, format!("\"{line}\""), "expected a whole number");
                    counts.insert(name.to_owned(), count.parse().map_err(|_| wrong())?);
                    continue;
                }
                if let Some(declared) = declaration(number, line)? {
                    arrays.push(declared);
                    continue;
                }
            }
            read_parameters(number, line, &mut groups, &mut parameters)?;
        }
        Ok(Self { big, counts, arrays, parameters, end })
    }

    /// The value of a parameter in some groups.
    fn parameter(&self, groups: &[&str], name: &str) -> Option<&str> {
        let is_there = |within: &[String]| within.first().is_some_and(|first| first == "Parameters") && within[1..] == *groups;
        let found = self.parameters.iter().find(|(within, known, _)| is_there(within) && known == name);
        found.map(|(.., value)| value.as_str())
    }

    /// What a user should know of the unit and the place.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.parameter(&["Units"], "Coordinates").is_none() {
            notes.push("the file states no unit: took `units`".to_owned());
        }
        let is_identity = |matrix: &str| {
            matrix.split_whitespace().enumerate().all(|(n, word)| word.parse() == Ok(if n % 5 == 0 { 1.0 } else { 0.0 }))
        };
        if self.parameter(&[], "TransformationMatrix").is_some_and(|matrix| !is_identity(matrix)) {
            notes.push("the file's TransformationMatrix is not applied: in Amira, apply the transform before saving".to_owned());
        }
        notes
    }

    /// How many numbers an array has.
    fn numbers(&self, array: &Declared) -> Result<usize, Fault> {
        let count = self.counts.get(&array.of).and_then(|count| count.checked_mul(array.row)).filter(|n| *n < 1 << 40);
        count.ok_or_else(|| {
            Fault::line(array.line, format!("{} of {}", array.name, array.of), "expected a line `define` with its number")
        })
    }

    /// The bytes of every section.
    fn sections<'a>(&self, bytes: &'a [u8]) -> Result<HashMap<u32, &'a [u8]>, Fault> {
        let mut found = HashMap::new();
        let mut at = self.end;
        while at < bytes.len() {
            let rest = &bytes[at..];
            let end = rest.iter().take(64).position(|byte| *byte == b'\n').unwrap_or(rest.len());
            let line = String::from_utf8_lossy(&rest[..end.min(64)]).trim().to_owned();
            let section = line.strip_prefix('@').and_then(|number| number.parse::<u32>().ok());
            let wrong = || Fault::item("data", format!("\"{}\"", line.escape_debug()), "expected a section such as @1");
            let section = section.ok_or_else(wrong)?;
            let start = at + (end + 1).min(rest.len());
            let rest = &bytes[start..];
            let length = if self.big.is_none() {
                find(rest, b"\n@").map_or(rest.len(), |at| at + 1)
            } else {
                let array = self.arrays.iter().find(|array| array.section == section);
                let array =
                    array.ok_or_else(|| Fault::item("data", format!("section @{section}"), "expected one of the header"))?;
                match &array.packed {
                    Some((_, length)) => *length,
                    None => self.numbers(array)?.saturating_mul(array.size),
                }
            };
            let data = rest.get(..length).ok_or_else(|| {
                let found = format!("{} of {length} bytes", rest.len());
                Fault::item(format!("section @{section}"), found, "expected all of them; is the file cut off?")
            })?;
            let wrong = || Fault::item("data", format!("section @{section} twice"), "expected it once");
            ensure(found.insert(section, data).is_none(), wrong)?;
            at = start + length;
            at += bytes[at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        }
        Ok(found)
    }

    /// The numbers of an array.
    fn values(&self, array: &Declared, data: &HashMap<u32, &[u8]>, most: u64) -> Result<Vec<f64>, Fault> {
        let here = |found: String, accepted: &str| Fault::item(format!("{} (@{})", array.name, array.section), found, accepted);
        let wanted = self.numbers(array)?;
        let bytes = data.get(&array.section).copied().unwrap_or_default();
        let cut = |found: usize| here(format!("{found} of {wanted} numbers"), "expected all of them; is the file cut off?");
        let Some(big) = self.big else {
            let mut values = Vec::new();
            for word in bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
                let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
                values.push(number.ok_or_else(|| {
                    let word = String::from_utf8_lossy(&word[..word.len().min(20)]).into_owned();
                    here(format!("\"{}\"", word.escape_debug()), "expected a number")
                })?);
            }
            return if values.len() == wanted { Ok(values) } else { Err(cut(values.len())) };
        };
        let size = wanted.saturating_mul(array.size);
        let unpacked;
        let bytes = match &array.packed {
            None => bytes,
            Some((how, _)) => {
                let room = UnpackLimit::of(bytes.len(), most);
                room.take(size).map_err(|(found, accepted)| here(found, accepted))?;
                unpacked = unpack(how, bytes, size).map_err(|found| here(found, "expected HxZip or HxByteRLE, whole"))?;
                unpacked.as_slice()
            }
        };
        ensure(bytes.len() >= size, || cut(bytes.len() / array.size))?;
        Ok(bytes[..size].chunks_exact(array.size).map(|stored| array.kind.value(stored, big)).collect())
    }

    /// The radius of every point, and whether edges state it; `None` without radii where they are optional.
    fn radii(
        &self,
        data: &HashMap<u32, &[u8]>,
        options: &ReadOptions,
        counts: &[f64],
    ) -> Result<Option<(Vec<f64>, bool)>, Fault> {
        let find = |name: &str, of: &str| {
            self.arrays.iter().find(|array| array.of == of && array.row == 1 && array.name.eq_ignore_ascii_case(name))
        };
        let called = |name: &str| find(name, "POINT").or_else(|| find(name, "EDGE"));
        let named = options.radius_array.as_deref();
        let found = named.map_or_else(|| RADIUS.iter().find_map(|name| called(name)), called);
        let Some(array) = found else {
            let all = self.arrays.iter().map(|array| array.name.as_str()).collect::<Vec<_>>().join(", ");
            let accepted = "expected it, or give `radius_array` or `default_radius`";
            return match named {
                Some(name) => Err(Fault::file(format!("no {name} among {all}"), "expected the array that `radius_array` names")),
                None if options.is_radius_optional() => Ok(None),
                None => Err(Fault::file(format!("no thickness among {all}"), accepted)),
            };
        };
        let mut values = self.values(array, data, options.max_input)?;
        if array.name.to_ascii_lowercase().contains("area") {
            values = values.into_iter().map(radius_of).collect();
        }
        let of_edges = array.of == "EDGE";
        if of_edges {
            values = counts.iter().zip(values).flat_map(|(count, radius)| std::iter::repeat_n(radius, *count as usize)).collect();
        }
        Ok(Some((values, of_edges)))
    }

    /// The label of every edge, if there are any.
    fn labels(&self, data: &HashMap<u32, &[u8]>, most: u64) -> Result<Option<Vec<String>>, Fault> {
        let of_edges = || {
            let is_whole = |array: &&Declared| array.of == "EDGE" && array.row == 1 && array.kind != NumberType::Real;
            self.arrays.iter().filter(is_whole).filter(|array| array.name != "NumEdgePoints")
        };
        let group = |array: &Declared| -> BTreeMap<i64, &str> {
            let is_of = |groups: &[String]| groups.len() > 2 && groups[1..groups.len() - 1].contains(&array.name);
            let ids = self.parameters.iter().filter(|(groups, name, _)| name == "Id" && is_of(groups));
            ids.filter_map(|(groups, _, id)| Some((id.parse().ok()?, groups.last()?.as_str()))).collect()
        };
        let named = of_edges().map(|array| (array, group(array))).find(|(_, group)| !group.is_empty());
        let called =
            || of_edges().find(|array| array.name.to_ascii_lowercase().contains("label")).map(|array| (array, BTreeMap::new()));
        let Some((array, group)) = named.or_else(called) else { return Ok(None) };
        let label = |value: f64| match group.get(&(value as i64)) {
            Some(name) => (*name).to_owned(),
            None if value == 0.0 => String::new(),
            None => value.to_string(),
        };
        Ok(Some(self.values(array, data, most)?.into_iter().map(label).collect()))
    }
}

/// The bytes of a packed array, at most `size` of them.
fn unpack(how: &str, bytes: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    match how {
        "HxZip" => {
            ZlibDecoder::new(bytes).take(size as u64).read_to_end(&mut out).map_err(|error| format!("unreadable: {error}"))?;
        }
        // A byte of less than 128 repeats the next one so often; of a larger one, 128 less says how many bytes follow as they are.
        "HxByteRLE" => {
            let mut rest = bytes;
            while let Some((count, after)) = rest.split_first().filter(|_| out.len() < size) {
                let length = usize::from(count & 127);
                rest = if *count < 128 {
                    let Some((value, after)) = after.split_first() else { break };
                    out.extend(std::iter::repeat_n(*value, length));
                    after
                } else {
                    let taken = length.min(after.len());
                    out.extend_from_slice(&after[..taken]);
                    &after[taken..]
                };
            }
        }
        other => return Err(format!("packed as {other}")),
    }
    Ok(out)
}

/// The array that a line declares, `VERTEX { float[3] VertexCoordinates } @1`; `None` for another line.
fn declaration(number: usize, line: &str) -> Result<Option<Declared>, Fault> {
    let parts = || {
        let (of, rest) = line.split_once('{')?;
        let (inside, place) = rest.split_once('}')?;
        let (kind, name) = inside.trim().split_once(char::is_whitespace)?;
        let place = place.trim().trim_start_matches('=').trim().strip_prefix('@')?;
        Some((of.trim(), kind, name.trim(), place))
    };
    let Some((of, kind, name, place)) = parts() else { return Ok(None) };
    let fault = |accepted: &str| Fault::line(number, format!("\"{line}\""), accepted);
    let (kind, row) = match kind.split_once('[') {
        None => (kind, 1),
        Some((kind, row)) => {
            let row = row.trim_end_matches(']').parse().ok().filter(|row| (1..=64).contains(row));
            (kind, row.ok_or_else(|| fault("expected from 1 to 64 numbers each"))?)
        }
    };
    let (kind, size) = match kind {
        "byte" => (NumberType::Unsigned, 1),
        "short" => (NumberType::Signed, 2),
        "ushort" => (NumberType::Unsigned, 2),
        "int" | "int32" => (NumberType::Signed, 4),
        "uint" | "uint32" => (NumberType::Unsigned, 4),
        "long" | "int64" => (NumberType::Signed, 8),
        "float" => (NumberType::Real, 4),
        "double" => (NumberType::Real, 8),
        _ => return Err(fault("expected float, int or another type of number")),
    };
    let (section, packed) = match place.split_once('(') {
        None => (place, None),
        Some((section, how)) => {
            let packed = how.trim_end_matches(')').split_once(',');
            let packed = packed.and_then(|(how, bytes)| Some((how.trim().to_owned(), bytes.trim().parse().ok()?)));
            (section, Some(packed.ok_or_else(|| fault("expected how it is packed, and its bytes"))?))
        }
    };
    let section = section.trim().parse().map_err(|_| fault("expected a section such as @1"))?;
    Ok(Some(Declared { line: number, of: of.to_owned(), name: name.to_owned(), kind, size, row, section, packed }))
}

/// Adds the parameters of a line, which may begin and end groups.
fn read_parameters(number: usize, line: &str, groups: &mut Vec<String>, found: &mut Vec<Parameter>) -> Result<(), Fault> {
    let mut words: Vec<String> = Vec::new();
    let mut finish = |words: &mut Vec<String>, groups: &[String]| {
        if !words.is_empty() && !groups.is_empty() {
            let value = words[1..].join(" ");
            found.push((groups.to_vec(), words.swap_remove(0), value));
        }
        words.clear();
    };
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '{' if groups.len() == MOST_DEPTH => {
                return Err(Fault::line(number, format!("more than {MOST_DEPTH} groups within one another"), "expected fewer"));
            }
            '{' => {
                groups.push(words.join(" "));
                words.clear();
            }
            '}' => {
                finish(&mut words, groups);
                groups.pop();
            }
            ',' => finish(&mut words, groups),
            '"' => {
                let mut word = String::new();
                while let Some(character) = characters.next().filter(|character| *character != '"') {
                    word.push(if character == '\\' { characters.next().unwrap_or(character) } else { character });
                }
                words.push(word);
            }
            space if space.is_whitespace() => {}
            other => {
                let mut word = String::from(other);
                while let Some(character) = characters.next_if(|c| !c.is_whitespace() && !"{},\"".contains(*c)) {
                    word.push(character);
                }
                words.push(word);
            }
        }
    }
    finish(&mut words, groups);
    Ok(())
}

/// Writes a network as a SpatialGraph in text: nodes as vertices, vessels as edges with their points from node to node, radii as thickness, labels
/// as whole numbers that a group of parameters names. mm; a missing radius is 0.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_amira(mut out: impl Write, network: &Network) -> io::Result<()> {
    let (points, lines) = cells(network)?;
    let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, vessel) in network.vessels().filter(|(_, vessel)| !vessel.label.is_empty()) {
        let next = numbers.len() + 1;
        numbers.entry(&vessel.label).or_insert(next);
    }
    let (vertices, edges) = (network.node_count(), network.vessel_count());
    writeln!(out, "# AmiraMesh 3D ASCII 2.0\n\n")?;
    let count: usize = lines.iter().map(Vec::len).sum();
    writeln!(out, "define VERTEX {vertices}\ndefine EDGE {edges}\ndefine POINT {count}\n")?;
    writeln!(out, "Parameters {{\n    Units {{\n        Coordinates \"mm\"\n    }}")?;
    if !numbers.is_empty() {
        writeln!(out, "    {LABELS} {{")?;
        for (label, number) in &numbers {
            writeln!(out, "        {} {{\n            Id {number}\n        }}", quoted(label))?;
        }
        writeln!(out, "        Id 0\n    }}")?;
    }
    writeln!(out, "    ContentType \"HxSpatialGraph\"\n}}\n")?;
    writeln!(out, "VERTEX {{ float[3] VertexCoordinates }} @1\nEDGE {{ int[2] EdgeConnectivity }} @2")?;
    writeln!(out, "EDGE {{ int NumEdgePoints }} @3\nPOINT {{ float[3] EdgePointCoordinates }} @4")?;
    writeln!(out, "POINT {{ float thickness }} @5")?;
    if !numbers.is_empty() {
        writeln!(out, "EDGE {{ int {LABELS} }} @6")?;
    }
    let place = |row: usize| figures(&points[row], "0")[..3].join(" ");
    writeln!(out, "\n# Data section follows\n@1")?;
    (0..vertices).try_for_each(|row| writeln!(out, "{}", place(row)))?;
    writeln!(out, "\n@2")?;
    network.vessels().try_for_each(|([a, b], _)| writeln!(out, "{a} {b}"))?;
    writeln!(out, "\n@3")?;
    lines.iter().try_for_each(|line| writeln!(out, "{}", line.len()))?;
    writeln!(out, "\n@4")?;
    lines.iter().flatten().try_for_each(|row| writeln!(out, "{}", place(*row as usize)))?;
    writeln!(out, "\n@5")?;
    lines.iter().flatten().try_for_each(|row| writeln!(out, "{}", figures(&points[*row as usize], "0")[3]))?;
    if !numbers.is_empty() {
        writeln!(out, "\n@6")?;
        let number = |vessel: &Vessel| numbers.get(vessel.label.as_str()).copied().unwrap_or(0);
        network.vessels().try_for_each(|(_, vessel)| writeln!(out, "{}", number(vessel)))?;
    }
    out.flush()
}

/// The name of a group of parameters, in quotes unless it is a plain word.
fn quoted(name: &str) -> String {
    if name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c)) && name.starts_with(|c: char| c.is_ascii_alphabetic())
    {
        return name.to_owned();
    }
    let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
}
