//! One figure, which the same code draws as PNG at any resolution and as SVG.

use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use super::bitmap::Bitmap;
use super::canvas::Sheet;
use super::font;
use super::svg::SvgPage;
use willis_core::error::{Error, Result};
use willis_io::output::atomic::write_file;

/// The default resolution, pixels per inch.
pub const DEFAULT_DPI: u32 = 150;

const DPI: RangeInclusive<u32> = 36..=1200;
/// The lowest resolution of drawing, dots per inch. Plotters puts glyphs and corners on whole dots, which are then averaged to pixels.
const FINEST: u32 = 600;

/// Refuses a resolution out of its range.
///
/// # Errors
///
/// Fewer than 36 or more than 1200 pixels per inch.
pub fn check_dpi(dpi: u32) -> Result<()> {
    let accepted = || format!("expected a number from {} to {}", DPI.start(), DPI.end());
    if DPI.contains(&dpi) { Ok(()) } else { Err(Error::parameter("dpi", dpi, accepted())) }
}

type Draw = dyn Fn(&mut Sheet<'_>) -> Result<()> + Send + Sync;

/// A figure that can be drawn in any format.
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
        check_dpi(dpi)?;
        let fine = FINEST.div_ceil(dpi);
        let pixels = self.inches.map(|length| (length * f64::from(dpi)).round() as u32);
        let mut bitmap = Bitmap::new(pixels, fine);
        self.on(&mut Sheet::new(&mut bitmap, self.name, dpi, fine))?;
        bitmap.png(dpi).map_err(|error| self.failure(&error))
    }

    /// The SVG file. It has only curves and filled shapes, for text too, so that it looks the same without any font and refers to no
    /// other file. Its ids begin with the name of the figure, so that one page can hold several figures.
    ///
    /// One unit is 1/100 point (1/7200 inch); coordinates are whole numbers.
    ///
    /// # Errors
    ///
    /// When the built-in font cannot be read.
    pub fn svg(&self) -> Result<String> {
        let mut page = SvgPage::new(self.name);
        self.on(&mut Sheet::new(&mut page, self.name, SvgPage::DPI, 1))?;
        Ok(page.svg(self.inches))
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
        if !font::is_registered() {
            return Err(self.failure("the built-in font cannot be read"));
        }
        (self.draw)(sheet)
    }

    fn failure(&self, reason: impl std::fmt::Display) -> Error {
        Error::Write { path: self.name.into(), source: std::io::Error::other(reason.to_string()) }
    }
}
