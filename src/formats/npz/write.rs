//! Writes a network as the arrays of a skeleton graph.

use std::io::{self, Seek, Write};

use ndarray::{Array1, Array2};
use ndarray_npy::{WritableElement, WriteNpyExt};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use super::super::polyline::positions;
use super::super::skeleton::{is_straight, skeleton};
use crate::geometry::Point;
use crate::network::Network;
use crate::units::millimetres;

/// Writes `coords` (N, 3) and `edges` (M, 2), the nodes first in their order, and the other arrays as
/// [`super::read_skeleton_npz`] takes them, mm.
///
/// Where a vessel has points between its nodes, the edges link points and `radii` (N) are theirs. Where none has, every edge
/// is a vessel, `radii` (M) and `lengths` (M) are the vessels'. `labels` (M) is left out where no vessel has one.
///
/// # Errors
///
/// A node without a position; two vessels that points cannot tell apart (`InvalidInput`); the writer's own.
pub fn write_skeleton_npz(out: impl Write + Seek, network: &Network) -> io::Result<()> {
    let mut zip = ZipWriter::new(out);
    let names: Vec<&str> = if is_straight(network) {
        let points = positions(network)?;
        let links: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
        write(&mut zip, "coords", &coords(points.iter()))?;
        write(&mut zip, "edges", &edges(&links))?;
        write(&mut zip, "radii", &network.vessels().map(|(_, v)| millimetres(v.radius)).collect::<Array1<f64>>())?;
        write(&mut zip, "lengths", &network.vessels().map(|(_, v)| millimetres(v.length)).collect::<Array1<f64>>())?;
        network.vessels().map(|(_, v)| v.label.as_str()).collect()
    } else {
        let found = skeleton(network)?;
        write(&mut zip, "coords", &coords(found.points.iter().map(|p| &p.position)))?;
        write(&mut zip, "edges", &edges(&found.links))?;
        write(&mut zip, "radii", &found.points.iter().map(|p| millimetres(p.radius)).collect::<Array1<f64>>())?;
        found.vessel.iter().map(|row| network.vessel(*row).label.as_str()).collect()
    };
    labels(&mut zip, &names)?;
    zip.finish().map_err(io::Error::other)?.flush()
}

fn coords<'a>(points: impl ExactSizeIterator<Item = &'a Point>) -> Array2<f64> {
    let n = points.len();
    let values: Vec<f64> = points.flatten().map(|x| millimetres(*x)).collect();
    Array2::from_shape_vec((n, 3), values).unwrap_or_default()
}

fn edges(links: &[[usize; 2]]) -> Array2<i64> {
    let values: Vec<i64> = links.iter().flatten().map(|row| *row as i64).collect();
    Array2::from_shape_vec((links.len(), 2), values).unwrap_or_default()
}

fn start(zip: &mut ZipWriter<impl Write + Seek>, name: &str) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true);
    zip.start_file(format!("{name}.npy"), options).map_err(io::Error::other)
}

fn write<T: WritableElement, D: ndarray::Dimension>(
    zip: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    array: &ndarray::Array<T, D>,
) -> io::Result<()> {
    start(zip, name)?;
    array.write_npy(zip).map_err(io::Error::other)
}

/// Text as NumPy's `<U`: UTF-32 of equal length, which no element type of a fixed size can be.
fn labels(zip: &mut ZipWriter<impl Write + Seek>, labels: &[&str]) -> io::Result<()> {
    let longest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    if longest == 0 {
        return Ok(());
    }
    start(zip, "labels")?;
    let mut header = format!("{{'descr': '<U{longest}', 'fortran_order': False, 'shape': ({},), }}", labels.len());
    // The values begin at a multiple of 64.
    let padded = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header.extend(std::iter::repeat_n(' ', padded - header.len() - 1).chain(['\n']));
    zip.write_all(b"\x93NUMPY\x01\x00")?;
    zip.write_all(&(header.len() as u16).to_le_bytes())?;
    zip.write_all(header.as_bytes())?;
    for label in labels {
        let letters = label.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest);
        let bytes: Vec<u8> = letters.flat_map(u32::to_le_bytes).collect();
        zip.write_all(&bytes)?;
    }
    Ok(())
}
