//! report.html: one self-contained page of a run, to open in any browser and to send to a colleague.

pub(crate) mod cohort;
mod encode;
mod inference;
pub(crate) mod lists;
mod modulation;
mod scene;
mod simulation;

pub use inference::page as infer_page;
pub use modulation::{Tables as ModulationTables, page as modulation_page};
pub use simulation::page as simulation_page;

use std::io::{self, Write};

use serde_json::{Value, json};

use crate::io::{Column, escape};
use lists::Figure;
use scene::Scene;

/// A page, whatever command it is of.
#[derive(Debug, Clone)]
pub struct Page {
    /// The command, as the heading says it.
    pub title: String,
    /// The record of the run, as in run.json: command, seed, parameters, notes.
    pub record: Value,
    /// The figures that come first.
    pub facts: Vec<Fact>,
    /// The vessels in space, or why they cannot be shown.
    pub scene: Result<Scene, String>,
    /// By what the vessels of the scene can be coloured; the first one is shown at the start.
    pub colourings: Vec<Colouring>,
    /// A threshold that the reader can move.
    pub threshold: Option<Threshold>,
    /// The pictures.
    pub figures: Vec<Figure>,
    /// The tables.
    pub tables: Vec<Table>,
}

/// A figure of the run with what it is called.
#[derive(Debug, Clone)]
pub struct Fact {
    /// What it is.
    pub name: &'static str,
    /// A number, a word or null.
    pub value: Value,
    /// Its unit, empty without one.
    pub unit: &'static str,
}

impl Fact {
    /// A figure of the record, by its JSON pointer.
    pub fn of(record: &Value, name: &'static str, pointer: &str, unit: &'static str) -> Self {
        Self { name, value: record.pointer(pointer).cloned().unwrap_or_default(), unit }
    }
}

/// A table whose rows may stand for vessels.
#[derive(Debug, Clone)]
pub struct Table {
    /// Its heading.
    pub title: String,
    /// The columns, all of one length; those without a value in any row are not shown.
    pub columns: Vec<Column>,
    /// Columns kept to the last bit; others with seven digits.
    pub exact: &'static [&'static str],
    /// Whether row i is vessel i.
    pub of_vessels: bool,
}

/// How a figure becomes a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Its logarithm.
    Log,
    /// The figure itself.
    Linear,
    /// The figure itself, between two colours on either side of zero.
    Diverging,
}

/// A figure by which vessels are coloured.
#[derive(Debug, Clone)]
pub struct Colouring {
    /// What it is called.
    pub name: &'static str,
    /// Its unit, empty without one.
    pub unit: &'static str,
    /// How it becomes a colour; the magnitude counts on any scale but [`Scale::Diverging`].
    pub scale: Scale,
    /// Whether vessels that are certain stay grey.
    pub uncertain_only: bool,
    /// Where it stands: the name of the variant, the row of the table, the column. All variants share one scale.
    pub variants: Vec<(String, usize, String)>,
}

/// A threshold on a column of the first table.
#[derive(Debug, Clone)]
pub struct Threshold {
    /// The column that is compared.
    pub figure: &'static str,
    /// What the figure is called.
    pub name: &'static str,
    /// Its unit, empty without one.
    pub unit: &'static str,
    /// The column of its standard error; without one it is that of a share of `samples`, sqrt(f(1-f)/n).
    pub error: Option<&'static str>,
    /// How many samples there were.
    pub samples: u64,
    /// Whether a figure equal to the threshold passes.
    pub at_least: bool,
    /// Whether a decision flips midway between the figures on the two sides of the threshold, or at the threshold itself.
    pub midway: bool,
    /// How many standard errors from there a decision counts as decided.
    pub within: f64,
    /// The threshold of the run.
    pub cut: Option<f64>,
    /// The median of the positive figures of uncertain vessels, where it is one of this figure.
    pub median: Option<f64>,
    /// The column that is 1 where the run kept a vessel, where its rule is no threshold on the figure ...
    pub kept: Option<&'static str>,
    /// ... and the figure about which its decisions are open.
    pub middle: Option<f64>,
    /// How near to the cut a figure without standard error is undecided; without it that error is one of a share.
    pub band: Option<f64>,
    /// The column that is 1 where a vessel is uncertain.
    pub uncertain: &'static str,
    /// How many nodes there are.
    pub nodes: usize,
}

/// What all pages have around what they show.
const FRAME: &str = include_str!("assets/frame.html");
const STYLE: &str = include_str!("assets/page.css");
/// The page of a run. Each file of its one module script has one purpose, and uses those before it.
const RUN: Template = Template {
    goal: "tables",
    main: include_str!("assets/page.html"),
    scripts: &[
        include_str!("assets/dom.js"),
        include_str!("assets/data.js"),
        include_str!("assets/colour.js"),
        include_str!("assets/camera.js"),
        include_str!("assets/shaders.js"),
        include_str!("assets/webgl.js"),
        include_str!("assets/canvas.js"),
        include_str!("assets/scene.js"),
        include_str!("assets/gestures.js"),
        include_str!("assets/threshold.js"),
        include_str!("assets/histogram.js"),
        include_str!("assets/table.js"),
        include_str!("assets/page.js"),
    ],
};

/// What a kind of page shows.
struct Template {
    /// The id of the section that the first link leads to.
    goal: &'static str,
    main: &'static str,
    scripts: &'static [&'static str],
}

/// Writes a page: markup, style, data and scripts in one file that asks for nothing from elsewhere.
///
/// # Errors
///
/// What the writer says; a table whose columns differ in length.
pub fn write_page(out: &mut impl Write, page: &Page) -> io::Result<()> {
    RUN.fill(out, &page.title, &encode::page(page)?)
}

impl Template {
    /// Writes the frame with what belongs into its places.
    fn fill(&self, out: &mut impl Write, title: &str, data: &Value) -> io::Result<()> {
        let mut rest = FRAME;
        while let Some((before, after)) = rest.split_once("{{") {
            let (name, after) = after.split_once("}}").unwrap_or((after, ""));
            out.write_all(before.as_bytes())?;
            match name {
                "title" => out.write_all(escape(title).as_bytes())?,
                "style" => out.write_all(STYLE.as_bytes())?,
                "goal" => out.write_all(self.goal.as_bytes())?,
                "main" => out.write_all(self.main.as_bytes())?,
                "data" => out.write_all(as_script(&serde_json::to_string(data)?).as_bytes())?,
                _ => self.scripts.iter().try_for_each(|script| out.write_all(script.as_bytes()))?,
            }
            rest = after;
        }
        out.write_all(rest.as_bytes())
    }
}

/// JSON in which nothing can end a script or a line of one.
fn as_script(json: &str) -> String {
    const ESCAPES: [(char, &str); 5] =
        [('<', "\\u003c"), ('>', "\\u003e"), ('&', "\\u0026"), ('\u{2028}', "\\u2028"), ('\u{2029}', "\\u2029")];
    ESCAPES.iter().fold(json.to_owned(), |text, (mark, escape)| text.replace(*mark, escape))
}

/// The record of a run for its page: what differs between two runs of one command, and lists that the tables hold, left out.
fn record(of: &impl serde::Serialize) -> Value {
    let mut record = serde_json::to_value(of).unwrap_or_default();
    if let Some(fields) = record.as_object_mut() {
        fields.remove("time");
    }
    if let Some(convergence) = record.get_mut("convergence").and_then(Value::as_object_mut) {
        convergence.remove("undecided_edges");
    }
    record
}

/// The heading of a run: its command, and the name of its input.
fn title(command: &str, record: &Value) -> String {
    let path = record["input"]["path"].as_str().unwrap_or_default();
    let name = std::path::Path::new(path).file_name().map_or(path.into(), |name| name.to_string_lossy());
    format!("willis {command}: {name}")
}

/// A part of the record that becomes a table, taken out of it.
fn take(record: &mut Value, name: &str) -> Value {
    record.get_mut(name).map_or(json!([]), Value::take)
}
