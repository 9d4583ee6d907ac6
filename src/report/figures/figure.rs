//! One figure, drawn by the same code as PNG at any resolution and as SVG.

use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use super::bitmap::Dots;
use super::canvas::Sheet;
use super::font;
use super::svg::Drawing;
use crate::error::{Error, Result};
use crate::output::atomic::write_file;

/// Pixels per inch where nobody says otherwise.
pub const DEFAULT_DPI: u32 = 150;

const DPI: RangeInclusive<u32> = 36..=1200;
/// plotters sets glyphs and corners on whole dots: a page is drawn at least this fine (dots per inch) and averaged down.
const FINEST: u32 = 600;

/// Refuses a resolution that no picture can have.
///
/// # Errors
///
/// Fewer than 36 or more than 1200 pixels per inch.
pub fn check_dpi(dpi: u32) -> Result<()> {
    let accepted = || format!("expected a number from {} to {}", DPI.start(), DPI.end());
    if DPI.contains(&dpi) { Ok(()) } else { Err(Error::parameter("dpi", dpi, accepted())) }
}

type Draw = dyn Fn(&mut Sheet<'_>) -> Result<()> + Send + Sync;

/// A picture that can be made as often and in whatever form it is wanted.
pub struct Figure {
    name: &'static str,
    inches: [f64; 2],
    draw: Box<Draw>,
}

impl Figure {
    /// A figure called `name`, of a width and height in inches.
    pub(crate) fn new(
        name: &'static str,
        inches: [f64; 2],
        draw: impl Fn(&mut Sheet<'_>) -> Result<()> + Send + Sync + 'static,
    ) -> Self {
        Self { name, inches, draw: Box::new(draw) }
    }

    /// What its files are called, without their endings.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The PNG file, 8-bit RGB, with its resolution: `dpi` pixels per inch (36 to 1200).
    ///
    /// # Errors
    ///
    /// When `dpi` is out of range.
    pub fn png(&self, dpi: u32) -> Result<Vec<u8>> {
        check_dpi(dpi)?;
        let fine = FINEST.div_ceil(dpi);
        let pixels = self.inches.map(|length| (length * f64::from(dpi)).round() as u32);
        let mut dots = Dots::new(pixels, fine);
        self.on(&mut Sheet::new(&mut dots, self.name, dpi, fine))?;
        dots.png(dpi).map_err(|error| self.failure(&error))
    }

    /// The SVG file: curves and filled shapes alone, text among them, so that it looks the same without any font installed
    /// and refers to nothing outside itself. Its ids begin with the figure's name, so that several fit in one page.
    ///
    /// One unit is 1/100 point (1/7200 inch), and every place lies on a whole one.
    ///
    /// # Errors
    ///
    /// When the built-in font cannot be read.
    pub fn svg(&self) -> Result<String> {
        let mut drawing = Drawing::new(self.name);
        self.on(&mut Sheet::new(&mut drawing, self.name, Drawing::DPI, 1))?;
        Ok(drawing.svg(self.inches))
    }

    /// Writes NAME.png and NAME.svg into a folder.
    ///
    /// # Errors
    ///
    /// When `dpi` is out of range, and when a file cannot be written.
    pub fn write(&self, folder: &Path, dpi: u32) -> Result<()> {
        let (png, svg) = (self.png(dpi)?, self.svg()?);
        write_file(&folder.join(format!("{}.png", self.name)), |out| out.write_all(&png))?;
        write_file(&folder.join(format!("{}.svg", self.name)), |out| out.write_all(svg.as_bytes()))
    }

    fn on(&self, sheet: &mut Sheet<'_>) -> Result<()> {
        if !font::is_known() {
            return Err(self.failure("the built-in font cannot be read"));
        }
        (self.draw)(sheet)
    }

    fn failure(&self, reason: impl std::fmt::Display) -> Error {
        Error::Write { path: self.name.into(), source: std::io::Error::other(reason.to_string()) }
    }
}
