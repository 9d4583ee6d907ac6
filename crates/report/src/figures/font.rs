//! The embedded font: registered with plotters, and as outlines for SVG.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, OutlineCurve, Point};
use plotters::style::{FontStyle, IntoFont, register_font};

/// The name of the font in plotters.
pub const FAMILY: &str = "willis";

/// Registers the font with plotters, once per process; false when it cannot be read.
pub fn is_registered() -> bool {
    static KNOWN: OnceLock<bool> = OnceLock::new();
    *KNOWN.get_or_init(|| register_font(FAMILY, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok())
}

/// The width of a line of text of a size in dots; `None` when the font cannot be read.
pub fn width(text: &str, size: f64) -> Option<f64> {
    if !is_registered() {
        return None;
    }
    (FAMILY, size).into_font().box_size(text).ok().map(|(width, _)| f64::from(width))
}

fn font() -> Option<&'static FontRef<'static>> {
    static FONT: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    FONT.get_or_init(|| FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).ok()).as_ref()
}

/// A piece of an outline: no, one or two control points, then its end. Points are (x, y) from the beginning of the base line, with y
/// downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Piece {
    /// A new contour starts; the one before is closed.
    Start([f64; 2]),
    /// A straight line.
    Line([f64; 2]),
    /// A quadratic Bezier curve.
    Quadratic([[f64; 2]; 2]),
    /// A cubic Bezier curve.
    Cubic([[f64; 2]; 3]),
}

/// The outline of a line of text of a size in dots; empty when the font cannot be read.
///
/// As in plotters, the size is from the lowest descender of the font to its highest ascender.
pub fn outline(text: &str, size: f64) -> Vec<Piece> {
    let Some(font) = font() else { return Vec::new() };
    let scale = size / f64::from(font.height_unscaled());
    let (mut pieces, mut along, mut before) = (Vec::new(), 0.0, None);
    for letter in text.chars() {
        let glyph = font.glyph_id(letter);
        along += before.map_or(0.0, |before| f64::from(font.kern_unscaled(before, glyph)) * scale);
        let place = |p: Point| [along + f64::from(p.x) * scale, -f64::from(p.y) * scale];
        let mut end = None;
        for curve in font.outline(glyph).into_iter().flat_map(|outline| outline.curves) {
            let (start, piece, last) = match curve {
                OutlineCurve::Line(a, b) => (a, Piece::Line(place(b)), b),
                OutlineCurve::Quad(a, b, c) => (a, Piece::Quadratic([b, c].map(place)), c),
                OutlineCurve::Cubic(a, b, c, d) => (a, Piece::Cubic([b, c, d].map(place)), d),
            };
            if end != Some(start) {
                pieces.push(Piece::Start(place(start)));
            }
            pieces.push(piece);
            end = Some(last);
        }
        along += f64::from(font.h_advance_unscaled(glyph)) * scale;
        before = Some(glyph);
    }
    pieces
}
