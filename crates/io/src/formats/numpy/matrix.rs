//! NumPy arrays: a symmetric matrix as a dense `.npy` and as the `.npz` that `scipy.sparse.load_npz` reads, and any arrays
//! by name as `.npz`.

use std::io::{self, Seek, Write};

use ndarray::{Array1, Array2, ArrayD, arr0};
use ndarray_npy::{NpzWriter, WritableElement, WriteDataError, WriteNpyExt};
use zip::CompressionMethod;
use zip::write::SimpleFileOptions;

/// The bytes of a NumPy `|S3` element.
#[derive(Clone, Copy)]
struct S3([u8; 3]);

impl WritableElement for S3 {
    fn type_descriptor() -> py_literal::Value {
        py_literal::Value::String("|S3".into())
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
    if i32::try_from(n.max(data.len())).is_ok() {
        npz.add_array("indices", &indices.iter().map(|i| *i as i32).collect::<Array1<_>>()).map_err(io::Error::other)?;
        npz.add_array("indptr", &starts.iter().map(|i| *i as i32).collect::<Array1<_>>()).map_err(io::Error::other)?;
    } else {
        npz.add_array("indices", &Array1::from(indices)).map_err(io::Error::other)?;
        npz.add_array("indptr", &Array1::from(starts)).map_err(io::Error::other)?;
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
    if n.checked_mul(n).and_then(|cells| cells.checked_mul(8)).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{n} x {n} cells are too many")));
    }
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
        let array = ArrayD::from_shape_vec(shape, values).map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e))?;
        npz.add_array(name, &array).map_err(io::Error::other)?;
    }
    npz.finish().map_err(io::Error::other)?.flush()
}

fn check(n: usize, entries: &[(u32, u32, f64)]) -> io::Result<()> {
    match entries.iter().find(|(a, b, _)| *a as usize >= n || *b as usize >= n) {
        None => Ok(()),
        Some((a, b, _)) => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("entry ({a}, {b}) is outside {n} x {n}"))),
    }
}
