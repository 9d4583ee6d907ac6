//! One figure, which is written as PNG at any resolution and as SVG.

use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::sheet::Sheet;
use super::style::POINTS_PER_INCH;
use super::{bitmap, svg};
use willis_core::error::{Error, Result};
use willis_io::output::write_file;

/// The default resolution, pixels per inch.
pub const DEFAULT_DPI: u32 = 150;

const DPI: RangeInclusive<u32> = 36..=1200;

/// How an output folder is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SaveOptions {
    /// Resolution of the pictures, dots an inch, 30 to 1200.
    pub dpi: u32,
}

impl Default for SaveOptions {
    fn default() -> Self {
        Self { dpi: DEFAULT_DPI }
    }
}

impl SaveOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let accepted = || format!("expected a number from {} to {}", DPI.start(), DPI.end());
        if DPI.contains(&self.dpi) { Ok(()) } else { Err(Error::parameter("dpi", self.dpi, accepted())) }
    }
}

/// A figure that can be written in any format.
pub struct Figure {
    name: &'static str,
    inches: [f64; 2],
    sheet: Sheet,
}

impl Figure {
    /// A figure called `name`, of a width and height in points.
    pub(crate) fn new(name: &'static str, points: [f64; 2], sheet: Sheet) -> Self {
        Self { name, inches: points.map(|length| length / POINTS_PER_INCH), sheet }
    }

    /// The name of its files, without the endings.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Whether it is so wide for its height that it needs the width of a page.
    pub fn is_wide(&self) -> bool {
        self.inches[0] > 1.7 * self.inches[1]
    }

    /// The PNG file, 8-bit RGB, with its resolution: `dpi` pixels per inch (36 to 1200).
    ///
    /// # Errors
    ///
    /// When `dpi` is out of range.
    pub fn png(&self, dpi: u32) -> Result<Vec<u8>> {
        SaveOptions { dpi }.validate()?;
        bitmap::png(self.inches, &self.sheet.marks, dpi).map_err(|reason| self.failure(reason))
    }

    /// The SVG file. Its text is text, which other programs can edit, in the font of the bitmap or in one about as wide. It refers to no other
    /// file. Its ids begin with the name of the figure, so that one page can hold several figures.
    ///
    /// One unit is 1/100 point (1/7200 inch); coordinates are whole numbers.
    ///
    /// # Errors
    ///
    /// When an image in it cannot be made.
    pub fn svg(&self) -> Result<String> {
        svg::svg(self.name, self.inches, &self.sheet.marks).map_err(|reason| self.failure(reason))
    }

    /// Writes NAME.png and NAME.svg into a folder, and returns the SVG.
    ///
    /// # Errors
    ///
    /// When `dpi` is out of range, and when a file cannot be written.
    pub fn write(&self, folder: &Path, dpi: u32) -> Result<String> {
        let (png, svg) = (self.png(dpi)?, self.svg()?);
        write_file(&folder.join(format!("{}.png", self.name)), |out| out.write_all(&png))?;
        write_file(&folder.join(format!("{}.svg", self.name)), |out| out.write_all(svg.as_bytes()))?;
        Ok(svg)
    }

    fn failure(&self, reason: String) -> Error {
        Error::Write { path: self.name.into(), source: std::io::Error::other(reason) }
    }
}
