//! Readers and writers, one file or folder for each family of formats; `format` decides which of them a file needs.

mod attributes;
mod binary;
mod companions;
pub mod convert;
mod format;
mod graphml;
mod images;
pub(crate) mod input;
mod itk;
mod landmarks;
mod numpy;
mod polylines;
pub(crate) mod read;
mod regular;
mod solvers;
mod swc;
pub mod tables;
mod unit_check;
mod vendors;
mod vtk;
mod xml;

pub use companions::{StatedSpacing, companion_files, stated_spacing};
pub use format::{Format, read_image, read_mask};
pub use graphml::{read_graphml, write_graphml};
pub use images::metaimage::read_metaimage;
pub use images::nifti::{read_nifti, write_nifti, write_nifti_image};
pub use images::numpy::read_npy_mask;
pub use input::{Checksummed, UnpackLimit, byte_count, checksum, checksum_of, checksum_of_file, regular_bytes_of};
pub use itk::tubes::{read_tre, write_tre};
pub use landmarks::SURE;
pub use landmarks::{LandmarkFormat, LandmarkList, ListedLandmark, MarkedPoint, read_landmarks, write_landmarks};
pub use numpy::array::read_arrays;
pub use numpy::matrix::{NamedArray, NamedComplexArray, write_arrays, write_complex_arrays, write_npy, write_npz};
pub use numpy::skeleton::{read_skeleton_npz, write_skeleton_npz};
pub use read::{BuiltNetwork, Content, Document, ReadOptions, bytes_of, read, read_bytes};
pub use regular::{is_there, open_regular};
pub use solvers::{write_openbf, write_svzerod};
pub use swc::{is_forest, read_swc, write_centerlines_swc, write_swc};
pub use tables::decisions::{ListedDecision, read_decisions};
pub use tables::graph::{
    END_POSITION_COLUMNS, axis, condition_columns, found_column, graph_columns, node_columns, vessel_columns, wall_columns,
    windkessel_columns,
};
pub use tables::graph::{read_csv_edges, read_csv_nodes, write_csv_graph};
pub use tables::lists::{add_loops, read_links, write_loops};
pub use tables::manifest::{Manifest, ManifestRow, read_manifest};
pub use tables::points::{read_points, write_points};
pub use tables::prior::{read_prior_csv, read_prior_npy};
pub use tables::reader::number;
pub use tables::unread::unread_columns;
pub use tables::waveform::read_waveform;
pub use tables::write::escape_formula;
pub use tables::write::{Column, Values, write_csv};
pub use unit_check::unit_check;
pub use vendors::icafe::{TracedVessel, name_stretches, read_traced_vessels};
pub use vendors::slicer_markups::{read_markups, write_markups};
pub use vendors::vesselvio::{read_vesselvio_edges, read_vesselvio_vertices, write_vesselvio};
pub use vendors::voreen::{read_voreen_edges, read_voreen_nodes, write_voreen};
pub use vendors::vtrails::read_vtrails;
pub use vtk::legacy::read_vtk;
pub use vtk::vtp::read_vtp;
pub use vtk::write::{write_vtk, write_vtp};
pub use xml::escape;
