//! Writes a network as a legacy file of version 4.2, which every program that knows VTK reads.

use std::fmt::Display;
use std::io::{self, Write};

use crate::io::polylines::cells;
use crate::io::tables::column::{Column, Values, check_rows, real};
use crate::network::Network;
use crate::network::units::millimetres;

/// Writes each vessel along its path, or straight where it has none, in mm, with its columns as cell data.
///
/// A node is one point, which all its vessels share. The point array `MaximumInscribedSphereRadius` is in mm; a node without radius
/// has that of its widest vessel, or NaN. Texts are arrays of strings.
///
/// # Errors
///
/// A node without position or a column without one value for each vessel (`InvalidInput`), or the writer's own.
pub fn write_vtk(mut out: impl Write, network: &Network, vessel_columns: &[Column]) -> io::Result<()> {
    check_rows(vessel_columns, network.vessel_count())?;
    let (points, lines) = cells(network)?;
    writeln!(out, "# vtk DataFile Version 4.2\nvessels, lengths in mm\nASCII\nDATASET POLYDATA")?;
    writeln!(out, "POINTS {} double", points.len())?;
    for point in &points {
        reals(&mut out, &point.position.map(millimetres))?;
    }
    let entries: usize = lines.iter().map(|line| line.len() + 1).sum();
    writeln!(out, "LINES {} {entries}", lines.len())?;
    for line in &lines {
        let entries: Vec<i64> = std::iter::once(line.len() as i64).chain(line.iter().copied()).collect();
        words(&mut out, entries.iter())?;
    }
    writeln!(out, "CELL_DATA {}\nFIELD FieldData {}", lines.len(), vessel_columns.len())?;
    for column in vessel_columns {
        let (name, rows) = (escape(&column.name), lines.len());
        match &column.values {
            Values::Real(values) => {
                writeln!(out, "{name} 1 {rows} double")?;
                values.iter().try_for_each(|x| reals(&mut out, &[*x]))?;
            }
            // The widths of longer types differ from program to program.
            Values::Integer(values) if values.iter().all(|x| i32::try_from(*x).is_ok()) => {
                writeln!(out, "{name} 1 {rows} int")?;
                values.iter().try_for_each(|x| writeln!(out, "{x}"))?;
            }
            Values::Integer(values) => {
                writeln!(out, "{name} 1 {rows} double")?;
                values.iter().try_for_each(|x| reals(&mut out, &[*x as f64]))?;
            }
            Values::Text(values) => {
                writeln!(out, "{name} 1 {rows} string")?;
                values.iter().try_for_each(|text| writeln!(out, "{}", escape(text)))?;
            }
        }
    }
    writeln!(out, "POINT_DATA {0}\nFIELD FieldData 1\nMaximumInscribedSphereRadius 1 {0} double", points.len())?;
    points.iter().try_for_each(|point| reals(&mut out, &[millimetres(point.radius)]))?;
    out.flush()
}

fn reals(out: &mut impl Write, values: &[f64]) -> io::Result<()> {
    words(out, values.iter().map(|x| if x.is_nan() { "nan".to_owned() } else { real(*x) }))
}

fn words(out: &mut impl Write, words: impl Iterator<Item = impl Display>) -> io::Result<()> {
    for (n, word) in words.enumerate() {
        write!(out, "{}{word}", if n > 0 { " " } else { "" })?;
    }
    writeln!(out)
}

/// Blanks, quotes, percent signs and what is not ASCII as `%` and two digits.
fn escape(text: &str) -> String {
    let escaped = |b: u8| !(33..=126).contains(&b) || b == b'"' || b == b'%';
    text.bytes().map(|b| if escaped(b) { format!("%{b:02X}") } else { char::from(b).to_string() }).collect()
}
