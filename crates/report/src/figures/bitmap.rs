//! A sheet as a bitmap: a PNG file.

use tiny_skia::{
    Color, FillRule, GradientStop, LineCap, LineJoin, LinearGradient, Paint, Pixmap, Point, PremultipliedColorU8, Rect,
    SpreadMode, Stroke, StrokeDash, Transform,
};

use super::colour::{INK, MAP, Rgb};
use super::sheet::{FilledBox, LineStyle, Mark, SheetPlace};
use super::style::{DASH, POINTS_PER_INCH};

const METRES_PER_INCH: f64 = 0.0254;

/// The PNG file of some marks: 8-bit RGB, with its resolution.
pub fn png(inches: [f64; 2], marks: &[Mark], dpi: u32) -> Result<Vec<u8>, String> {
    let [width, height] = inches.map(|length| (length * f64::from(dpi)).round() as u32);
    let mut page = page(width, height)?;
    let scale = f64::from(dpi) / POINTS_PER_INCH;
    for mark in marks {
        draw(&mut page, mark, scale);
    }
    encoded(&page, Some((f64::from(dpi) / METRES_PER_INCH).round() as u32))
}

/// Boxes as a PNG file of a side in pixels. The first of them fills it.
pub fn image(boxes: &[FilledBox], side: u32) -> Result<Vec<u8>, String> {
    let mut page = page(side, side)?;
    if let Some(([corner, to], _)) = boxes.first() {
        fill(&mut page, boxes, *corner, f64::from(side) / (to[0] - corner[0]));
    }
    encoded(&page, None)
}

/// A white page of a size in pixels.
fn page(width: u32, height: u32) -> Result<Pixmap, String> {
    let mut page = Pixmap::new(width, height).ok_or("it is too large")?;
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
        Mark::Text(outline, _) => {
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
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(colour(rgb, opacity));
    paint
}

/// A page as a PNG file: 8-bit RGB.
fn encoded(page: &Pixmap, per_metre: Option<u32>) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, page.width(), page.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(per_metre.map(|n| png::PixelDimensions { xppu: n, yppu: n, unit: png::Unit::Meter }));
    // Figures have large even parts, which filters do not make smaller.
    encoder.set_filter(png::Filter::NoFilter);
    let rgb: Vec<[u8; 3]> = page.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(rgb.as_flattened()).and_then(|()| writer.finish()).map_err(|error| error.to_string())?;
    Ok(file)
}
