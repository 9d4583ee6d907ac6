//! An SWC tracing with what iCafe leaves beside it: a table of vessels, which names them, and the spacing of the voxels.

use std::path::Path;

use super::beside::{table_of_vessels_beside, tracing_beside};
use super::document::{Content, ReadOptions, without_mark};
use super::limit::bytes_within;
use super::sniff::Format;
use super::{icafe, name_stretches, read_swc, read_traced_vessels};
use crate::centerline::Centerlines;
use crate::error::{Fault, Result};
use crate::units::{LengthUnit, Scale};

/// Reads the points of a tracing, named after the table of vessels beside it where that is its own.
pub(super) fn read_tracing(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Format, Content, Vec<String>)> {
    let (mut lines, mut notes) = read_swc(bytes, &options.scale).map_err(|fault| fault.in_file(path))?;
    let mut format = Format::Swc;
    if let Some(table) = table_of_vessels_beside(path)
        && let Some(note) = name_vessels(&mut lines, &bytes_within(&table, options.max_input)?, &table, &options.scale)?
    {
        format = Format::ICafe;
        notes.push(note);
    }
    notes.extend(spacing_note(path, &options.scale));
    Ok((format, Content::Centerlines(lines), notes))
}

/// Reads the one tracing beside a table of vessels.
pub(super) fn read_table_of_vessels(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let here = |fault: Fault| fault.in_file(path);
    let tracing = tracing_beside(path).map_err(here)?;
    let traced = bytes_within(&tracing, options.max_input)?;
    let (mut lines, mut notes) = read_swc(without_mark(&traced), &options.scale).map_err(|fault| fault.in_file(&tracing))?;
    notes.push(format!("the points are those of {}", tracing.display()));
    let wrong = || Fault::file("none of its vessels begins and ends at points of the tracing", "expected those of one image");
    notes.push(name_vessels(&mut lines, bytes, path, &options.scale)?.ok_or_else(wrong).map_err(here)?);
    notes.extend(spacing_note(&tracing, &options.scale));
    Ok((Content::Centerlines(lines), notes))
}

/// Names the stretches of a tracing after its table of vessels; `None` when the table is that of another tracing.
fn name_vessels(lines: &mut Centerlines, bytes: &[u8], table: &Path, scale: &Scale) -> Result<Option<String>> {
    let vessels = read_traced_vessels(without_mark(bytes), scale).map_err(|fault| fault.in_file(table))?;
    let named = name_stretches(lines, &vessels);
    let note = || format!("labels are those of {}: {named} of its {} vessels are in the tracing", table.display(), vessels.len());
    Ok((named > 0).then(note))
}

/// The voxel spacing that iCafe states beside a tracing, where lengths are not taken as voxels.
fn spacing_note(tracing: &Path, scale: &Scale) -> Option<String> {
    let spacing = icafe::spacing_beside(tracing).filter(|_| scale.unit != LengthUnit::Voxel)?;
    Some(format!("Image_info.txt beside it states a voxel spacing of {spacing} mm; give --units voxel --spacing {spacing}"))
}
