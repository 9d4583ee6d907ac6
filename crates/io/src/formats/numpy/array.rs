//! NumPy arrays, whatever their type, byte order and order of axes: those of an `.npz` by name, and a symmetric matrix as a dense `.npy` and as
//! the `.npz` that `scipy.sparse.load_npz` reads.

use std::io::{self, Cursor, Read, Seek, Write};

use ndarray::{Array1, Array2, ArrayD, ShapeBuilder, arr0};
use ndarray_npy::{NpzWriter, WritableElement, WriteDataError, WriteNpyExt};
use py_literal::Value;
use zip::{CompressionMethod, ZipArchive, write::SimpleFileOptions};

use crate::formats::input::MAX_INPUT;
use crate::formats::{Fault, NumberType, UnpackLimit, ensure, refused, word};

/// Values of one array at the most: 1 GiB of float64.
const MOST_VALUES: usize = 1 << 27;
/// No compression of zip makes more of a byte (deflate: 1032).
const MOST_INFLATION: u64 = 1100;
/// The header of a plain array has less than 200 bytes.
const MOST_HEADER: usize = 4096;
/// The values that skeleton graphs have.
const ACCEPTED: &str = "expected float32, float64, integers, or text for labels";
/// The archives that are read.
const ACCEPTED_NAMES: &str =
    "expected a skeleton graph: coords (N, 3), edges (M, 2) and radii (N) or (M); or a mask: mask, and affine or spacing";
/// Brackets within one another at the most.
const MOST_BRACKETS: usize = 6;

#[derive(Clone, Copy, PartialEq)]
enum ElementKind {
    Number(NumberType),
    /// True or false, as a byte.
    Truth,
    /// UTF-32 text.
    Utf32,
    /// Bytes of ASCII text.
    Ascii,
}

/// An array that has been read.
pub(crate) struct NumpyArray {
    name: String,
    pub(crate) shape: Vec<usize>,
    kind: ElementKind,
    /// Bytes of one value.
    size: usize,
    big: bool,
    /// Whether the first axis runs fastest.
    pub(crate) fortran: bool,
    /// The values as they are stored.
    pub(crate) data: Vec<u8>,
}

impl NumpyArray {
    /// Reads a member of the archive, which takes `stored` bytes there. The size that the file states alone allocates nothing.
    pub(crate) fn read(name: &str, mut member: impl Read, stored: u64, room: &UnpackLimit) -> Result<Self, Fault> {
        let fault = |found: String, accepted: &str| Fault::item(format!("array {name}"), found, accepted);
        let text = header(&mut member).ok_or_else(|| fault("not a NumPy array".into(), "expected .npy members"))?;
        let unreadable = || fault(format!("header {}", text.trim_end()), "expected descr, fortran_order and shape");
        let header = text.trim().parse::<Value>().ok();
        let pairs = header.as_ref().and_then(Value::as_dict).ok_or_else(unreadable)?;
        let entry = |key: &str| pairs.iter().find(|(k, _)| k.as_string().is_some_and(|k| k == key)).map(|(_, value)| value);
        let fortran = entry("fortran_order").and_then(Value::as_boolean).ok_or_else(unreadable)?;
        let shape = entry("shape").and_then(Value::as_tuple).ok_or_else(unreadable)?;
        let length = |n: &Value| n.as_integer().and_then(|n| n.to_string().parse::<usize>().ok());
        let shape: Vec<usize> = shape.iter().map(length).collect::<Option<_>>().ok_or_else(unreadable)?;
        let descr = entry("descr").ok_or_else(unreadable)?;
        let Some(dtype) = descr.as_string().map(String::as_str).filter(|d| d.is_ascii()) else {
            return Err(fault("structured values".into(), ACCEPTED));
        };
        let (order, kind, size) = (dtype.get(..1), dtype.get(1..2), dtype.get(2..).and_then(|s| s.parse::<usize>().ok()));
        let (kind, size) = match (kind, size) {
            (Some("f"), Some(size @ (4 | 8))) => (ElementKind::Number(NumberType::Real), size),
            (Some("i"), Some(size @ (1 | 2 | 4 | 8))) => (ElementKind::Number(NumberType::Signed), size),
            (Some("u"), Some(size @ (1 | 2 | 4 | 8))) => (ElementKind::Number(NumberType::Unsigned), size),
            (Some("b"), Some(size @ 1)) => (ElementKind::Truth, size),
            (Some("U"), Some(length @ 0..=4096)) => (ElementKind::Utf32, 4 * length),
            (Some("S"), Some(length @ 0..=4096)) => (ElementKind::Ascii, length),
            (Some("O"), _) => return Err(fault("Python objects (pickled)".into(), ACCEPTED)),
            _ => return Err(fault(format!("values of type {dtype}"), ACCEPTED)),
        };
        let values = shape.iter().try_fold(1_usize, |all, n| all.checked_mul(*n)).filter(|n| *n <= MOST_VALUES);
        let many = || fault(format!("shape {}", tuple(&shape)), &format!("expected at most {MOST_VALUES} values"));
        let bytes = values.and_then(|values| values.checked_mul(size)).ok_or_else(many)?;
        let short = |found: usize| {
            fault(format!("shape {} needs {bytes} bytes, the file has {found}", tuple(&shape)), "expected a whole file")
        };
        ensure(bytes as u64 <= stored.saturating_mul(MOST_INFLATION), || short(stored as usize))?;
        // Texts of no length take room too, once they are read.
        let texts = matches!(kind, ElementKind::Utf32 | ElementKind::Ascii);
        let least = if texts { shape.iter().product::<usize>().saturating_mul(size_of::<String>()) } else { 0 };
        room.take(bytes.max(least)).map_err(|(found, accepted)| fault(found, accepted))?;
        let mut data = Vec::new();
        let whole = member.take(bytes as u64 + 1).read_to_end(&mut data);
        whole.map_err(|e| fault(format!("cannot be read: {e}"), "expected a whole file"))?;
        ensure(data.len() == bytes, || short(data.len()))?;
        Ok(Self { name: name.to_owned(), shape, kind, size, big: order == Some(">"), fortran, data })
    }

    /// How many values there are.
    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// The rows of a table of `N` columns as numbers.
    pub(crate) fn rows<const N: usize>(&self) -> Result<Vec<[f64; N]>, Fault> {
        let wrong = || self.fault(format!("shape {}", tuple(&self.shape)), format!("expected a row of {N} for each"));
        ensure(self.shape.len() == 2 && self.shape[1] == N, wrong)?;
        let rows = self.table(self.shape[0], N)?;
        Ok(rows.outer_iter().map(|row| std::array::from_fn(|column| row[column])).collect())
    }

    /// The values of a table.
    fn table(&self, rows: usize, columns: usize) -> Result<Array2<f64>, Fault> {
        let table = Array2::from_shape_vec((rows, columns).set_f(self.fortran), self.reals()?);
        table.map_err(|error| self.fault(error.to_string(), "expected a whole file"))
    }

    /// Whether the values are whole numbers.
    pub(crate) fn is_whole(&self) -> bool {
        matches!(self.kind, ElementKind::Number(NumberType::Signed | NumberType::Unsigned))
    }

    /// All values as numbers, in the order of the file.
    pub(crate) fn reals(&self) -> Result<Vec<f64>, Fault> {
        ensure(self.kind != ElementKind::Truth, || self.fault("values of type |b1", ACCEPTED))?;
        let (kind, size, big) = self.numbers()?;
        Ok(self.data.chunks_exact(size).map(|bytes| kind.value(bytes, big)).collect())
    }

    /// All values as text; whole numbers too, 0 being none.
    pub(crate) fn texts(&self) -> Result<Vec<String>, Fault> {
        if let ElementKind::Number(_) = self.kind {
            let numbers = self.reals()?;
            if let Some(odd) = numbers.iter().find(|x| x.is_infinite() || x.fract().abs() > 0.0) {
                return Err(self.fault(format!("value {odd}"), "expected names, or whole numbers"));
            }
            let name = |x: f64| if x == 0.0 || x.is_nan() { String::new() } else { x.to_string() };
            return Ok(numbers.into_iter().map(name).collect());
        }
        let letters = |bytes: &[u8]| -> Option<String> {
            let all: Option<String> = match self.kind {
                ElementKind::Utf32 => bytes.chunks_exact(4).map(|c| char::from_u32(word(c, self.big) as u32)).collect(),
                ElementKind::Ascii => bytes.iter().map(|b| b.is_ascii().then_some(char::from(*b))).collect(),
                ElementKind::Number(..) | ElementKind::Truth => None,
            };
            all.map(|text| text.trim_end_matches('\0').to_owned())
        };
        if self.size == 0 {
            return Ok(vec![String::new(); self.len()]);
        }
        let texts: Option<Vec<String>> = self.data.chunks_exact(self.size).map(letters).collect();
        texts.ok_or_else(|| self.fault("values that are no text".to_owned(), "expected names, or whole numbers"))
    }

    /// The type of its numbers, the bytes of each, and whether the most significant byte is first.
    pub(crate) fn numbers(&self) -> Result<(NumberType, usize, bool), Fault> {
        match self.kind {
            ElementKind::Number(kind) => Ok((kind, self.size, self.big)),
            ElementKind::Truth => Ok((NumberType::Unsigned, self.size, self.big)),
            ElementKind::Utf32 | ElementKind::Ascii => Err(self.fault("text", "expected numbers")),
        }
    }

    /// A fault of this array.
    pub(crate) fn fault(&self, found: impl Into<String>, accepted: impl Into<String>) -> Fault {
        Fault::item(format!("array {}", self.name), found, accepted)
    }
}

/// An open `.npz`.
pub(crate) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    room: &'a UnpackLimit,
    pub(crate) names: Vec<String>,
}

impl<'a> Archive<'a> {
    pub(crate) fn open(bytes: &'a [u8], room: &'a UnpackLimit) -> Result<Self, Fault> {
        let broken = |e| Fault::file(format!("the archive is broken: {e}"), "expected a whole .npz file");
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
        let names = zip.file_names().map(|name| name.strip_suffix(".npy").unwrap_or(name).to_owned()).collect();
        Ok(Self { zip, room, names })
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    pub(crate) fn lacks(&self, name: &str) -> Fault {
        let names = if self.names.is_empty() { "nothing".to_owned() } else { self.names.join(", ") };
        Fault::file(format!("no array {name} among {names}"), ACCEPTED_NAMES)
    }

    /// The array under the first of the names that is there.
    pub(crate) fn first(&mut self, names: &[&str]) -> Result<Option<NumpyArray>, Fault> {
        let found = names.iter().find_map(|name| Some((self.names.iter().position(|known| known == name)?, *name)));
        let Some((row, name)) = found else { return Ok(None) };
        let broken = |e| Fault::item(format!("array {name}"), format!("cannot be read: {e}"), "expected stored or deflated");
        let member = self.zip.by_index(row).map_err(broken)?;
        let stored = member.compressed_size();
        NumpyArray::read(name, member, stored, self.room).map(Some)
    }
}

/// The dictionary of a NumPy array in text; `None` where the bytes are something else.
fn header(member: &mut impl Read) -> Option<String> {
    let mut start = [0; 8];
    member.read_exact(&mut start).ok()?;
    let width = match (&start[..6], start[6]) {
        (b"\x93NUMPY", 1) => 2,
        (b"\x93NUMPY", 2 | 3) => 4,
        _ => return None,
    };
    let mut length = [0; 4];
    member.read_exact(&mut length[..width]).ok()?;
    let length = u32::from_le_bytes(length) as usize;
    let mut text = vec![0; Some(length).filter(|length| *length <= MOST_HEADER)?];
    member.read_exact(&mut text).ok()?;
    // The parser takes twice as long for each bracket within another: a header has two or three.
    let (mut depth, mut deepest) = (0_usize, 0);
    for byte in &text {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    String::from_utf8(text).ok().filter(|_| deepest <= MOST_BRACKETS)
}

fn tuple(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    format!("({})", lengths.join(", "))
}

/// Reads an n x n matrix of any real type.
///
/// # Errors
///
/// Another shape or type, or a file that is cut.
pub fn read_npy_matrix(bytes: &[u8], n: usize) -> Result<Array2<f64>, Fault> {
    let array = NumpyArray::read("A", bytes, bytes.len() as u64, &UnpackLimit::of(bytes.len(), MAX_INPUT))?;
    let accepted = || format!("expected ({n}, {n}): a row and a column for every node of the graph");
    ensure(array.shape == [n, n], || Fault::file(format!("shape {}", tuple(&array.shape)), accepted()))?;
    array.table(n, n)
}

/// The bytes of a NumPy `|S3` element.
#[derive(Clone, Copy)]
struct S3([u8; 3]);

impl WritableElement for S3 {
    fn type_descriptor() -> Value {
        Value::String("|S3".into())
    }

    fn write<W: Write>(&self, mut out: W) -> Result<(), WriteDataError> {
        Ok(out.write_all(&self.0)?)
    }

    fn write_slice<W: Write>(slice: &[Self], mut out: W) -> Result<(), WriteDataError> {
        slice.iter().try_for_each(|x| Ok(out.write_all(&x.0)?))
    }
}

/// Writes the symmetric n x n matrix of `entries` (row, column, value) as compressed sparse rows, both triangles.
///
/// Either triangle may be given; the values of one pair are summed in the order of `entries`.
///
/// # Errors
///
/// A row or column that is not below n (`InvalidInput`), or the writer's own.
pub fn write_npz(out: impl Write + Seek, n: usize, entries: &[(u32, u32, f64)]) -> io::Result<()> {
    check(n, entries)?;
    let mut both = Vec::with_capacity(2 * entries.len());
    for (a, b, value) in entries {
        both.push((*a, *b, *value));
        if a != b {
            both.push((*b, *a, *value));
        }
    }
    both.sort_by_key(|(a, b, _)| (*a, *b));
    let (mut indices, mut data, mut starts) = (Vec::<i64>::new(), Vec::<f64>::new(), vec![0_i64; n + 1]);
    let mut last = None;
    for (a, b, value) in both {
        if let (true, Some(sum)) = (last == Some((a, b)), data.last_mut()) {
            *sum += value;
        } else {
            indices.push(i64::from(b));
            data.push(value);
            starts[a as usize + 1] += 1;
            last = Some((a, b));
        }
    }
    for row in 0..n {
        starts[row + 1] += starts[row];
    }
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(data.len() >= 1 << 28);
    let mut npz = NpzWriter::new_with_options(out, options);
    // scipy takes 32-bit indices where they suffice.
    let is_short = i32::try_from(n.max(data.len())).is_ok();
    for (name, values) in [("indices", indices), ("indptr", starts)] {
        let values = Array1::from(values);
        let added = if is_short { npz.add_array(name, &values.mapv(|i| i as i32)) } else { npz.add_array(name, &values) };
        added.map_err(io::Error::other)?;
    }
    npz.add_array("format", &arr0(S3(*b"csr"))).map_err(io::Error::other)?;
    npz.add_array("shape", &Array1::from(vec![n as i64; 2])).map_err(io::Error::other)?;
    npz.add_array("data", &Array1::from(data)).map_err(io::Error::other)?;
    npz.finish().map_err(io::Error::other)?.flush()
}

/// Writes the symmetric n x n matrix of `entries` (row, column, value) as a dense float64 array in C order.
///
/// Either triangle may be given; the values of one pair are summed in the order of `entries`.
///
/// # Errors
///
/// A row or column that is not below n (`InvalidInput`), more cells than memory can address, or the writer's own.
pub fn write_npy(mut out: impl Write, n: usize, entries: &[(u32, u32, f64)]) -> io::Result<()> {
    check(n, entries)?;
    let fits = n.checked_mul(n).and_then(|cells| cells.checked_mul(8)).is_some_and(|bytes| isize::try_from(bytes).is_ok());
    ensure(fits, || refused(format!("{n} x {n} cells are too many")))?;
    let mut matrix = Array2::<f64>::zeros((n, n));
    for (a, b, value) in entries {
        let (a, b) = (*a as usize, *b as usize);
        matrix[[a, b]] += value;
        if a != b {
            matrix[[b, a]] += value;
        }
    }
    matrix.write_npy(&mut out).map_err(io::Error::other)?;
    out.flush()
}

/// An array with the name by which `numpy.load` finds it.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedArray<T = f64> {
    /// The name.
    pub name: String,
    /// Its length along each axis.
    pub shape: Vec<usize>,
    /// Its values in C order.
    pub values: Vec<T>,
}

/// Writes arrays, one after another, as the uncompressed `.npz` of `numpy.savez`.
///
/// # Errors
///
/// Values that do not fill their shape (`InvalidInput`), or the writer's own.
pub fn write_arrays<T: WritableElement>(out: impl Write + Seek, all: impl IntoIterator<Item = NamedArray<T>>) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    let mut npz = NpzWriter::new_with_options(out, options);
    for NamedArray { name, shape, values } in all {
        let array = ArrayD::from_shape_vec(shape, values).map_err(|e| refused(e.to_string()))?;
        npz.add_array(name, &array).map_err(io::Error::other)?;
    }
    npz.finish().map_err(io::Error::other)?.flush()
}

fn check(n: usize, entries: &[(u32, u32, f64)]) -> io::Result<()> {
    let outside = entries.iter().find(|(a, b, _)| *a as usize >= n || *b as usize >= n);
    outside.map_or(Ok(()), |(a, b, _)| Err(refused(format!("entry ({a}, {b}) is outside {n} x {n}"))))
}
