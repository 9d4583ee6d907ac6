//! A single `.npy`: a square matrix of numbers.

use ndarray::Array2;

use super::super::limit::{MAX_INPUT, Room};
use super::array::Array;
use crate::error::Fault;

/// Reads an n x n matrix of any real type.
///
/// # Errors
///
/// Another shape or type, or a file that is cut.
pub fn read_npy_matrix(bytes: &[u8], n: usize) -> Result<Array2<f64>, Fault> {
    let array = Array::read("A", bytes, bytes.len() as u64, &Room::of(bytes.len(), MAX_INPUT))?;
    if array.shape != [n, n] {
        let shape = array.shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        return Err(Fault::file(
            format!("shape ({shape})"),
            format!("expected ({n}, {n}): a row and a column for every node of the graph"),
        ));
    }
    let values = array.reals()?;
    let at = |row: usize, column: usize| if array.is_fortran() { column * n + row } else { row * n + column };
    Ok(Array2::from_shape_fn((n, n), |(row, column)| values[at(row, column)]))
}
