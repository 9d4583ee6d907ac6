//! Any arrays of numbers by name, as [`super::super::write_arrays`] writes them.

use std::io::Cursor;

use zip::ZipArchive;

use super::super::limit::{MAX_INPUT, Room};
use super::super::numpy::NamedArray;
use super::array::Array;
use crate::error::Fault;

/// Reads every array of an `.npz` as float64, in the order of the file.
///
/// # Errors
///
/// A file that is cut or damaged, or an array of something else than numbers in C order.
pub fn read_arrays(bytes: &[u8]) -> Result<Vec<NamedArray>, Fault> {
    let broken = |e: &dyn std::fmt::Display| Fault::file(format!("a broken archive ({e})"), "expected arrays of NumPy (.npz)");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| broken(&e))?;
    // Counts of samples may be zeros throughout: they unpack to any times their size.
    let room = Room::of(usize::MAX, MAX_INPUT);
    let mut arrays = Vec::with_capacity(archive.len());
    for at in 0..archive.len() {
        let member = archive.by_index(at).map_err(|e| broken(&e))?;
        let name = member.name().trim_end_matches(".npy").to_owned();
        let stored = member.compressed_size();
        let array = Array::read(&name, member, stored, &room)?;
        if array.is_fortran() && array.shape.len() > 1 {
            return Err(Fault::item(format!("array {name}"), "in Fortran order", "expected C order"));
        }
        arrays.push(NamedArray { name, values: array.reals()?, shape: array.shape });
    }
    Ok(arrays)
}
