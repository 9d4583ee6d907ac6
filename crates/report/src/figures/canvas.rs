//! The drawing surface of the figures: lines, boxes, text and ticks in points, on a bitmap or an SVG page.

use std::io;

use super::axis::Label;
use super::colour::{GRID, INK, Rgb};
use super::font;
use super::style::{HAIR, POINTS_PER_INCH, TEXT, TICK, TITLE, TITLE_AT};
use willis_core::error::{Error, Result};

/// Height of the digits as a share of the text's.
const DIGIT: f64 = 0.6;
/// Height of an exponent as a share of the text's.
const EXPONENT: f64 = 0.72;
/// How far an exponent is raised, as a share of the text's height.
const LIFT: f64 = 0.3;

/// A place on the page, points from its upper left corner.
pub type Place = [f64; 2];

/// Which point of the text is at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Its beginning.
    Begin,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// The direction of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Run {
    /// From left to right.
    Right,
    /// Upwards.
    Up,
}

/// A place on the page in dots from its upper left corner.
pub type Dot = (i32, i32);

/// A square image, row by row from the top.
pub struct Image {
    /// Pixels along a side.
    pub side: usize,
    /// Red, green and blue of each.
    pub rgb: Vec<u8>,
}

impl Image {
    /// An image of one colour.
    pub fn new(side: usize, rgb: Rgb) -> Self {
        Self { side, rgb: rgb.repeat(side * side) }
    }

    /// Fills pixels: `corner` (x, y), `size` (width, height).
    pub fn fill(&mut self, corner: [usize; 2], size: [usize; 2], rgb: Rgb) {
        for row in corner[1]..corner[1] + size[1] {
            let start = (row * self.side + corner[0]) * 3;
            for pixel in self.rgb[start..start + 3 * size[0]].chunks_exact_mut(3) {
                pixel.copy_from_slice(&rgb);
            }
        }
    }
}

/// A kind of page: a bitmap or SVG.
///
/// The last three functions return whether they drew anything. Where a page does not support them, lines and rectangles do the work.
pub trait Page {
    /// Fills a rectangle.
    fn rectangle(&mut self, from: Dot, to: Dot, rgb: Rgb) -> Result<(), String>;
    /// A line through two or more dots.
    fn path(&mut self, dots: &[Dot], width: u32, rgb: Rgb, opacity: f64) -> Result<(), String>;
    /// A line through one or more dots with round corners and ends.
    fn tube(&mut self, dots: &[Dot], width: u32, rgb: Rgb) -> Result<(), String>;
    /// A line of text, with its base line half of its size below the place.
    fn text(&mut self, text: &str, size: f64, at: Dot, run: Run) -> Result<(), String>;
    /// The outline of a rectangle.
    fn frame(&mut self, _from: Dot, _to: Dot, _width: u32) -> Result<bool, String> {
        Ok(false)
    }
    /// A colour gradient from bottom to top.
    fn ramp(&mut self, _from: Dot, _to: Dot, _stops: &[Rgb]) -> Result<bool, String> {
        Ok(false)
    }
    /// An image in a rectangle.
    fn image(&mut self, _from: Dot, _to: Dot, _image: &dyn Fn() -> Image) -> Result<bool, String> {
        Ok(false)
    }
}

/// A page whose unit is the point (1/72 inch), at any resolution.
pub struct Sheet<'a> {
    page: &'a mut dyn Page,
    name: &'static str,
    dpi: u32,
    /// Dots along the side of a pixel.
    fine: u32,
}

impl<'a> Sheet<'a> {
    /// The page of the figure called `name`, of `dpi` pixels an inch and `fine` dots along a pixel.
    pub fn new(page: &'a mut dyn Page, name: &'static str, dpi: u32, fine: u32) -> Self {
        Self { page, name, dpi, fine }
    }

    /// The number of pixels nearest to a length in points.
    pub fn pixels(&self, points: f64) -> usize {
        (points * f64::from(self.dpi) / POINTS_PER_INCH).round() as usize
    }

    /// A length in pixels in points.
    pub fn points(&self, pixels: usize) -> f64 {
        pixels as f64 * POINTS_PER_INCH / f64::from(self.dpi)
    }

    /// Fills pixels: `corner` (x, y), `size` (width, height), both in pixels.
    pub fn fill(&mut self, corner: [usize; 2], size: [usize; 2], rgb: Rgb) -> Result<()> {
        let [from, to] = self.whole(corner, size);
        self.draw(|page| page.rectangle(from, to, rgb))
    }

    /// Fills pixels with a colour gradient from bottom to top; false where the page does not support it.
    pub fn ramp(&mut self, corner: [usize; 2], size: [usize; 2], stops: &[Rgb]) -> Result<bool> {
        let [from, to] = self.whole(corner, size);
        self.draw(|page| page.ramp(from, to, stops))
    }

    /// Draws an image on pixels; false where the page does not support it.
    pub fn image(&mut self, corner: [usize; 2], size: [usize; 2], image: &dyn Fn() -> Image) -> Result<bool> {
        let [from, to] = self.whole(corner, size);
        self.draw(|page| page.image(from, to, image))
    }

    /// A line along `path`, `width` points wide, `opacity` in (0, 1].
    pub fn line(&mut self, path: impl IntoIterator<Item = Place>, width: f64, rgb: Rgb, opacity: f64) -> Result<()> {
        let mut dots: Vec<_> = path.into_iter().map(|p| self.dot(p)).collect();
        dots.dedup();
        if dots.len() < 2 {
            return Ok(());
        }
        let width = self.stroke(width);
        self.draw(|page| page.path(&dots, width, rgb, opacity))
    }

    /// A line along `path` with round corners and ends, `width` points wide.
    pub fn tube(&mut self, path: impl IntoIterator<Item = Place>, width: f64, rgb: Rgb) -> Result<()> {
        let mut dots: Vec<_> = path.into_iter().map(|p| self.dot(p)).collect();
        dots.dedup();
        let width = self.stroke(width);
        self.draw(|page| page.tube(&dots, width, rgb))
    }

    /// A straight dashed line: dashes of 4 points, gaps of 3.
    pub fn dashes(&mut self, ends: [Place; 2], width: f64, rgb: Rgb) -> Result<()> {
        self.dashed(ends, width, rgb)
    }

    /// A dashed line along `path`: dashes of 4 points, gaps of 3.
    pub fn dashed(&mut self, path: impl IntoIterator<Item = Place>, width: f64, rgb: Rgb) -> Result<()> {
        const DASH: [f64; 2] = [4.0, 3.0];
        let mut path = path.into_iter();
        let Some(mut at) = path.next() else { return Ok(()) };
        // What is left of the dash (first) or the gap, and the dash so far.
        let (mut gap, mut left, mut dash) = (0, DASH[0], vec![at]);
        for to in path {
            loop {
                let length = (to[0] - at[0]).hypot(to[1] - at[1]);
                if length <= left {
                    (left, at) = (left - length, to);
                    dash.push(to);
                    break;
                }
                at = [0, 1].map(|axis| at[axis] + (to[axis] - at[axis]) * left / length);
                dash.push(at);
                if gap == 0 {
                    self.line(dash, width, rgb, 1.0)?;
                }
                (gap, dash) = (1 - gap, vec![at]);
                left = DASH[gap];
            }
        }
        if gap == 0 { self.line(dash, width, rgb, 1.0) } else { Ok(()) }
    }

    /// Fills a rectangle of any corner and size (width, height), points.
    pub fn rectangle(&mut self, corner: Place, size: [f64; 2], rgb: Rgb) -> Result<()> {
        let (from, to) = (self.dot(corner), self.dot([corner[0] + size[0], corner[1] + size[1]]));
        self.draw(|page| page.rectangle(from, to, rgb))
    }

    /// The outline of a rectangle of a corner and size (width, height).
    pub fn frame(&mut self, [left, top]: Place, [width, height]: [f64; 2]) -> Result<()> {
        let (right, bottom) = (left + width, top + height);
        let (from, to, hair) = (self.dot([left, top]), self.dot([right, bottom]), self.stroke(HAIR));
        if self.draw(|page| page.frame(from, to, hair))? {
            return Ok(());
        }
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

    /// The title of a figure, from `x`, the left edge of its axes.
    pub fn title(&mut self, text: &str, x: f64) -> Result<()> {
        self.text(&Label::plain(text), [x, TITLE_AT], TITLE, Align::Begin, Run::Right)
    }

    /// Plain text.
    pub fn plain(&mut self, text: &str, place: Place, align: Align) -> Result<()> {
        self.text(&Label::plain(text), place, TEXT, align, Run::Right)
    }

    /// Plain text that runs upwards, around `place`.
    pub fn upright(&mut self, text: &str, place: Place) -> Result<()> {
        self.text(&Label::plain(text), place, TEXT, Align::Middle, Run::Up)
    }

    /// Ticks at heights left of the axes, with grid lines between `left` and `right`.
    pub fn ticks_left(&mut self, [left, right]: [f64; 2], ticks: impl IntoIterator<Item = (f64, Label)>) -> Result<()> {
        for (y, label) in ticks {
            self.line([[left, y], [right, y]], HAIR, GRID, 1.0)?;
            self.line([[left - TICK, y], [left, y]], HAIR, INK, 1.0)?;
            self.text(&label, [left - TICK - 3.0, y], TEXT, Align::End, Run::Right)?;
        }
        Ok(())
    }

    /// Ticks below the axes, with grid lines between `top` and `bottom`.
    pub fn ticks_below(&mut self, [top, bottom]: [f64; 2], ticks: impl IntoIterator<Item = (f64, Label)>) -> Result<()> {
        for (x, label) in ticks {
            self.line([[x, top], [x, bottom]], HAIR, GRID, 1.0)?;
            self.line([[x, bottom], [x, bottom + TICK]], HAIR, INK, 1.0)?;
            self.text(&label, [x, bottom + TICK + 7.0], TEXT, Align::Middle, Run::Right)?;
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
            let at = match run {
                Run::Right => (at.0 + along, at.1 + across),
                Run::Up => (at.0 + across, at.1 - along),
            };
            self.draw(|page| page.text(text, size, at, run))?;
        }
        Ok(())
    }

    /// The width of text without an exponent, points.
    pub fn text_width(&self, text: &str, height: f64) -> Result<f64> {
        Ok(self.width(text, self.dots_in(height))? / self.dots_in(1.0))
    }

    fn dots_in(&self, points: f64) -> f64 {
        points * f64::from(self.dpi * self.fine) / POINTS_PER_INCH
    }

    fn dot(&self, place: Place) -> Dot {
        let [x, y] = place.map(|points| self.dots_in(points).round() as i32);
        (x, y)
    }

    /// The width of a line in dots.
    fn stroke(&self, points: f64) -> u32 {
        (self.dots_in(points).round() as u32).max(1)
    }

    /// The corners of pixels, in dots.
    fn whole(&self, corner: [usize; 2], size: [usize; 2]) -> [Dot; 2] {
        let dot = |pixel: usize| (pixel * self.fine as usize) as i32;
        [(dot(corner[0]), dot(corner[1])), (dot(corner[0] + size[0]), dot(corner[1] + size[1]))]
    }

    fn width(&self, text: &str, size: f64) -> Result<f64> {
        font::width(text, size).ok_or_else(|| self.failure("the built-in font cannot be read"))
    }

    fn draw<T>(&mut self, mark: impl FnOnce(&mut dyn Page) -> Result<T, String>) -> Result<T> {
        mark(self.page).map_err(|reason| self.failure(reason))
    }

    fn failure(&self, reason: impl Into<String>) -> Error {
        Error::Write { path: self.name.into(), source: io::Error::other(reason.into()) }
    }
}
