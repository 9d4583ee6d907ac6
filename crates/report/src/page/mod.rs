//! report.html: one self-contained page of a run, to open in any browser and to send to a colleague: what it holds, and how it is put together.

pub mod lead;
pub mod scene;

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use crate::figures::{DEFAULT_DPI, Figure, Rgb, colour};
use crate::run_record::{ConditionRecord, RunRecord};
use scene::PageScene;
use willis_core::error;
use willis_core::network::{Role, millimetres};
use willis_io::formats::{Column, Texts, Values, escape};
use willis_io::masks::cubes::{SIDE, STEP};
use willis_io::output::{names, write_file};
use willis_models::circle_of_willis::LANDMARK_NOTE_ENDING;

pub use scene::{ImagePlace, Segmentation};
pub(crate) use scene::{cut, scene};

/// The page of a run, of any command. Its fields stand in alphabetical order: they are the keys of the page.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Page {
    /// The figures that can colour the vessels of the scene; the page starts with the first.
    pub(crate) colourings: Vec<Colouring>,
    pub(crate) colours: Vec<Rgb>,
    /// The figures at the end of the page.
    pub(crate) facts: Vec<Fact>,
    pub(crate) figures: Vec<PagePicture>,
    pub(crate) image_places: Value,
    /// The sentence that it begins with; empty where the page makes one of its vessels.
    pub(crate) lead: Vec<lead::Part>,
    pub(crate) no_scene: Option<String>,
    /// The phenotype of a Circle of Willis, where there is one, as phenotype.json has it.
    pub(crate) phenotype: Option<Value>,
    pub(crate) record: Value,
    pub(crate) scene: Option<PageScene>,
    /// The segmentation that the vessels were found in.
    pub(crate) segmentation: Value,
    /// The tables.
    pub(crate) tables: Vec<PageTable>,
    /// A threshold on a column of the first table that the reader can move.
    pub(crate) threshold: Value,
    /// The heading.
    pub(crate) title: String,
    /// What a reader should know before anything else.
    pub(crate) warnings: Vec<String>,
}

impl Page {
    /// The page of a run of a command with the least that every run has: its record, as in run.json, what it warns of, the vessels in space, or the
    /// reason why they cannot be shown, and pictures.
    pub fn new(command: &str, of_run: &RunRecord, scene: Result<PageScene, String>, figures: Vec<PagePicture>) -> Self {
        let (name, record) = (of_run.name(), of_run.for_page());
        let (title, colours, warnings) = (format!("willis {command}: {name}"), colours(), warnings(&record, &of_run.conditions));
        let image_places = json!({ "side": SIDE, "step_mm": millimetres(STEP), "of": [] });
        let (no_scene, scene) = scene.map_or_else(|reason| (Some(reason), None), |scene| (None, Some(scene)));
        Self { colours, figures, image_places, no_scene, record, scene, title, warnings, ..Self::default() }
    }

    /// Writes it into a folder: markup, style, data and scripts in one file that refers to no other.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> error::Result<()> {
        write_file(&folder.join(names::PAGE), |out| write_page(out, &self.title, RUN, self))
    }
}

/// Steps of the colour map; the page interpolates between them.
const COLOURS: u32 = 32;

/// The colour map in equal steps, from low to high.
pub(crate) fn colours() -> Vec<Rgb> {
    (0..=COLOURS).map(|i| colour(f64::from(i) / f64::from(COLOURS))).collect()
}

/// A figure of the run: its name, its value (a number, a word or null) and its unit, empty without one.
pub(crate) type Fact = (&'static str, Value, &'static str);

/// Figures of the record by name, JSON pointer and unit. A list stands for its length.
pub(crate) fn facts(record: &Value, names: &[(&'static str, &str, &'static str)]) -> Vec<Fact> {
    let value = |pointer: &str| match record.pointer(pointer) {
        Some(Value::Array(items)) => items.len().into(),
        value => value.cloned().unwrap_or_default(),
    };
    let frame = record.pointer("/input/frame").map(|_| ("frame of the coordinates", "/input/frame", ""));
    names.iter().copied().chain(frame).map(|(name, pointer, unit)| (name, value(pointer), unit)).collect()
}

/// The most warnings on a page.
const MOST_WARNINGS: usize = 6;

/// What a reader of a run should know before anything else: inlets that nobody stated, parts without flow, doubtful units.
pub(crate) fn warnings(record: &Value, conditions: &[ConditionRecord]) -> Vec<String> {
    let mut all = Vec::new();
    // The direction of the lines in the file states a source.
    let inlets = conditions.iter().filter(|c| c.role == Role::Inlet.name() && c.found && !c.source).count();
    let assumed = match inlets {
        0 => None,
        1 => Some("one free end is assumed to be the inlet. The option inlet states it.".to_owned()),
        n => Some(format!("{n} free ends are assumed to be inlets. The option inlet states them.")),
    };
    all.extend(assumed.map(|what| format!("Nobody stated where blood enters: {what}")));
    if !conditions.is_empty() && conditions.iter().all(|c| c.role != Role::Outlet.name()) {
        all.push("There is no outlet, so that no blood flows.".to_owned());
    }
    match record.pointer("/counts/topology/unperfused_components").and_then(Value::as_u64) {
        None | Some(0) => {}
        Some(1) => all.push("One part of what the run kept carries no flow: it lacks an inlet or an outlet.".to_owned()),
        Some(n) => all.push(format!("{n} parts of what the run kept carry no flow: they lack an inlet or an outlet.")),
    }
    let notes = record["notes"].as_array().map_or(&[][..], Vec::as_slice).iter().filter_map(Value::as_str);
    let plain = |note: &&str| {
        note.starts_with("a mask of") || note.ends_with(LANDMARK_NOTE_ENDING) || note.contains(" plausible topologies, ")
    };
    all.extend(notes.filter(|note| !plain(note)).map(|note| {
        let mut letters = note.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    }));
    all.truncate(MOST_WARNINGS);
    all
}

/// A table of the page. Its fields stand in alphabetical order, as those of [`Page`].
#[derive(Debug, Clone, Serialize)]
pub(crate) struct PageTable {
    /// The columns with any value, and whether the page holds their numbers in double precision; it holds others in single precision.
    #[serde(serialize_with = "as_arrays")]
    columns: Vec<(Column, bool)>,
    /// Whether row i is vessel i.
    of_vessels: bool,
    rows: usize,
    /// Its heading.
    title: String,
}

impl PageTable {
    /// A table of columns of the same length with numbers in single precision.
    pub fn new(title: impl Into<String>, columns: Vec<Column>, of_vessels: bool) -> Self {
        Self::with_exact(title, columns, &[], of_vessels)
    }

    /// A table with numbers in double precision in the columns `exact`.
    pub fn with_exact(title: impl Into<String>, columns: Vec<Column>, exact: &[&str], of_vessels: bool) -> Self {
        let rows = columns.first().map_or(0, |column| column.values.rows());
        let shown = columns.into_iter().filter(has_values).map(|column| (exact.contains(&&*column.name), column));
        Self { columns: shown.map(|(exact, column)| (column, exact)).collect(), of_vessels, rows, title: title.into() }
    }
}

/// How a figure is converted to a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ColourScale {
    /// By its logarithm.
    Log,
    /// By its value.
    Linear,
    /// By its value, which lies between 0 and 1; the ends of the scale stay there.
    Share,
    /// By its value, with one colour for each side of zero.
    Diverging,
    /// It is a colour itself, red · 2¹⁶ + green · 2⁸ + blue.
    Mixed,
}

/// A figure that colours the vessels. Its fields stand in alphabetical order, as those of [`Page`].
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Colouring {
    /// What is mixed by [`ColourScale::Mixed`]: names and colours.
    pub legend: Vec<(String, Rgb)>,
    /// Its name.
    pub name: &'static str,
    /// How it is converted to a colour. All scales but [`ColourScale::Diverging`] use the magnitude.
    pub scale: ColourScale,
    /// Whether vessels that are certain stay grey.
    pub uncertain_only: bool,
    /// Its unit, empty without one.
    pub unit: &'static str,
    /// Its variants: name, number of the table, and column. All variants share one scale.
    pub variants: Vec<(String, usize, String)>,
}

impl Colouring {
    /// A figure that colours all vessels.
    pub fn new(name: &'static str, unit: &'static str, scale: ColourScale, variants: Vec<(String, usize, String)>) -> Self {
        Self { name, unit, scale, uncertain_only: false, variants, legend: Vec::new() }
    }
}

/// Removes a part of the record that the page shows elsewhere.
pub(crate) fn take(record: &mut Value, name: &str) -> Value {
    record.get_mut(name).map_or(Value::Null, Value::take)
}

/// The largest packed SVG in a page, bytes. A larger picture becomes a PNG.
const LARGEST_SVG: usize = 100_000;

/// A picture of the page, with its description. Its fields stand in alphabetical order, as those of [`Page`].
#[derive(Debug, Clone, Serialize)]
pub(crate) struct PagePicture {
    /// What it shows: its caption, and its text for readers who cannot see it.
    pub caption: String,
    /// Whether it is an SVG.
    is_svg: bool,
    /// The picture itself in base64: an SVG packed by gzip, or a PNG.
    source: String,
    /// Its heading.
    pub title: &'static str,
    /// Whether it takes the width of two.
    wide: bool,
}

impl PagePicture {
    /// Writes a figure into a folder. The page has it as SVG, or as PNG where the SVG is large.
    ///
    /// # Errors
    ///
    /// When `dpi` is out of range, and when a file cannot be written.
    pub fn write(title: &'static str, caption: &str, figure: &Figure, folder: &Path, dpi: u32) -> error::Result<Self> {
        let drawing = figure.write(folder, dpi)?;
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        let packed = packer.write_all(drawing.as_bytes()).and_then(|()| packer.finish()).unwrap_or_default();
        let is_svg = (1..=LARGEST_SVG).contains(&packed.len());
        let source = STANDARD.encode(if is_svg { packed } else { figure.png(DEFAULT_DPI)? });
        Ok(Self { title, caption: caption.to_owned(), source, is_svg, wide: figure.inches[0] > 1.7 * figure.inches[1] })
    }
}

/// A column of cells of a record: of numbers where all are numbers, else of words.
pub(crate) fn column_of<'a>(name: impl Into<Cow<'static, str>>, cells: impl Iterator<Item = &'a Value> + Clone) -> Column {
    if cells.clone().all(|cell| cell.is_null() || cell.is_number()) {
        return Column::real(name, cells.map(|cell| cell.as_f64().unwrap_or(f64::NAN)));
    }
    let word = |cell: &Value| match cell {
        Value::Null => String::new(),
        Value::Bool(yes) => (if *yes { "yes" } else { "no" }).to_owned(),
        cell => cell.as_str().map_or_else(|| cell.to_string(), str::to_owned),
    };
    Column::text(name, cells.map(word))
}

/// A table with one row per item, of those of its fields that are named. `None` without an item.
pub(crate) fn list<T: Serialize>(title: &str, items: &[T], columns: &[&'static str]) -> Option<PageTable> {
    let mut cells = vec![Vec::new(); columns.len()];
    for item in items {
        let mut fields = json!(item);
        cells.iter_mut().zip(columns).for_each(|(cells, name)| cells.push(fields[name].take()));
    }
    let columns = columns.iter().zip(&cells).map(|(name, cells)| column_of(*name, cells.iter()));
    (!items.is_empty()).then(|| PageTable::new(title, columns.collect(), false))
}

/// The boundary conditions of a run; `None` without one.
pub(crate) fn condition_table(of: &[ConditionRecord]) -> Option<PageTable> {
    let columns = [
        "node",
        "id",
        "role",
        "found",
        "holds",
        "pressure_mmHg",
        "resistance_mmHg_s_per_mL",
        "venous_pressure_mmHg",
        "flow_mL_per_min",
    ];
    list("Boundary conditions", of, &columns)
}

impl Serialize for PageScene {
    /// The points as four u16 each (x, y, z, radius), with the corner and the two step sizes that convert them to mm.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let points = || self.vessels.iter().flatten().chain(self.markers.iter().map(|(place, ..)| place));
        let [low, high] = willis_core::support::geometry::bounds(points().map(|[x, y, z, _]| [*x, *y, *z]));
        let widest = points().map(|[.., radius]| *radius).fold(0.0, f64::max);
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let step = |range: f64| if range > 0.0 { range / f64::from(u16::MAX) } else { 1.0 };
        let steps = [step(extent), step(widest)];
        let whole = |[x, y, z, radius]: &[f64; 4]| {
            let whole = [(x - low[0]) / steps[0], (y - low[1]) / steps[0], (z - low[2]) / steps[0], radius / steps[1]];
            whole.into_iter().flat_map(|w| (w.round() as u16).to_le_bytes())
        };
        let counts: Vec<i64> = self.vessels.iter().map(|points| points.len() as i64).collect();
        let data = json!({
            "corner": low.map(|x| if x.is_finite() { x } else { 0.0 }),
            "counts": integers(&counts),
            "markers": self.markers.iter().map(|(_, kind, name)| (kind, name)).collect::<Vec<_>>(),
            "points": STANDARD.encode(points().flat_map(whole).collect::<Vec<u8>>()),
            "steps": steps,
        });
        data.serialize(serializer)
    }
}

fn has_values(column: &Column) -> bool {
    match &column.values {
        Values::Real(values) => values.iter().any(|x| !x.is_nan()),
        Values::Integer(values) => !values.is_empty(),
        Values::Text(values) => values.iter().any(|text| !text.is_empty()),
    }
}

/// Each array is made as it is written: no text of all of them is held.
fn as_arrays<S: Serializer>(columns: &[(Column, bool)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(columns.iter().map(|(Column { name, values }, is_exact)| {
        let mut data = match values {
            Values::Real(v) if *is_exact => array("f64", v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Values::Real(v) => array("f32", v.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect()),
            Values::Integer(v) => integers(v),
            Values::Text(v) => {
                let (words, rows) = words(v);
                json!({ "kind": "text", "rows": integers(&rows), "words": words })
            }
        };
        data["name"] = json!(name);
        data
    }))
}

/// Numbers of a kind, as bytes.
fn array(kind: &str, bytes: Vec<u8>) -> Value {
    json!({ "data": STANDARD.encode(bytes), "kind": kind })
}

/// Whole numbers in the narrowest type that holds them; those that equal their row numbers need no array.
fn integers(values: &[i64]) -> Value {
    if values.iter().enumerate().all(|(row, v)| *v == row as i64) {
        return json!({ "kind": "row" });
    }
    let holds = |bytes: usize| values.iter().all(|v| (0..1_i64 << (8 * bytes)).contains(v));
    match [("u8", 1), ("u16", 2), ("u32", 4)].into_iter().find(|(_, bytes)| holds(*bytes)) {
        Some((kind, bytes)) => array(kind, values.iter().flat_map(|v| v.to_le_bytes().into_iter().take(bytes)).collect()),
        None => array("f64", values.iter().flat_map(|v| (*v as f64).to_le_bytes()).collect()),
    }
}

/// The distinct words in the order of their first rows, and the number of the word for each row.
fn words(values: &Texts) -> (Vec<&str>, Vec<i64>) {
    let (mut number, mut list) = (std::collections::HashMap::new(), Vec::new());
    let number_of = |text| {
        let next = number.len() as i64;
        *number.entry(text).or_insert_with(|| {
            list.push(text);
            next
        })
    };
    let rows = values.iter().map(number_of).collect();
    (list, rows)
}

/// The section of a Circle of Willis, which several pages have.
const CIRCLE: &str = include_str!("assets/circle.html");
/// How to repeat a run, on the pages that say so.
const RUN_SECTION: &str = include_str!("assets/run.html");
/// Scripts with their names.
macro_rules! scripts {
    ($($name:ident)*) => {
        &[$((stringify!($name), include_str!(concat!("assets/", stringify!($name), ".js")))),*]
    };
}

/// The scripts by name, in the order that they have on any page; each has one purpose and uses those before it.
const SCRIPTS: &[(&str, &str)] = scripts! {
    dom data colour camera shaders surface webgl canvas shape overlay scene flows gestures rules threshold decisions edits review
    histogram table slices record circle cycle page distribution zip walk cohort comparison phenotype
};

/// The id of the section that the first link of a kind of page skips to, its markup, and the names of its scripts.
pub(crate) type PageKind = [&'static str; 3];

/// The page of a run.
const RUN: PageKind = [
    "tables",
    include_str!("assets/page.html"),
    "dom data colour camera shaders surface webgl canvas shape overlay scene flows gestures \
     rules threshold decisions edits review histogram table slices record circle cycle page",
];

/// Writes a page of a kind: the frame with the content in its places.
///
/// # Errors
///
/// An error of the writer.
pub(crate) fn write_page(out: &mut impl Write, title: &str, kind: PageKind, data: &impl Serialize) -> io::Result<()> {
    let [goal, main, scripts] = kind;
    let mut rest = include_str!("assets/frame.html");
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        out.write_all(before.as_bytes())?;
        match name {
            "title" => out.write_all(escape(title).as_bytes())?,
            "style" => out.write_all(include_bytes!("assets/page.css"))?,
            "goal" => out.write_all(goal.as_bytes())?,
            "main" => out.write_all(main.replace("{{circle}}", CIRCLE).replace("{{run}}", RUN_SECTION).as_bytes())?,
            "data" => data.serialize(&mut serde_json::Serializer::with_formatter(&mut *out, ScriptSafe))?,
            _ => {
                for (_, script) in SCRIPTS.iter().filter(|(name, _)| scripts.split(' ').any(|own| own == *name)) {
                    out.write_all(script.as_bytes())?;
                }
            }
        }
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

/// What JSON within a script element has as numbers of characters.
const UNSAFE: [char; 5] = ['<', '>', '&', '\u{2028}', '\u{2029}'];

/// Writes JSON so that it is safe within a script element.
struct ScriptSafe;

impl serde_json::ser::Formatter for ScriptSafe {
    fn write_string_fragment<W: Write + ?Sized>(&mut self, out: &mut W, text: &str) -> io::Result<()> {
        for part in text.split_inclusive(UNSAFE) {
            match part.char_indices().next_back().filter(|(_, last)| UNSAFE.contains(last)) {
                Some((at, mark)) => write!(out, "{}\\u{:04x}", &part[..at], u32::from(mark))?,
                None => out.write_all(part.as_bytes())?,
            }
        }
        Ok(())
    }
}
