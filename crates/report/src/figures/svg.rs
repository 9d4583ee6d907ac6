//! An SVG page of curves and filled shapes.
//!
//! The SVG page of plotters is not used: it rounds to whole pixels, and its text depends on the fonts of the viewer.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::bitmap::png;
use super::canvas::{Dot, Image, Page, Run};
use super::colour::{INK, Rgb};
use super::font::{Piece, outline};
use willis_io::formats::escape;

/// An SVG page. A dot is 1/100 point.
pub struct SvgPage {
    name: &'static str,
    elements: String,
}

impl SvgPage {
    /// Dots per inch.
    pub const DPI: u32 = 7200;

    /// An empty page for the figure called `name`.
    pub fn new(name: &'static str) -> Self {
        Self { name, elements: String::new() }
    }

    /// The SVG file.
    pub fn svg(self, inches: [f64; 2]) -> String {
        let [width, height] = inches.map(|length| (length * f64::from(Self::DPI)).round() as i32);
        let [wide, high] = [width, height].map(|dots| f64::from(dots) / 100.0);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{wide}pt\" \
             height=\"{high}pt\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n<path fill=\"#fff\" d=\"M0 0H{width}V{height}H0z\"/>\n{}</svg>\n",
            self.name, self.elements
        )
    }

    fn element(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.elements, "{text}");
    }
}

impl Page for SvgPage {
    fn rectangle(&mut self, from: Dot, to: Dot, rgb: Rgb) -> Result<(), String> {
        let ((x, y), (right, bottom)) = (from, to);
        // Crisp edges leave no gap between neighbours.
        let rgb = hex(rgb);
        self.element(format_args!("<path fill=\"{rgb}\" shape-rendering=\"crispEdges\" d=\"M{x} {y}H{right}V{bottom}H{x}z\"/>"));
        Ok(())
    }

    fn path(&mut self, dots: &[Dot], width: u32, rgb: Rgb, opacity: f64) -> Result<(), String> {
        let mut d = Path::default();
        for (at, dot) in dots.iter().enumerate() {
            d.go(if at == 0 { 'M' } else { 'l' }, &[*dot]);
        }
        let closed = if dots.len() > 3 && dots.first() == dots.last() { "z" } else { "" };
        let clear = if opacity < 1.0 { format!(" stroke-opacity=\"{opacity:.3}\"") } else { String::new() };
        let (rgb, d) = (hex(rgb), d.text);
        self.element(format_args!(
            "<path fill=\"none\" stroke=\"{rgb}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{clear} d=\"{d}{closed}\"/>"
        ));
        Ok(())
    }

    fn tube(&mut self, dots: &[Dot], width: u32, rgb: Rgb) -> Result<(), String> {
        let mut d = Path::default();
        let end = dots.last().copied();
        // A single dot is a line to itself, which has round ends.
        for (at, dot) in dots.iter().copied().chain(end.filter(|_| dots.len() == 1)).enumerate() {
            d.go(if at == 0 { 'M' } else { 'l' }, &[dot]);
        }
        let (rgb, d) = (hex(rgb), d.text);
        self.element(format_args!(
            "<path fill=\"none\" stroke=\"{rgb}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" stroke-linecap=\"round\" d=\"{d}\"/>"
        ));
        Ok(())
    }

    fn text(&mut self, text: &str, size: f64, at: Dot, run: Run) -> Result<(), String> {
        // As in plotters, the base line is half of the size below the place.
        let place = |[x, y]: [f64; 2]| {
            let y = y + size / 2.0;
            let (x, y) = match run {
                Run::Right => (x, y),
                Run::Up => (y, -x),
            };
            (at.0 + x.round() as i32, at.1 + y.round() as i32)
        };
        let mut d = Path::default();
        for piece in outline(text, size) {
            match piece {
                Piece::Start(p) => d.go('M', &[place(p)]),
                Piece::Line(p) => d.go('l', &[place(p)]),
                Piece::Quadratic(points) => d.go('q', &points.map(place)),
                Piece::Cubic(points) => d.go('c', &points.map(place)),
            }
        }
        if !d.text.is_empty() {
            let (rgb, label, d) = (hex(INK), escape(text), d.text);
            self.element(format_args!("<path fill=\"{rgb}\" aria-label=\"{label}\" d=\"{d}\"/>"));
        }
        Ok(())
    }

    fn frame(&mut self, from: Dot, to: Dot, width: u32) -> Result<bool, String> {
        self.path(&[from, (to.0, from.1), to, (from.0, to.1), from], width, INK, 1.0)?;
        Ok(true)
    }

    fn ramp(&mut self, from: Dot, to: Dot, stops: &[Rgb]) -> Result<bool, String> {
        let id = format!("{}-ramp", self.name);
        let last = stops.len().saturating_sub(1).max(1) as f64;
        let stop = |(at, rgb): (usize, &Rgb)| format!("<stop offset=\"{}\" stop-color=\"{}\"/>", at as f64 / last, hex(*rgb));
        let stops: String = stops.iter().enumerate().map(stop).collect();
        let ((x, y), (right, bottom)) = (from, to);
        self.element(format_args!("<linearGradient id=\"{id}\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">{stops}</linearGradient>"));
        self.element(format_args!("<path fill=\"url(#{id})\" d=\"M{x} {y}H{right}V{bottom}H{x}z\"/>"));
        Ok(true)
    }

    fn image(&mut self, from: Dot, to: Dot, image: &dyn Fn() -> Image) -> Result<bool, String> {
        let image = image();
        let side = image.side as u32;
        // Programs older than SVG 2 need the prefix.
        let file = png([side; 2], &image.rgb, None)?;
        let ((x, y), width, height, data) = (from, to.0 - from.0, to.1 - from.1, STANDARD.encode(file));
        self.element(format_args!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
             xlink:href=\"data:image/png;base64,{data}\"/>"
        ));
        Ok(true)
    }
}

/// The commands of a path. The first place of a contour is absolute, the others are relative to the one before.
#[derive(Default)]
struct Path {
    text: String,
    at: Dot,
    last: Option<char>,
}

impl Path {
    fn go(&mut self, command: char, places: &[Dot]) {
        // A repeated command is left out. Filled contours close automatically.
        if self.last != Some(command) || command == 'M' {
            self.text.push(command);
        } else {
            self.text.push(' ');
        }
        let from = if command == 'M' { (0, 0) } else { self.at };
        let numbers = places.iter().flat_map(|p| [p.0 - from.0, p.1 - from.1]);
        for (at, number) in numbers.enumerate() {
            let between = if at == 0 || number < 0 { "" } else { " " };
            let _ = write!(self.text, "{between}{number}");
        }
        self.at = places.last().copied().unwrap_or(self.at);
        self.last = Some(command);
    }
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
