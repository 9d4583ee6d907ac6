//! The files that a page is put together from: a frame, and the markup and the scripts of a kind of page.

use std::io::{self, Write};

use serde::Serialize;

use super::content::Page;
use willis_io::formats::escape;

/// The frame around the content of every page.
const FRAME: &str = include_str!("assets/frame.html");
/// The section of a Circle of Willis, which several pages have.
const CIRCLE: &str = include_str!("assets/circle.html");
/// How to repeat a run, on the pages that say so.
const RUN_SECTION: &str = include_str!("assets/run.html");
const STYLE: &str = include_str!("assets/page.css");
/// The page of a run. Its script is made of these files in order; each has one purpose and uses those before it.
const RUN: Template = Template {
    goal: "tables",
    main: include_str!("assets/page.html"),
    scripts: &[
        include_str!("assets/dom.js"),
        include_str!("assets/data.js"),
        include_str!("assets/colour.js"),
        include_str!("assets/camera.js"),
        include_str!("assets/shaders.js"),
        include_str!("assets/surface.js"),
        include_str!("assets/webgl.js"),
        include_str!("assets/canvas.js"),
        include_str!("assets/shape.js"),
        include_str!("assets/overlay.js"),
        include_str!("assets/scene.js"),
        include_str!("assets/flows.js"),
        include_str!("assets/gestures.js"),
        include_str!("assets/rules.js"),
        include_str!("assets/threshold.js"),
        include_str!("assets/decisions.js"),
        include_str!("assets/edits.js"),
        include_str!("assets/review.js"),
        include_str!("assets/histogram.js"),
        include_str!("assets/table.js"),
        include_str!("assets/slices.js"),
        include_str!("assets/record.js"),
        include_str!("assets/circle.js"),
        include_str!("assets/cycle.js"),
        include_str!("assets/page.js"),
    ],
};

/// The content of a kind of page.
pub struct Template {
    /// The id of the section that the first link skips to.
    pub goal: &'static str,
    /// Its markup.
    pub main: &'static str,
    /// Its scripts, in order.
    pub scripts: &'static [&'static str],
}

/// Writes a page: markup, style, data and scripts in one file that refers to no other.
///
/// # Errors
///
/// An error of the writer.
pub fn write_page(out: &mut impl Write, page: &Page) -> io::Result<()> {
    RUN.fill(out, &page.title, page)
}

impl Template {
    /// Writes the frame with the content in its places.
    pub fn fill(&self, out: &mut impl Write, title: &str, data: &impl Serialize) -> io::Result<()> {
        let mut rest = FRAME;
        while let Some((before, after)) = rest.split_once("{{") {
            let (name, after) = after.split_once("}}").unwrap_or((after, ""));
            out.write_all(before.as_bytes())?;
            match name {
                "title" => out.write_all(escape(title).as_bytes())?,
                "style" => out.write_all(STYLE.as_bytes())?,
                "goal" => out.write_all(self.goal.as_bytes())?,
                "main" => out.write_all(self.main.replace("{{circle}}", CIRCLE).replace("{{run}}", RUN_SECTION).as_bytes())?,
                "data" => serde_json::to_writer(ScriptSafe(&mut *out), data)?,
                _ => self.scripts.iter().try_for_each(|script| out.write_all(script.as_bytes()))?,
            }
            rest = after;
        }
        out.write_all(rest.as_bytes())
    }
}

/// Writes JSON so that it is safe within a script element. What it escapes never comes in two pieces: JSON is written by whole characters.
struct ScriptSafe<W>(W);

impl<W: Write> Write for ScriptSafe<W> {
    fn write(&mut self, json: &[u8]) -> io::Result<usize> {
        const ESCAPES: [(&[u8], &str); 5] = [
            (b"<", "\\u003c"),
            (b">", "\\u003e"),
            (b"&", "\\u0026"),
            ("\u{2028}".as_bytes(), "\\u2028"),
            ("\u{2029}".as_bytes(), "\\u2029"),
        ];
        let (mut written, mut at) = (0, 0);
        while at < json.len() {
            let escape = ESCAPES.iter().find(|(mark, _)| json[at..].starts_with(mark));
            if let Some((mark, escape)) = escape {
                self.0.write_all(&json[written..at])?;
                self.0.write_all(escape.as_bytes())?;
                at += mark.len();
                written = at;
            } else {
                at += 1;
            }
        }
        self.0.write_all(&json[written..])?;
        Ok(json.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
