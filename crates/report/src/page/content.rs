//! What the page of a run holds: tables, pictures, colourings, a threshold, and what its record says in short.

use std::io::Write as _;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde_json::{Value, json};

use super::image::ImagePlace;
use super::lead;
use super::scene::PageScene;
use crate::figures::colour::{Rgb, colour};
use crate::figures::{DEFAULT_DPI, Figure};
use crate::run_record::ConditionRecord;
use willis_core::error::Result;
use willis_core::network::Role;
use willis_core::network::units::millimetres;
use willis_io::formats::Column;
use willis_io::masks::cubes::{SIDE, STEP};
use willis_models::circle_of_willis::LANDMARK_NOTE_ENDING;

/// The page of a run, of any command. Its fields stand in alphabetical order: they are the keys of the page.
#[derive(Debug, Default, Serialize)]
pub struct Page {
    /// The figures that can colour the vessels of the scene; the page starts with the first.
    pub(super) colourings: Vec<Colouring>,
    pub(super) colours: Vec<Rgb>,
    /// The figures at the end of the page.
    pub(super) facts: Vec<Fact>,
    pub(super) figures: Vec<PagePicture>,
    pub(super) image_places: Value,
    /// The sentence that it begins with; empty where the page makes one of its vessels.
    pub(super) lead: Vec<lead::Part>,
    pub(super) no_scene: Option<String>,
    /// The phenotype of a Circle of Willis, where there is one, as phenotype.json has it.
    pub(super) phenotype: Option<Value>,
    pub(super) record: Value,
    pub(super) scene: Option<PageScene>,
    /// The segmentation that the vessels were found in.
    pub(super) segmentation: Value,
    /// The tables.
    pub(super) tables: Vec<PageTable>,
    /// A threshold on a column of the first table that the reader can move.
    pub(super) threshold: Value,
    /// The heading.
    pub(super) title: String,
    /// What a reader should know before anything else.
    pub(super) warnings: Vec<String>,
}

impl Page {
    /// The page of a run of a command with the least that every run has: its record, as in run.json, the vessels in space, or the reason why
    /// they cannot be shown, what an image shows around doubtful ones, and pictures.
    pub fn new(
        command: &str,
        record: Value,
        scene: std::result::Result<PageScene, String>,
        image_places: &[ImagePlace],
        figures: Vec<PagePicture>,
    ) -> Self {
        let path = Path::new(record["input"]["path"].as_str().unwrap_or_default());
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let (title, colours) = (format!("willis {command}: {name}"), colours());
        let (no_scene, scene) = (scene.as_ref().err().cloned(), scene.ok());
        let image_places = json!({ "side": SIDE, "step_mm": millimetres(STEP), "of": image_places });
        Self { colours, figures, image_places, no_scene, record, scene, title, ..Self::default() }
    }
}

/// Steps of the colour map; the page interpolates between them.
const COLOURS: u32 = 32;

/// The colour map in equal steps, from low to high.
pub fn colours() -> Vec<Rgb> {
    (0..=COLOURS).map(|i| colour(f64::from(i) / f64::from(COLOURS))).collect()
}

/// A figure of the run: its name, its value (a number, a word or null) and its unit, empty without one.
pub type Fact = (&'static str, Value, &'static str);

/// Figures of the record by name, JSON pointer and unit. A list stands for its length.
pub fn facts(record: &Value, names: &[(&'static str, &str, &'static str)]) -> Vec<Fact> {
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
pub fn warnings(record: &Value, conditions: &[ConditionRecord]) -> Vec<String> {
    let mut all = Vec::new();
    // The direction of the lines in the file states a source.
    let inlets = conditions.iter().filter(|c| c.role == Role::Inlet.name() && c.found && !c.source).count();
    match inlets {
        0 => {}
        1 => all.push(
            "Nobody stated where blood enters: the widest free end is assumed to be the inlet. The option inlet states it."
                .to_owned(),
        ),
        n => all.push(format!(
            "Nobody stated where blood enters: {n} free ends are assumed to be inlets. The option inlet states them."
        )),
    }
    if !conditions.is_empty() && conditions.iter().all(|c| c.role != Role::Outlet.name()) {
        all.push("There is no outlet, so that no blood flows.".to_owned());
    }
    match record.pointer("/counts/topology/unperfused_components").and_then(Value::as_u64) {
        None | Some(0) => {}
        Some(1) => all.push("One part of what the run kept carries no flow: it lacks an inlet or an outlet.".to_owned()),
        Some(n) => all.push(format!("{n} parts of what the run kept carry no flow: they lack an inlet or an outlet.")),
    }
    let notes = record["notes"].as_array().map_or(&[][..], Vec::as_slice).iter().filter_map(Value::as_str);
    let plain = |note: &&str| note.starts_with("a mask of") || note.ends_with(LANDMARK_NOTE_ENDING);
    all.extend(notes.filter(|note| !plain(note)).map(|note| {
        let mut letters = note.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    }));
    all.truncate(MOST_WARNINGS);
    all
}

/// A table of the page.
#[derive(Debug, Clone)]
pub struct PageTable {
    /// Its heading.
    pub title: String,
    /// The columns, all of the same length. The page leaves out columns without any value.
    pub columns: Vec<Column>,
    /// The columns that the page holds in double precision; it holds others in single precision.
    pub exact: &'static [&'static str],
    /// Whether row i is vessel i.
    pub of_vessels: bool,
}

impl PageTable {
    /// A table of numbers in single precision.
    pub fn new(title: impl Into<String>, columns: Vec<Column>, of_vessels: bool) -> Self {
        Self { title: title.into(), columns, exact: &[], of_vessels }
    }
}

/// How a figure is converted to a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ColourScale {
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
pub struct Colouring {
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

/// Removes a part of the record that becomes a table.
pub fn take(record: &mut Value, name: &str) -> Value {
    record.get_mut(name).map_or(json!([]), Value::take)
}

/// The largest packed SVG in a page, bytes. A larger picture becomes a PNG.
const LARGEST_SVG: usize = 100_000;

/// A picture of the page, with its description. Its fields stand in alphabetical order, as those of [`Page`].
#[derive(Debug, Clone, Serialize)]
pub struct PagePicture {
    /// What it shows: its caption, and its text for readers who cannot see it.
    pub caption: &'static str,
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
    pub fn write(title: &'static str, caption: &'static str, figure: &Figure, folder: &Path, dpi: u32) -> Result<Self> {
        let drawing = figure.write(folder, dpi)?;
        let mut packer = GzEncoder::new(Vec::new(), Compression::default());
        let packed = packer.write_all(drawing.as_bytes()).and_then(|()| packer.finish()).unwrap_or_default();
        let is_svg = (1..=LARGEST_SVG).contains(&packed.len());
        let source = STANDARD.encode(if is_svg { packed } else { figure.png(DEFAULT_DPI)? });
        Ok(Self { title, caption, source, is_svg, wide: figure.is_wide() })
    }
}

/// A table with one row per item. A column holds numbers where all its values are numbers. `None` without an item.
pub fn list(title: &str, items: &Value, columns: &[&'static str]) -> Option<PageTable> {
    let items = items.as_array().filter(|items| !items.is_empty())?;
    let column = |&name: &&'static str| {
        let values = || items.iter().map(|item| &item[name]);
        let are_numbers = values().all(|v| v.is_null() || v.is_number());
        let reals = || values().map(|v| v.as_f64().unwrap_or(f64::NAN));
        if are_numbers { Column::real(name, reals()) } else { Column::text(name, values().map(word)) }
    };
    Some(PageTable::new(title, columns.iter().map(column).collect(), false))
}

fn word(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Bool(yes) => (if *yes { "yes" } else { "no" }).to_owned(),
        other => other.to_string(),
    }
}

/// The boundary conditions of a run; `None` without one.
pub fn conditions(of: &[ConditionRecord]) -> Option<PageTable> {
    let text = |name, text: fn(&ConditionRecord) -> &str| Column::text(name, of.iter().map(text));
    let yes = |yes: bool| if yes { "yes" } else { "no" };
    let figure =
        |name, figure: fn(&ConditionRecord) -> Option<f64>| Column::real(name, of.iter().map(|c| figure(c).unwrap_or(f64::NAN)));
    let columns = vec![
        Column::real("node", of.iter().map(|c| c.node as f64)),
        text("id", |c| &c.id),
        text("role", |c| c.role),
        Column::text("found", of.iter().map(|c| yes(c.found))),
        Column::text("holds", of.iter().map(|c| c.holds.map_or("", yes))),
        figure("pressure_mmHg", |c| c.pressure),
        figure("resistance_mmHg_s_per_mL", |c| c.resistance),
        figure("venous_pressure_mmHg", |c| c.venous),
        figure("flow_mL_per_min", |c| c.flow),
    ];
    (!of.is_empty()).then(|| PageTable::new("Boundary conditions", columns, false))
}
