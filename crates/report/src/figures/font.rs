//! The embedded font, whose letters are outlines in bitmaps, which need no installed font.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, Point};
use tiny_skia::{Path, PathBuilder};

fn font() -> Option<&'static FontRef<'static>> {
    static FONT: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    FONT.get_or_init(|| FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).ok()).as_ref()
}

/// Each letter of a text of a size with its place along the base line, then the end; and the scale of the font. The size is from the
/// lowest descender of the font to its highest ascender.
fn letters(font: &FontRef<'_>, text: &str, size: f64) -> (Vec<(GlyphId, f64)>, f64, f64) {
    let scale = size / f64::from(font.height_unscaled());
    let (mut all, mut along) = (Vec::new(), 0.0);
    for letter in text.chars() {
        let glyph = font.glyph_id(letter);
        along += all.last().map_or(0.0, |(before, _)| f64::from(font.kern_unscaled(*before, glyph)) * scale);
        all.push((glyph, along));
        along += f64::from(font.h_advance_unscaled(glyph)) * scale;
    }
    (all, along, scale)
}

/// The size that programs call that of text of a size: the side of its em square.
pub fn em(size: f64) -> f64 {
    font().map_or(size, |font| size * f64::from(font.units_per_em().unwrap_or(1.0) / font.height_unscaled()))
}

/// The width of a line of text of a size; zero when the font cannot be read.
pub fn width(text: &str, size: f64) -> f64 {
    font().map_or(0.0, |font| letters(font, text, size).1)
}

/// The outline of a line of text of a size. `at` places its points, which are (x, y) from the beginning of the base line, with y
/// downwards. `None` where nothing is to be drawn, or the font cannot be read.
pub fn outline(text: &str, size: f64, at: impl Fn([f64; 2]) -> [f64; 2]) -> Option<Path> {
    let font = font()?;
    let (letters, _, scale) = letters(font, text, size);
    let mut path = PathBuilder::new();
    for (glyph, along) in letters {
        let place = |p: Point| at([along + f64::from(p.x) * scale, -f64::from(p.y) * scale]).map(|c| c as f32);
        let mut end = None;
        for curve in font.outline(glyph).into_iter().flat_map(|outline| outline.curves) {
            let (OutlineCurve::Line(start, _) | OutlineCurve::Quad(start, ..) | OutlineCurve::Cubic(start, ..)) = curve;
            if end != Some(start) {
                let [x, y] = place(start);
                path.move_to(x, y);
            }
            let (last, places) = match curve {
                OutlineCurve::Line(_, b) => (b, vec![b]),
                OutlineCurve::Quad(_, b, c) => (c, vec![b, c]),
                OutlineCurve::Cubic(_, b, c, d) => (d, vec![b, c, d]),
            };
            match places.into_iter().map(place).collect::<Vec<_>>()[..] {
                [[x, y]] => path.line_to(x, y),
                [[a, b], [x, y]] => path.quad_to(a, b, x, y),
                [[a, b], [c, d], [x, y]] => path.cubic_to(a, b, c, d, x, y),
                _ => {}
            }
            end = Some(last);
        }
    }
    path.finish()
}
