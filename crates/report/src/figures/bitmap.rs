//! A bitmap page: dots drawn by plotters, averaged into the pixels of a PNG.

use std::fmt::Display;

use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{Color, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use super::canvas::{Dot, Page, Run};
use super::colour::{INK, PAPER, Rgb};
use super::font::FAMILY;

const METRES_PER_INCH: f64 = 0.0254;

/// A bitmap page. Each pixel is a square of dots.
pub struct Bitmap {
    pixels: [u32; 2],
    /// Dots along the side of a pixel.
    fine: u32,
    rgb: Vec<u8>,
}

impl Bitmap {
    /// A white page.
    pub fn new(pixels: [u32; 2], fine: u32) -> Self {
        let dots = pixels.map(|p| (p * fine) as usize);
        Self { pixels, fine, rgb: PAPER.repeat(dots[0] * dots[1]) }
    }

    /// The PNG file: 8-bit RGB, with the resolution.
    pub fn png(&self, dpi: u32) -> Result<Vec<u8>, String> {
        let per_metre = (f64::from(dpi) / METRES_PER_INCH).round() as u32;
        png(self.pixels, &self.averaged(), Some(per_metre))
    }

    /// The pixels, each the mean of its dots.
    fn averaged(&self) -> Vec<u8> {
        let [width, height] = self.pixels.map(|p| p as usize);
        let fine = self.fine as usize;
        let count = (fine * fine) as u32;
        let mut image = Vec::with_capacity(width * height * 3);
        let mut sums = vec![0_u32; width * 3];
        for rows in self.rgb.chunks_exact(width * fine * 3 * fine) {
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

    fn draw<E: Display>(&mut self, stroke: impl FnOnce(&mut BitMapBackend<'_>) -> Result<(), E>) -> Result<(), String> {
        let [width, height] = self.pixels.map(|p| p * self.fine);
        stroke(&mut BitMapBackend::with_buffer(&mut self.rgb, (width, height))).map_err(|error| error.to_string())
    }
}

impl Page for Bitmap {
    fn rectangle(&mut self, from: Dot, to: Dot, rgb: Rgb) -> Result<(), String> {
        self.draw(|page| page.draw_rect(from, to, &ink(rgb, 1.0), true))
    }

    fn path(&mut self, dots: &[Dot], width: u32, rgb: Rgb, opacity: f64) -> Result<(), String> {
        self.draw(|page| page.draw_path(dots.iter().copied(), &ink(rgb, opacity).stroke_width(width)))
    }

    /// plotters draws long spikes at sharp corners of a thick line, so that here each straight stretch and each corner is drawn by itself.
    fn tube(&mut self, dots: &[Dot], width: u32, rgb: Rgb) -> Result<(), String> {
        let half = f64::from(width) / 2.0;
        for (at, dot) in dots.iter().enumerate() {
            self.draw(|page| page.draw_circle(*dot, half.round() as u32, &ink(rgb, 1.0), true))?;
            let Some(next) = dots.get(at + 1) else { continue };
            let [x, y] = [f64::from(next.0 - dot.0), f64::from(next.1 - dot.1)];
            let aside = |(x, y): Dot, side: f64, across: [f64; 2]| {
                (x + (side * across[0]).round() as i32, y + (side * across[1]).round() as i32)
            };
            let across = [-y, x].map(|c| half * c / x.hypot(y).max(f64::MIN_POSITIVE));
            let corners = [(*dot, 1.0), (*next, 1.0), (*next, -1.0), (*dot, -1.0)].map(|(dot, side)| aside(dot, side, across));
            self.draw(|page| page.fill_polygon(corners, &ink(rgb, 1.0)))?;
        }
        Ok(())
    }

    fn text(&mut self, text: &str, size: f64, at: Dot, run: Run) -> Result<(), String> {
        let turn = match run {
            Run::Right => FontTransform::None,
            Run::Up => FontTransform::Rotate270,
        };
        let style = TextStyle::from((FAMILY, size).into_font()).color(&RGBColor(INK[0], INK[1], INK[2])).transform(turn);
        self.draw(|page| page.draw_text(text, &style, at))
    }
}

fn ink(rgb: Rgb, opacity: f64) -> ShapeStyle {
    RGBColor(rgb[0], rgb[1], rgb[2]).mix(opacity).filled()
}

/// An 8-bit RGB image, row by row from the top, as a PNG file.
pub fn png(pixels: [u32; 2], rgb: &[u8], per_metre: Option<u32>) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, pixels[0], pixels[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(per_metre.map(|n| png::PixelDimensions { xppu: n, yppu: n, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(rgb).and_then(|()| writer.finish()).map_err(|error| error.to_string())?;
    Ok(file)
}
