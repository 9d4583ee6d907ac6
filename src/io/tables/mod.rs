//! Tables of text: centerline points, graphs, boundary conditions, landmarks, priors.

pub(crate) mod column;
pub mod conditions;
pub(crate) mod csv_graph;
pub(crate) mod graph_columns;
pub(crate) mod landmarks;
pub(crate) mod links;
pub(crate) mod number;
pub(crate) mod points;
pub(crate) mod prior;
pub(crate) mod rows;
pub(crate) mod table_pair;
pub(crate) mod unread;
pub(crate) mod write;
