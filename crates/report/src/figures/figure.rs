//! One figure, which is written as PNG at any resolution, and as SVG: curves, filled shapes, and text that other programs can edit.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use tiny_skia::{
    Color, FillRule, GradientStop, LineCap, LineJoin, LinearGradient, Paint, PathSegment, Pixmap, Point, PremultipliedColorU8,
    Rect, Shader, SpreadMode, Stroke, StrokeDash, Transform,
};

use super::sheet::{Align, DASH, EXPONENT, FilledBox, LIFT, LineStyle, Mark, POINTS_PER_INCH, Sheet, SheetPlace, em};
use super::{INK, MAP, Rgb};
use willis_core::error::{Error, Result, require};
use willis_io::output::write_file;

/// The default resolution, pixels per inch.
pub const DEFAULT_DPI: u32 = 150;

const DPI: std::ops::RangeInclusive<u32> = 36..=1200;

/// How an output folder is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SaveOptions {
    /// Resolution of the pictures, dots an inch, 36 to 1200.
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
        let accepted = format!("expected a number from {} to {}", DPI.start(), DPI.end());
        require(DPI.contains(&self.dpi), "dpi", self.dpi, accepted)
    }
}

/// A figure that can be written in any format.
pub struct Figure {
    name: &'static str,
    pub(crate) inches: [f64; 2],
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

    /// The PNG file, 8-bit RGB, with its resolution: `dpi` pixels per inch (36 to 1200).
    ///
    /// # Errors
    ///
    /// When `dpi` is out of range.
    pub fn png(&self, dpi: u32) -> Result<Vec<u8>> {
        SaveOptions { dpi }.validate()?;
        let [width, height] = self.inches.map(|length| (length * f64::from(dpi)).round() as u32);
        let drawn = page(width, height).and_then(|mut page| {
            for mark in &self.sheet.marks {
                draw(&mut page, mark, f64::from(dpi) / POINTS_PER_INCH);
            }
            encoded(&page, Some((f64::from(dpi) / METRES_PER_INCH).round() as u32))
        });
        drawn.map_err(|source| self.failure(source))
    }

    /// The SVG file. Its text is text, which other programs can edit, in the font of the bitmap or in one about as wide. It refers to no other
    /// file. Its ids begin with the name of the figure, so that one page can hold several figures. A browser prints it on a page of its size.
    ///
    /// One unit is 1/100 point (1/7200 inch); coordinates are whole numbers.
    ///
    /// # Errors
    ///
    /// When an image in it cannot be made.
    pub fn svg(&self) -> Result<String> {
        let name = self.name;
        let [wide, high] = self.inches.map(|length| units(length * POINTS_PER_INCH));
        let [width, height] = [wide, high].map(|length| f64::from(length) / UNITS);
        let mut file = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{width}pt\" \
             height=\"{height}pt\" viewBox=\"0 0 {wide} {high}\" role=\"img\" aria-label=\"{name}\">\n\
             <style>@page{{size:{width}pt {height}pt;margin:0}}</style>\n<path fill=\"#fff\" d=\"M0 0H{wide}V{high}H0z\"/>\n"
        );
        for mark in &self.sheet.marks {
            file += &element(name, mark).map_err(|source| self.failure(source))?;
        }
        Ok(file + "</svg>\n")
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

    fn failure(&self, source: io::Error) -> Error {
        Error::Write { path: self.name.into(), source }
    }
}

const METRES_PER_INCH: f64 = 0.0254;

/// A white page of a size in pixels.
fn page(width: u32, height: u32) -> io::Result<Pixmap> {
    let mut page = Pixmap::new(width, height).ok_or_else(|| io::Error::other("it is too large"))?;
    page.fill(Color::WHITE);
    Ok(page)
}

fn draw(page: &mut Pixmap, mark: &Mark, scale: f64) {
    let to_pixels = Transform::from_scale(scale as f32, scale as f32);
    match mark {
        Mark::Boxes(boxes) => fill(page, boxes, [0.0; 2], scale),
        Mark::Map([from, to]) => {
            let [left, top, right, bottom] = [from[0], from[1], to[0], to[1]].map(|c| c as f32);
            let last = (MAP.len() - 1) as f32;
            let stops = MAP.iter().enumerate().map(|(at, rgb)| GradientStop::new(at as f32 / last, colour(*rgb, 1.0)));
            let ends = [bottom, top].map(|y| Point::from_xy(left, y));
            let shader = LinearGradient::new(ends[0], ends[1], stops.collect(), SpreadMode::Pad, Transform::identity());
            if let Some((shader, rectangle)) = shader.zip(Rect::from_ltrb(left, top, right, bottom)) {
                page.fill_rect(rectangle, &Paint { shader, ..Paint::default() }, to_pixels, None);
            }
        }
        Mark::Line(path, line, width, rgb, opacity) => {
            let stroke = Stroke {
                width: *width as f32,
                line_cap: if *line == LineStyle::Tube { LineCap::Round } else { LineCap::Butt },
                line_join: LineJoin::Round,
                dash: (*line == LineStyle::Dashed).then(|| StrokeDash::new(DASH.to_vec(), 0.0)).flatten(),
                ..Stroke::default()
            };
            page.stroke_path(path, &paint(*rgb, *opacity), &stroke, to_pixels, None);
        }
        Mark::Text { outline, .. } => {
            if let Some(outline) = outline {
                page.fill_path(outline, &paint(INK, 1.0), FillRule::Winding, to_pixels, None);
            }
        }
    }
}

/// Fills whole pixels, at least one for each box.
fn fill(page: &mut Pixmap, boxes: &[FilledBox], corner: SheetPlace, scale: f64) {
    let [width, height] = [page.width(), page.height()].map(|side| side as usize);
    for ([from, to], [r, g, b]) in boxes {
        let Some(rgb) = PremultipliedColorU8::from_rgba(*r, *g, *b, u8::MAX) else { continue };
        let edges = |axis: usize, side: usize| {
            let [low, high] = [from, to].map(|place| ((place[axis] - corner[axis]) * scale).round() as usize);
            let low = low.min(side.saturating_sub(1));
            low..high.clamp(low + usize::from(from[axis] < to[axis]), side)
        };
        for row in edges(1, height) {
            let across = edges(0, width);
            page.pixels_mut()[row * width + across.start..row * width + across.end].fill(rgb);
        }
    }
}

fn colour([r, g, b]: Rgb, opacity: f64) -> Color {
    Color::from_rgba8(r, g, b, (opacity * 255.0).round() as u8)
}

fn paint(rgb: Rgb, opacity: f64) -> Paint<'static> {
    Paint { shader: Shader::SolidColor(colour(rgb, opacity)), ..Paint::default() }
}

/// A page as a PNG file: 8-bit RGB.
fn encoded(page: &Pixmap, per_metre: Option<u32>) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, page.width(), page.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(per_metre.map(|n| png::PixelDimensions { xppu: n, yppu: n, unit: png::Unit::Meter }));
    // Figures have large even parts, which filters do not make smaller.
    encoder.set_filter(png::Filter::NoFilter);
    let rgb: Vec<[u8; 3]> = page.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb.as_flattened())?;
    writer.finish()?;
    Ok(file)
}

/// The units of a point. Coordinates are whole numbers.
const UNITS: f64 = 100.0;
/// The font of the bitmaps, and those that stand in for it.
const FONTS: &str = "Ubuntu, Arial, Helvetica, 'Liberation Sans', sans-serif";
/// The largest number of boxes in a matrix; beyond it they are one image ...
const BOXES: usize = 4000;
/// ... of this side in pixels.
const IMAGE: u32 = 1325;

fn element(name: &str, mark: &Mark) -> io::Result<String> {
    Ok(match mark {
        Mark::Boxes(boxes) if boxes.len() > BOXES => embedded(boxes)?,
        Mark::Boxes(boxes) => {
            // Crisp edges leave no gap between neighbours.
            let each = |same: &[FilledBox]| {
                let (fill, shapes) = (hex(same[0].1), same.iter().map(|(corners, _)| rectangle(corners)).collect::<String>());
                format!("<path fill=\"{fill}\" shape-rendering=\"crispEdges\" d=\"{shapes}\"/>\n")
            };
            boxes.chunk_by(|a, b| a.1 == b.1).map(each).collect()
        }
        Mark::Map(corners) => {
            let last = (MAP.len() - 1) as f64;
            let stop = |(at, rgb): (usize, &Rgb)| format!("<stop offset=\"{}\" stop-color=\"{}\"/>", at as f64 / last, hex(*rgb));
            let (stops, shape) = (MAP.iter().enumerate().map(stop).collect::<String>(), rectangle(corners));
            format!(
                "<linearGradient id=\"{name}-ramp\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">{stops}</linearGradient>\n\
                 <path fill=\"url(#{name}-ramp)\" d=\"{shape}\"/>\n"
            )
        }
        Mark::Line(path, line, width, rgb, opacity) => {
            let clear = if *opacity < 1.0 { format!(" stroke-opacity=\"{opacity:.3}\"") } else { String::new() };
            let shape = match line {
                LineStyle::Solid => String::new(),
                LineStyle::Dashed => format!(" stroke-dasharray=\"{} {}\"", units(DASH[0].into()), units(DASH[1].into())),
                LineStyle::Tube => " stroke-linecap=\"round\"".to_owned(),
            };
            let (rgb, width, places) = (hex(*rgb), units(*width).max(1), commands(path));
            let stroke = format!("stroke=\"{rgb}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{shape}{clear}");
            format!("<path fill=\"none\" {stroke} d=\"{places}\"/>\n")
        }
        // In the font of the bitmaps where a viewer has it, or in one about as wide.
        Mark::Text { label, place, height, align, is_upright, .. } => {
            let [x, y] = place.map(units);
            let size = |height| units(em(height));
            let anchor = match align {
                Align::Begin => "",
                Align::Middle => " text-anchor=\"middle\"",
                Align::End => " text-anchor=\"end\"",
            };
            let turned = if *is_upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
            let (up, small) = (-units(height * LIFT), size(height * EXPONENT));
            let raised = match &*label.exponent {
                "" => String::new(),
                exponent => format!("<tspan dy=\"{up}\" font-size=\"{small}\">{exponent}</tspan>"),
            };
            let (fill, size, text) = (hex(INK), size(*height), willis_io::formats::escape(&label.text));
            let font = format!("font-family=\"{FONTS}\" font-weight=\"300\" font-size=\"{size}\"");
            format!("<text x=\"{x}\" y=\"{y}\" fill=\"{fill}\" {font}{anchor}{turned}>{text}{raised}</text>\n")
        }
    })
}

/// Boxes as one image, which the first of them fills. Programs older than SVG 2 need the prefix.
fn embedded(boxes: &[FilledBox]) -> io::Result<String> {
    let Some(([from, to], _)) = boxes.first() else { return Ok(String::new()) };
    let ([x, y], [right, bottom]) = (from.map(units), to.map(units));
    let mut page = page(IMAGE, IMAGE)?;
    fill(&mut page, boxes, *from, f64::from(IMAGE) / (to[0] - from[0]));
    let (place, data) = (format!("x=\"{x}\" y=\"{y}\""), STANDARD.encode(encoded(&page, None)?));
    let size = format!("width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"", right - x, bottom - y);
    Ok(format!("<image {place} {size} xlink:href=\"data:image/png;base64,{data}\"/>\n"))
}

/// Points in units of the files.
pub fn units(points: f64) -> i32 {
    (UNITS * points).round() as i32
}

fn rectangle([from, to]: &[SheetPlace; 2]) -> String {
    let ([x, y], [right, bottom]) = (from.map(units), to.map(units));
    format!("M{x} {y}H{right}V{bottom}H{x}z")
}

/// The commands of a path. The first place of a contour is absolute, the others are relative to the one before; a repeated command is
/// left out.
fn commands(path: &tiny_skia::Path) -> String {
    let (mut text, mut at, mut last) = (String::new(), [0, 0], None);
    for segment in path.segments() {
        let (command, places) = match segment {
            PathSegment::MoveTo(p) => ('M', vec![p]),
            PathSegment::LineTo(p) => ('l', vec![p]),
            PathSegment::QuadTo(a, p) => ('q', vec![a, p]),
            PathSegment::CubicTo(a, b, p) => ('c', vec![a, b, p]),
            PathSegment::Close => ('z', Vec::new()),
        };
        text.push(if last == Some(command) && command != 'M' { ' ' } else { command });
        let from = if command == 'M' { [0, 0] } else { at };
        let places: Vec<[i32; 2]> = places.iter().map(|p| [p.x, p.y].map(|c| units(c.into()))).collect();
        for (row, number) in places.iter().flat_map(|p| [p[0] - from[0], p[1] - from[1]]).enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(text, "{}{number}", if row == 0 || number < 0 { "" } else { " " });
        }
        at = places.last().copied().unwrap_or(at);
        last = Some(command);
    }
    text
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
