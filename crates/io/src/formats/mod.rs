//! Readers and writers, one file or folder for each family of formats; `format` decides which of them a file needs.

mod attributes;
mod binary;
mod content;
pub mod convert;
mod format;
mod graphml;
mod header_fields;
mod images;
pub(crate) mod input;
mod known;
mod landmarks;
mod numpy;
pub(crate) mod options;
mod polylines;
mod regular;
mod solvers;
mod swc;
pub mod tables;
mod tre;
mod vendors;
mod vtk;
mod xml;

pub use attributes::POSITION_COLUMNS;
pub use content::{BuiltNetwork, Content, unit_check};
pub use format::{Document, StatedSpacing, Written, companion_files, read, read_bytes, read_image, read_mask, stated_spacing};
pub use graphml::{read_graphml, write_graphml};
pub use images::nifti::{write_nifti, write_nifti_image};
pub use input::{Checksummed, UnpackLimit, byte_count, bytes_of, checksum, checksum_of, checksum_of_file, regular_bytes_of};
pub use known::{Format, FormatTrait};
pub use landmarks::{LandmarkFormat, LandmarkList, ListedLandmark, MarkedPoint, SURE, read_landmarks, write_landmarks};
pub use numpy::array::{NamedArray, write_arrays, write_npy, write_npz};
pub use numpy::{skeleton::read_skeleton_npz, skeleton::write_skeleton_npz};
pub use options::{ReadOptions, check_name};
pub use regular::{is_there, open_regular};
pub use solvers::{SolverSetting, write_openbf, write_openbf_inlet, write_svzerod};
pub use swc::{read_swc, write_centerlines_swc, write_swc};
pub use tables::graph::{
    END_POSITION_COLUMNS, condition_columns, coordinates, graph_columns, graph_columns_with, node_columns, read_csv_edges,
    read_csv_nodes, read_points, stated_columns, vessel_columns, wall_columns, windkessel_columns, write_csv_graph, write_points,
};
pub use tables::lists::{
    ANSWERS, ConnectionDecision, GraphEdit, ListedDecision, ListedDecisions, add_loops, read_decisions, read_links,
    read_prior_csv, read_prior_npy, write_loops,
};
pub use tables::manifest::{Covariates, ManifestRow, read_manifest, read_participants};
pub use tables::write::{Column, Texts, Values, coordinate_columns, escape_formula, write_csv, write_stacked};
pub use tables::{conditions::read_waveform, reader::number, unread::unread_columns};
pub use tre::{read_tre, write_tre};
pub use vendors::amira::{read_amira, write_amira};
pub use vendors::edge_tables::{read_vesselvio_edges, read_vesselvio_vertices, write_vesselvio};
pub use vendors::edge_tables::{read_voreen_edges, read_voreen_nodes, write_voreen};
pub use vendors::icafe::{ICAFE_ARTERIES, TracedVessel, name_stretches, read_traced_vessels};
pub use vendors::slicer_markups::{read_markups, write_markups};
pub use vendors::vtrails::read_vtrails;
pub use vtk::{legacy::read_vtk, vtp::read_vtp, write::write_vtk, write::write_vtp};
pub use xml::escape;

// What most readers and writers name.
pub(crate) use binary::{NumberType, find, word};
pub(crate) use options::stated_unit;
pub(crate) use polylines::{cells, centerlines, parents_first, parts_of, steps_from_inlets};
pub(crate) use tables::reader::{TableReader, counted, is_missing, listed, plural};
pub(crate) use tables::write::{check_rows, figures, real};
pub(crate) use willis_core::error::{Fault, Result, ensure};
pub(crate) use willis_core::network::walks::{other_end, vessels_at};
pub(crate) use willis_core::network::{Centerlines, Frame, LengthUnit, Network, Node, PathPoint, Scale, is_radius, millimetres};
pub(crate) use willis_core::support::geometry::{Point, box_diagonal, distance, dot, lerp, norm_squared, radius_of, sub};

/// The error that a format cannot hold what is to be written.
pub(crate) fn refused(why: impl Into<String>) -> std::io::Error {
    std::io::Error::new(std::io::ErrorKind::InvalidInput, why.into())
}
