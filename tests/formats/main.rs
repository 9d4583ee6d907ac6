//! Readers, writers and conversion of every file format, and files that are damaged or hostile.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/draw.rs"]
mod draw;
#[path = "../support/refused.rs"]
mod refused;
#[path = "../support/shuffle.rs"]
mod shuffle;

mod amira;
mod arrays;
mod as_meant;
mod by_hand;
mod conditions;
mod convert;
mod damaged;
mod frames;
mod gzip;
mod hostile;
mod hostile_outputs;
mod icafe;
mod images;
mod mask_noise;
mod masks;
mod nrrd;
mod partial_volume;
mod peer_files;
mod peers;
mod phantom_masks;
mod polylines;
mod polylines_round_trip;
mod round_trip;
mod solvers;
mod stated;
mod tables;
mod tiff;
mod tubes;
mod unread_formats;
mod vmtk_lines;
mod vtk;
