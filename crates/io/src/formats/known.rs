//! The table of the formats that are known: a row says all of a format but how its files are recognised,
//! read and written, and whether a file beside one states its spacing (`stated_spacing`).

use FormatTrait::{Covered, GivenSpacing, Graph, Mask, Model, NamedRadii, OwnSpacing, Pairs, PairsIfStraight, TwoTables};
use Property::{Conditions, Figures, Frame, Ids, Labels, LoneNodes, Names, Paths, Radii, Resistances, Statements};

/// What is known of a format. A text that a row leaves out is empty, or the usual name where that is said; a list that it leaves out is empty.
#[derive(Default)]
struct FormatRow {
    /// The usual name.
    name: &'static str,
    /// The name in lists of help, if it is not the usual one.
    short: &'static str,
    /// The name in what is expected of a file that no reader knows, if it is not the usual one.
    expected: &'static str,
    /// The word for it, if it can be written.
    word: &'static str,
    /// The ending of its files. If it can be written, a file of this ending is written in it.
    ending: &'static str,
    /// What the help of `convert` says of the ending.
    says: &'static str,
    /// How many other kinds of files have the ending: 0 none, 1 some, 2 many.
    others: u8,
    /// What it is.
    is: &'static [FormatTrait],
    /// What of a network it cannot store, if it can be written.
    lacks: &'static [Property],
}

/// What a format is. One that is no mask, graph or model holds centerlines or vessels; one that has no pairs is written as lines of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FormatTrait {
    /// It holds a segmentation mask, of which centerlines are made.
    Mask,
    /// It holds a ready graph.
    Graph,
    /// It is a model of a solver in time, only written.
    Model,
    /// Each vessel is written as a pair of nodes, with or without points between.
    Pairs,
    /// The same, where all vessels of a network are straight.
    PairsIfStraight,
    /// It is written as two tables, of vessels and of nodes.
    TwoTables,
    /// `radius_array` names the radii in it.
    NamedRadii,
    /// It states the spacing of its voxels.
    OwnSpacing,
    /// `spacing` may state that of its voxels.
    GivenSpacing,
    /// The name of another format covers it where a file is refused that no reader knows.
    Covered,
}

/// A property of a network that a format may be unable to store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Property {
    /// The centerline of a vessel between its nodes.
    Paths,
    /// A length or radius of a vessel that differs from that of its centerline, where vessels are lines.
    Figures,
    /// Ids of nodes.
    Ids,
    /// Ids of nodes, unless all are whole numbers.
    Names,
    /// Nodes on no vessel.
    LoneNodes,
    /// What vessels store beyond geometry: origins, priors, resistances, walls.
    Statements,
    /// The resistances that vessels state, in a format that has more of what they state.
    Resistances,
    /// Labels of vessels.
    Labels,
    /// What nodes store beyond geometry: labels, conditions.
    Conditions,
    /// Radii of nodes, where vessels are pairs of nodes.
    Radii,
    /// The frame of positions.
    Frame,
}

/// Makes the formats of their rows.
macro_rules! formats {
    ($($(#[$doc:meta])+ $format:ident { $($row:tt)+ })+) => {
        /// The formats that are known.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Format { $($(#[$doc])+ $format),+ }

        const ALL: &[Format] = &[$(Format::$format),+];

        impl Format {
            #[expect(clippy::needless_update, reason = "a row may state everything")]
            fn row(self) -> FormatRow {
                match self { $(Self::$format => FormatRow { $($row)+, ..FormatRow::default() }),+ }
            }
        }
    };
}

// In the order of lists in messages and help.
formats! {
    /// SWC: one centerline point a line.
    Swc { name: "SWC", word: "swc", ending: "swc", lacks: &[Figures, Ids, Statements, Conditions] }
    /// VTK XML PolyData.
    Vtp { name: "VTP", word: "vtp", ending: "vtp", is: &[NamedRadii],
        lacks: &[Figures, Ids, LoneNodes, Statements, Conditions] }
    /// VTK legacy PolyData.
    Vtk { name: "VTK legacy", short: "VTK", expected: "VTK PolyData", word: "vtk", ending: "vtk", says: "legacy", others: 1, is: &[NamedRadii],
        lacks: &[Figures, Ids, LoneNodes, Statements, Conditions] }
    /// GraphML.
    GraphMl { name: "GraphML", word: "graphml", ending: "graphml", is: &[Graph, Pairs] }
    /// A table of edges, with or without a table of nodes in the same folder.
    Csv { name: "CSV", short: "CSV of edges", word: "csv", ending: "csv", says: "a table of vessels, with one of nodes beside it", others: 2,
        is: &[Graph, Pairs, TwoTables], lacks: &[Frame] }
    /// ITK tubes.
    Tre { name: "TRE", word: "tre", ending: "tre", says: "ITK tubes", lacks: &[Figures, Ids, LoneNodes, Statements, Conditions] }
    /// 3D Slicer markups.
    Markups { name: "Slicer markups", expected: "3D Slicer markups", word: "markups", ending: "json", says: "3D Slicer markups", others: 2,
        is: &[NamedRadii], lacks: &[Figures, Ids, LoneNodes, Statements, Conditions] }
    /// iCafe: a tracing in SWC with its table of vessels.
    ICafe { name: "iCafe", is: &[Covered] }
    /// Voreen's tables of nodes and edges.
    Voreen { name: "Voreen CSV", short: "Voreen", word: "voreen", is: &[Pairs, TwoTables, Covered],
        lacks: &[Paths, Names, Statements, Conditions, Radii, Frame] }
    /// VesselVio's tables of vertices and edges.
    VesselVio { name: "VesselVio CSV", short: "VesselVio", word: "vesselvio", is: &[PairsIfStraight, TwoTables, Covered],
        lacks: &[Figures, Ids, Statements, Conditions, Radii, Frame] }
    /// A skeleton graph as NumPy arrays.
    Npz { name: "NPZ", word: "npz", ending: "npz", says: "skeleton graph for NumPy", others: 1, is: &[PairsIfStraight],
        lacks: &[Figures, Ids, Statements, Conditions, Radii] }
    /// The SpatialGraph of Amira and Avizo.
    Amira { name: "Amira SpatialGraph", short: "Amira", expected: "Amira", word: "amira", ending: "am", says: "Amira", is: &[NamedRadii],
        lacks: &[Figures, Ids, Statements, Conditions, Frame] }
    /// VTrails' geodesic trees, a MATLAB 7.3 file.
    VTrails { name: "VTrails MAT", short: "MAT", ending: "mat", others: 1 }
    /// A table of points, `fragment,x,y,z,radius`.
    Points { name: "CSV of points", word: "points", is: &[Covered], lacks: &[Figures, Ids, LoneNodes, Statements, Conditions, Frame] }
    /// A mask in NIfTI-1 or NIfTI-2, plain or compressed by gzip.
    Nifti { name: "NIfTI mask", short: "NIfTI", is: &[Mask, OwnSpacing] }
    /// A mask in MetaImage, the format of ITK.
    MetaImage { name: "MetaImage mask", short: "MetaImage", is: &[Mask, OwnSpacing, GivenSpacing] }
    /// A mask in NRRD, plain or a segmentation of 3D Slicer.
    Nrrd { name: "NRRD mask", short: "NRRD", is: &[Mask, OwnSpacing, GivenSpacing] }
    /// A mask as a stack of TIFF pages.
    Tiff { name: "TIFF mask", short: "TIFF", is: &[Mask, OwnSpacing, GivenSpacing] }
    /// A mask as a NumPy array, in a file of its own or an archive.
    Npy { name: "NumPy mask", short: "NPY", is: &[Mask, GivenSpacing] }
    /// A model of the solver svZeroDSolver, only written.
    SvZeroD { name: "svZeroDSolver JSON", word: "svzerod", is: &[Model, Pairs], lacks: &[Paths, Ids, Labels, LoneNodes, Radii] }
    /// A model of the solver openBF, only written.
    OpenBf { name: "openBF YAML", word: "openbf", ending: "yaml", says: "openBF", is: &[Model, Pairs],
        lacks: &[Paths, Ids, Resistances, LoneNodes, Radii] }
}

impl Format {
    /// The usual name.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Whether it is so.
    pub fn is(self, what: FormatTrait) -> bool {
        self.row().is.contains(&what)
    }

    /// Whether it holds a segmentation mask, of which centerlines are made.
    pub fn is_mask(self) -> bool {
        self.is(Mask)
    }

    /// Whether it cannot store a property of networks.
    pub(super) fn lacks(self, property: Property) -> bool {
        self.row().lacks.contains(&property)
    }

    /// The words for the formats that can be written.
    pub fn words() -> impl Iterator<Item = &'static str> {
        rows().map(|row| row.word).filter(|word| !word.is_empty())
    }

    /// The format that can be written and has this word.
    pub(super) fn of_word(word: &str) -> Option<Self> {
        ALL.iter().copied().find(|format| !word.is_empty() && format.row().word.eq_ignore_ascii_case(word))
    }

    /// The format that can be written and that the ending of a file name means.
    pub fn of_ending(path: &std::path::Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        ALL.iter().copied().find(|format| format.row().is_written_by_ending() && format.row().ending == ending)
    }

    /// The endings that mean a format that is written.
    pub fn written_endings() -> String {
        series(rows().filter(FormatRow::is_written_by_ending).map(|row| format!(".{}", row.ending)), "or")
    }

    /// The same, with what they stand for.
    pub fn explained_endings() -> String {
        let said = |row: FormatRow| format!(".{} ({})", row.ending, row.says).replace(" ()", "");
        rows().filter(FormatRow::is_written_by_ending).map(said).collect::<Vec<_>>().join(", ")
    }

    /// Of the endings of centerlines and graphs those that `has` knows, the first of those that the fewest other kinds of files have.
    pub fn clearest_ending(has: impl Fn(&str) -> bool) -> Option<&'static str> {
        let rows = rows().filter(|row| !row.ending.is_empty() && !row.is.contains(&Model) && has(row.ending));
        rows.min_by_key(|row| row.others).map(|row| row.ending)
    }

    /// The usual names of all that are so, with `last`, "or" or "and", before the last one.
    pub fn listed(what: FormatTrait, last: &str) -> String {
        let rows = rows().filter(|row| row.is.contains(&what));
        series(rows.map(|row| row.name.trim_end_matches(" mask").to_owned()), last)
    }

    /// The short names of all that are so.
    pub fn short(what: FormatTrait) -> String {
        short(|row| row.is.contains(&what))
    }

    /// What can be read, for help.
    pub fn inputs() -> String {
        let lines = short(|row| ![Mask, Graph, Model].iter().any(|what| row.is.contains(what)));
        format!("A mask ({}), centerlines ({lines}) or a candidate graph ({})", Self::short(Mask), Self::short(Graph))
    }

    /// What is expected of a file that no reader knows.
    pub(super) fn expected() -> String {
        let rows = rows().filter(|row| ![Mask, Model, Covered].iter().any(|what| row.is.contains(what)));
        let others: Vec<&str> = rows.map(|row| row.or_name(row.expected)).collect();
        format!("expected {}, or a mask: {}", others.join(", "), Self::short(Mask))
    }
}

impl FormatRow {
    fn is_written_by_ending(&self) -> bool {
        !self.word.is_empty() && !self.ending.is_empty()
    }

    fn or_name(&self, text: &'static str) -> &'static str {
        if text.is_empty() { self.name } else { text }
    }
}

fn rows() -> impl Iterator<Item = FormatRow> {
    ALL.iter().map(|format| format.row())
}

fn short(is_so: impl Fn(&FormatRow) -> bool) -> String {
    rows().filter(is_so).map(|row| row.or_name(row.short)).collect::<Vec<_>>().join(", ")
}

/// Words as in a sentence: a, b or c.
fn series(words: impl Iterator<Item = String>, last: &str) -> String {
    let all = words.collect::<Vec<_>>().join(", ");
    all.rsplit_once(", ").map_or(all.clone(), |(most, one)| format!("{most} {last} {one}"))
}
