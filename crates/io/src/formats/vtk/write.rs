//! Writes a network as VTP and as legacy VTK: one polyline a vessel, for ParaView, VMTK and 3D Slicer.

use std::io::{self, Write};

use base64::{Engine, engine::general_purpose::STANDARD};

use crate::formats::vtk::SPACE;
use crate::formats::{Column, Network, Values, cells, check_rows, millimetres, real};

/// The first lines of a VTP file.
const HEAD: &str = r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">
  <PolyData>
"#;
/// Bytes compressed at a time, as VTK does.
const BLOCK: usize = 1 << 15;

/// Writes each vessel along its path, or straight where it has none, in mm, with its columns as cell data.
///
/// A node is one point, which all its vessels share. The point array `MaximumInscribedSphereRadius` is in mm; a node
/// without radius has that of its widest vessel, or NaN. Texts are arrays of strings.
///
/// # Errors
///
/// A node without position or a column without one value for each vessel (`InvalidInput`), or the writer's own.
pub fn write_vtp(mut out: impl Write, network: &Network, vessel_columns: &[Column]) -> io::Result<()> {
    check_rows(vessel_columns, network.vessel_count())?;
    let (points, cells) = cells(network)?;
    let connectivity: Vec<i64> = cells.iter().flatten().copied().collect();
    let mut offsets: Vec<i64> = Vec::with_capacity(cells.len());
    for cell in &cells {
        offsets.push(offsets.last().unwrap_or(&0) + cell.len() as i64);
    }
    write!(out, "{HEAD}")?;
    let (n, lines) = (points.len(), offsets.len());
    if let Some(name) = network.frame.name() {
        writeln!(out, "      <FieldData>")?;
        array(&mut out, &format!(r#"type="String" Name="{SPACE}" NumberOfTuples="1""#), format!("{name}\0").as_bytes())?;
        writeln!(out, "      </FieldData>")?;
    }
    write!(out, r#"    <Piece NumberOfPoints="{n}" NumberOfVerts="0" NumberOfLines="{lines}""#)?;
    writeln!(out, r#" NumberOfStrips="0" NumberOfPolys="0">"#)?;
    writeln!(out, r#"      <PointData Scalars="MaximumInscribedSphereRadius">"#)?;
    let reals = |values: &mut dyn Iterator<Item = f64>| values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let wholes = |values: &[i64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let radius = reals(&mut points.iter().map(|p| millimetres(p.radius)));
    array(&mut out, r#"type="Float64" Name="MaximumInscribedSphereRadius""#, &radius)?;
    writeln!(out, "      </PointData>\n      <CellData>")?;
    for column in vessel_columns {
        let name = crate::formats::escape(&column.name);
        let (attributes, bytes) = match &column.values {
            Values::Real(values) => (format!(r#"type="Float64" Name="{name}""#), reals(&mut values.iter().copied())),
            Values::Integer(values) => (format!(r#"type="Int64" Name="{name}""#), wholes(values)),
            // Every string ends with a zero byte, so it can hold none.
            Values::Text(values) => (
                format!(r#"type="String" Name="{name}" NumberOfTuples="{lines}""#),
                values.iter().flat_map(|s| s.bytes().filter(|b| *b != 0).chain([0])).collect(),
            ),
        };
        array(&mut out, &attributes, &bytes)?;
    }
    writeln!(out, "      </CellData>\n      <Points>")?;
    let coordinates = reals(&mut points.iter().flat_map(|p| p.position).map(millimetres));
    array(&mut out, r#"type="Float64" Name="Points" NumberOfComponents="3""#, &coordinates)?;
    writeln!(out, "      </Points>\n      <Lines>")?;
    array(&mut out, r#"type="Int64" Name="connectivity""#, &wholes(&connectivity))?;
    array(&mut out, r#"type="Int64" Name="offsets""#, &wholes(&offsets))?;
    writeln!(out, "      </Lines>\n    </Piece>\n  </PolyData>\n</VTKFile>")?;
    out.flush()
}

/// One array: the header of sizes and the compressed blocks, each in base64.
fn array(out: &mut impl Write, attributes: &str, bytes: &[u8]) -> io::Result<()> {
    let mut header = vec![bytes.len().div_ceil(BLOCK) as u64, BLOCK as u64, (bytes.len() % BLOCK) as u64];
    let mut packed = Vec::new();
    for block in bytes.chunks(BLOCK) {
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        zlib.write_all(block)?;
        let block = zlib.finish()?;
        header.push(block.len() as u64);
        packed.extend(block);
    }
    let header: Vec<u8> = header.into_iter().flat_map(u64::to_le_bytes).collect();
    writeln!(out, r#"        <DataArray {attributes} format="binary">"#)?;
    writeln!(out, "          {}{}", STANDARD.encode(header), STANDARD.encode(packed))?;
    writeln!(out, "        </DataArray>")
}

/// Writes each vessel along its path, or straight where it has none, in mm, with its columns as cell data.
///
/// A node is one point, which all its vessels share. The point array `MaximumInscribedSphereRadius` is in mm; a node without
/// radius has that of its widest vessel, or NaN. Texts are arrays of strings.
///
/// # Errors
///
/// A node without position or a column without one value for each vessel (`InvalidInput`), or the writer's own.
pub fn write_vtk(mut out: impl Write, network: &Network, vessel_columns: &[Column]) -> io::Result<()> {
    check_rows(vessel_columns, network.vessel_count())?;
    let (points, lines) = cells(network)?;
    let frame = network.frame.name().map_or(String::new(), |name| format!("; {SPACE}={name}"));
    writeln!(out, "# vtk DataFile Version 4.2\nvessels, lengths in mm{frame}\nASCII\nDATASET POLYDATA")?;
    writeln!(out, "POINTS {} double", points.len())?;
    points.iter().try_for_each(|point| writeln!(out, "{}", point.position.map(|x| number(millimetres(x))).join(" ")))?;
    let entries: usize = lines.iter().map(|line| line.len() + 1).sum();
    writeln!(out, "LINES {} {entries}", lines.len())?;
    for line in &lines {
        write!(out, "{}", line.len())?;
        line.iter().try_for_each(|point| write!(out, " {point}"))?;
        writeln!(out)?;
    }
    writeln!(out, "CELL_DATA {}\nFIELD FieldData {}", lines.len(), vessel_columns.len())?;
    for column in vessel_columns {
        let (kind, mut rows): (_, Box<dyn Iterator<Item = String> + '_>) = match &column.values {
            Values::Real(values) => ("double", Box::new(values.iter().map(|x| number(*x)))),
            // The widths of longer types differ from program to program.
            Values::Integer(values) if values.iter().all(|x| i32::try_from(*x).is_ok()) => {
                ("int", Box::new(values.iter().map(i64::to_string)))
            }
            Values::Integer(values) => ("double", Box::new(values.iter().map(|x| number(*x as f64)))),
            Values::Text(values) => ("string", Box::new(values.iter().map(escape))),
        };
        writeln!(out, "{} 1 {} {kind}", escape(&column.name), lines.len())?;
        rows.try_for_each(|row| writeln!(out, "{row}"))?;
    }
    writeln!(out, "POINT_DATA {0}\nFIELD FieldData 1\nMaximumInscribedSphereRadius 1 {0} double", points.len())?;
    points.iter().try_for_each(|point| writeln!(out, "{}", number(millimetres(point.radius))))?;
    out.flush()
}

fn number(x: f64) -> String {
    if x.is_nan() { "nan".to_owned() } else { real(x) }
}

/// Blanks, quotes, percent signs and what is not ASCII as `%` and two digits.
fn escape(text: &str) -> String {
    let escaped = |b: u8| !(33..=126).contains(&b) || b == b'"' || b == b'%';
    text.bytes().map(|b| if escaped(b) { format!("%{b:02X}") } else { char::from(b).to_string() }).collect()
}
