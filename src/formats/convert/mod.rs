//! Any network into any format that can be written: which one, into which files, and what is lost on the way.

mod lines;
mod losses;

pub use losses::losses;

use std::io;
use std::path::{Path, PathBuf};

use self::lines::with_lines;
use super::skeleton::is_straight;
use super::sniff::Format;
use super::{
    Digits, graph_columns, pair, write_csv_graph, write_graphml, write_loops, write_markups, write_points, write_skeleton_npz,
    write_swc, write_tre, write_vesselvio, write_voreen, write_vtk, write_vtp,
};
use crate::error::{Error, Result};
use crate::network::Network;

/// The formats that can be written, with the word for each and the ending that means it.
const TARGETS: [(Format, &str, &str); 11] = [
    (Format::Swc, "swc", "swc"),
    (Format::Vtp, "vtp", "vtp"),
    (Format::Vtk, "vtk", "vtk"),
    (Format::GraphMl, "graphml", "graphml"),
    (Format::Csv, "csv", "csv"),
    (Format::Points, "points", ""),
    (Format::Voreen, "voreen", ""),
    (Format::VesselVio, "vesselvio", ""),
    (Format::Markups, "markups", "json"),
    (Format::Tre, "tre", "tre"),
    (Format::Npz, "npz", "npz"),
];

/// What to write, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// The format.
    pub format: Format,
    /// The file that was named: of a pair of tables that of the vessels.
    pub path: PathBuf,
    /// The table of nodes, for formats of two tables.
    pub nodes: Option<PathBuf>,
}

impl Target {
    /// The words for the formats that can be written.
    pub fn words() -> impl Iterator<Item = &'static str> {
        TARGETS.into_iter().map(|(_, word, _)| word)
    }

    /// The target that a path and perhaps a word for its format mean.
    ///
    /// # Errors
    ///
    /// A word that is none of [`Target::words`], an ending that means no format, a table of vessels with the name of that of nodes.
    pub fn new(path: &Path, word: Option<&str>) -> Result<Self> {
        let words = || Self::words().collect::<Vec<_>>().join(", ");
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let found = match word {
            Some(word) => TARGETS.iter().find(|(_, known, _)| *known == word.to_ascii_lowercase()),
            None => TARGETS.iter().find(|(.., known)| *known == ending && !ending.is_empty()),
        };
        let format = found.map(|(format, ..)| *format).ok_or_else(|| {
            if let Some(word) = word {
                return Error::parameter("--to", word, format!("expected one of {}", words()));
            }
            let accepted = "expected an ending .swc, .vtp, .vtk, .graphml, .csv, .json, .tre or .npz, or --to FORMAT";
            Error::parameter("output", path.display(), accepted)
        })?;
        let nodes = match format {
            Format::Csv | Format::Voreen | Format::VesselVio => Some(pair::nodes_path(path).ok_or_else(|| {
                Error::parameter("output", path.display(), "is the name of the table of nodes; expected that of the vessels")
            })?),
            _ => None,
        };
        Ok(Self { format, path: path.to_owned(), nodes })
    }
}

/// The files of a conversion with their bytes, and what a person should know about them.
pub type Files = (Vec<(PathBuf, Vec<u8>)>, Vec<String>);

/// Writes a network into memory as the files of a target, the one that was named first.
///
/// # Errors
///
/// A network that the format cannot hold at all: without positions where the format consists of them.
pub fn write(network: &Network, target: &Target) -> Result<Files> {
    let refuse = |error: io::Error| {
        let accepted = format!("{} cannot hold the network: {error}", target.format.name());
        Error::parameter("output", target.path.display(), accepted)
    };
    let mut notes = Vec::new();
    let drawn;
    let network = if consists_of_lines(target.format, network) {
        drawn = with_lines(network).map_err(refuse)?;
        if drawn.made > 0 {
            notes.push(format!("{} straight vessels got points of their own, which keep their radius", drawn.made));
        }
        &drawn.network
    } else {
        network
    };
    let (mut vessels, mut nodes, mut loops) = (Vec::new(), Vec::new(), Vec::new());
    let (node_columns, vessel_columns) = graph_columns(network);
    match target.format {
        Format::Swc | Format::ICafe => write_swc(&mut vessels, network).map(|closing| loops = closing),
        Format::Vtp => write_vtp(&mut vessels, network, &vessel_columns),
        Format::Vtk => write_vtk(&mut vessels, network, &vessel_columns, Digits::Ascii),
        Format::GraphMl => write_graphml(&mut vessels, network, &node_columns, &vessel_columns),
        Format::Csv => write_csv_graph(&mut nodes, &mut vessels, network),
        Format::Points => write_points(&mut vessels, network),
        Format::Voreen => write_voreen(&mut nodes, &mut vessels, network),
        Format::VesselVio => write_vesselvio(&mut nodes, &mut vessels, network),
        Format::Markups => write_markups(&mut vessels, network),
        Format::Tre => write_tre(&mut vessels, network),
        Format::Npz => write_skeleton_npz(io::Cursor::new(&mut vessels), network),
        Format::VTrails => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is only read")),
    }
    .map_err(refuse)?;
    let mut files = vec![(target.path.clone(), vessels)];
    files.extend(target.nodes.clone().map(|path| (path, nodes)));
    if !loops.is_empty() {
        let (path, mut table) = (target.path.with_extension("loops.csv"), Vec::new());
        write_loops(&mut table, &loops).map_err(refuse)?;
        notes.push(format!("the links that close loops are in {}: give it with --loops", path.display()));
        files.push((path, table));
    }
    Ok((files, notes))
}

/// Whether a format holds vessels as lines of points, so that a vessel without any needs some.
fn consists_of_lines(format: Format, network: &Network) -> bool {
    match format {
        Format::GraphMl | Format::Csv | Format::Voreen => false,
        Format::Npz | Format::VesselVio => !is_straight(network),
        _ => true,
    }
}
