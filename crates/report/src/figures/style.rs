//! The style that all figures share: sizes of text and lines, where titles and legends stand, and names that fit a width.

use super::font;

/// Places and lengths on a page are in points.
pub const POINTS_PER_INCH: f64 = 72.0;
/// Height of text, points.
pub const TEXT: f64 = 10.0;
/// Height of numbers at marks and of names in tight places, points.
pub const SMALL: f64 = 8.0;
/// Height of a title, points.
pub const TITLE: f64 = 12.0;
/// Height of the middle of a title, points.
pub const TITLE_AT: f64 = 15.0;
/// Height of the middle of a legend, points.
pub const LEGEND_AT: f64 = 36.0;
/// Width of axes and ticks, points.
pub const HAIR: f64 = 0.6;
/// Width of a curve, and of one that matters most, points.
pub const CURVE: f64 = 1.0;
/// The line that everything else is compared with, points.
pub const BOLD: f64 = 1.8;
/// Lengths of a dash and of the gap after it, points.
pub const DASH: [f32; 2] = [4.0, 3.0];
/// Length of a tick, points.
pub const TICK: f64 = 4.0;
/// The name of the axis below stands so far below its ticks, points.
pub const NAME_BELOW: f64 = 25.0;
/// The middle of the upright name of an axis, points from the left edge.
pub const NAME_LEFT: f64 = 9.0;

/// More letters than fit, even narrow ones.
const MOST_LETTERS: usize = 200;

/// A font that stands in for that of the bitmaps is so much wider at the most.
const WIDER: f64 = 1.16;

/// The room that a text needs in any of the fonts, points.
pub fn room(text: &str, height: f64) -> f64 {
    WIDER * font::width(text, height)
}

/// A name without its middle where it needs more room than `most` points.
pub fn fitting(name: &str, most: f64, height: f64) -> String {
    let letters: Vec<char> = name.chars().collect();
    let shortened = |kept: usize| {
        let (first, last) = (&letters[..kept.div_ceil(2)], &letters[letters.len() - kept / 2..]);
        first.iter().chain(&['\u{2026}']).chain(last).collect::<String>()
    };
    let whole = (letters.len() <= MOST_LETTERS).then(|| name.to_owned());
    let shorter = (0..letters.len().min(MOST_LETTERS)).rev().map(shortened);
    whole.into_iter().chain(shorter).find(|cut| room(cut, height) <= most).unwrap_or_else(|| shortened(0))
}
