//! Writes a network as a legacy file of version 4.2, which every program that knows VTK reads.

use std::fmt::Display;
use std::io::{self, Write};

use super::super::column::{Column, Values, check_rows, real};
use super::super::polyline::cells;
use crate::network::Network;
use crate::units::millimetres;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Digits {
    /// In digits: the shortest that bring a number back.
    #[default]
    Ascii,
    /// In big-endian binary.
    Binary,
}

/// Writes each vessel along its path, or straight where it has none, in mm, with its columns as cell data.
///
/// A node is one point, which all its vessels share. The point array `MaximumInscribedSphereRadius` is in mm; a node without radius
/// has that of its widest vessel, or NaN. Texts are arrays of strings.
///
/// # Errors
///
/// A node without position or a column without one value for each vessel (`InvalidInput`), or the writer's own.
pub fn write_vtk(mut out: impl Write, network: &Network, vessel_columns: &[Column], digits: Digits) -> io::Result<()> {
    check_rows(vessel_columns, network.vessel_count())?;
    let (points, lines) = cells(network)?;
    let encoding = if digits == Digits::Ascii { "ASCII" } else { "BINARY" };
    writeln!(out, "# vtk DataFile Version 4.2\nvessels, lengths in mm\n{encoding}\nDATASET POLYDATA")?;
    writeln!(out, "POINTS {} double", points.len())?;
    for point in &points {
        reals(&mut out, digits, &point.position.map(millimetres))?;
    }
    let entries: usize = lines.iter().map(|line| line.len() + 1).sum();
    writeln!(out, "{}LINES {} {entries}", end(digits), lines.len())?;
    for line in &lines {
        let entries: Vec<i64> = std::iter::once(line.len() as i64).chain(line.iter().copied()).collect();
        wholes(&mut out, digits, &entries)?;
    }
    writeln!(out, "{}CELL_DATA {}\nFIELD FieldData {}", end(digits), lines.len(), vessel_columns.len())?;
    for column in vessel_columns {
        let (name, rows) = (escape(column.name), lines.len());
        match &column.values {
            Values::Real(values) => {
                writeln!(out, "{name} 1 {rows} double")?;
                values.iter().try_for_each(|x| reals(&mut out, digits, &[*x]))?;
            }
            // The widths of longer types differ from program to program.
            Values::Integer(values) if values.iter().all(|x| i32::try_from(*x).is_ok()) => {
                writeln!(out, "{name} 1 {rows} int")?;
                values.iter().try_for_each(|x| wholes(&mut out, digits, &[*x]))?;
            }
            Values::Integer(values) => {
                writeln!(out, "{name} 1 {rows} double")?;
                values.iter().try_for_each(|x| reals(&mut out, digits, &[*x as f64]))?;
            }
            Values::Text(values) => {
                writeln!(out, "{name} 1 {rows} string")?;
                values.iter().try_for_each(|text| string(&mut out, digits, text))?;
            }
        }
        write!(out, "{}", end(digits))?;
    }
    writeln!(out, "POINT_DATA {0}\nFIELD FieldData 1\nMaximumInscribedSphereRadius 1 {0} double", points.len())?;
    points.iter().try_for_each(|point| reals(&mut out, digits, &[millimetres(point.radius)]))?;
    write!(out, "{}", end(digits))?;
    out.flush()
}

/// What ends an array: in digits its last line has ended already.
fn end(digits: Digits) -> &'static str {
    if digits == Digits::Ascii { "" } else { "\n" }
}

fn reals(out: &mut impl Write, digits: Digits, values: &[f64]) -> io::Result<()> {
    if digits == Digits::Binary {
        return values.iter().try_for_each(|x| out.write_all(&x.to_be_bytes()));
    }
    words(out, values.iter().map(|x| if x.is_nan() { "nan".to_owned() } else { real(*x) }))
}

fn wholes(out: &mut impl Write, digits: Digits, values: &[i64]) -> io::Result<()> {
    if digits == Digits::Ascii {
        return words(out, values.iter());
    }
    for value in values {
        let narrow = i32::try_from(*value).map_err(|_| {
            io::Error::new(io::ErrorKind::InvalidInput, format!("{value} is beyond the 32 bits of a legacy VTK file"))
        })?;
        out.write_all(&narrow.to_be_bytes())?;
    }
    Ok(())
}

fn words(out: &mut impl Write, words: impl Iterator<Item = impl Display>) -> io::Result<()> {
    for (n, word) in words.enumerate() {
        write!(out, "{}{word}", if n > 0 { " " } else { "" })?;
    }
    writeln!(out)
}

/// A text: a line with escapes, or in binary its length, whose two upper bits say how many bytes it has, before it.
fn string(out: &mut impl Write, digits: Digits, text: &str) -> io::Result<()> {
    if digits == Digits::Ascii {
        return writeln!(out, "{}", escape(text));
    }
    let length = text.len();
    match length {
        0..=0x3f => out.write_all(&[0xc0 | length as u8])?,
        0x40..=0x3fff => out.write_all(&(0x8000 | length as u16).to_be_bytes())?,
        0x4000..=0x3fff_ffff => out.write_all(&(0x4000_0000 | length as u32).to_be_bytes())?,
        _ => out.write_all(&(length as u64).to_be_bytes())?,
    }
    out.write_all(text.as_bytes())
}

/// Blanks, quotes, percent signs and what is not ASCII as `%` and two digits.
fn escape(text: &str) -> String {
    let escaped = |b: u8| !(33..=126).contains(&b) || b == b'"' || b == b'%';
    text.bytes().map(|b| if escaped(b) { format!("%{b:02X}") } else { char::from(b).to_string() }).collect()
}
