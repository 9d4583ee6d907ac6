//! Legends: what a key shows, and keys with their texts in a row.

use super::colour::{INK, Rgb};
use super::font;
use super::sheet::{Align, Sheet, SheetPlace};
use super::style::{LEGEND_AT, TEXT};

/// What a legend shows of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LegendKey {
    /// A line of a width in points.
    Line(f64),
    /// A dashed line of a width in points.
    Dashes(f64),
    /// A filled box.
    Box,
}

/// Size of a key, the space before its text, and between two entries, points.
const KEY: [f64; 2] = [18.0, 8.0];
const SPACE: f64 = 5.0;
const APART: f64 = 18.0;

/// One entry of a legend, with the left and middle of its key at a place; returns its width.
pub fn key(sheet: &mut Sheet, [x, y]: SheetPlace, text: &str, key: LegendKey, rgb: Rgb) -> f64 {
    let ends = [[x, y], [x + KEY[0], y]];
    match key {
        LegendKey::Line(width) => sheet.line(ends, width.max(1.5), rgb, 1.0),
        LegendKey::Dashes(width) => sheet.dashed(ends, width, rgb),
        LegendKey::Box => sheet.rectangle([x, y - KEY[1] / 2.0], KEY, rgb),
    }
    sheet.plain(text, [x + KEY[0] + SPACE, y], Align::Begin);
    KEY[0] + SPACE + font::width(text, TEXT)
}

/// A legend in a row below the title, from the left edge of the axes.
pub fn legend(sheet: &mut Sheet, left: f64, entries: &[(&str, LegendKey, Rgb)]) {
    let mut x = left;
    for (text, kind, rgb) in entries {
        x += key(sheet, [x, LEGEND_AT], text, *kind, *rgb) + APART;
    }
}

/// The key of the line that everything else is compared with.
pub const REFERENCE: (LegendKey, Rgb) = (LegendKey::Dashes(1.2), INK);
