//! Reads an input file of any format and makes a network of it.

use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use super::content::Content;
use super::format::{Document, format_of};
use super::known::Format;
use super::options::ReadOptions;
use super::unit_check::{check_extent, unit_check};
use super::xml;
use crate::formats::graphml::read_graphml;
use crate::formats::images::nifti::{self, is_nifti};
use crate::formats::input::{HEAD, LimitedFile, bytes_within, checksum, unpacked_file, unpacked_head, without_mark};
use crate::formats::tables::lists::add_loops;
use crate::formats::tables::reader::plural;
use willis_core::error::{Error, Fault, Result};

/// Reads centerlines or a graph.
///
/// # Errors
///
/// A file that cannot be read, has no known format or wrong content; a loops file with a graph.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Document> {
    completed(read_any(path, options)?, path, options)
}

/// Reads the bytes of a file that would be called `name`. Tables of two files are read from files only.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(name: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Document> {
    completed(read_content(name, bytes.to_vec(), checksum(bytes), options)?, name, options)
}

/// What was read, checked, with the links of the file beside it.
fn completed(mut document: Document, path: &Path, options: &ReadOptions) -> Result<Document> {
    let Document { format, content, notes, .. } = &mut document;
    content.settle_labels();
    check_extent(content).map_err(|fault| fault.in_file(path))?;
    if let Some(loops) = &options.loops {
        let Content::Centerlines(lines) = content else {
            let accepted = format!("goes with centerlines; {} holds a graph, which can have loops itself", path.display());
            return Err(Error::parameter("loops", loops.display(), accepted));
        };
        let bytes = unpacked_file(bytes_within(loops, options.max_input)?, loops, options.max_input)?;
        let added = add_loops(&bytes, lines).map_err(|fault| fault.in_file(loops))?;
        notes.push(format!("{} added from {}", plural(added, "link"), loops.display()));
    }
    notes.extend(unit_check(content, &options.scale, format.is_mask()));
    Ok(document)
}

/// Reads what a file holds, whose checksum is given. Gzip around it is taken off, but for NIfTI, whose reader does so piece by piece.
fn read_content(path: &Path, mut bytes: Vec<u8>, sha256: String, options: &ReadOptions) -> Result<Document> {
    let here = |fault: Fault| fault.in_file(path);
    if !is_nifti(&unpacked_head(&bytes, nifti::HEAD)) {
        bytes = unpacked_file(bytes, path, options.max_input)?;
    }
    let bytes = without_mark(&bytes);
    format_of(path, bytes).map_err(here)?.read(path, bytes, sha256, options)
}

/// Reads a file and computes its SHA-256. GraphML is read as a stream where it is not packed.
fn read_any(path: &Path, options: &ReadOptions) -> Result<Document> {
    let mut file = LimitedFile::open(path, options.max_input)?;
    let unread = |source| Error::Read { path: path.to_owned(), source };
    let mut all = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut all).map_err(unread)?;
    if xml::root(without_mark(&all)).is_some_and(|(name, _)| name == "graphml") {
        let stream = BufReader::with_capacity(HEAD as usize, Cursor::new(all).chain(&mut file));
        let (graph, notes) = read_graphml(stream, options).map_err(|fault| fault.in_file(path))?;
        let (format, content) = (Format::GraphMl, Content::Graph(graph));
        return Ok(Document { format, content, notes, sha256: file.file.finish(), lumen: None });
    }
    file.read_to_end(&mut all).map_err(unread)?;
    let sha256 = file.file.finish();
    read_content(path, all, sha256, options)
}
