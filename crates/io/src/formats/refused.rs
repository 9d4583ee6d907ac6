//! Names the formats that are known but not read, with what to export instead.

use std::ffi::OsStr;
use std::path::Path;

use super::input::unpacked_name;
use super::xml;
use willis_core::error::Fault;

/// How much of a file is looked at.
const HEAD: usize = 1 << 16;

/// Why a file is not read that begins with these bytes, if its format is one of those.
pub(super) fn refused(path: &Path, bytes: &[u8]) -> Option<Fault> {
    let head = &bytes[..bytes.len().min(HEAD)];
    let has = |word: &[u8]| head.windows(word.len()).any(|part| part == word);
    let ending = unpacked_name(path).extension().map(OsStr::to_ascii_lowercase);
    let is_called = |word: &str| ending.as_ref().is_some_and(|ending| *ending == *word);
    let (found, accepted) = if head.get(128..132) == Some(b"DICM") {
        // The class of segmentations stands in the first group.
        let kind = if has(b"1.2.840.10008.5.1.4.1.1.66.4") { "a segmentation in DICOM (DICOM SEG)" } else { "a file of DICOM" };
        (kind, "expected a mask in NIfTI or NRRD: export it with 3D Slicer, or with segimage2itkimage of dcmqi")
    } else if head.starts_with(b"CDF\x01")
        || head.starts_with(b"CDF\x02")
        || (head.starts_with(b"\x89HDF") && (is_called("mnc") || has(b"minc-2.0")))
    {
        ("a volume in MINC", "expected NIfTI: convert it with mnc2nii")
    } else if head.starts_with(&[0, 0, 0, 1]) && (is_called("mgz") || is_called("mgh")) {
        ("a volume of FreeSurfer (.mgz)", "expected NIfTI: convert it with mri_convert")
    } else if head.starts_with("⛾ gt".as_bytes()) {
        ("a graph of graph-tool (.gt)", "expected GraphML: save it with graph.save(\"name.graphml\")")
    } else {
        let root = xml::root(head).map(|(name, _)| name.to_owned())?;
        let is = |word: &str| root == word || (root == "format" && has(format!("<{word} ").as_bytes()));
        let centerlines = "expected centerlines: extract those of the model in SimVascular, and save them as .vtp";
        if is("contourgroup") || (root == "format" && is_called("ctgr")) {
            ("contours of SimVascular (.ctgr)", centerlines)
        } else if is("path") || (root == "format" && is_called("pth")) {
            ("a path of SimVascular (.pth), which has no radii", centerlines)
        } else {
            return None;
        }
    };
    Some(Fault::file(found, accepted))
}
