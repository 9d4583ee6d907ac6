//! File formats: one file per format over `BufRead` and `Write`, and one place that decides which it is.

mod attributes;
mod column;
pub mod conditions;
mod csv_graph;
mod document;
mod graphml;
mod numpy;
mod polydata;
mod polyline;
mod sniff;
mod swc;
mod swc_points;
mod table;
mod vtk_legacy;
mod vtp;
mod xml;

pub use column::{Column, Values};
pub use csv_graph::{NodeTable, read_csv_edges, read_csv_nodes};
pub use document::{Content, Document, ReadOptions, read};
pub use graphml::{read_graphml, write_graphml};
pub use numpy::{NamedArray, write_arrays, write_npy, write_npz};
pub use polydata::RadiusArray;
pub use sniff::Format;
pub use swc::{add_loops, is_forest, read_swc, write_swc};
pub use swc_points::{write_centerlines_swc, write_loops};
pub use table::write_csv;
pub use vtk_legacy::{Digits, read_vtk, write_vtk};
pub use vtp::{read_vtp, write_vtp};
