//! A page in memory: lines, boxes and text by plotters, handed over as PNG. The only file that names plotters.

use std::io;
use std::ops::RangeInclusive;
use std::sync::OnceLock;

use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, TextStyle, register_font};

use super::axis::Label;
use super::colour::{INK, PAPER, Rgb};
use crate::error::{Error, Result};

/// Pixels per inch where nobody says otherwise.
pub const DEFAULT_DPI: u32 = 150;

const DPI: RangeInclusive<u32> = 36..=1200;
/// plotters sets glyphs and corners on whole dots: a page is drawn at least this fine (dots per inch) and averaged down.
const FINEST: u32 = 600;
const FAMILY: &str = "willis";
const POINTS_PER_INCH: f64 = 72.0;
const METRES_PER_INCH: f64 = 0.0254;
/// Height of text, points.
pub const TEXT: f64 = 10.0;
/// Height of a title, points.
pub const TITLE: f64 = 12.0;
/// Width of axes and ticks, points.
pub const HAIR: f64 = 0.6;
/// Height of the digits as a share of the text's.
const DIGIT: f64 = 0.6;
/// Height of an exponent as a share of the text's.
const EXPONENT: f64 = 0.72;
/// How far an exponent is raised, as a share of the text's height.
const LIFT: f64 = 0.3;

/// A place on the page, points from its upper left corner.
pub type Place = [f64; 2];

/// Where text lies from its place, in reading direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// The text begins there.
    Begin,
    /// The text's middle is there.
    Middle,
    /// The text ends there.
    End,
}

/// Which way text runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Run {
    /// From left to right.
    Right,
    /// From below upwards.
    Up,
}

/// A page of a size in inches. Lengths are in points (1/72 inch), whatever the dots per inch.
pub struct Sheet {
    name: &'static str,
    pixels: [u32; 2],
    dpi: u32,
    /// Dots along a pixel's side.
    fine: u32,
    dots: Vec<u8>,
}

impl Sheet {
    /// A white page for the picture called `name`.
    pub fn new(name: &'static str, inches: [f64; 2], dpi: u32) -> Result<Self> {
        if !DPI.contains(&dpi) {
            let accepted = format!("expected pixels per inch from {} to {}", DPI.start(), DPI.end());
            return Err(Error::parameter("dpi", dpi, accepted));
        }
        if !font() {
            return Err(failure(name, "the built-in font cannot be read"));
        }
        let pixels = inches.map(|length| (length * f64::from(dpi)).round() as u32);
        let fine = FINEST.div_ceil(dpi);
        let dots = pixels.map(|p| (p * fine) as usize);
        let dots = PAPER.repeat(dots[0] * dots[1]);
        Ok(Self { name, pixels, dpi, fine, dots })
    }

    /// Whole pixels nearest to a length in points.
    pub fn pixels(&self, points: f64) -> usize {
        (points * f64::from(self.dpi) / POINTS_PER_INCH).round() as usize
    }

    /// The points of a length in pixels.
    pub fn points(&self, pixels: usize) -> f64 {
        pixels as f64 * POINTS_PER_INCH / f64::from(self.dpi)
    }

    /// Fills whole pixels: `corner` (x, y), `size` (width, height), both in pixels.
    pub fn fill(&mut self, corner: [usize; 2], size: [usize; 2], rgb: Rgb) -> Result<()> {
        let fine = self.fine as usize;
        let dot = |pixel: usize| (pixel * fine) as i32;
        let from = (dot(corner[0]), dot(corner[1]));
        let to = (dot(corner[0] + size[0]), dot(corner[1] + size[1]));
        self.draw(|page| page.draw_rect(from, to, &ink(rgb, 1.0), true))
    }

    /// A line along `path`, `width` points wide, `opacity` in (0, 1].
    pub fn line(&mut self, path: impl IntoIterator<Item = Place>, width: f64, rgb: Rgb, opacity: f64) -> Result<()> {
        let mut dots: Vec<_> = path.into_iter().map(|p| self.dot(p)).collect();
        dots.dedup();
        if dots.len() < 2 {
            return Ok(());
        }
        let width = (self.dots_in(width).round() as u32).max(1);
        self.draw(|page| page.draw_path(dots, &ink(rgb, opacity).stroke_width(width)))
    }

    /// A straight line of dashes 4 points long, 3 apart.
    pub fn dashes(&mut self, [from, to]: [Place; 2], width: f64, rgb: Rgb) -> Result<()> {
        const DASH: f64 = 4.0;
        const STEP: f64 = 7.0;
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let at = |along: f64| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * (along / length).min(1.0));
        for dash in 0..(length / STEP).ceil() as usize {
            let start = dash as f64 * STEP;
            self.line([at(start), at(start + DASH)], width, rgb, 1.0)?;
        }
        Ok(())
    }

    /// Fills a rectangle of any place and size (width, height), points.
    pub fn rectangle(&mut self, corner: Place, size: [f64; 2], rgb: Rgb) -> Result<()> {
        let (from, to) = (self.dot(corner), self.dot([corner[0] + size[0], corner[1] + size[1]]));
        self.draw(|page| page.draw_rect(from, to, &ink(rgb, 1.0), true))
    }

    /// A box around `corner` and `size` (width, height).
    pub fn frame(&mut self, [left, top]: Place, [width, height]: [f64; 2]) -> Result<()> {
        let (right, bottom) = (left + width, top + height);
        for (from, to) in [
            ([left, top], [right, top]),
            ([left, bottom], [right, bottom]),
            ([left, top], [left, bottom]),
            ([right, top], [right, bottom]),
        ] {
            self.line([from, to], HAIR, INK, 1.0)?;
        }
        Ok(())
    }

    /// Text whose digits are centred on `place` across its direction.
    pub fn text(&mut self, label: &Label, place: Place, height: f64, align: Align, run: Run) -> Result<()> {
        let (size, raised) = (self.dots_in(height), self.dots_in(height * EXPONENT));
        let widths = [self.width(&label.text, size)?, self.width(&label.exponent, raised)?];
        let back = match align {
            Align::Begin => 0.0,
            Align::Middle => f64::midpoint(widths[0], widths[1]),
            Align::End => widths[0] + widths[1],
        };
        // plotters draws text with its base line half its size below the place.
        let base = size * (DIGIT - 1.0) / 2.0;
        let lifted = size * (DIGIT / 2.0 - LIFT) - raised / 2.0;
        let at = self.dot(place);
        for (text, size, along, across) in [(&label.text, size, -back, base), (&label.exponent, raised, widths[0] - back, lifted)]
        {
            let (along, across) = (along.round() as i32, across.round() as i32);
            let (at, turn) = match run {
                Run::Right => ((at.0 + along, at.1 + across), FontTransform::None),
                Run::Up => ((at.0 + across, at.1 - along), FontTransform::Rotate270),
            };
            let style = TextStyle::from((FAMILY, size).into_font()).color(&RGBColor(INK[0], INK[1], INK[2])).transform(turn);
            self.draw(|page| page.draw_text(text, &style, at))?;
        }
        Ok(())
    }

    /// The width of text without an exponent, points.
    pub fn text_width(&self, text: &str, height: f64) -> Result<f64> {
        Ok(self.width(text, self.dots_in(height))? / self.dots_in(1.0))
    }

    /// The PNG file, 8-bit RGB, with its resolution.
    pub fn png(self) -> Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.pixels[0], self.pixels[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let per_metre = (f64::from(self.dpi) / METRES_PER_INCH).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }));
        let averaged = self.averaged();
        encoder
            .write_header()
            .and_then(|mut writer| {
                writer.write_image_data(&averaged)?;
                writer.finish()
            })
            .map_err(|error| failure(self.name, error))?;
        Ok(file)
    }

    /// Each pixel as the mean of its dots.
    fn averaged(&self) -> Vec<u8> {
        let [width, height] = self.pixels.map(|p| p as usize);
        let fine = self.fine as usize;
        let count = (fine * fine) as u32;
        let mut image = Vec::with_capacity(width * height * 3);
        let mut sums = vec![0_u32; width * 3];
        for rows in self.dots.chunks_exact(width * fine * 3 * fine) {
            sums.fill(0);
            for row in rows.chunks_exact(width * fine * 3) {
                for (sum, dots) in sums.chunks_exact_mut(3).zip(row.chunks_exact(fine * 3)) {
                    for dot in dots.chunks_exact(3) {
                        for (s, d) in sum.iter_mut().zip(dot) {
                            *s += u32::from(*d);
                        }
                    }
                }
            }
            image.extend(sums.iter().map(|s| ((s + count / 2) / count) as u8));
        }
        image
    }

    fn dots_in(&self, points: f64) -> f64 {
        points * f64::from(self.dpi * self.fine) / POINTS_PER_INCH
    }

    fn dot(&self, place: Place) -> (i32, i32) {
        let [x, y] = place.map(|points| self.dots_in(points).round() as i32);
        (x, y)
    }

    fn width(&self, text: &str, size: f64) -> Result<f64> {
        let (width, _) = (FAMILY, size).into_font().box_size(text).map_err(|error| failure(self.name, error))?;
        Ok(f64::from(width))
    }

    fn draw<E: std::fmt::Display>(&mut self, stroke: impl FnOnce(&mut BitMapBackend<'_>) -> Result<(), E>) -> Result<()> {
        let [width, height] = self.pixels.map(|p| p * self.fine);
        stroke(&mut BitMapBackend::with_buffer(&mut self.dots, (width, height))).map_err(|error| failure(self.name, error))
    }
}

fn ink(rgb: Rgb, opacity: f64) -> plotters::style::ShapeStyle {
    RGBColor(rgb[0], rgb[1], rgb[2]).mix(opacity).filled()
}

fn failure(name: &str, reason: impl std::fmt::Display) -> Error {
    Error::Write { path: name.into(), source: io::Error::other(reason.to_string()) }
}

/// Makes the built-in font known, once in the process; false when it cannot be read.
fn font() -> bool {
    static KNOWN: OnceLock<bool> = OnceLock::new();
    *KNOWN.get_or_init(|| register_font(FAMILY, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok())
}
