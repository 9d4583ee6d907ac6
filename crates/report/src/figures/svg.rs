//! A sheet as SVG: curves, filled shapes, and text that other programs can edit.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use tiny_skia::{Path, PathSegment};

use super::bitmap::image;
use super::colour::{INK, MAP, Rgb};
use super::font;
use super::sheet::{Align, EXPONENT, FilledBox, LIFT, LineStyle, Mark, SheetPlace, TextDirection, Words};
use super::style::{DASH, POINTS_PER_INCH};
use willis_io::formats::escape;

/// The units of a point. Coordinates are whole numbers.
const UNITS: f64 = 100.0;
/// The font of the bitmaps, and those that stand in for it.
const FONTS: &str = "Ubuntu, Arial, Helvetica, 'Liberation Sans', sans-serif";
/// The largest number of boxes in a matrix; beyond it they are one image ...
const BOXES: usize = 4000;
/// ... of this side in pixels.
const IMAGE: u32 = 1325;

/// The SVG file of some marks, for the figure called `name`. A browser prints it on a page of its size.
pub fn svg(name: &str, inches: [f64; 2], marks: &[Mark]) -> Result<String, String> {
    let [wide, high] = inches.map(|length| units(length * POINTS_PER_INCH));
    let [width, height] = [wide, high].map(|length| f64::from(length) / UNITS);
    let mut file = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{width}pt\" \
         height=\"{height}pt\" viewBox=\"0 0 {wide} {high}\" role=\"img\" aria-label=\"{name}\">\n\
         <style>@page{{size:{width}pt {height}pt;margin:0}}</style>\n<path fill=\"#fff\" d=\"M0 0H{wide}V{high}H0z\"/>\n"
    );
    for mark in marks {
        file += &element(name, mark)?;
    }
    Ok(file + "</svg>\n")
}

fn element(name: &str, mark: &Mark) -> Result<String, String> {
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
        Mark::Text(_, words) => text(words),
    })
}

/// Text in the font of the bitmaps where a viewer has it, or in one about as wide.
fn text(Words { label, place, height, align, run }: &Words) -> String {
    let [x, y] = place.map(units);
    let size = |height| units(font::em(height));
    let anchor = match align {
        Align::Begin => "",
        Align::Middle => " text-anchor=\"middle\"",
        Align::End => " text-anchor=\"end\"",
    };
    let turned = if *run == TextDirection::Up { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
    let (up, small) = (-units(height * LIFT), size(height * EXPONENT));
    let raised = match &*label.exponent {
        "" => String::new(),
        exponent => format!("<tspan dy=\"{up}\" font-size=\"{small}\">{exponent}</tspan>"),
    };
    let (fill, size, text) = (hex(INK), size(*height), escape(&label.text));
    let font = format!("font-family=\"{FONTS}\" font-weight=\"300\" font-size=\"{size}\"");
    format!("<text x=\"{x}\" y=\"{y}\" fill=\"{fill}\" {font}{anchor}{turned}>{text}{raised}</text>\n")
}

/// Boxes as one image. Programs older than SVG 2 need the prefix.
fn embedded(boxes: &[FilledBox]) -> Result<String, String> {
    let Some(([from, to], _)) = boxes.first() else { return Ok(String::new()) };
    let ([x, y], [right, bottom]) = (from.map(units), to.map(units));
    let (place, data) = (format!("x=\"{x}\" y=\"{y}\""), STANDARD.encode(image(boxes, IMAGE)?));
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
fn commands(path: &Path) -> String {
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
