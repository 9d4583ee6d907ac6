//! Any network into any format that can be written: which one, into which files, and what is lost on the way.

mod losses;
mod straight_lines;

pub use losses::losses;

use std::io;
use std::path::{Path, PathBuf};

use super::companions::nodes_path;
use super::format::Format;
use super::graphml::write::write_graphml;
use super::itk::write::write_tre;
use super::numpy::skeleton::write_skeleton_npz;
use super::skeleton::is_straight;
use super::swc::write_swc;
use super::tables::csv_graph::write_csv_graph;
use super::tables::graph_columns::graph_columns;
use super::tables::points::write_points;
use super::vendors::slicer_markups::write_markups;
use super::vendors::vesselvio::write_vesselvio;
use super::vendors::voreen::write_voreen;
use super::vtk::legacy::write::write_vtk;
use super::vtk::xml::write::write_vtp;
use crate::error::{Error, Result};
use crate::network::Network;
use straight_lines::with_lines;

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
                return Error::parameter("to", word, format!("expected one of {}", words()));
            }
            let accepted = "expected an ending .swc, .vtp, .vtk, .graphml, .csv, .json, .tre or .npz, or --to FORMAT";
            Error::parameter("output", path.display(), accepted)
        })?;
        let nodes = match format {
            Format::Csv | Format::Voreen | Format::VesselVio => Some(nodes_path(path).ok_or_else(|| {
                Error::parameter("output", path.display(), "is the name of the table of nodes; expected that of the vessels")
            })?),
            _ => None,
        };
        Ok(Self { format, path: path.to_owned(), nodes })
    }

    /// The file of links that a tree cannot hold.
    pub fn loops(&self) -> PathBuf {
        self.path.with_extension("loops.csv")
    }
}

/// That a target cannot hold a network, for an error of the kind `InvalidInput` that [`write_into`] gives.
pub fn refusal(target: &Target, error: &io::Error) -> Error {
    Error::parameter("output", target.path.display(), format!("{} cannot hold the network: {error}", target.format.name()))
}

/// What is left to do and say after a network was written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// Pairs of point ids for the file [`Target::loops`], where there are any.
    pub loops: Vec<[u64; 2]>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Writes a network as the file of a target, and as its table of nodes where it has one.
///
/// # Errors
///
/// A network that the format cannot hold at all (`InvalidInput`, see [`refusal`]), or the writers' own.
pub fn write_into(
    network: &Network,
    target: &Target,
    mut vessels: impl io::Write + io::Seek,
    nodes: impl io::Write,
) -> io::Result<Written> {
    let mut written = Written::default();
    let drawn;
    let network = if consists_of_lines(target.format, network) {
        drawn = with_lines(network)?;
        if drawn.made > 0 {
            written.notes.push(format!("{} straight vessels got points of their own, which keep their radius", drawn.made));
        }
        &drawn.network
    } else {
        network
    };
    match target.format {
        Format::Swc => written.loops = write_swc(&mut vessels, network)?,
        Format::Vtp => write_vtp(&mut vessels, network, &graph_columns(network).1)?,
        Format::Vtk => write_vtk(&mut vessels, network, &graph_columns(network).1)?,
        Format::GraphMl => {
            let (of_nodes, of_vessels) = graph_columns(network);
            write_graphml(&mut vessels, network, &of_nodes, &of_vessels)?;
        }
        Format::Csv => write_csv_graph(nodes, &mut vessels, network)?,
        Format::Points => write_points(&mut vessels, network)?,
        Format::Voreen => write_voreen(nodes, &mut vessels, network)?,
        Format::VesselVio => write_vesselvio(nodes, &mut vessels, network)?,
        Format::Markups => write_markups(&mut vessels, network)?,
        Format::Tre => write_tre(&mut vessels, network)?,
        Format::Npz => write_skeleton_npz(&mut vessels, network)?,
        Format::ICafe | Format::VTrails => return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is only read")),
    }
    if !written.loops.is_empty() {
        let path = target.loops();
        written.notes.push(format!("the links that close loops are in {}: give it with --loops", path.display()));
    }
    Ok(written)
}

/// Whether a format holds vessels as lines of points, so that a vessel without any needs some.
fn consists_of_lines(format: Format, network: &Network) -> bool {
    match format {
        Format::GraphMl | Format::Csv | Format::Voreen => false,
        Format::Npz | Format::VesselVio => !is_straight(network),
        _ => true,
    }
}
